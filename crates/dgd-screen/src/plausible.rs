//! Whether a recording can be what its well description says it is.

mod causes;
mod checks;
mod coarse;
mod facts;
mod fed;
mod filler;
mod state;
mod words;

use crate::{ScreenError, error};
use causes::{Cause, TwoUnits, explain, two_units};
use checks::{Fault, faults, through};
pub use coarse::{Coarse, Kept, TOO_SELDOM_S, coarse};
use dgd_recording::{Channel, Recording, Well};
use dgd_units::{PressureReference, STANDARD_ATMOSPHERE_PA};
use facts::{FactPass, Facts, quantile};
use fed::ill_fed;
use state::State;
use std::fmt;

/// A line of the well description.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct WellLine {
    /// Section: `mud`, `geometry` or `channels`.
    pub section: &'static str,
    /// Key in it.
    pub key: &'static str,
    /// Which of several transmitters, counted from 0.
    pub transmitter: Option<usize>,
    /// The channel, where it is one.
    pub channel: Option<Channel>,
}

impl WellLine {
    fn new(section: &'static str, key: &'static str) -> Self {
        Self {
            section,
            key,
            transmitter: None,
            channel: None,
        }
    }

    fn of(channel: Channel) -> Self {
        let transmitter = match channel {
            Channel::PumpInletPressure(n) | Channel::PumpOutletPressure(n) => Some(n),
            _ => None,
        };
        Self {
            channel: Some(channel),
            transmitter,
            ..Self::new("channels", channel.name())
        }
    }
}

/// Something that a recording makes unlikely in its well description.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct Suspicion {
    /// The line to look at first.
    pub place: WellLine,
    /// What does not fit, and what would.
    pub message: String,
}

impl fmt::Display for Suspicion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

/// Most alternatives that one suspicion names.
const ALTERNATIVES: usize = 3;
/// Share of samples below which a channel is called mostly empty.
const MOSTLY: f64 = 0.5;

/// What in a well description a recording makes unlikely: units, tags, depths, density, diameters
/// and the clock's unit; and channels that say nothing.
///
/// - `recording`: as read, before any screening, on an even clock; any length.
/// - `step_s`: step of that clock, s.
///
/// A suspicion rests on what holds for any rig with this geometry, with room for what a
/// diagnosis is for (meters off by a fifth, transmitters by 5 bar, mud lighter or heavier by as
/// much as gas and cuttings make it): pressures lie between an empty and a full column of
/// mud; the pump's inlet and outlet lie near each other; twins agree; the pump raises the pressure; no flow exceeds 30,000 L/min; what is
/// pumped in comes back, between 0.6 and 1.67 times, and of each pump's changes between 0.4 and 2.5 times; the level moves with what the flows leave in the riser; the return line's
/// friction factor is one of a pipe; a pump's speed is in percent; time steps are a recorder's. Of
/// every single mistake of description (another unit of one or several channels, tags swapped,
/// depths or one of them, density or diameters in another unit) those that mend all of it are named; where none does, a unit of pressures
/// and one of flows that mend it together, if there are such, each with its line. A number that a pressure reads three times or more, and
/// that lies beyond four times all its other readings, stands for no value: that is told, and it is left out of all this.
///
/// What it cannot see: all pressures gauge where absolute is said (an atmosphere is no more than
/// a transmitter's bias), UK for US gallons, swapped inflows (only their sum is used), swapped
/// transmitters of one side. It is silent where there is too little to judge.
///
/// # Errors
/// [`ScreenError::Step`], [`ScreenError::Unequal`], [`ScreenError::Uneven`]: silence would pass for a sound description.
/// Without samples there is nothing to suspect.
pub fn suspect(
    recording: &Recording,
    step_s: f64,
    well: &Well,
) -> Result<Vec<Suspicion>, ScreenError> {
    error::check(recording, step_s)?;
    if recording.is_empty() {
        return Ok(Vec::new());
    }
    Ok(judge(&Facts::of(recording, step_s, well), well))
}

/// [`suspect`] of a recording that comes in blocks, to the same words, whatever the blocks.
///
/// Held are the means of a minute of every channel, which grow with the recording.
///
/// ```
/// # use dgd_recording::{Recording, Well};
/// # use dgd_screen::{BlockSuspect, ScreenError, Suspicion};
/// # fn told(well: &Well, blocks: &[Recording]) -> Result<Vec<Suspicion>, ScreenError> {
/// let mut suspect = BlockSuspect::new(1.0)?;
/// for block in blocks {
///     suspect.add(block)?;
/// }
/// Ok(suspect.finish(well))
/// # }
/// ```
#[derive(Debug)]
pub struct BlockSuspect {
    step_s: f64,
    /// Second of the last sample.
    last_s: Option<f64>,
    passes: Vec<(Channel, FactPass)>,
}

impl BlockSuspect {
    /// For a recording on an even clock of this step, s.
    ///
    /// # Errors
    /// [`ScreenError::Step`] if the step is no positive number.
    pub fn new(step_s: f64) -> Result<Self, ScreenError> {
        error::check_step(step_s)?;
        Ok(Self {
            step_s,
            last_s: None,
            passes: Vec::new(),
        })
    }

