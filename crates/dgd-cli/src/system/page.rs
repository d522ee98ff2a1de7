//! Parts of the pages on systems: runs beside the recording, residuals, parameters.

use super::measure::Measure;
use super::runs::{self, Run};
use super::{Gauge, bounds, gauges};
use crate::say::{self, brief, count, number};
use dgd_assembly::{Assembly, Identifiability};
use dgd_documents::FittedParameter;
use dgd_report::{
    Axis, Figure, MOST_ROWS, Page, Ranked, ReportError, Residuals, Role, Series, Table, TimePanel,
    WithinBounds, ranking, residual_histogram, series_over, time_series, within_bounds,
};

/// Panels of one figure.
const PANELS: usize = 4;
/// 97.5 % point of the normal distribution.
const TWO_SIDED_95: f64 = 1.959_963_984_540_054;

/// A 95 % interval, as far as the bounds that the value was sought within: no area is below 0.
pub(crate) fn interval(p: &FittedParameter, (low, high): (f64, f64)) -> (f64, f64) {
    let half = TWO_SIDED_95 * p.standard_error;
    ((p.value - half).max(low), (p.value + half).min(high))
}

/// A unit as it is printed: `m³/s` for `m3/s`.
pub(crate) fn typeset(unit: &str) -> String {
    unit.replace("m3", "m³").replace("m2", "m²")
}

/// A fitted parameter and the interval that is told of it.
pub(crate) struct Parameter<'a> {
    pub(crate) fitted: &'a FittedParameter,
    pub(crate) ci95: (f64, f64),
}

/// What is told of a parameter: its value and, where the recording tells it, an interval.
pub(crate) struct Told {
    pub(crate) value: String,
    pub(crate) ends: Option<[String; 2]>,
    /// Why there is no interval.
    pub(crate) note: &'static str,
}

impl Told {
    /// Of a fitted parameter, in the unit that people read it in.
    pub(crate) fn of_fitted(assembly: &Assembly, p: &FittedParameter) -> Self {
        let measure = Measure::of(assembly.system(), &p.path);
        let bounds = bounds(assembly, &p.path);
        let ci95 = measure.ends(interval(p, bounds));
        Self::of(
            measure.shown(p.value),
            p.at_bound,
            ci95,
            measure.ends(bounds),
        )
    }

    /// `bounds` are those that the value was sought within.
    pub(crate) fn of(value: f64, at_bound: bool, ci95: (f64, f64), bounds: (f64, f64)) -> Self {
        let unseen = !(ci95.0 > bounds.0 || ci95.1 < bounds.1);
        let [shown, from, to] = say::with_interval(value, ci95);
        let without = |value: String, note| Self {
            value,
            ends: None,
            note,
        };
        if at_bound {
            without(shown, "on its bound")
        } else if unseen {
            without(brief(value), "not determined by this recording")
        } else {
            Self {
                value: shown,
                ends: Some([from, to]),
                note: "",
            }
        }
    }
}

/// A curve of a run: what it is called, how it is drawn, and its values for an instrument.
struct CurveOf<'a> {
    label: &'static str,
    role: Role,
    values: &'a dyn Fn(&Run, usize) -> Vec<f64>,
}

/// Curves over the windows of a part, parted by a gap that is not drawn.
struct Joined {
    time: Vec<f64>,
    curves: Vec<Vec<f64>>,
}

