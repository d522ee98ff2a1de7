//! The fit before and after on windows that no fit has seen: small multiples and errors.

use dgd_diagnose::{Diagnosis, Signal, Simulation};

use super::draw::{
    ACTS, TEXT, WIDTH, border, grid, keys, line, pen, range, stretches, time_label, time_units,
};
use super::html::{Cell, Html};
use super::quantity::{clock, percent_change, percent_changes, significant, split};
use super::words::{self, capital, improvement};
use crate::axis::{Scale, Units};
use crate::color::{INK, Role, SOFT_INK, tone};
use crate::panel::Sign;
use crate::scene::{Anchor, Pen, Scene};
use crate::thin::Frame;

const LEFT: f64 = 58.0;
const RIGHT: f64 = WIDTH - 10.0;
const GAP: f64 = 14.0;
const ROW: f64 = 96.0;
const MOST_WINDOWS: usize = 4;
const MOST_SIGNALS: usize = 6;

pub(super) fn write(diagnosis: &Diagnosis, html: &mut Html) {
    let twofold = !diagnosis.findings.is_empty();
    html.paragraph(if twofold {
        "On windows that no fit has used, both models run freely: from the measured state at the start of the window, driven only by the flows \
         into the well and the pump speed set-point."
    } else {
        "On windows that no fit has used, the model runs freely: from the measured state at the start of the window, driven only by the flows into \
         the well and the pump speed set-point."
    });
    let windows = windows(diagnosis);
    if windows.is_empty() || diagnosis.simulation.signals.is_empty() {
        html.small("There is no held-out window to show.");
    } else {
        multiples(diagnosis, &windows, twofold, html);
    }
    errors(diagnosis, twofold, html);
    gains(diagnosis, html);
}

/// Measured: wide and grey, so that a model that fits is seen on it.
fn under() -> Pen {
    Pen::new(tone(Role::Measured.color(), 0.5), 3.4)
}

/// Windows to draw, those in which a finding acts first, spread over the recording.
fn windows(diagnosis: &Diagnosis) -> Vec<(f64, f64)> {
    let sound = diagnosis
        .held_out_s
        .iter()
        .copied()
        .filter(|(from, to)| from.is_finite() && to.is_finite() && to > from);
    let acts = |&(from, to): &(f64, f64)| {
        diagnosis
            .findings
            .iter()
            .flat_map(|f| &f.intervals_s)
            .any(|&(a, b)| a < to && b > from)
    };
    let (touched, other): (Vec<_>, Vec<_>) = sound.partition(acts);
    let mut out = spread(&touched, MOST_WINDOWS);
    out.extend(spread(&other, MOST_WINDOWS - out.len()));
    out.sort_by(|a, b| a.0.total_cmp(&b.0));
    out
}

/// At most `most` of them, evenly by number.
fn spread(all: &[(f64, f64)], most: usize) -> Vec<(f64, f64)> {
    match (all.len(), most) {
        (_, 0) | (0, _) => Vec::new(),
        (n, _) if n <= most => all.to_vec(),
        (n, 1) => vec![all[n / 2]],
        (n, _) => (0..most).map(|i| all[i * (n - 1) / (most - 1)]).collect(),
    }
}

fn multiples(diagnosis: &Diagnosis, windows: &[(f64, f64)], twofold: bool, html: &mut Html) {
    let signals = diagnosis.simulation.signals.iter();
    let signals: Vec<&Signal> = signals.take(MOST_SIGNALS).collect();
    #[expect(clippy::cast_precision_loss, reason = "at most four windows")]
    let columns = windows.len() as f64;
    let (units, label) = time_units(words::span(diagnosis));
    let multiples = Multiples {
        simulation: &diagnosis.simulation,
        windows,
        indices: indices(&diagnosis.simulation, windows),
        spans: acting(diagnosis),
        twofold,
        units,
        width: (RIGHT - LEFT - GAP * (columns - 1.0)) / columns,
    };
    let mut scene = Scene {
        width: WIDTH,
        ..Scene::default()
    };
    let legend = multiples.legend();
    let mut top = keys(&mut scene, LEFT, RIGHT, 4.0, &legend) + 2.0;
    for (row, signal) in signals.iter().enumerate() {
        heading(&mut scene, top, diagnosis, signal, twofold);
        top += 19.0;
        multiples.row(&mut scene, top, signal, row + 1 == signals.len());
        top += ROW + 10.0;
    }
    time_label(&mut scene, LEFT, RIGHT, top + 24.0, label);
    scene.height = (top + 32.0).round();
    html.picture(
        &scene,
        "Free runs on held-out windows",
        &caption(diagnosis, windows, &signals, twofold),
    );
}

