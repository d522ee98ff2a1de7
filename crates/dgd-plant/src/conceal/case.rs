//! Which cases are made: levels, kinds, effects and severities in turn.

use crate::conceal::dialect::{Dialect, Form};
use crate::conceal::effect::{self, EFFECTS, FOREIGN, Hidden, PASSING, RECURRING, Severity};
use crate::conceal::rig::{Level, Rig, pick};
use crate::conceal::routine;
use crate::config::Plan;
use crate::noise::Noise;

/// What cases hide.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// One effect of the catalogue.
    Single,
    /// Two effects of the catalogue.
    Pair,
    /// Three effects of the catalogue, or four.
    Several,
    /// One of [`PASSING`], which ends.
    Passing,
    /// One of [`RECURRING`], which comes twice.
    Recurring,
    /// Nothing.
    Clean,
    /// One effect that is in no catalogue.
    Foreign,
    /// One that is in no catalogue, and one of the catalogue in another relation.
    Beside,
    /// Of twenty cases twelve single, three pairs, three clean, two foreign.
    Mix,
}

/// A series of cases to be made.
#[derive(Debug, Clone, PartialEq)]
pub struct Order {
    /// Seed of everything.
    pub seed: u64,
    /// How clean the base physics is.
    pub level: Level,
    /// What is hidden.
    pub kind: Kind,
    /// Only this severity; by default singles and foreigns take all in turn, and what comes in company is moderate.
    pub severity: Option<Severity>,
    /// Only this effect of [`EFFECTS`] or kind of [`FOREIGN`]; in company, the first.
    pub effect: Option<&'static str>,
    /// How long each recording lasts, h; by default 4 to 8, as drawn.
    pub hours: Option<f64>,
    /// How many times as viscous the mud is as drawn: at 6, half the usual flow is laminar in nearly half of the wells.
    pub viscosity: f64,
}

/// A case: the plan of its recording, what it hides, and how it is filed.
#[derive(Debug, Clone, PartialEq)]
pub struct Case {
    /// `c000`, `c001`, ...
    pub id: String,
    /// Everything that is simulated, causes included.
    pub plan: Plan,
    /// What is hidden; empty in a clean case.
    pub hidden: Vec<Hidden>,
    /// Seconds from sample to sample in the file: 1, 2 or 5.
    pub sampling_s: usize,
    /// Channels that are not in the file.
    pub absent: [bool; 10],
    /// Tags and units.
    pub dialect: Dialect,
    /// File format.
    pub form: Form,
}

/// Effects of which a recording shows nothing unless subsea pump and booster stop at times.
const NEED_STOPS: [&str; 5] = [
    "gel_strength",
    "line_drainage",
    "booster_line_storage",
    "friction_swell",
    "booster_crosstalk",
];

const MIX: [Kind; 20] = {
    use Kind::{Clean, Foreign, Pair, Single};
    [
        Single, Single, Clean, Single, Pair, Single, Single, Foreign, Single, Single, Clean,
        Single, Pair, Single, Single, Foreign, Single, Clean, Single, Pair,
    ]
};

/// The case number `index` of an order. The same order gives the same case, whatever comes before it.
pub fn conceal(order: &Order, index: usize) -> Case {
    let kind = match order.kind {
        Kind::Mix => MIX[index % MIX.len()],
        kind => kind,
    };
    // Number among its like, so that a mix goes through effects and severities as evenly as a pure series.
    let turn = match order.kind {
        Kind::Mix => {
            let like = |k: &&Kind| **k == kind;
            let round = MIX.iter().filter(like).count();
            index / MIX.len() * round + MIX[..index % MIX.len()].iter().filter(like).count()
        }
        _ => index,
    };
    let mut noise = Noise::new(order.seed, 10_000 + index as u64);
    let plant_seed = noise.whole();
    let rig = Rig::draw(order.level, order.hours, order.viscosity, &mut noise);
    let filing = filing(order.level, &mut noise);
    let hidden = hide(order, kind, turn, &rig, &mut Noise::new(plant_seed, 3));
    // What shows only around a standstill must get one.
    let stops = hidden.iter().any(|h| {
        let name = h.kind.unwrap_or(h.effect);
        NEED_STOPS.contains(&name)
    });
    let schedule = routine::draw(&rig, stops, &mut Noise::new(plant_seed, 5));
    let mut plan = rig.plan(plant_seed);
    plan.schedule = schedule;
    plan.causes = hidden.iter().map(|h| h.cause.clone()).collect();
    let (sampling_s, mut absent, dialect, form) = filing;
    // A shift of a transmitter that is not recorded would conceal nothing.
    if hidden
        .iter()
        .any(|h| h.effect == "outlet_pressure_bias_step")
    {
        absent[OUTLETS].fill(false);
    }
    Case {
        id: format!("c{index:03}"),
        plan,
        hidden,
        sampling_s,
        absent,
        dialect,
        form,
    }
}

/// Severity and effect in turn: every effect in each severity, before the round begins again.
fn in_turn(order: &Order, turn: usize, ids: &'static [&'static str]) -> (&'static str, Severity) {
    let chosen = order.effect.and_then(|e| ids.iter().find(|id| **id == e));
    let all = Severity::ALL;
    match chosen {
        Some(id) => (id, order.severity.unwrap_or(all[turn % all.len()])),
        None => (
            ids[turn % ids.len()],
            // Neighbours differ in severity too, and from round to round each effect takes the next.
            order
                .severity
                .unwrap_or(all[(turn % ids.len() + turn / ids.len()) % all.len()]),
        ),
    }
}