fn join(runs: &[&Run], output: usize, curves: &[CurveOf<'_>]) -> Joined {
    let mut joined = Joined {
        time: Vec::new(),
        curves: vec![Vec::new(); curves.len()],
    };
    for run in runs {
        // Samples of a static relation may come in any order.
        let mut order: Vec<usize> = (0..run.window.time.len()).collect();
        order.sort_by(|&a, &b| run.window.time[a].total_cmp(&run.window.time[b]));
        let gap = !joined.time.is_empty();
        joined.time.extend(gap.then(|| run.window.time[order[0]]));
        joined
            .time
            .extend(order.iter().map(|&i| run.window.time[i]));
        for (out, curve) in joined.curves.iter_mut().zip(curves) {
            let values = (curve.values)(run, output);
            out.extend(gap.then_some(f64::NAN));
            out.extend(order.iter().map(|&i| values[i]));
        }
    }
    joined
}

/// Label of the independent variable, with its unit, if it is not time.
pub(crate) fn independent(assembly: &Assembly) -> Option<Axis> {
    let name = assembly.system().independent.as_str();
    let mut letters = name.chars();
    let first = letters.next()?.to_uppercase();
    let mut label: String = first.chain(letters).collect();
    if let Some(unit) = &assembly.system().record.unit {
        label.push_str(&format!(" [{unit}]"));
    }
    (name != "time").then(|| Axis::new(label))
}

/// A panel for each of some instruments, with its curves; of readings only where there are any.
fn figure(
    assembly: &Assembly,
    gauges: &[Gauge],
    some: &[usize],
    part: &[&Run],
    curves: &[CurveOf<'_>],
    caption: &str,
) -> Result<Figure, ReportError> {
    let joined: Vec<Joined> = some.iter().map(|&o| join(part, o, curves)).collect();
    let series: Vec<Vec<Series<'_>>> = joined
        .iter()
        .map(|j| {
            let drawn = curves.iter().zip(&j.curves).filter(|(curve, value)| {
                curve.role == Role::Model || value.iter().any(|v| v.is_finite())
            });
            drawn
                .map(|(curve, value)| Series {
                    label: curve.label,
                    role: curve.role,
                    time_s: &j.time,
                    value,
                })
                .collect()
        })
        .collect();
    let panels: Vec<TimePanel<'_>> = some
        .iter()
        .zip(&series)
        .map(|(&o, series)| TimePanel {
            axis: Axis::new(gauges[o].label()),
            title: "",
            series,
        })
        .collect();
    match independent(assembly) {
        Some(axis) => series_over(&axis, &panels, &[], caption),
        None => Ok(time_series(&panels, &[])?.with_caption(caption)),
    }
}

/// Readings beside the simulation, some instruments a figure.
pub(crate) fn beside(
    assembly: &Assembly,
    runs: &[Run],
    held_out: bool,
) -> Result<Vec<Figure>, ReportError> {
    let gauges = gauges(assembly);
    let part: Vec<&Run> = runs.iter().filter(|r| r.held_out == held_out).collect();
    let mut figures = Vec::new();
    if part.is_empty() {
        return Ok(figures);
    }
    let which = if held_out { "held-out" } else { "training" };
    let curves = [
        CurveOf {
            label: "Measured",
            role: Role::Measured,
            values: &|r, o| runs::measured(r, o, &gauges[o]),
        },
        CurveOf {
            label: "Simulated",
            role: Role::Model,
            values: &|r, o| runs::simulated(r, o, &gauges[o]),
        },
    ];
    let all: Vec<usize> = (0..gauges.len()).collect();
    for some in all.chunks(PANELS) {
        let said: Vec<String> = some
            .iter()
            .filter_map(|&o| off(runs, held_out, o, &gauges[o]))
            .collect();
        let caption = format!(
            "Measured and simulated in the {which} part. Root mean square of the difference: {}.",
            if said.is_empty() {
                "nothing was recorded".to_owned()
            } else {
                said.join("; ")
            }
        );
        figures.push(figure(assembly, &gauges, some, &part, &curves, &caption)?);
    }
    Ok(figures)
}

/// `level 0.012 m`, if it was recorded.
pub(crate) fn off(runs: &[Run], held_out: bool, output: usize, gauge: &Gauge) -> Option<String> {
    let (rms, samples) = runs::rms(runs, held_out, output);
    let rms = brief(gauge.difference(rms));
    (samples > 0).then(|| format!("{} {}", gauge.name, gauge.with_unit(&rms)))
}

/// Residuals along the runs and their distribution.
pub(crate) fn residuals(assembly: &Assembly, runs: &[Run]) -> Result<Vec<Figure>, ReportError> {
    let gauges = gauges(assembly);
    let known: Vec<usize> = (0..gauges.len())
        .filter(|&o| runs::recorded(runs, o))
        .collect();
    let of = |r: &Run, o: usize| -> Vec<f64> {
        let residual = runs::residual(r, o).into_iter();
        residual.map(|v| gauges[o].difference(v)).collect()
    };
    let curves = [CurveOf {
        label: "Simulated minus measured",
        role: Role::Model,
        values: &of,
    }];
    let mut figures = Vec::new();
    for (held_out, which) in [(false, "training"), (true, "held-out")] {
        let part: Vec<&Run> = runs.iter().filter(|r| r.held_out == held_out).collect();
        for some in known.chunks(PANELS).filter(|_| !part.is_empty()) {
            let caption = format!("Residuals of the {which} part.");
            figures.push(figure(assembly, &gauges, some, &part, &curves, &caption)?);
        }
    }
    for &o in known.iter().take(PANELS) {
        let values = |held_out: bool| -> Vec<f64> {
            let part = runs.iter().filter(|r| r.held_out == held_out);
            part.flat_map(|r| of(r, o))
                .filter(|v| v.is_finite())
                .collect()
        };
        let (train, test) = (values(false), values(true));
        let mut sets = Vec::new();
        for (label, role, value) in [
            ("Training", Role::Model, &train),
            ("Held out", Role::Before, &test),
        ] {
            if !value.is_empty() {
                sets.push(Residuals { label, role, value });
            }
        }
        let axis = Axis::new(format!("Residual of {}", gauges[o].label()));
        figures.push(residual_histogram(&sets, &axis)?);
    }
    Ok(figures)
}

/// Errors by instrument and part.
pub(crate) fn errors(assembly: &Assembly, runs: &[Run]) -> Table {
    let cells = |o: usize, gauge: &Gauge, held_out: bool| {
        let (rms, samples) = runs::rms(runs, held_out, o);
        if samples == 0 {
            ["—".to_owned(), "0".to_owned()]
        } else {
            [number(gauge.difference(rms)), count(samples)]
        }
    };
    let rows = gauges(assembly).into_iter().enumerate().map(|(o, gauge)| {
        let (train, test) = (cells(o, &gauge, false), cells(o, &gauge, true));
        let mut row = vec![gauge.name.clone(), gauge.symbol.clone()];
        row.extend(train.into_iter().chain(test));
        row
    });
    Table {
        caption: "Root mean square of simulated minus measured".into(),
        head: [
            "Instrument",
            "Unit",
            "Training",
            "Readings",
            "Held out",
            "Readings",
        ]
        .map(Into::into)
        .to_vec(),
        rows: rows.collect(),
    }
}

/// Parameters with their doubt, as a table and drawn between their bounds.
///
/// - `includes`: what their intervals include.
pub(crate) fn parameters(
    page: &mut Page,
    assembly: &Assembly,
    fitted: &[Parameter<'_>],
    includes: &str,
) -> Result<(), ReportError> {
    let known = assembly.parameters();
    let mut rows = Vec::new();
    let mut drawn = Vec::new();
    for Parameter { fitted: p, ci95 } in fitted {
        let Some(bounds) = known.iter().find(|k| k.path == p.path) else {
            continue;
        };
        let measure = Measure::of(assembly.system(), &p.path);
        let (value, ci95) = (measure.shown(p.value), measure.ends(*ci95));
        let bounds = measure.ends((bounds.low, bounds.high));
        let unit = typeset(&measure.symbol);
        let told = Told::of(value, p.at_bound, ci95, bounds);
        let between = told.ends.map(|[from, to]| format!("{from} to {to}"));
        rows.push(vec![
            p.path.clone(),
            told.value,
            between.unwrap_or_else(|| told.note.to_owned()),
            format!("{} to {}", number(bounds.0), number(bounds.1)),
            unit.clone(),
        ]);
        drawn.push(WithinBounds {
            label: p.path.clone(),
            value,
            interval: ci95,
            bounds,
            note: format!("{} {unit}", brief(value)).trim_end().to_owned(),
        });
    }
    page.table(&Table {
        caption: format!("Parameters; intervals include {includes}, and end at the bounds"),
        head: [
            "Parameter",
            "Estimate",
            "95 % interval",
            "Sought within",
            "Unit",
        ]
        .map(Into::into)
        .to_vec(),
        rows,
    });
    // The table has them all.
    if drawn.len() > MOST_ROWS {
        page.note(&format!(
            "Drawn are the first {MOST_ROWS} of the {} parameters.",
            drawn.len()
        ));
        drawn.truncate(MOST_ROWS);
    }
    page.figure(&within_bounds(&drawn)?);
    Ok(())
}

/// What the sensitivities tell of the parameters.
pub(crate) fn identifiable(page: &mut Page, found: &Identifiability) -> Result<(), ReportError> {
    let mut rows: Vec<Ranked> = found
        .parameters
        .iter()
        .zip(&found.importance)
        .map(|(label, value)| Ranked {
            label: label.clone(),
            value: *value,
            note: String::new(),
        })
        .collect();
    let axis = Axis::new("Change of the readings over the range of a parameter [usual sizes]");
    page.paragraph(&rank_sentence(found));
    if rows.len() > MOST_ROWS {
        page.note(&format!(
            "Drawn are the {MOST_ROWS} of the {} parameters that change the readings most.",
            rows.len()
        ));
        rows.sort_by(|a, b| b.value.total_cmp(&a.value));
        rows.truncate(MOST_ROWS);
    }
    page.figure(&ranking(&rows, &axis)?);
    let alike: Vec<String> = found.near_null.iter().map(near_null_sentence).collect();
    if !alike.is_empty() {
        page.paragraph(
            "Combinations (in shares of each range) that change the readings least, weakest first:",
        )
        .list(&alike);
    }
    let pairs: Vec<String> = found
        .pairs
        .iter()
        .map(|(a, b, index)| format!("{a} and {b}: collinearity index {}", brief(*index)))
        .collect();
    if !pairs.is_empty() {
        page.paragraph("Pairs that change the readings in nearly the same way (index above 5):")
            .list(&pairs);
    }
    Ok(())
}

/// `Of 4 parameters only 3 combinations change the readings (collinearity index 12; …).`
pub(crate) fn rank_sentence(found: &Identifiability) -> String {
    let (rank, all) = (found.rank, found.parameters.len());
    let told = match all {
        0 => return "Nothing is free.".into(),
        _ if rank == all => {
            format!("All {all} parameters change the readings, each in its own way")
        }
        _ => format!("Of {all} parameters only {rank} combinations change the readings"),
    };
    let index = found.collinearity;
    let apart = if index.is_finite() && index < 1e6 {
        format!(
            " (collinearity index {}; above 10 to 15 some can substitute for others).",
            brief(index)
        )
    } else {
        ".".to_owned()
    };
    told + &apart
}

/// `not determined: 0.71 a − 0.70 b`
pub(crate) fn near_null_sentence(direction: &dgd_assembly::NearNull) -> String {
    // Where the rank leaves off.
    const NOTHING: f64 = 1e-10;
    let mut text = String::new();
    for (index, (path, share)) in direction.shares.iter().enumerate() {
        let sign = match (index, *share < 0.0) {
            (0, false) => "",
            (0, true) => "−",
            (_, false) => " + ",
            (_, true) => " − ",
        };
        text.push_str(&format!("{sign}{:.2} {path}", share.abs()));
    }
    if direction.relative <= NOTHING {
        format!("not determined: {text}")
    } else {
        let strength = direction.relative.sqrt();
        format!(
            "least determined: {text}, {} times weaker than the strongest",
            brief(1.0 / strength)
        )
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may fail by panic")]
    use super::*;

    const TANK: &str = r#"
connections = ["feed -> tank -> outlet -> atmosphere"]
[components]
feed = { kind = "boundary" }
tank = { kind = "tank" }
outlet = { kind = "orifice", discharge_coefficient = 0.6, area = 1e-4 }
level = { kind = "instrument", measures = "level", of = "tank", channel = "h", unit = "cm" }
[inputs]
"feed.flow" = { channel = "q", unit = "l/min" }
[initial]
"tank.level" = 0.1
[free]
"tank.area" = { start = 0.02, low = 0.01, high = 0.04 }
"#;

    #[test]
    fn more_parameters_than_a_figure_has_rows_are_all_in_the_table() {
        let assembly = Assembly::parse(TANK).unwrap();
        let fitted = FittedParameter {
            path: "tank.area".into(),
            value: 0.02,
            standard_error: 0.001,
            at_bound: false,
        };
        let html = |n: usize| {
            let of = |_| Parameter {
                fitted: &fitted,
                ci95: (0.018, 0.022),
            };
            let fitted: Vec<Parameter<'_>> = (0..n).map(of).collect();
            let mut page = Page::new("A tank", "");
            parameters(&mut page, &assembly, &fitted, "noise").unwrap();
            page.html()
        };
        let rows = |html: &str| html.matches("<td>tank.area</td>").count();
        let (few, many) = (html(MOST_ROWS), html(MOST_ROWS + 10));
        assert_eq!((rows(&few), rows(&many)), (MOST_ROWS, MOST_ROWS + 10));
        let told = "Drawn are the first 200 of the 210 parameters.";
        assert!(many.contains(told) && !few.contains("Drawn are"));
    }

    #[test]
    fn of_more_parameters_than_a_figure_has_rows_those_that_tell_most_are_ranked() {
        let n = MOST_ROWS + 10;
        let found = Identifiability {
            parameters: (0..n).map(|i| format!("p{i}")).collect(),
            importance: (0..n).map(|i| i as f64).collect(),
            gram: Vec::new(),
            eigenvalues: Vec::new(),
            rank: n,
            collinearity: 1.0,
            pairs: Vec::new(),
            near_null: Vec::new(),
        };
        let mut page = Page::new("A tank", "");
        identifiable(&mut page, &found).unwrap();
        let html = page.html();
        assert!(html.contains(">p209<") && html.contains(">p10<") && !html.contains(">p9<"));
        assert!(html.contains("the 200 of the 210 parameters"));
    }

    #[test]
    fn an_interval_ends_at_the_bounds_and_one_beyond_both_tells_nothing() {
        let bounds = (0.0, 0.1);
        let told = |standard_error| {
            let p = FittedParameter {
                path: "upper.area".into(),
                value: 0.0203,
                standard_error,
                at_bound: false,
            };
            Told::of(p.value, p.at_bound, interval(&p, bounds), bounds)
        };
        assert_eq!(told(0.00117).ends, Some(["0.0180".into(), "0.0226".into()]));
        let cut = told(0.0356).ends;
        assert_eq!(cut, Some(["0.000".into(), "0.090".into()]));
        let nothing = told(160.0);
        assert_eq!((nothing.value.as_str(), nothing.ends), ("0.0203", None));
        assert!(nothing.note.contains("not determined"));
        assert_eq!(told(f64::INFINITY).ends, None);
    }
}
