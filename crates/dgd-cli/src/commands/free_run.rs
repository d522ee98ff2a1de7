//! A model with effects beside a recording: level and flow run free.

use crate::args::{KindArg, Simulate};
use crate::failure::Failure;
use crate::load;
use dgd_documents::ModelDocument;
use dgd_dynamics::integrate::{Statistics, Status};
use dgd_dynamics::return_line::RiserBounds;
use dgd_effects::{AugmentedModel, Inputs, START_S, Setting, find};
use dgd_identify::Prepared;
use dgd_recording::{Recording, Well};
use dgd_replay::{Pair, Replay, ReplayError, ReplayOptions, Start, fill_gaps};
use std::ops::Range;
use std::path::Path;

/// Refuses what only a two-state model can do.
pub(crate) fn check(arguments: &Simulate) -> Result<(), Failure> {
    if arguments.kind == KindArg::Coupled {
        return Ok(());
    }
    let kind = format!("{:?}", arguments.kind).to_lowercase();
    let reason = format!(
        "--kind {kind} needs a two-state model written by `dgd fit`; {} is a model with effects, which runs coupled",
        arguments.model.display()
    );
    Err(Failure::Arguments { reason })
}

/// Runs the model over the window; effects live from the start of the recording.
///
/// Mud and geometry are the model's. What the two-state replay measures is measured here in the same way; the
/// flow through the pump is not compared, as effects may stand between it and its meter.
pub(crate) fn run(
    document: &ModelDocument,
    model: &AugmentedModel,
    well: &Well,
    prepared: &Prepared,
    options: &ReplayOptions,
    path: &Path,
) -> Result<Replay, Failure> {
    replay(document, model, well, prepared, options).map_err(|reason| Failure::input(path, reason))
}

fn replay(
    document: &ModelDocument,
    model: &AugmentedModel,
    well: &Well,
    prepared: &Prepared,
    options: &ReplayOptions,
) -> Result<Replay, String> {
    let recording = &prepared.recording;
    let time = &recording.time_s;
    let window = load::window(recording, options.window_s).map_err(|e| e.to_string())?;
    let (density_kg_m3, geometry) = document.well();
    let well = Well {
        mud_density_kg_m3: density_kg_m3,
        geometry: geometry.clone(),
        ..well.clone()
    };
    let setting = Setting::of(&well, recording, &prepared.inlet_pressure_pa);
    let none = |name| none(name, time, &window);
    let driven = Driven::read(recording, &window).map_err(none)?;
    let levels_m = |inlet_pa: &[f64]| inlet_pa.iter().map(|p| well.level_m(*p)).collect();
    let heads_m = |outlet_pa: &[f64], inlet_pa: &[f64]| {
        let both = inlet_pa.iter().zip(outlet_pa);
        both.map(|(inlet, outlet)| well.head_m(*inlet, *outlet))
            .collect()
    };
    let inlet = &prepared.inlet_pressure_pa[window.clone()];
    let outlet = &prepared.outlet_pressure_pa[window.clone()];
    let flow = &recording.return_flow_m3_s[window.clone()];
    let (first, start) =
        start(&options.start, &well, prepared.step_s, inlet, flow).map_err(none)?;
    let inputs = driven.inputs(time, prepared.step_s);
    let mut ran = model
        .free_run(&setting, inputs, window.start + first..window.end, start)
        .map_err(|e| e.to_string())?;
    for series in [
        &mut ran.return_flow_m3_s,
        &mut ran.inlet_pa,
        &mut ran.outlet_pa,
    ] {
        series.splice(0..0, std::iter::repeat_n(f64::NAN, first));
    }
    let level: Vec<f64> = levels_m(&ran.inlet_pa);
    let at = |reached: &dyn Fn(f64) -> bool| {
        let index = level.iter().position(|h| reached(*h));
        index.map(|i| time[window.start + i])
    };
    let bounds = RiserBounds {
        full_s: at(&|level| level <= 0.0),
        empty_s: at(&|level| level >= geometry.pump_inlet_depth_m),
        valve_shut_s: None,
    };
    let ahead = ahead(&recording.return_flow_m3_s, &window, model, prepared.step_s);
    let pair = |measured: Vec<f64>, simulated: Vec<f64>| Pair {
        measured,
        simulated,
    };
    Ok(Replay {
        bounds,
        time_s: time[window.clone()].to_vec(),
        level_m: pair(levels_m(inlet), level),
        pump_flow_m3_s: pair(ahead, Vec::new()),
        return_flow_m3_s: pair(flow.to_vec(), ran.return_flow_m3_s),
        head_m: pair(
            heads_m(outlet, inlet),
            heads_m(&ran.outlet_pa, &ran.inlet_pa),
        ),
        inlet_pressure_pa: pair(inlet.to_vec(), ran.inlet_pa),
        outlet_pressure_pa: pair(outlet.to_vec(), ran.outlet_pa),
        inflow_m3_s: window.clone().map(|i| driven.inflow_m3_s(i)).collect(),
        speed_pct: driven.speed[window].to_vec(),
        filled: driven.filled,
        status: Some(Status::Finished),
        statistics: Statistics::default(),
        unsolved: 0,
    })
}