fn hide(order: &Order, kind: Kind, turn: usize, rig: &Rig, noise: &mut Noise) -> Vec<Hidden> {
    let mut hidden = Vec::new();
    match kind {
        Kind::Clean | Kind::Mix => {}
        Kind::Single => {
            let (id, severity) = in_turn(order, turn, &EFFECTS);
            hidden.extend(effect::draw(id, severity, rig, noise));
        }
        Kind::Passing => {
            let (id, severity) = in_turn(order, turn, &PASSING);
            let one = effect::draw(id, severity, rig, noise);
            hidden.extend(one.map(|one| one.ending(rig.length_s, noise)));
        }
        Kind::Recurring => {
            let (id, severity) = in_turn(order, turn, &RECURRING);
            let one = effect::draw(id, severity, rig, noise);
            hidden.extend(one.map(|one| one.recurring(rig.length_s, noise)));
        }
        Kind::Foreign => {
            let (kind, severity) = match order.severity {
                Some(s) => (in_turn(order, turn, &FOREIGN).0, s),
                None => (
                    in_turn(order, turn, &FOREIGN).0,
                    [Severity::Moderate, Severity::Subtle, Severity::Strong][turn % 3],
                ),
            };
            hidden.extend(effect::draw_foreign(kind, severity, rig, noise));
        }
        Kind::Pair => {
            let severity = order.severity.unwrap_or(Severity::Moderate);
            let first = order
                .effect
                .unwrap_or(EFFECTS[(turn * 7 + pick(noise, 3)) % EFFECTS.len()]);
            hidden.extend(effect::draw(first, severity, rig, noise));
            // Half of the pairs meet in one relation.
            let same = noise.unit() < 0.5;
            for _ in 0..200 {
                let id = EFFECTS[pick(noise, EFFECTS.len())];
                let Some(second) = effect::draw(id, severity, rig, noise) else {
                    continue;
                };
                let meets = hidden
                    .first()
                    .is_some_and(|h| h.relation.iter().any(|r| second.relation.contains(r)));
                if id != first && meets == same {
                    hidden.push(second);
                    break;
                }
            }
        }
        Kind::Several => {
            let severity = order.severity.unwrap_or(Severity::Moderate);
            let first = order.effect.unwrap_or(EFFECTS[turn % EFFECTS.len()]);
            hidden.extend(effect::draw(first, severity, rig, noise));
            let count = 3 + pick(noise, 2);
            for _ in 0..200 {
                if hidden.len() == count {
                    break;
                }
                let id = EFFECTS[pick(noise, EFFECTS.len())];
                if hidden.iter().all(|h| h.effect != id) {
                    hidden.extend(effect::draw(id, severity, rig, noise));
                }
            }
        }
        Kind::Beside => {
            let severity = order.severity.unwrap_or(Severity::Moderate);
            let turned = FOREIGN.iter().cycle().skip(turn % FOREIGN.len());
            // The first of both that do not meet, the foreign ones in turn and those of the catalogue by lot.
            for foreign in turned.take(FOREIGN.len()) {
                let foreign = effect::draw_foreign(foreign, severity, rig, noise);
                let Some(known) =
                    (foreign.as_ref()).and_then(|f| apart(order, severity, f, rig, noise))
                else {
                    continue;
                };
                hidden.extend(foreign);
                hidden.push(known);
                break;
            }
        }
    }
    hidden
}

/// An effect of the catalogue in another relation than a foreign one, if there is any: the chosen one, or one by lot.
fn apart(
    order: &Order,
    severity: Severity,
    foreign: &Hidden,
    rig: &Rig,
    noise: &mut Noise,
) -> Option<Hidden> {
    let tries = if order.effect.is_some() { 1 } else { 200 };
    for _ in 0..tries {
        let id = order.effect.unwrap_or(EFFECTS[pick(noise, EFFECTS.len())]);
        let known = effect::draw(id, severity, rig, noise);
        let meets = |known: &Hidden| known.relation.iter().any(|r| foreign.relation.contains(r));
        if let Some(known) = known.filter(|known| !meets(known)) {
            return Some(known);
        }
    }
    None
}

/// Channels of the two outlet transmitters.
const OUTLETS: std::ops::Range<usize> = 6..8;

fn filing(level: Level, noise: &mut Noise) -> (usize, [bool; 10], Dialect, Form) {
    let sampling_s = match level {
        Level::One => 1,
        Level::Two => [1, 1, 1, 2, 5][pick(noise, 5)],
    };
    let mut absent = [false; 10];
    let lost = pick(noise, 4);
    if level == Level::Two && noise.unit() < 0.35 {
        // The riser sensor, an outlet or an inlet transmitter.
        absent[[8, 7, 6, 5][lost]] = true;
    }
    let mut dialect = Dialect::ALL[[0, 0, 0, 0, 0, 1, 2, 3][pick(noise, 8)]].clone();
    let form = [Form::Mat, Form::Mat, Form::Csv, Form::Mcap][pick(noise, 4)];
    if form == Form::Mcap {
        // Its time is the log time, which has no tag of the rig's own.
        dialect.time = "t";
    }
    (sampling_s, absent, dialect, form)
}
