//! `--profile`: what a recording tells of a parameter while all others make up for it as well as they can.
//!
//! Raue, A. et al., *Bioinformatics* 25 (2009): the profile likelihood; the interval ends where twice the logarithm of the likelihood
//! has fallen by the 95 % point of chi square with one degree of freedom.

use crate::say::{self, TextTable};
use crate::system::{bounds, page, unit_of};
use dgd_assembly::{Assembly, AssemblyError, FitOptions, Window, fit, profile};
use dgd_report::{Axis, Page, ReportError, Role, Series, Table, TimePanel, series_over};
use serde_json::{Value, json};

/// 95 % point of chi square with one degree of freedom.
const CHI_SQUARE_95: f64 = 3.841_458_820_694_124;
/// Points to either side at most.
const POINTS: usize = 16;
/// Points between the last that the recording allows and the first that it does not.
const HALVINGS: usize = 8;
/// Word that stands for every parameter.
const ALL: &str = "all";

/// How the misfit rises as one parameter is held off its best value and the others are fitted again.
pub(super) struct Profile {
    path: String,
    unit: String,
    /// At the best fit of all.
    best: f64,
    /// Values held, ascending, and the rise in variances of the residual.
    points: Vec<(f64, f64)>,
    /// Ends of the interval; `None` where it is open as far as the bound.
    ends: [Option<f64>; 2],
    bounds: (f64, f64),
}

/// Profiles of the named parameters, of every one if `all` is named.
pub(super) fn of(
    assembly: &Assembly,
    theta: &[f64],
    train: &[Window],
    asked: &[String],
) -> Result<Vec<Profile>, AssemblyError> {
    if asked.is_empty() {
        return Ok(Vec::new());
    }
    let parameters = assembly.parameters();
    let every = asked.iter().any(|path| path == ALL);
    let paths: Vec<String> = if every {
        parameters.iter().map(|p| p.path.clone()).collect()
    } else {
        asked.to_vec()
    };
    let options = FitOptions {
        start: Some(theta.to_vec()),
        ..FitOptions::default()
    };
    let best = fit(assembly, train, &options)?;
    let options = FitOptions {
        start: Some(best.theta.clone()),
        ..options
    };
    #[expect(clippy::cast_precision_loss, reason = "sample counts")]
    let free = best.samples.saturating_sub(parameters.len()).max(1) as f64;
    let variance = (2.0 * best.cost / free * best.inflation).max(f64::MIN_POSITIVE);
    let root = |cost: f64| (2.0 * (cost - best.cost) / variance).max(0.0).sqrt();
    let limit = CHI_SQUARE_95.sqrt();
    let mut all = Vec::new();
    for path in paths {
        let index = parameters.iter().position(|p| p.path == path);
        let (low, high) = bounds(assembly, &path);
        let value = index.map_or(f64::NAN, |i| best.theta[i]);
        let error = index.map_or(f64::NAN, |i| best.standard_error[i]);
        let told = error > 0.0 && error < 0.25 * (high - low);
        let step = if told {
            0.5 * error
        } else {
            0.05 * (high - low)
        };
        let mut points = vec![(value, 0.0)];
        let mut ends = [None; 2];
        for (side, end) in [low, high].into_iter().enumerate() {
            let (mut start, mut held) = (options.clone(), value);
            let mut before = (value, 0.0_f64);
            let mut width = step;
            for k in 0..POINTS {
                let next = if side == 0 {
                    (held - width).max(end)
                } else {
                    (held + width).min(end)
                };
                // Even steps around the interval that the curvature tells, wider ones beyond.
                width *= if k < 5 { 1.0 } else { 1.5 };
                if next == held {
                    break;
                }
                held = next;
                let mut at = |held: f64| -> Result<f64, AssemblyError> {
                    let found = profile(assembly, train, &start, &path, &[held])?.pop();
                    let reached = found.as_ref().map_or(f64::INFINITY, |p| root(p.cost));
                    if reached.is_finite() {
                        points.push((held, reached * reached));
                    }
                    if reached < limit {
                        start.start = found.map(|p| p.theta);
                    }
                    Ok(reached)
                };
                let mut beyond = (held, at(held)?);
                if beyond.1 < limit {
                    before = beyond;
                    continue;
                }
                // Where another parameter comes to its bound the misfit rises at once.
                for _ in 0..HALVINGS {
                    if beyond.1 < 2.0 * limit {
                        break;
                    }
                    let middle = 0.5 * (before.0 + beyond.0);
                    let between = (middle, at(middle)?);
                    if between.1 < limit {
                        before = between;
                    } else {
                        beyond = between;
                    }
                }
                // Between two points the root is nearly straight.
                let share = (limit - before.1) / (beyond.1 - before.1).max(f64::MIN_POSITIVE);
                ends[side] = Some(before.0 + share.clamp(0.0, 1.0) * (beyond.0 - before.0));
                break;
            }
        }
        // A path that is none is refused with the list of those there are.
        if index.is_none() {
            profile(assembly, train, &options, &path, &[])?;
        }
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        all.push(Profile {
            unit: unit_of(assembly.system(), &path),
            path,
            best: value,
            points,
            ends,
            bounds: (low, high),
        });
    }
    Ok(all)
}

