//! The thesis's figures out of a fit and its simulations.

mod envelope;

pub(crate) use envelope::Envelope;

use crate::commands::fit::Fitted;
use crate::failure::Failure;
use crate::output::{self, Outputs};
use dgd_friction::Polynomial;
use dgd_identify::Series;
use dgd_pump::HeadCurve;
use dgd_replay::{Pair, Replay};
use dgd_report::{
    Axis, Compared, Curve, Figure, ReportError, Role, Scatter, SearchPath, Series as Line,
    SpeedFamily, all_samples, complete_dynamics, delay_sweep, delayed_friction_fit,
    dynamic_and_static, exponent_search, final_friction_fit, final_pump_curves, first_pump_curves,
    friction_fit, kept_samples, return_flow, riser_level,
};
use std::path::{Path, PathBuf};

/// Pixels a unit of the drawing, for the PNG beside each SVG.
const PNG_SCALE: f64 = 2.0;
/// Points of a drawn law.
const CURVE_POINTS: u32 = 200;
/// Samples this near a speed are drawn with its curve, % (section 3.4.1).
const SPEED_TOLERANCE_PCT: f64 = 0.1;
/// Curves of Figures 3.9 and 3.11.
const SPEEDS: usize = 9;

/// Units of a set of figures: what an SI value is multiplied by, and the label.
pub(crate) struct Units {
    flow: (f64, &'static str),
    friction: (f64, &'static str),
    head: (f64, &'static str),
    level: (f64, &'static str),
}

impl Units {
    /// Units of the rig floor.
    pub(crate) fn plain() -> Self {
        Self {
            flow: (6e4, "L/min"),
            friction: (1e-5, "bar"),
            head: (1.0, "m"),
            level: (1.0, "m"),
        }
    }

    /// Percent of the references (Eqs. 3.9-3.12).
    pub(crate) fn percent(references: &dgd_units::MaskReferences) -> Self {
        Self {
            flow: (references.mask_flow(1.0), "%"),
            friction: (references.mask_friction(1.0), "%"),
            head: (references.mask_head(1.0), "%"),
            level: (references.mask_level(1.0), "%"),
        }
    }

    fn axis(name: &str, unit: (f64, &str)) -> Axis {
        Axis::new(format!("{name} [{}]", unit.1))
    }
}

/// Draws Figures 3.2-3.7 and 3.9-3.11 into a folder.
pub(crate) fn draw_identification(
    outputs: &mut Outputs,
    folder: &Path,
    fitted: &Fitted,
) -> Result<Vec<PathBuf>, Failure> {
    let figures = identification(fitted, &Units::plain()).map_err(|e| undrawn(folder, &e))?;
    save(outputs, folder, &figures)
}

/// Draws Figures 4.1-4.4 into a folder; runs are riser, flow, steady, coupled.
pub(crate) fn draw_simulations(
    outputs: &mut Outputs,
    folder: &Path,
    runs: &[Replay; 4],
) -> Result<Vec<PathBuf>, Failure> {
    let figures = simulations(runs, &Units::plain()).map_err(|e| undrawn(folder, &e))?;
    save(outputs, folder, &figures)
}

/// Draws Figure 4.4 of a model that runs level and flow together and nothing else.
pub(crate) fn draw_free_run(
    outputs: &mut Outputs,
    folder: &Path,
    run: &Replay,
) -> Result<Vec<PathBuf>, Failure> {
    let units = Units::plain();
    let level = ScaledPair::of(run, &run.level_m, units.level.0);
    let flow = ScaledPair::of(run, &run.return_flow_m3_s, units.flow.0);
    let figure = complete_dynamics(
        &level.compared(),
        &flow.compared(),
        &Units::axis("Riser level, depth", units.level),
        &Units::axis("Flow", units.flow),
    );
    save(outputs, folder, &[figure.map_err(|e| undrawn(folder, &e))?])
}

/// Refuses early what drawing into the folder would refuse.
pub(crate) fn check(folder: &Path) -> Result<(), Failure> {
    output::check(&folder.join("figure.svg"))
}

fn undrawn(folder: &Path, error: &ReportError) -> Failure {
    Failure::unwritten(folder, error)
}

/// Writes each figure as SVG and PNG, named by its number.
pub(crate) fn save(
    outputs: &mut Outputs,
    folder: &Path,
    figures: &[Figure],
) -> Result<Vec<PathBuf>, Failure> {
    let mut written = Vec::new();
    for figure in figures {
        let stem = format!("figure-{}", figure.number().replace('.', "-"));
        let (svg, png) = (
            folder.join(format!("{stem}.svg")),
            folder.join(format!("{stem}.png")),
        );
        outputs.add_bytes(&svg, figure.svg())?;
        outputs.add_bytes(&png, figure.png(PNG_SCALE).map_err(|e| undrawn(&png, &e))?)?;
        written.extend([svg, png]);
    }
    Ok(written)
}

/// Figures 3.2-3.7 and 3.9-3.11.
pub(crate) fn identification(fitted: &Fitted, units: &Units) -> Result<Vec<Figure>, ReportError> {
    let measured_flow = &fitted.prepared.recording.return_flow_m3_s;
    let kept_q = chosen(measured_flow, &fitted.prepared.keep, units.flow.0);
    let flows = flows_to(largest(&kept_q) / units.flow.0);
    let mut figures = friction(fitted, units, &kept_q, &flows)?;
    figures.extend(pump(fitted, units, flows)?);
    Ok(figures)
}

/// Figures 3.2-3.7: `kept_q` in the figures' unit, `flows` to draw the laws at in m³/s.
fn friction(
    fitted: &Fitted,
    units: &Units,
    kept_q: &[f64],
    flows: &[f64],
) -> Result<Vec<Figure>, ReportError> {
    let id = &fitted.identification;
    let keep = &fitted.prepared.keep;
    let flow_axis = Units::axis("Return flow", units.flow);
    let friction_axis = Units::axis("Frictional loss", units.friction);
    let kept_f = chosen(&id.series.friction_pa, keep, units.friction.0);
    let shifted_q = chosen(&id.pump_flow_m3_s, keep, units.flow.0);
    let kept = Scatter {
        x: kept_q,
        y: &kept_f,
    };
    let shifted = Scatter {
        x: &shifted_q,
        y: &kept_f,
    };
    let mut figures = Vec::new();
    if let Some((Series { friction_pa, .. }, flow)) = &fitted.unscreened {
        // What fills gaps and seams of the even clock was never measured.
        let (all_q, all_f): (Vec<f64>, Vec<f64>) = flow
            .iter()
            .zip(friction_pa)
            .filter(|(q, f)| q.is_finite() || f.is_finite())
            .map(|(q, f)| (q * units.flow.0, f * units.friction.0))
            .unzip();
        let all = Scatter {
            x: &all_q,
            y: &all_f,
        };
        figures.push(all_samples(all, &flow_axis, &friction_axis)?);
        figures.push(kept_samples(all, kept, &flow_axis, &friction_axis)?);
    }
    let drawn_flows = scaled(flows, units.flow.0);
    let values = |law: &Polynomial| -> Vec<f64> {
        flows
            .iter()
            .map(|q| law.eval(*q) * units.friction.0)
            .collect()
    };
    if let Ok(fit) = &id.undelayed {
        let law = values(&fit.law);
        figures.push(friction_fit(
            kept,
            Curve {
                x: &drawn_flows,
                y: &law,
            },
            &flow_axis,
            &friction_axis,
        )?);
    }
    let mse = scaled(&id.sweep.mse_pa2, units.friction.0.powi(2));
    let mse_axis = Axis::new(format!("Mean squared error [{}²]", units.friction.1));
    figures.push(delay_sweep(&id.sweep.delays_s, &mse, &mse_axis)?);
    let delay_s = id.sweep.delays_s[id.sweep.best];
    let law = values(&id.sweep.fit.law);
    figures.push(delayed_friction_fit(
        delay_s,
        shifted,
        Curve {
            x: &drawn_flows,
            y: &law,
        },
        &flow_axis,
        &friction_axis,
    )?);
    if let Ok(fit) = &id.cubic {
        let law = values(&fit.law);
        figures.push(final_friction_fit(
            delay_s,
            shifted,
            Curve {
                x: &drawn_flows,
                y: &law,
            },
            &flow_axis,
            &friction_axis,
        )?);
    }
    Ok(figures)
}

/// Figures 3.9-3.11; `flows` in m³/s where no cloud of samples says how far to draw.
fn pump(fitted: &Fitted, units: &Units, flows: Vec<f64>) -> Result<Vec<Figure>, ReportError> {
    let fits = &fitted.identification.pump;
    let flow_axis = Units::axis("Return flow", units.flow);
    let head_axis = Units::axis("Pump head", units.head);
    let clouds = SpeedClouds::of(fitted, units);
    let flows = clouds.flows_m3_s(units).unwrap_or(flows);
    let drawn_flows = scaled(&flows, units.flow.0);
    let mut figures = Vec::new();
    if let Ok(fit) = &fits.plain {
        let curves = clouds.curves(&fit.curve, &flows, units);
        figures.push(first_pump_curves(
            &clouds.families(&drawn_flows, &curves),
            SPEED_TOLERANCE_PCT,
            &flow_axis,
            &head_axis,
        )?);
    }
    if let Some(Ok(search)) = &fits.search {
        // The first search is the thesis's; its restarts only confirm the end.
        let first: Vec<_> = search.path.iter().filter(|p| p.search == 0).collect();
        let corner = |f: fn(&dgd_pump::PathPoint) -> f64| -> Vec<f64> {
            first.iter().map(|p| f(p)).collect()
        };
        let (n0, n2) = (corner(|p| p.n0), corner(|p| p.n2));
        let cost = scaled(&corner(|p| p.mse_m2), units.head.0.powi(2));
        let path = SearchPath {
            n0: &n0,
            n2: &n2,
            cost: &cost,
        };
        let cost_axis = Axis::new(format!("Mean squared error [{}²]", units.head.1));
        figures.push(exponent_search(&path, None, &cost_axis)?);
        let curves = clouds.curves(&search.fit.curve, &flows, units);
        figures.push(final_pump_curves(
            &clouds.families(&drawn_flows, &curves),
            SPEED_TOLERANCE_PCT,
            &flow_axis,
            &head_axis,
        )?);
    }
    Ok(figures)
}

fn scaled(values: &[f64], scale: f64) -> Vec<f64> {
    values.iter().map(|v| v * scale).collect()
}

/// The kept ones, scaled.
fn chosen(values: &[f64], keep: &[bool], scale: f64) -> Vec<f64> {
    let kept = values.iter().zip(keep).filter(|(_, k)| **k);
    kept.map(|(v, _)| v * scale).collect()
}

fn largest<'a>(values: impl IntoIterator<Item = &'a f64>) -> f64 {
    values.into_iter().copied().fold(0.0, f64::max)
}

/// Flows to draw laws at.
fn flows_to(largest_m3_s: f64) -> Vec<f64> {
    (0..=CURVE_POINTS)
        .map(|i| largest_m3_s * f64::from(i) / f64::from(CURVE_POINTS))
        .collect()
}

/// Samples near each of some evenly spread speeds.
struct SpeedClouds {
    speeds_pct: Vec<f64>,
    flow: Vec<Vec<f64>>,
    head: Vec<Vec<f64>>,
}

impl SpeedClouds {
    fn of(fitted: &Fitted, units: &Units) -> Self {
        let id = &fitted.identification;
        let speed = &fitted.prepared.recording.pump_speed_pct;
        let mut kept = chosen(speed, &id.pump_keep, 1.0);
        kept.sort_by(f64::total_cmp);
        // The outermost hundredths are starts and stops.
        let at = |share: f64| kept.get(index(kept.len(), share)).copied().unwrap_or(0.0);
        let (low, high) = (at(0.01), at(0.99));
        let speeds_pct: Vec<f64> = (0..SPEEDS)
            .map(|i| low + (high - low) * i as f64 / (SPEEDS - 1) as f64)
            .map(|w| (w * 10.0).round() / 10.0)
            .collect();
        let mut clouds = Self {
            flow: vec![Vec::new(); SPEEDS],
            head: vec![Vec::new(); SPEEDS],
            speeds_pct,
        };
        for (i, w) in speed.iter().enumerate().filter(|(i, _)| id.pump_keep[*i]) {
            let near = clouds
                .speeds_pct
                .iter()
                .position(|s| (s - w).abs() <= SPEED_TOLERANCE_PCT + 1e-9);
            if let Some(near) = near {
                clouds.flow[near].push(id.pump_flow_m3_s[i] * units.flow.0);
                clouds.head[near].push(id.series.head_m[i] * units.head.0);
            }
        }
        clouds
    }

    /// Flows to draw the curves at: from none to a little beyond the samples, where the law has been seen to hold.
    fn flows_m3_s(&self, units: &Units) -> Option<Vec<f64>> {
        const BEYOND: f64 = 1.15;
        let largest = largest(self.flow.iter().flatten()) / units.flow.0;
        (largest > 0.0).then(|| flows_to(BEYOND * largest))
    }

    fn curves(&self, curve: &HeadCurve, flows_m3_s: &[f64], units: &Units) -> Vec<Vec<f64>> {
        let at = |w: &f64| {
            flows_m3_s
                .iter()
                .map(|q| curve.head_m(*w, *q) * units.head.0)
                .collect()
        };
        self.speeds_pct.iter().map(at).collect()
    }

    fn families<'a>(&'a self, flows: &'a [f64], curves: &'a [Vec<f64>]) -> Vec<SpeedFamily<'a>> {
        let one = |i: usize| SpeedFamily {
            speed_pct: self.speeds_pct[i],
            samples: Scatter {
                x: &self.flow[i],
                y: &self.head[i],
            },
            model: Curve {
                x: flows,
                y: &curves[i],
            },
        };
        (0..self.speeds_pct.len()).map(one).collect()
    }
}

/// Index of a quantile.
fn index(len: usize, share: f64) -> usize {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a share of a length"
    )]
    let index = (len as f64 * share) as usize;
    index.min(len.saturating_sub(1))
}

