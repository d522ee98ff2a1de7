//! `--profile`: what a recording tells of a parameter while all others make up for it as well as they can.
//!
//! Raue, A. et al., *Bioinformatics* 25 (2009): the profile likelihood; the interval ends where twice the logarithm of the likelihood
//! has fallen by the 95 % point of chi square with one degree of freedom.

use crate::say::{self, TextTable};
use crate::system::measure::Measure;
use crate::system::{bounds, page};
use dgd_assembly::{Assembly, AssemblyError, Fit, FitOptions, Window, fit, profile};
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

/// How the misfit rises as one parameter is held off its best value and the others are fitted again; values in `unit`.
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

/// The parameters that are asked for: those named, or every one if `all` is.
///
/// # Errors
/// [`AssemblyError::Free`] for a path that is none, with the list of those there are.
pub(super) fn paths(assembly: &Assembly, asked: &[String]) -> Result<Vec<String>, AssemblyError> {
    if asked.iter().any(|path| path == ALL) {
        return Ok(assembly.parameters().into_iter().map(|p| p.path).collect());
    }
    for path in asked {
        profile(assembly, &[], &FitOptions::default(), path, &[])?;
    }
    Ok(asked.to_vec())
}

/// Profiles of parameters, around the best fit that is found from `theta`.
pub(super) fn of(
    assembly: &Assembly,
    theta: &[f64],
    train: &[Window],
    paths: &[String],
) -> Result<Vec<Profile>, AssemblyError> {
    if paths.is_empty() {
        return Ok(Vec::new());
    }
    let options = FitOptions {
        start: Some(theta.to_vec()),
        ..FitOptions::default()
    };
    let best = fit(assembly, train, &options)?;
    let parameters = assembly.parameters();
    #[expect(clippy::cast_precision_loss, reason = "sample counts")]
    let free = best.samples.saturating_sub(parameters.len()).max(1) as f64;
    let around = Around {
        assembly,
        train,
        variance: (2.0 * best.cost / free * best.inflation).max(f64::MIN_POSITIVE),
        options: FitOptions {
            start: Some(best.theta.clone()),
            ..options
        },
        best: &best,
    };
    let of_paths = (parameters.iter().enumerate()).filter(|(_, p)| paths.contains(&p.path));
    of_paths
        .map(|(index, p)| around.profile(index, &p.path))
        .collect()
}

/// The best fit, around which parameters are held.
struct Around<'a> {
    assembly: &'a Assembly,
    train: &'a [Window],
    best: &'a Fit,
    /// Of the residual.
    variance: f64,
    /// From the best fit.
    options: FitOptions,
}

/// From which value, by which first step and how far a parameter is moved.
#[derive(Clone, Copy)]
struct Way {
    from: f64,
    step: f64,
    end: f64,
}

impl Around<'_> {
    fn profile(&self, index: usize, path: &str) -> Result<Profile, AssemblyError> {
        let (low, high) = bounds(self.assembly, path);
        let (value, error) = (self.best.theta[index], self.best.standard_error[index]);
        let told = error > 0.0 && error < 0.25 * (high - low);
        let step = if told {
            0.5 * error
        } else {
            0.05 * (high - low)
        };
        let mut points = vec![(value, 0.0)];
        let mut to = |end: f64| {
            let way = Way {
                from: value,
                step,
                end,
            };
            self.end(path, way, &mut points)
        };
        let ends = [to(low)?, to(high)?];
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        let measure = Measure::of(self.assembly.system(), path);
        let shown = |si: f64| measure.shown(si);
        Ok(Profile {
            path: path.to_owned(),
            best: shown(value),
            points: points
                .into_iter()
                .map(|(v, rise)| (shown(v), rise))
                .collect(),
            ends: ends.map(|end| end.map(shown)),
            bounds: measure.ends((low, high)),
            unit: measure.symbol,
        })
    }

    /// Where a parameter leaves its interval on the way to a bound; `None` if it does not.
    fn end(
        &self,
        path: &str,
        way: Way,
        points: &mut Vec<(f64, f64)>,
    ) -> Result<Option<f64>, AssemblyError> {
        let limit = CHI_SQUARE_95.sqrt();
        let mut options = self.options.clone();
        let mut root = |held: f64| -> Result<f64, AssemblyError> {
            let found = profile(self.assembly, self.train, &options, path, &[held])?.pop();
            let root = (found.as_ref()).map_or(f64::INFINITY, |p| self.root(p.cost));
            if root.is_finite() {
                points.push((held, root * root));
            }
            if root < limit {
                options.start = found.map(|p| p.theta);
            }
            Ok(root)
        };
        let mut within = (way.from, 0.0);
        let mut width = way.step;
        for k in 0..POINTS {
            let next = if way.end < way.from {
                (within.0 - width).max(way.end)
            } else {
                (within.0 + width).min(way.end)
            };
            // Even steps around the interval that the curvature tells, wider ones beyond.
            width *= if k < 5 { 1.0 } else { 1.5 };
            if next == within.0 {
                return Ok(None);
            }
            let reached = (next, root(next)?);
            if reached.1 >= limit {
                return between(within, reached, limit, root).map(Some);
            }
            within = reached;
        }
        Ok(None)
    }

    /// Root of the rise of the misfit, in variances of the residual.
    fn root(&self, cost: f64) -> f64 {
        let rise = 2.0 * (cost - self.best.cost) / self.variance;
        rise.max(0.0).sqrt()
    }
}

/// Where the root of the rise comes to its limit between a value within and one beyond, each with its root.
fn between(
    mut within: (f64, f64),
    mut beyond: (f64, f64),
    limit: f64,
    mut root: impl FnMut(f64) -> Result<f64, AssemblyError>,
) -> Result<f64, AssemblyError> {
    // Where another parameter comes to its bound the misfit rises at once.
    for _ in 0..HALVINGS {
        if beyond.1 < 2.0 * limit {
            break;
        }
        let middle = 0.5 * (within.0 + beyond.0);
        let reached = (middle, root(middle)?);
        if reached.1 < limit {
            within = reached;
        } else {
            beyond = reached;
        }
    }
    // Between two points the root is nearly straight.
    let share = (limit - within.1) / (beyond.1 - within.1).max(f64::MIN_POSITIVE);
    Ok(within.0 + share.clamp(0.0, 1.0) * (beyond.0 - within.0))
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