/// What drives the model, without gaps.
struct Driven {
    mud_pump: Vec<f64>,
    booster: Vec<f64>,
    topfill: Vec<f64>,
    speed: Vec<f64>,
    /// Samples of the window that were none.
    filled: usize,
}

impl Driven {
    /// `Err` names the channel without a value.
    fn read(recording: &Recording, window: &Range<usize>) -> Result<Self, &'static str> {
        let mut filled = 0;
        let mut input = |name: &'static str, values: &[f64]| {
            let within = values[window.clone()].iter();
            filled += within.filter(|v| !v.is_finite()).count();
            let mut values = values.to_vec();
            fill_gaps(&mut values).map(|_| values).ok_or(name)
        };
        let mut driven = Self {
            mud_pump: input("mud_pump_flow", &recording.mud_pump_flow_m3_s)?,
            booster: input("booster_flow", &recording.booster_flow_m3_s)?,
            topfill: input("topfill_flow", &recording.topfill_flow_m3_s)?,
            speed: input("pump_speed", &recording.pump_speed_pct)?,
            filled: 0,
        };
        driven.filled = filled;
        driven.speed.iter_mut().for_each(|w| *w = w.max(0.0));
        Ok(driven)
    }

    fn inputs<'a>(&'a self, time_s: &'a [f64], step_s: f64) -> Inputs<'a> {
        Inputs {
            time_s,
            step_s,
            mud_pump_m3_s: &self.mud_pump,
            booster_m3_s: &self.booster,
            topfill_m3_s: &self.topfill,
            speed_pct: &self.speed,
        }
    }

    fn inflow_m3_s(&self, i: usize) -> f64 {
        self.mud_pump[i] + self.booster[i] + self.topfill[i]
    }
}

/// The first sample at which level and flow are given or measured, with the inlet pressure and the flow there; `Err` names the channel
/// that has none.
fn start(
    given: &Start,
    well: &Well,
    step_s: f64,
    inlet: &[f64],
    flow: &[f64],
) -> Result<(usize, (f64, f64)), &'static str> {
    let first = inlet.iter().zip(flow).position(|(inlet, flow)| {
        (given.level_m.is_some() || inlet.is_finite())
            && (given.flow_m3_s.is_some() || flow.is_finite())
    });
    let first = first.ok_or_else(|| {
        if inlet.iter().any(|p| p.is_finite()) {
            "return_flow"
        } else {
            "pump_inlet_pressure"
        }
    })?;
    let start_inlet = match given.level_m {
        Some(level) => well.inlet_pressure_pa(level),
        None => start_of(&inlet[first..], step_s),
    };
    let start_flow = match given.flow_m3_s {
        Some(flow) => flow,
        None => start_of(&flow[first..], step_s).max(0.0),
    };
    Ok((first, (start_inlet, start_flow)))
}

/// Mean of the first seconds, as a diagnosis starts its free runs: one sample alone would start the run on its noise.
fn start_of(values: &[f64], step_s: f64) -> f64 {
    let within = |(i, _): &(usize, &f64)| *i == 0 || (*i as f64) * step_s < START_S;
    let few = values.iter().enumerate().take_while(within);
    let few = few.map(|(_, v)| v).filter(|v| v.is_finite());
    few.clone().sum::<f64>() / few.count() as f64
}

fn none(name: &'static str, time: &[f64], window: &Range<usize>) -> String {
    let error = ReplayError::NoInput {
        name,
        from_s: time[window.start],
        to_s: time[window.end - 1],
    };
    error.to_string()
}

/// The meter's flow, read ahead by the delay that the model's effects put before it.
fn ahead(flow: &[f64], window: &Range<usize>, model: &AugmentedModel, step_s: f64) -> Vec<f64> {
    let delays = model.effects.iter().filter_map(|applied| {
        let effect = find(&applied.id)?;
        let known = effect.takes(applied.parameters.len());
        known.then(|| effect.meter_path(&applied.parameters).delay_s)
    });
    let steps = (delays.sum::<f64>() / step_s).round();
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "clamped to the length of the series"
    )]
    let steps = steps.clamp(0.0, flow.len() as f64) as usize;
    window
        .clone()
        .map(|i| flow.get(i + steps).copied().unwrap_or(f64::NAN))
        .collect()
}