/// Panels of one signal a row and one window a column.
struct Multiples<'a> {
    simulation: &'a Simulation,
    windows: &'a [(f64, f64)],
    /// Samples of each window.
    indices: Vec<Vec<usize>>,
    /// Where a finding acts, s.
    spans: Vec<(f64, f64)>,
    twofold: bool,
    units: Units,
    /// Of a panel.
    width: f64,
}

impl Multiples<'_> {
    fn legend(&self) -> Vec<(Sign, &'static str)> {
        let mut legend = vec![(Sign::Line(under()), "Measured")];
        if self.twofold {
            legend.push((Sign::Line(pen(Role::Before)), "Before"));
            legend.push((Sign::Line(pen(Role::Model)), "After"));
        } else {
            legend.push((Sign::Line(pen(Role::Model)), "Model"));
        }
        if !self.spans.is_empty() {
            legend.push((Sign::Box(ACTS), "A finding acts"));
        }
        legend
    }

    fn row(&self, scene: &mut Scene, top: f64, signal: &Signal, last: bool) {
        let factor = split(signal.name).1.factor;
        let y = y_range(signal, &self.indices, self.twofold, factor);
        let y_scale = Scale::new(y, 3.0, Units::Plain);
        let mut left = LEFT;
        for (column, (window, index)) in self.windows.iter().zip(&self.indices).enumerate() {
            let frame = Frame {
                left,
                top,
                width: self.width,
                height: ROW,
                x: [window.0, window.1],
                y,
            };
            let x_scale = Scale::new(frame.x, (self.width / 70.0).max(2.0), self.units);
            stretches(scene, &frame, &self.spans, ACTS);
            grid(scene, &frame, &x_scale, &y_scale);
            self.lines(scene, &frame, signal, index, factor);
            border(scene, &frame, &x_scale, &y_scale, last, column == 0);
            left += self.width + GAP;
        }
    }

    fn lines(
        &self,
        scene: &mut Scene,
        frame: &Frame,
        signal: &Signal,
        index: &[usize],
        factor: f64,
    ) {
        let mut draw = |values: &[f64], role: Role| {
            let points = index
                .iter()
                .filter_map(|&i| Some((*self.simulation.t_s.get(i)?, values.get(i)? * factor)));
            let measured = role == Role::Measured;
            let pen = if measured { under() } else { pen(role) };
            line(scene, frame, points, pen, measured);
        };
        draw(&signal.measured, Role::Measured);
        if self.twofold {
            draw(&signal.before, Role::Before);
        }
        draw(&signal.after, Role::Model);
    }
}

/// Samples of each window.
fn indices(simulation: &Simulation, windows: &[(f64, f64)]) -> Vec<Vec<usize>> {
    windows
        .iter()
        .map(|(from, to)| {
            let inside = |(_, t): &(usize, &f64)| (*from..=*to).contains(*t);
            let times = simulation.t_s.iter().enumerate();
            times.filter(inside).map(|(i, _)| i).collect()
        })
        .collect()
}

/// Where a finding acts. What acts throughout would shade everything and tell nothing.
fn acting(diagnosis: &Diagnosis) -> Vec<(f64, f64)> {
    let (start, end) = words::span(diagnosis);
    diagnosis
        .findings
        .iter()
        .flat_map(|f| f.intervals_s.iter().copied())
        .filter(|(from, to)| to - from < 0.98 * (end - start))
        .collect()
}

fn heading(scene: &mut Scene, top: f64, diagnosis: &Diagnosis, signal: &Signal, twofold: bool) {
    let (name, unit) = split(signal.name);
    let heading = format!("{} [{}]", capital(&name), unit.symbol);
    scene.bold([LEFT, top + 13.0], &heading, 13.0, INK, Anchor::Start);
    let told = told_error(diagnosis, signal, twofold);
    scene.text([RIGHT, top + 13.0], &told, TEXT, SOFT_INK, Anchor::End);
}