    /// Takes the next samples; all blocks must have the same transmitters.
    ///
    /// # Errors
    /// Those of [`suspect`], and [`ScreenError::Transmitters`] on others than before; the block is then left out.
    pub fn add(&mut self, block: &Recording) -> Result<(), ScreenError> {
        error::check_next(block, self.step_s, self.last_s)?;
        let all = block.series();
        if self.passes.is_empty() {
            let pass = FactPass::new(self.step_s);
            self.passes = all.iter().map(|(c, _)| (*c, pass.clone())).collect();
        }
        if !all.iter().map(|s| s.0).eq(self.passes.iter().map(|p| p.0)) {
            return Err(ScreenError::Transmitters {
                found: all.len(),
                expected: self.passes.len(),
            });
        }
        for ((_, pass), (_, values)) in self.passes.iter_mut().zip(all) {
            pass.add(values);
        }
        self.last_s = block.time_s.last().copied().or(self.last_s);
        Ok(())
    }

    /// What the recording makes unlikely.
    pub fn finish(self, well: &Well) -> Vec<Suspicion> {
        if self.passes.iter().all(|(_, pass)| pass.is_empty()) {
            return Vec::new();
        }
        judge(&Facts::gathered(self.passes, self.step_s, well), well)
    }
}

fn judge(facts: &Facts, well: &Well) -> Vec<Suspicion> {
    let mut suspicions = mute(facts);
    let state = State::described(facts, well);
    let found = faults(&state);
    let sound = found.is_empty();
    let any_pressure = found.iter().any(|f| f.check.is_of_pressures());
    let mut told = one_by_one(&state, &found);
    // A mistake that mends all is the plainest explanation; several need not be better than two units at once.
    if told.mistakes > 1
        && let Some(both) = two_units(&state)
        && (told.mistakes > 2 || both.strain < told.strain)
    {
        told = pair_told(&state, &found, both);
    }
    suspicions.extend(told.suspicions);
    let state = told.state;
    if !any_pressure {
        suspicions.extend(atmosphere(&state));
    }
    // Only of a recording without any other fault: a wrong unit upsets this too.
    if sound {
        suspicions.extend(exchanged(&state));
        suspicions.extend(ill_fed(&state));
    }
    suspicions
}

/// Mistakes in words, and how the recording reads without them.
struct Told<'a> {
    suspicions: Vec<Suspicion>,
    /// How many they are; none explains what stays at fault.
    mistakes: usize,
    strain: f64,
    state: State<'a>,
}

/// One mistake after the other, each of which explains most of what is at fault by then.
fn one_by_one<'a>(described: &State<'a>, found: &[Fault]) -> Told<'a> {
    let (mut state, mut found) = (described.clone(), found.to_vec());
    let (mut suspicions, mut mistakes, mut price) = (Vec::new(), 0, 0.0);
    // Each turn takes away at least one fault.
    while !found.is_empty() {
        let explained = explain(&state, &found);
        let Some(best) = explained.first() else {
            mistakes = usize::MAX;
            suspicions.extend(found.iter().map(|fault| Suspicion {
                place: words::place_of_fault(&state, fault),
                message: format!(
                    "{}: check {}",
                    words::fault(&state, fault),
                    words::check_first(&state, fault)
                ),
            }));
            break;
        };
        mistakes += 1;
        price += causes::price(&state, &best.cause);
        let gone = |f: &&Fault| best.left.iter().all(|l| l.check != f.check);
        let told: Vec<&Fault> = found.iter().filter(gone).collect();
        let first = told.first().map(|f| words::fault(&state, f));
        let alternatives: Vec<String> = explained
            .iter()
            .take(ALTERNATIVES)
            .map(|e| words::cause(&state, &e.cause, &e.state))
            .collect();
        suspicions.push(Suspicion {
            place: words::place_of_cause(&state, &best.cause),
            message: format!(
                "{}; {}",
                first.unwrap_or_default(),
                alternatives.join("; or ")
            ),
        });
        let (next, left) = (best.state.clone(), best.left.clone());
        state = next;
        found = left;
    }
    Told {
        suspicions,
        mistakes,
        strain: causes::unease(&state) + price,
        state,
    }
}

/// A unit of pressures, and beside it one of flows: what the second explains shows once the first is mended.
fn pair_told<'a>(described: &State<'a>, found: &[Fault], both: TwoUnits<'a>) -> Told<'a> {
    let TwoUnits {
        pressures: (pressure, between),
        flows: (flow, state),
        strain,
    } = both;
    let said = |before: &State<'_>, cause: &Cause, after: &State<'_>, fault: Option<&Fault>| {
        let fault = fault.map(|f| words::fault(before, f));
        Suspicion {
            place: words::place_of_cause(before, cause),
            message: format!(
                "{}; {}",
                fault.unwrap_or_default(),
                words::cause(before, cause, after)
            ),
        }
    };
    let shown = found.iter().find(|f| f.check.is_of_pressures());
    let first = said(described, &pressure, &between, shown.or(found.first()));
    let mut second = said(&between, &flow, &state, faults(&between).first());
    second.message = format!("with the pressures mended, {}", second.message);
    Told {
        suspicions: vec![first, second],
        mistakes: 2,
        strain,
        state,
    }
}

