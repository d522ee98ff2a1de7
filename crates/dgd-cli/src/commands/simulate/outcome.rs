//! What is told of a simulation.

use crate::args::Simulate;
use crate::say::{self, TextTable, count, counted, number};
use dgd_dynamics::integrate::{Statistics, Status};
use dgd_dynamics::return_line::RiserBounds;
use dgd_replay::{Deviation, DeviationSums, Pair, Replay};
use dgd_units::Legible;
use serde_json::{Value, json};
use std::fmt::Write as _;

/// A run without its series.
#[derive(Default)]
pub(super) struct Outcome {
    from_s: f64,
    to_s: f64,
    samples: usize,
    /// Signals with their names.
    deviations: Vec<(&'static str, DeviationSums)>,
    filled: usize,
    bounds: RiserBounds,
    pub(super) status: Option<Status>,
    statistics: Statistics,
    unsolved: usize,
}

impl Outcome {
    pub(super) fn of(run: &Replay) -> Self {
        let mut outcome = Self::default();
        outcome.add(run);
        outcome
    }

    /// Takes the next rows of a run; its counts are those of the run so far.
    pub(super) fn add(&mut self, part: &Replay) {
        if let (Some(first), Some(last)) = (part.time_s.first(), part.time_s.last()) {
            if self.samples == 0 {
                self.from_s = *first;
            }
            self.to_s = *last;
        }
        self.samples += part.time_s.len();
        let signals = signals(part);
        if self.deviations.is_empty() {
            let none = DeviationSums::default();
            self.deviations = signals.iter().map(|(n, ..)| (*n, none)).collect();
        }
        for ((_, sums), (_, _, pair)) in self.deviations.iter_mut().zip(signals) {
            sums.add(pair);
        }
        (self.filled, self.bounds, self.unsolved) = (part.filled, part.bounds, part.unsolved);
        (self.status, self.statistics) = (part.status, part.statistics);
    }
}

/// Signals with their names and units, measured beside simulated.
pub(super) fn signals(run: &Replay) -> [(&'static str, &'static str, &Pair); 6] {
    [
        ("riser_level_m", "m", &run.level_m),
        ("return_flow_m3_s", "m3/s", &run.return_flow_m3_s),
        ("pump_flow_m3_s", "m3/s", &run.pump_flow_m3_s),
        ("pump_inlet_pressure_pa", "Pa", &run.inlet_pressure_pa),
        ("pump_outlet_pressure_pa", "Pa", &run.outlet_pressure_pa),
        ("pump_head_m", "m", &run.head_m),
    ]
}

pub(super) fn why(status: Status) -> String {
    match status {
        Status::Finished => "it had finished".into(),
        Status::StepTooSmall { t } => format!(
            "at {} s no step meets the tolerance; raise --tolerance",
            number(t)
        ),
        Status::TooManySteps { t } => {
            format!(
                "at {} s the step limit was reached; raise --tolerance",
                number(t)
            )
        }
        Status::NonFinite { t } => format!(
            "at {} s the model gives no finite rate; check model.toml",
            number(t)
        ),
        _ => format!("{status:?}"),
    }
}

/// What went wrong or deserves notice in the run.
fn notes(run: &Outcome) -> Vec<String> {
    let mut notes = Vec::new();
    match run.status {
        None | Some(Status::Finished) => {}
        Some(status) => notes.push(format!("the integration stopped early: {}", why(status))),
    }
    if run.filled > 0 {
        notes.push(format!(
            "{} input values were missing or rejected, and were interpolated",
            count(run.filled)
        ));
    }
    if let Some(at) = run.bounds.full_s {
        notes.push(format!("the simulated riser was full at {} s", number(at)));
    }
    if let Some(at) = run.bounds.empty_s {
        notes.push(format!(
            "the simulated riser was empty down to the pump at {} s",
            number(at)
        ));
    }
    if run.unsolved > 0 {
        notes.push(format!(
            "no steady flow was found at {} samples",
            count(run.unsolved)
        ));
    }
    notes
}

pub(super) fn tell(
    run: &Outcome,
    arguments: &Simulate,
    effects: Option<&[String]>,
    drawn: usize,
) -> String {
    let mut text = String::new();
    let _ = writeln!(
        text,
        "{:?} simulation, {} s to {} s, {} samples",
        arguments.kind,
        number(run.from_s),
        number(run.to_s),
        count(run.samples)
    );
    let s = &run.statistics;
    let _ = match effects {
        Some([]) => writeln!(text, "model of a diagnosis, without effects\n"),
        Some(effects) => writeln!(text, "with {}\n", effects.join(", ")),
        None => writeln!(
            text,
            "{} steps, {} rejected, {} evaluations\n",
            count(s.steps),
            count(s.rejected),
            count(s.rhs)
        ),
    };
    let mut table = TextTable::new([
        "simulated minus measured",
        "root mean square",
        "mean",
        "largest",
        "unit",
    ]);
    for (name, sums) in &run.deviations {
        let Some(Deviation {
            rmse,
            bias,
            largest,
            ..
        }) = sums.deviation()
        else {
            continue;
        };
        let legible = Legible::of(name);
        let Legible { factor, unit, .. } = legible;
        // Below the rotary table, where a system's tanks have heights.
        let depth = if legible.stem == "riser_level" {
            " (depth)"
        } else {
            ""
        };
        table.row([
            legible.words() + depth,
            number(rmse * factor),
            number(bias * factor),
            number(largest * factor),
            unit.into(),
        ]);
    }
    text.push_str(&table.render());
    for note in notes(run) {
        let _ = writeln!(text, "note: {note}");
    }
    let _ = writeln!(text, "\nwrote {}", arguments.out.display());
    if let Some(folder) = &arguments.figures {
        let _ = writeln!(
            text,
            "drew {} into {}",
            counted(drawn / 2, "figure"),
            folder.display()
        );
    }
    text
}

pub(super) fn as_json(
    run: &Outcome,
    arguments: &Simulate,
    drawn: &[std::path::PathBuf],
    seconds: f64,
) -> Value {
    let deviation = |sums: &DeviationSums| {
        sums.deviation().map(|d| json!({ "rmse": d.rmse, "bias": d.bias, "largest": d.largest, "samples": d.samples }))
    };
    let s = &run.statistics;
    json!({
        "schema": "dgd.simulate/1",
        "kind": format!("{:?}", arguments.kind).to_lowercase(),
        "from_s": run.from_s,
        "to_s": run.to_s,
        "samples": run.samples,
        "finished": matches!(run.status, None | Some(Status::Finished)),
        "deviation": run.deviations.iter().map(|(name, sums)| ((*name).to_owned(), json!(deviation(sums)))).collect::<serde_json::Map<_, _>>(),
        "filled": run.filled,
        "notes": notes(run),
        "statistics": { "steps": s.steps, "rejected": s.rejected, "rhs": s.rhs, "jacobians": s.jacobians },
        "out": arguments.out.display().to_string(),
        "figures": say::paths(drawn),
        "seconds": seconds,
    })
}