/// A pair in the unit of a figure.
struct ScaledPair<'a> {
    time_s: &'a [f64],
    measured: Vec<f64>,
    simulated: Vec<f64>,
}

impl<'a> ScaledPair<'a> {
    fn of(run: &'a Replay, pair: &Pair, scale: f64) -> Self {
        Self {
            time_s: &run.time_s,
            measured: scaled(&pair.measured, scale),
            simulated: scaled(&pair.simulated, scale),
        }
    }

    fn compared(&self) -> Compared<'_> {
        Compared {
            measured: Curve {
                x: self.time_s,
                y: &self.measured,
            },
            simulated: Curve {
                x: self.time_s,
                y: &self.simulated,
            },
        }
    }
}

/// Figures 4.1-4.4; runs are riser, flow, steady, coupled.
pub(crate) fn simulations(runs: &[Replay; 4], units: &Units) -> Result<Vec<Figure>, ReportError> {
    let [riser, flow, steady, coupled] = runs;
    let flow_axis = Units::axis("Flow", units.flow);
    let level_axis = Units::axis("Riser level, depth", units.level);
    let speed_axis = Axis::new("Pump speed [%]");
    let level = ScaledPair::of(riser, &riser.level_m, units.level.0);
    let inflow = scaled(&riser.inflow_m3_s, units.flow.0);
    let outflow = scaled(&riser.pump_flow_m3_s.measured, units.flow.0);
    let line = |label, role, values| Line {
        label,
        role,
        time_s: riser.time_s.as_slice(),
        value: values,
    };
    let inputs = [
        line("Into the riser", Role::Input(0), inflow.as_slice()),
        line("Through the pump", Role::Input(1), outflow.as_slice()),
    ];
    let alone = ScaledPair::of(flow, &flow.pump_flow_m3_s, units.flow.0);
    let at_rest = ScaledPair::of(steady, &steady.pump_flow_m3_s, units.flow.0);
    let coupled_level = ScaledPair::of(coupled, &coupled.level_m, units.level.0);
    let coupled_flow = ScaledPair::of(coupled, &coupled.pump_flow_m3_s, units.flow.0);
    let speed = Curve {
        x: &flow.time_s,
        y: &flow.speed_pct,
    };
    let (dynamic, still) = (alone.compared(), at_rest.compared());
    Ok(vec![
        riser_level(&level.compared(), &inputs, &level_axis, &flow_axis)?,
        return_flow(&dynamic, speed, &flow_axis, &speed_axis)?,
        dynamic_and_static(
            dynamic.measured,
            dynamic.simulated,
            still.simulated,
            &flow_axis,
        )?,
        complete_dynamics(
            &coupled_level.compared(),
            &coupled_flow.compared(),
            &level_axis,
            &flow_axis,
        )?,
    ])
}
