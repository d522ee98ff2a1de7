//! The two-state model with effects, and its free run.

mod run;

use crate::curves::Curves;
use crate::{Curve, Effect, MeterPath, Method, Quantity, Setting, find_taking};
use dgd_recording::STANDING_M3_S;
use run::{Acting, Line, Stretch};
use std::ops::Range;

/// An effect with its parameters, in the order of its description.
#[derive(Debug, Clone, PartialEq)]
pub struct AppliedEffect {
    /// Id in the catalogue.
    pub id: String,
    /// Parameters in the order of [`About::parameters`](crate::About::parameters), SI.
    pub parameters: Vec<f64>,
}

impl AppliedEffect {
    /// The effect of the catalogue that this is.
    ///
    /// # Errors
    /// [`UnknownEffect`] if the catalogue holds none of that id, or one with another number of parameters.
    pub fn look_up(&self) -> Result<&'static dyn Effect, UnknownEffect> {
        find_taking(&self.id, self.parameters.len()).ok_or_else(|| UnknownEffect {
            id: self.id.clone(),
            given: self.parameters.len(),
        })
    }
}

/// The return-line model (Eqs. 3.45-3.46) with general curves and effects.
#[derive(Debug, Clone, PartialEq)]
pub struct AugmentedModel {
    /// Base curves.
    pub curves: Curves,
    /// Least and greatest speed, %, at which the curves were identified.
    pub speed_range_pct: (f64, f64),
    /// Least and greatest flow over speed, m³/s/%, at which the curves were identified.
    pub ratio_range: (f64, f64),
    /// Start and end of the recording that it was identified on, s: what grows over a recording grew over this one.
    /// The recording that it runs on, if none.
    pub span_s: Option<(f64, f64)>,
    /// [`Setting::inlet_range_pa`] of the recording that it was identified on, Pa absolute: shares of a range are of this one.
    /// The recording that it runs on, if none.
    pub inlet_range_pa: Option<(f64, f64)>,
    /// Effects that act.
    pub effects: Vec<AppliedEffect>,
}

/// An effect that the catalogue does not hold, or with another number of parameters than it takes.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("effect `{id}` is not in the catalogue, or does not take {given} parameters")]
pub struct UnknownEffect {
    /// The id asked for.
    pub id: String,
    /// Number of parameters given.
    pub given: usize,
}

/// What drives a free run: flow meters and the set-point of the pump, without gaps.
///
/// Slices of shape `(n,)` on one clock; of unequal ones the run uses what all of them have.
#[derive(Debug, Clone, Copy)]
pub struct Inputs<'a> {
    /// Time of the recording's clock, s, on an even clock.
    pub time_s: &'a [f64],
    /// Step of the clock, s.
    pub step_s: f64,
    /// Mud pump, m³/s.
    pub mud_pump_m3_s: &'a [f64],
    /// Booster, m³/s.
    pub booster_m3_s: &'a [f64],
    /// Topfill, m³/s.
    pub topfill_m3_s: &'a [f64],
    /// Speed set-point, %.
    pub speed_pct: &'a [f64],
}

/// What a free run gives: shape `(window,)`, one value a sample of its window.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FreeRun {
    /// Return flow as its meter would read, m³/s.
    pub return_flow_m3_s: Vec<f64>,
    /// Inlet pressure as the mean of its transmitters would read, Pa absolute.
    pub inlet_pa: Vec<f64>,
    /// Outlet pressure as the mean of its meters would read, Pa absolute.
    pub outlet_pa: Vec<f64>,
}

/// The curve of a correction that acts for a while or from some time on.
fn episode_of(effect: &dyn Effect, parameters: &[f64]) -> Option<Curve> {
    let curve =
        (effect.about().search.method == Method::Correction).then(|| Curve::read(parameters))?;
    curve.filter(|curve| curve.quantity == Quantity::Episode)
}