impl Profile {
    fn note(&self) -> &'static str {
        match self.ends {
            [Some(_), Some(_)] => "",
            [None, Some(_)] => "open as far as its lower bound",
            [Some(_), None] => "open as far as its upper bound",
            [None, None] => "not determined by this recording",
        }
    }

    /// Best value and the ends, the bounds where it is open.
    fn told(&self) -> [String; 3] {
        let low = self.ends[0].unwrap_or(self.bounds.0);
        let high = self.ends[1].unwrap_or(self.bounds.1);
        say::with_interval(self.best, (low, high))
    }

    fn as_json(&self) -> Value {
        json!({
            "path": self.path,
            "unit": self.unit,
            "best": self.best,
            "ci95": self.ends,
            "points": self.points.iter().map(|(value, rise)| json!({ "value": value, "rise": rise })).collect::<Vec<_>>(),
        })
    }
}

pub(super) fn as_json(profiles: &[Profile]) -> Value {
    profiles.iter().map(Profile::as_json).collect()
}

pub(super) fn tell(profiles: &[Profile]) -> String {
    let mut table = TextTable::new(["profile", "best", "95 % from", "to", "unit", "note"]);
    for p in profiles {
        let [best, from, to] = p.told();
        table.row([
            p.path.clone(),
            best,
            from,
            to,
            p.unit.clone(),
            p.note().into(),
        ]);
    }
    table.render()
}

pub(super) fn draw(page: &mut Page, profiles: &[Profile]) -> Result<(), ReportError> {
    page.section("Profile likelihood").paragraph(
        "One parameter is held and all others are re-fitted. The recording allows the value where the misfit stays below the line; a flat profile \
         means a parameter that the recording does not determine. Unlike the intervals of a fit, these do not assume a linear model. Rise: in \
         variances of the residual, widened for its autocorrelation.",
    );
    let rows = profiles.iter().map(|p| {
        let [best, from, to] = p.told();
        let interval = format!("{from} to {to}");
        let unit = page::typeset(&p.unit);
        vec![p.path.clone(), best, interval, unit, p.note().into()]
    });
    page.table(&Table {
        caption: "Best value and 95 % interval from the profile".into(),
        head: ["Parameter", "Best", "95 % interval", "Unit", ""]
            .map(Into::into)
            .to_vec(),
        rows: rows.collect(),
    });
    for p in profiles {
        let (held, rise): (Vec<f64>, Vec<f64>) = p.points.iter().copied().unzip();
        let limit = vec![CHI_SQUARE_95; held.len()];
        let series = [
            ("profile", Role::Model, &rise),
            ("95 %", Role::Measured, &limit),
        ]
        .map(|(label, role, value)| Series {
            label,
            role,
            time_s: &held,
            value,
        });
        let panel = [TimePanel {
            axis: Axis::new("Rise of the misfit"),
            title: "",
            series: &series,
        }];
        let unit = page::typeset(&p.unit);
        let x = if unit.is_empty() {
            p.path.clone()
        } else {
            format!("{} [{unit}]", p.path)
        };
        let caption = format!("Profile of {}.", p.path);
        page.figure(&series_over(&Axis::new(x), &panel, &[], &caption)?);
    }
    Ok(())
}