/// Channels that have no value, hardly any, or always the same, or a number that stands for none.
fn mute(facts: &Facts) -> Vec<Suspicion> {
    let state_of = |i: usize| {
        let told = &facts.told[i];
        let tag = told.tag.as_deref().unwrap_or_default();
        format!("{} `{tag}`", told.channel.name())
    };
    let returns = facts.find(Channel::ReturnFlow);
    let stops = returns.is_some_and(|i| {
        let blocks = || facts.told[i].blocks.iter().copied();
        quantile(blocks(), 0.05) < 0.5 * quantile(blocks(), 0.95)
    });
    let mut suspicions = Vec::new();
    // Rows that are missing are missing of every channel.
    let recorded = facts.told.iter().filter(|told| told.tag.is_some());
    let rows = recorded.fold(0.0, |most: f64, told| most.max(told.present));
    let some_rows = rows > 0.0 && rows < MOSTLY;
    let least = if some_rows { MOSTLY * rows } else { MOSTLY };
    if some_rows {
        suspicions.push(Suspicion {
            place: WellLine::new("channels", "time"),
            message: format!(
                "no channel has a value at more than {} % of the samples of its clock",
                words::number(100.0 * rows)
            ),
        });
    }
    for (i, told) in facts
        .told
        .iter()
        .enumerate()
        .filter(|(_, t)| t.tag.is_some())
    {
        let place = WellLine::of(told.channel);
        let mut say = |message| suspicions.push(Suspicion { place, message });
        if told.present == 0.0 {
            say(format!(
                "{} has no value in the whole recording",
                state_of(i)
            ));
        } else if told.present < least {
            say(format!(
                "{} has a value at only {} % of the samples",
                state_of(i),
                words::number(100.0 * told.present)
            ));
        }
        if let Some(filler) = told.filler {
            let read = |si| words::number(told.unit.from_si(si));
            say(format!(
                "{} reads {} {} {} times, and besides {} at the most: where that stands for no value, leave the cells empty",
                state_of(i),
                read(filler.value),
                told.unit,
                filler.times,
                read(filler.next),
            ));
        }
        let Some(value) = told.constant else {
            continue;
        };
        let dead = match told.channel {
            // Booster and topfill run at one rate for days, or not at all.
            Channel::BoosterFlow | Channel::TopfillFlow => false,
            Channel::MudPumpFlow => stops,
            _ => true,
        };
        if dead {
            say(format!(
                "{} never changes ({} {} throughout): is it connected?",
                state_of(i),
                words::number(told.unit.from_si(value)),
                told.unit
            ));
        }
    }
    suspicions
}

/// An inflow that is the return flow by what the line's pressure says.
fn exchanged(state: &State<'_>) -> Option<Suspicion> {
    let back = state.facts.find(Channel::ReturnFlow)?;
    if state.facts.told[back].constant.is_some() {
        return None;
    }
    let (i, closer) = through(state)?;
    let cause = Cause::Swap(vec![(i, back)]);
    let after = cause.undone(state)?;
    (state.facts.told[i].tag.is_some() && faults(&after).is_empty()).then(|| Suspicion {
        place: words::place_of(state, Some(back)),
        message: format!(
            "the pump outlet pressure follows {} {} times as closely as {}; {}",
            words::named(state, i),
            words::number(closer),
            words::named(state, back),
            words::cause(state, &cause, &after)
        ),
    })
}

/// Twins that read an atmosphere apart, one of them described as gauge.
///
/// Without the description an atmosphere is a bias like any other.
fn atmosphere(state: &State<'_>) -> Option<Suspicion> {
    const NEAR_PA: f64 = 15e3;
    let flowing = state.flowing();
    let gauge = |i: usize| state.units[i].pressure_reference == Some(PressureReference::Gauge);
    for side in [state.inlets(), state.outlets()] {
        for (n, a) in side.iter().enumerate() {
            for b in &side[n + 1..] {
                let (above, below) = match (gauge(*a), gauge(*b)) {
                    (true, false) => (*a, *b),
                    (false, true) => (*b, *a),
                    _ => continue,
                };
                let apart = state.median(above, &flowing) - state.median(below, &flowing);
                if (apart - STANDARD_ATMOSPHERE_PA).abs() < NEAR_PA {
                    return Some(Suspicion {
                        place: words::place_of(state, Some(above)),
                        message: format!(
                            "{}, read as {}, and its twin {}, read as {}, differ by one atmosphere ({} bar): both must be gauge or both absolute",
                            words::named(state, above),
                            state.units[above],
                            words::named(state, below),
                            state.units[below],
                            words::number(apart * 1e-5),
                        ),
                    });
                }
            }
        }
    }
    None
}