/// What became of effects that set in at some time of one recording, or grew over it, on a later one, by id.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct CarriedOver {
    /// They go on.
    pub ongoing: Vec<&'static str>,
    /// They have passed.
    pub over: Vec<&'static str>,
    /// They grow, as fast as over the span that the model was identified on.
    pub growing: Vec<&'static str>,
}

impl AugmentedModel {
    /// Takes the effects to a later recording, of this setting: what set in and had no end acts from its start on, what lasted for a while is
    /// over, and a pressure stays that pressure. An id that the catalogue does not hold stays as it is.
    pub fn carry_over(&mut self, setting: &Setting) -> CarriedOver {
        let from_s = setting.span_s.0;
        let range_pa = self.inlet_range_pa.replace(setting.inlet_range_pa);
        let mut carried = CarriedOver::default();
        // Before the span that the model was identified on, and so before anything of it that takes time.
        let before_s = self.span_s.map_or(from_s, |(begins, _)| from_s.min(begins));
        self.effects.retain_mut(|one| {
            let Ok(effect) = one.look_up() else {
                return true;
            };
            let about = effect.about();
            let episode = episode_of(effect, &one.parameters);
            let passes = match &episode {
                Some(episode) => !episode.goes_on(),
                None => about.duration().is_some(),
            };
            if effect.grown(&one.parameters, 1.0).is_some() {
                carried.growing.push(about.id);
            }
            let here = setting.inlet_range_pa;
            if let Some(p) = range_pa.and_then(|there| effect.ranged(&one.parameters, there, here))
            {
                one.parameters = p;
            }
            if passes {
                carried.over.push(about.id);
            } else if let Some(episode) = episode {
                let begun = (from_s, None);
                one.parameters =
                    Curve::episode(episode.place, begun, episode.at(episode.from)).parameters();
                carried.ongoing.push(about.id);
            } else if let Some(onset) = about.onset() {
                one.parameters[onset] = before_s;
                carried.ongoing.push(about.id);
            }
            !passes
        });
        // What came more than once is told once.
        for ids in [
            &mut carried.over,
            &mut carried.ongoing,
            &mut carried.growing,
        ] {
            ids.sort_unstable();
            ids.dedup();
        }
        carried
    }

    /// The effects as they are told of a recording that spans from, to, s: what grows over a recording is as strong as its rate makes it by the
    /// end of this one, within its bounds.
    pub fn effects_over(&self, span_s: (f64, f64)) -> Vec<AppliedEffect> {
        let lasts_s = |(from, to): (f64, f64)| (to - from).max(1.0);
        let times = self
            .span_s
            .map_or(1.0, |own| lasts_s(span_s) / lasts_s(own));
        let told = |one: &AppliedEffect| {
            let mut told = one.clone();
            if let Ok(effect) = one.look_up()
                && let Some(mut grown) = effect.grown(&one.parameters, times)
            {
                let strength = &effect.about().parameters[0];
                grown[0] = within(grown[0], strength.low, strength.high);
                told.parameters = grown;
            }
            told
        };
        self.effects.iter().map(told).collect()
    }

    /// Pressure rise over the pump, Pa, at a speed, %, and a flow, m³/s.
    ///
    /// Beyond the range of speeds by affinity (head over speed squared is a function of flow over speed); beyond the range of
    /// flow over speed straight on with the slope at its end, or level where that slope would rise.
    pub fn head_pa(&self, speed_pct: f64, flow_m3_s: f64) -> f64 {
        let (low, high) = self.speed_range_pct;
        let held = within(speed_pct, low, high);
        let share = speed_pct / held.max(1e-3);
        // Affinity: head goes with the square of the speed at the same flow over speed.
        let flow = if share > 1e-3 {
            flow_m3_s / share
        } else {
            flow_m3_s
        };
        let (least, most) = (self.ratio_range.0 * held, self.ratio_range.1 * held);
        let inside = within(flow, least, most);
        let mut head = self.curves.head_pa(held, inside);
        if flow != inside {
            let span = 0.1 * (most - least).max(1e-4);
            let inner = if flow > inside {
                inside - span
            } else {
                inside + span
            };
            let slope = (head - self.curves.head_pa(held, inner)) / (inside - inner);
            head += slope.min(0.0) * (flow - inside);
        }
        head * share * share
    }