fn caption(
    diagnosis: &Diagnosis,
    windows: &[(f64, f64)],
    signals: &[&Signal],
    twofold: bool,
) -> String {
    let shown = windows
        .iter()
        .map(|(from, to)| format!("{} to {}", clock(*from), clock(*to)))
        .collect::<Vec<_>>();
    let all = diagnosis.held_out_s.len();
    let which = if all > windows.len() {
        format!("{} of the {all} held-out windows", windows.len())
    } else {
        "the held-out windows".to_owned()
    };
    let first = if twofold && all > windows.len() {
        " Windows in which a finding acts come first; the errors below are for all windows."
    } else {
        ""
    };
    let depth = if signals.iter().any(|s| s.name == "riser_level_m") {
        " The riser level is a depth below the rotary table, which grows as the riser empties."
    } else {
        ""
    };
    format!(
        "Each column is one of {which} ({}); each row is a signal on one scale. The pale band behind a line spans the measured \
         samples.{depth}{first}",
        words::listed(&shown, "and")
    )
}

/// Range of a signal over the windows shown.
fn y_range(signal: &Signal, indices: &[Vec<usize>], twofold: bool, factor: f64) -> [f64; 2] {
    let mut values = Vec::new();
    for &i in indices.iter().flatten() {
        let before = signal.before.get(i).filter(|_| twofold);
        let three = [signal.measured.get(i), before, signal.after.get(i)];
        values.extend(
            three
                .into_iter()
                .flatten()
                .map(|v| v * factor)
                .filter(|v| v.is_finite()),
        );
    }
    range(&mut values)
}

/// Errors of a signal over the held-out samples that the screening trusts.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Errors {
    before: f64,
    after: f64,
    samples: usize,
    /// Windows in which the error fell or grew by a hundredth or more.
    better: usize,
    worse: usize,
}

fn errors_of(diagnosis: &Diagnosis, signal: &Signal) -> Errors {
    let s = &diagnosis.simulation;
    // Per window: sum of squares before and after, number.
    let mut sums = vec![(0.0, 0.0, 0_usize); diagnosis.held_out_s.len() + 1];
    let mut window = 0;
    for (i, t) in s.t_s.iter().enumerate() {
        let flag = |flags: &[bool]| flags.get(i).copied().unwrap_or(false);
        if !flag(&s.held_out) || !flag(&s.valid) {
            continue;
        }
        let at = |values: &[f64]| values.get(i).copied().unwrap_or(f64::NAN);
        let (y, b, a) = (at(&signal.measured), at(&signal.before), at(&signal.after));
        if !(y.is_finite() && b.is_finite() && a.is_finite()) {
            continue;
        }
        let holds = |w: usize| {
            diagnosis
                .held_out_s
                .get(w)
                .is_some_and(|(from, to)| (*from..=*to).contains(t))
        };
        if !holds(window) {
            // Samples that no window holds are gathered behind the last.
            window = (0..diagnosis.held_out_s.len())
                .find(|&w| holds(w))
                .unwrap_or(diagnosis.held_out_s.len());
        }
        let sum = &mut sums[window];
        *sum = (sum.0 + (b - y).powi(2), sum.1 + (a - y).powi(2), sum.2 + 1);
    }
    let samples: usize = sums.iter().map(|s| s.2).sum();
    #[expect(clippy::cast_precision_loss, reason = "a number of samples")]
    let mean = |total: f64| (total / samples as f64).sqrt();
    let filled = || sums.iter().filter(|s| s.2 > 0);
    Errors {
        before: mean(sums.iter().map(|s| s.0).sum()),
        after: mean(sums.iter().map(|s| s.1).sum()),
        samples,
        better: filled()
            .filter(|s| s.1.sqrt() <= 0.99 * s.0.sqrt() && s.1 < s.0)
            .count(),
        worse: filled()
            .filter(|s| s.0.sqrt() <= 0.99 * s.1.sqrt() && s.0 < s.1)
            .count(),
    }
}