    /// Friction of the line, Pa, at a flow, m³/s, as a run has it.
    ///
    /// Beyond the greatest flow of the ranges of speed and of flow over speed straight on with the slope at its end; from where the curve
    /// is greatest within them level, if it falls from there.
    pub fn friction_pa(&self, flow_m3_s: f64) -> f64 {
        Held::of(self).friction_pa(&self.curves, flow_m3_s)
    }

    /// Simulates samples `window` from a measured state: inlet pressure, Pa absolute, and line flow, m³/s, at its first
    /// sample.
    ///
    /// The model is `rho L/A dq/dt = p_in + H(w, q) - p_0 - rho g L - F(q)` and `A dh/dt = q_in - q` (Slettebø 2015,
    /// Eqs. 3.46 and 3.45, with the line's inertia alone), each term as the effects' [`Changes`](crate::Changes) alter it. Below 5 % of
    /// speed the pump stands and a check valve holds the line: no flow, and the outlet shows the column.
    ///
    /// Effects live through the recording from its start, or for as long before the window as they remember
    /// ([`Effect::memory_s`]), so that those with an onset before the window are in force; before the window they see the
    /// inputs, the start's pressures, and a pump that while it turns passes the start's flow, or what flows into the riser where
    /// the window starts at rest. While the line fills
    /// ([`Changes::line_fall_m`](crate::Changes::line_fall_m)) its meter shows nothing. Implicit in the flow (its time constant is a
    /// second), trapezoidal in the level, in steps of at most 1 s up to a clock of 20 s. Flow stays within 0 to 0.3 m³/s,
    /// the true inlet pressure within 0.5 to 1000 bar. `start` holds readings.
    ///
    /// # Errors
    /// [`UnknownEffect`] if an effect is not in the catalogue or takes another number of parameters.
    pub fn free_run(
        &self,
        setting: &Setting,
        inputs: Inputs<'_>,
        window: Range<usize>,
        start: (f64, f64),
    ) -> Result<FreeRun, UnknownEffect> {
        let window = [(window, start)];
        let mut runs = self.free_runs(setting, inputs, &window)?;
        Ok(runs.next().unwrap_or_default())
    }

    /// Simulates windows one after the other, each from its own measured state, as [`free_run`](Self::free_run) does the first.
    ///
    /// Windows ascend and do not overlap. Effects live on from one to the next, and remember of a window before theirs what was
    /// simulated in it: one pass over the samples, however long they remember.
    ///
    /// # Errors
    /// [`UnknownEffect`] if an effect is not in the catalogue or takes another number of parameters.
    pub fn free_runs<'a>(
        &'a self,
        setting: &'a Setting,
        inputs: Inputs<'a>,
        windows: &'a [(Range<usize>, (f64, f64))],
    ) -> Result<impl Iterator<Item = FreeRun> + 'a, UnknownEffect> {
        let mut acting = self.begin(setting)?;
        let remembered = self.remembered(inputs.step_s)?;
        let line = Line::of(self, setting);
        let mut seen_to = 0;
        let run = move |(window, start): &(Range<usize>, (f64, f64))| {
            let from = window.start.saturating_sub(remembered).max(seen_to);
            seen_to = window.end;
            let stretch = Stretch {
                from,
                window: window.clone(),
                start: *start,
            };
            line.run(inputs, &stretch, &mut acting)
        };
        Ok(windows.iter().map(run))
    }

    /// Starts every effect.
    fn begin(&self, setting: &Setting) -> Result<Acting, UnknownEffect> {
        let mut path = MeterPath::default();
        let mut actions = Vec::new();
        let identified = self.span_s.map(|span_s| Setting {
            span_s,
            ..setting.clone()
        });
        for one in &self.effects {
            let effect = one.look_up()?;
            let p = effect.meter_path(&one.parameters);
            path.delay_s += p.delay_s;
            path.lag_s += p.lag_s;
            // Stands, and what was there before the first sample, are those of the recording that runs.
            let grows = effect.grown(&one.parameters, 1.0).is_some();
            let setting = identified.as_ref().filter(|_| grows).unwrap_or(setting);
            actions.push(effect.begin(&one.parameters, setting));
        }
        Ok(Acting::new(actions, path))
    }

    /// How many samples before a window an effect may still remember in it.
    fn remembered(&self, step_s: f64) -> Result<usize, UnknownEffect> {
        let mut memory_s = 0.0_f64;
        for one in &self.effects {
            memory_s = memory_s.max(one.look_up()?.memory_s(&one.parameters));
        }
        let samples = (memory_s / step_s).ceil();
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a cast of floats saturates; a NaN becomes all of them"
        )]
        Ok(if samples.is_nan() {
            usize::MAX
        } else {
            samples as usize
        })
    }
}

/// Friction of the line in a run: its curve up to where that is greatest within the flows at which it was identified, and how it goes on.
///
/// Mud that flows faster rubs more. A curve that was bent by what it does not hold, or that is asked beyond its range, may fall
/// without end, and there is then no flow that balances it within what is physical.
#[derive(Debug, Clone, Copy)]
struct Held {
    top_m3_s: f64,
    at_top_pa: f64,
    /// Pa/(m³/s), at least 0.
    slope: f64,
}

impl Held {
    fn of(model: &AugmentedModel) -> Self {
        /// Flows at which the curve is looked at, and over how many of them the slope at its end is taken.
        const LOOKS: usize = 100;
        const END: usize = 10;
        let most = model.ratio_range.1 * model.speed_range_pct.1;
        if most.is_nan() || most < 10.0 * STANDING_M3_S {
            // Of a range that is none nothing is known: the curve is taken as it is.
            return Self {
                top_m3_s: f64::INFINITY,
                at_top_pa: 0.0,
                slope: 0.0,
            };
        }
        let most = most.min(MOST_M3_S);
        let flow = |k: usize| STANDING_M3_S + (most - STANDING_M3_S) * k as f64 / LOOKS as f64;
        let curve = |k: usize| model.curves.friction_pa(flow(k));
        let top = (1..=LOOKS).max_by(|a, b| curve(*a).total_cmp(&curve(*b)));
        let top = top.unwrap_or(LOOKS);
        let slope = if top < LOOKS {
            0.0
        } else {
            (curve(LOOKS) - curve(LOOKS - END)) / (flow(LOOKS) - flow(LOOKS - END))
        };
        Self {
            top_m3_s: flow(top),
            at_top_pa: curve(top),
            slope: slope.max(0.0),
        }
    }

    fn friction_pa(&self, curves: &Curves, flow_m3_s: f64) -> f64 {
        if flow_m3_s > self.top_m3_s {
            self.at_top_pa + self.slope * (flow_m3_s - self.top_m3_s)
        } else {
            curves.friction_pa(flow_m3_s)
        }
    }
}

/// Flow that no run exceeds, m³/s.
const MOST_M3_S: f64 = 0.3;

/// Below this speed, %, the pump is taken to stand.
pub const STANDING_PCT: f64 = 5.0;

impl Inputs<'_> {
    /// What the meters say flows into the riser at a sample, m³/s.
    fn inflow_m3_s(&self, i: usize) -> f64 {
        self.mud_pump_m3_s[i] + self.booster_m3_s[i] + self.topfill_m3_s[i]
    }

    /// Samples that every channel has.
    fn samples(&self) -> usize {
        [
            self.time_s,
            self.mud_pump_m3_s,
            self.booster_m3_s,
            self.topfill_m3_s,
            self.speed_pct,
        ]
        .iter()
        .map(|channel| channel.len())
        .fold(usize::MAX, usize::min)
    }
}

/// `f64::clamp` without its panic on a range that is none.
fn within(value: f64, low: f64, high: f64) -> f64 {
    if value < low {
        low
    } else if value > high && high >= low {
        high
    } else if value > high {
        low
    } else {
        value
    }
}