fn told_error(diagnosis: &Diagnosis, signal: &Signal, twofold: bool) -> String {
    let errors = errors_of(diagnosis, signal);
    let factor = split(signal.name).1.factor;
    let [before, after] = [errors.before, errors.after].map(|v| significant(v * factor, 3));
    if errors.samples == 0 {
        "nothing to compare".to_owned()
    } else if twofold {
        format!("RMSE {before} before, {after} after")
    } else {
        format!("RMSE {after}")
    }
}

fn errors(diagnosis: &Diagnosis, twofold: bool, html: &mut Html) {
    let rows: Vec<Vec<Cell>> = diagnosis
        .simulation
        .signals
        .iter()
        .map(|signal| {
            let e = errors_of(diagnosis, signal);
            let (name, unit) = split(signal.name);
            let name = Cell::Named(
                format!("{} [{}]", capital(&name), unit.symbol),
                signal.name.to_owned(),
            );
            let after = Cell::Number(unit.number(e.after));
            let samples = Cell::Number(crate::axis::count(e.samples));
            if !twofold {
                return vec![name, after, samples];
            }
            vec![
                name,
                Cell::Number(unit.number(e.before)),
                after,
                Cell::Number(
                    improvement(e.before, e.after)
                        .map_or_else(|| "–".to_owned(), |s| percent_change(-s)),
                ),
                Cell::Number(format!("{} better, {} worse", e.better, e.worse)),
                samples,
            ]
        })
        .collect();
    if rows.is_empty() {
        return;
    }
    let head: &[&str] = if twofold {
        &[
            "Signal",
            "RMSE before",
            "RMSE after",
            "Change of error",
            "Windows",
            "Samples",
        ]
    } else {
        &["Signal", "RMSE", "Samples"]
    };
    let together = if twofold {
        ", all findings together"
    } else {
        ""
    };
    let caption = format!(
        "Error of the free runs over all held-out windows{together}.{}",
        uncounted(&diagnosis.simulation)
    );
    html.table(&caption, head, &rows, "wide-first");
}

/// What of the held-out windows is drawn and not counted, if anything.
fn uncounted(simulation: &Simulation) -> String {
    let held = simulation.held_out.iter().zip(&simulation.valid);
    let (mut all, mut counted) = (0, 0);
    for (_, valid) in held.filter(|(held, _)| **held) {
        all += 1;
        counted += usize::from(*valid);
    }
    if counted == all {
        return String::new();
    }
    format!(
        " Of their {} samples {} count: the screening rejects the others, which are still drawn.",
        crate::axis::count(all),
        crate::axis::count(counted)
    )
}

/// What the findings bring together, with its interval.
fn gains(diagnosis: &Diagnosis, html: &mut Html) {
    let Some(held) = diagnosis.findings.iter().find_map(|f| f.held_out.as_ref()) else {
        return;
    };
    if !diagnosis.acts_held_out() {
        html.paragraph(
            "No held-out window lies where what was found acts: these windows can neither support nor contradict it.",
        );
        return;
    }
    let (name, unit) = split(&held.signal);
    let improvement = improvement(held.rmse_before, held.rmse_after);
    let row = vec![
        Cell::Text(format!("{} [{}]", capital(&name), unit.symbol)),
        Cell::Number(unit.number(held.rmse_before)),
        Cell::Number(unit.number(held.rmse_after)),
        Cell::Number(improvement.map_or_else(|| "–".to_owned(), |s| percent_change(-s))),
        Cell::Number(percent_changes((
            -held.improvement_ci95.1,
            -held.improvement_ci95.0,
        ))),
    ];
    let several = diagnosis.findings.len() > 1;
    let what = match (held.rmse_after < held.rmse_before, several) {
        (true, true) => "What all findings together improve, on the signal that gains most",
        (true, false) => "What the finding improves, on the signal that gains most",
        (false, true) => "No signal gains with the findings, this one least",
        (false, false) => "No signal gains with the finding, this one least",
    };
    html.table(
        &format!("{what}; the interval is from a paired bootstrap over blocks."),
        &[
            "Signal",
            "RMSE without",
            "RMSE with",
            "Change of error",
            "95 % interval",
        ],
        &[row],
        "wide-first",
    );
}
