//! Figures without a number in the thesis: stacked time series and a histogram of residuals.

use crate::axis::{Axis, Units, given, robust_range, roomy, short, written};
use crate::color::{Role, SOFT_INK, tone};
use crate::data::{Interval, Series, same_length};
use crate::error::ReportError;
use crate::figure::Figure;
use crate::panel::{Drawn, Key, Line, Panel, Sign, Stack, draw};
use crate::scene::Pen;

const MOST_PANELS: usize = 12;
const MOST_SERIES: usize = 12;
const MOST_INTERVALS: usize = 1000;
/// From here on a clock reads better in hours.
const HOURS_FROM_S: f64 = 3.0 * 3600.0;

/// One panel of a stack that shares its time axis.
#[derive(Debug, Clone, PartialEq)]
pub struct TimePanel<'a> {
    /// Label with unit, and range.
    pub axis: Axis,
    /// Words above the panel; may be empty.
    pub title: &'a str,
    /// Lines, first below; at most 12.
    pub series: &'a [Series<'a>],
}

/// Time series in panels under one another (at most 12), with shaded intervals through all of them.
///
/// Time is labelled in seconds below three hours, in hours from there.
///
/// # Errors
/// [`ReportError::Length`] on unequal slices, [`ReportError::TooMany`] above 12 panels, 12 lines a panel or 1000
/// intervals, [`ReportError::Range`] on an axis range that cannot be drawn.
pub fn time_series(
    panels: &[TimePanel<'_>],
    intervals: &[Interval<'_>],
) -> Result<Figure, ReportError> {
    let names: Vec<String> = panels.iter().map(|p| p.axis.in_sentence()).collect();
    let mut caption = match names.as_slice() {
        [] => "Nothing to show".to_owned(),
        [only] => format!("Time series of {only}"),
        [first @ .., last] => format!("Time series of {} and {last}", first.join(", ")),
    };
    caption.push('.');
    if !intervals.is_empty() {
        caption.push_str(" Shaded: ");
        let mut words: Vec<&str> = intervals
            .iter()
            .map(|i| i.label)
            .filter(|l| !l.is_empty())
            .collect();
        words.dedup();
        words.truncate(4);
        caption.push_str(&if words.is_empty() {
            "marked intervals".to_owned()
        } else {
            words.join(", ")
        });
        caption.push('.');
    }
    let height = match panels.len() {
        0 | 1 => 300.0,
        2 => 190.0,
        3 => 150.0,
        _ => 120.0,
    };
    stacked("", caption, panels, intervals, &vec![height; panels.len()])
}

/// As [`time_series`], over any independent variable: `time_s` of the series then holds its values, which `x` labels.
///
/// # Errors
/// As [`time_series`].
pub fn series_over(
    x: &Axis,
    panels: &[TimePanel<'_>],
    intervals: &[Interval<'_>],
    caption: &str,
) -> Result<Figure, ReportError> {
    let height = match panels.len() {
        0 | 1 => 260.0,
        2 => 180.0,
        3 => 150.0,
        _ => 120.0,
    };
    let heights = vec![height; panels.len()];
    laid_out("", caption.to_owned(), panels, intervals, &heights, Some(x))
}

pub(crate) fn stacked(
    number: &str,
    caption: String,
    panels: &[TimePanel<'_>],
    intervals: &[Interval<'_>],
    heights: &[f64],
) -> Result<Figure, ReportError> {
    laid_out(number, caption, panels, intervals, heights, None)
}

/// `x`: the label of the independent variable, if it is not time in seconds.
fn laid_out(
    number: &str,
    caption: String,
    panels: &[TimePanel<'_>],
    intervals: &[Interval<'_>],
    heights: &[f64],
    x: Option<&Axis>,
) -> Result<Figure, ReportError> {
    at_most("panels", panels.len(), MOST_PANELS)?;
    at_most("intervals", intervals.len(), MOST_INTERVALS)?;
    let mut drawn = Vec::new();
    for (panel, height) in panels.iter().zip(heights) {
        at_most("lines in a panel", panel.series.len(), MOST_SERIES)?;
        let mut out = Panel::new(&panel.axis, *height);
        // A short peak in a series is an event, not an outlier; only a far spike is cut.
        out.tolerance = 4.0;
        out.title = (!panel.title.is_empty()).then(|| panel.title.to_owned());
        for series in panel.series {
            same_length("series.value", series.time_s, series.value)?;
            let pen = Pen {
                color: series.role.color(),
                width: series.role.width(),
                dash: series.role.dash(),
            };
            out.lines.push(Line::new(series.time_s, series.value, pen));
            // Readings with gaps between them all are dots.
            let known = series.value.iter().map(|v| v.is_finite());
            let any = known.clone().any(|known| known);
            let joined = known.clone().zip(known.skip(1)).any(|(a, b)| a && b);
            out.keys.push(Key {
                sign: if any && !joined {
                    Sign::Dot(pen.color)
                } else {
                    Sign::Line(pen)
                },
                text: series.label.to_owned(),
            });
        }
        drawn.push(out);
    }
    if drawn.is_empty() {
        drawn.push(Panel::new(&Axis::new(""), 200.0));
    }
    let times = panels
        .iter()
        .flat_map(|p| p.series)
        .flat_map(|s| s.time_s)
        .copied()
        .filter(|t| t.is_finite());
    let (low, high) = times.fold((f64::MAX, f64::MIN), |(l, h), t| (l.min(t), h.max(t)));
    let hours = x.is_none() && high - low >= HOURS_FROM_S;
    let clock = Axis::new(if hours { "Time [h]" } else { "Time [s]" });
    let mut stack = Stack::new(x.unwrap_or(&clock), drawn);
    stack.units = if hours { Units::Hours } else { Units::Plain };
    stack.tight_x = true;
    stack.shades = intervals
        .iter()
        .filter(|i| i.start_s.is_finite() && i.end_s.is_finite())
        .map(|i| ([i.start_s, i.end_s], i.label.to_owned()))
        .collect();
    Ok(Figure::new(number, caption, draw(&stack)?))
}

fn at_most(what: &'static str, found: usize, most: usize) -> Result<(), ReportError> {
    if found > most {
        Err(ReportError::TooMany { what, found, most })
    } else {
        Ok(())
    }
}

/// Residuals of one model. Values that are not finite are left out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Residuals<'a> {
    /// Words for the legend.
    pub label: &'a str,
    /// [`Role::Before`] and [`Role::Model`] for a before and after.
    pub role: Role,
    /// Measured minus model, in the unit of the axis.
    pub value: &'a [f64],
}

/// Histogram of residuals, one outline for each set (at most 12), as shares of the samples of its set.
///
/// A single set is filled and has the normal curve of the same median and spread beside it: tails that reach beyond
/// it are seen at once. The caption gives median and middle half of each set.
///
/// # Errors
/// [`ReportError::TooMany`] above 12 sets, [`ReportError::Range`] on an axis range that cannot be drawn.
pub fn residual_histogram(sets: &[Residuals<'_>], axis: &Axis) -> Result<Figure, ReportError> {
    at_most("sets", sets.len(), MOST_SERIES)?;
    let values: Vec<Vec<f64>> = sets.iter().map(|s| finite_sorted(s.value)).collect();
    let range = match given(axis)? {
        Some(range) => range,
        None => roomy(robust_range(&mut values.concat(), 1.5)),
    };
    let bins = bin_count(&values, range);
    let outlines: Vec<Curve> = values.iter().map(|v| outline(v, range, bins)).collect();
    let single = (sets.len() == 1)
        .then(|| normal(&values[0], range, bins))
        .flatten();

    let mut panel = Panel::new(&share_axis(outlines.iter().chain(&single)), 320.0);
    let mut caption = format!("Distribution of the {}.", axis.in_sentence());
    for (index, (set, curve)) in sets.iter().zip(&outlines).enumerate() {
        if values[index].is_empty() {
            continue;
        }
        add_outline(&mut panel, set, curve, index == 0);
        caption.push_str(&quartiles(set.label, &values[index]));
    }
    if let Some(curve) = &single {
        add_normal(&mut panel, curve);
    }
    let mut drawn = draw(&Stack::new(
        &axis.clone().within(range[0], range[1]),
        vec![panel],
    ))?;
    mark_zero(&mut drawn, range);
    drawn.outside = values
        .iter()
        .flatten()
        .filter(|v| **v < range[0] || **v > range[1])
        .count();
    drawn.missing = sets.iter().map(|s| s.value.len()).sum::<usize>()
        - values.iter().map(Vec::len).sum::<usize>();
    Ok(Figure::new("", caption, drawn))
}

/// Abscissas and ordinates.
type Curve = [Vec<f64>; 2];

fn finite_sorted(values: &[f64]) -> Vec<f64> {
    let mut finite: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
    finite.sort_unstable_by(f64::total_cmp);
    finite
}

/// From zero to a little above the highest of the curves.
fn share_axis<'a>(curves: impl Iterator<Item = &'a Curve>) -> Axis {
    let top = curves.flat_map(|c| &c[1]).copied().fold(0.0, f64::max);
    let share = Axis::new("Share of the samples [%]");
    if top > 0.0 {
        share.within(0.0, 1.06 * top)
    } else {
        share
    }
}

fn add_outline<'a>(panel: &mut Panel<'a>, set: &Residuals<'_>, [x, y]: &'a Curve, filled: bool) {
    let color = set.role.color();
    if filled {
        let points = x.iter().copied().zip(y.iter().copied());
        panel
            .areas
            .push((points.map(|(x, y)| [x, y]).collect(), tone(color, 0.3)));
    }
    let pen = Pen::new(color, if filled { 1.4 } else { 2.0 });
    panel.lines.push(Line {
        counted: false,
        ..Line::new(x, y, pen)
    });
    let sign = if filled {
        Sign::Box(tone(color, 0.45))
    } else {
        Sign::Line(pen)
    };
    panel.keys.push(Key {
        sign,
        text: set.label.to_owned(),
    });
}

fn add_normal<'a>(panel: &mut Panel<'a>, [x, y]: &'a Curve) {
    let pen = Pen {
        color: SOFT_INK,
        width: 1.5,
        dash: Some([5.0, 3.5]),
    };
    panel.lines.push(Line {
        counted: false,
        ..Line::new(x, y, pen)
    });
    panel.keys.push(Key {
        sign: Sign::Line(pen),
        text: "Normal, same median and spread".to_owned(),
    });
}

/// Median and middle half of a set, in words.
fn quartiles(label: &str, sorted: &[f64]) -> String {
    let [low, median, high] = [0.25, 0.5, 0.75].map(|share| quantile(sorted, share));
    let told = |value: f64| told(value, high - low);
    format!(
        " {label}: median {}, middle half from {} to {}.",
        told(median),
        told(low),
        told(high),
    )
}

/// A line at zero, where zero is inside.
fn mark_zero(drawn: &mut Drawn, [low, high]: [f64; 2]) {
    let frame = drawn.frames.first().copied();
    if let Some(frame) = frame.filter(|_| low < 0.0 && high > 0.0) {
        let x = frame.place(0.0, 0.0)[0];
        drawn.scene.line(
            [x, frame.top],
            [x, frame.bottom()],
            Pen::new(tone(SOFT_INK, 0.7), 1.0),
        );
    }
}

/// Value below which `share` of the sorted values lie; 0 for none.
fn quantile(sorted: &[f64], share: f64) -> f64 {
    let last = sorted.len().saturating_sub(1);
    sorted
        .get(rounded(last as f64 * share).min(last))
        .copied()
        .unwrap_or(0.0)
}

/// A value with the decimals its spread deserves: a hundredth of it.
fn told(value: f64, spread: f64) -> String {
    let decimals = 2.0 - spread.log10().floor();
    if (0.0..8.0).contains(&decimals) {
        written(value, rounded(decimals))
    } else {
        short(value)
    }
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "clamped"
)]
fn rounded(v: f64) -> usize {
    v.round().clamp(0.0, 1e15) as usize
}

/// Freedman and Diaconis on the largest set, kept between 20 and 80.
fn bin_count(sets: &[Vec<f64>], [low, high]: [f64; 2]) -> usize {
    let Some(set) = sets.iter().max_by_key(|s| s.len()) else {
        return 20;
    };
    let spread = quantile(set, 0.75) - quantile(set, 0.25);
    let width = 2.0 * spread / (set.len().max(1) as f64).cbrt();
    if width > 0.0 {
        rounded((high - low) / width).clamp(20, 80)
    } else {
        40
    }
}

/// Steps over the bins, starting and ending at zero.
fn outline(sorted: &[f64], [low, high]: [f64; 2], bins: usize) -> Curve {
    let edge = |bin: usize| low + (high - low) * bin as f64 / bins as f64;
    let total = sorted.len().max(1) as f64;
    let (mut xs, mut ys) = (vec![low], vec![0.0]);
    for bin in 0..bins {
        let (from, to) = (edge(bin), edge(bin + 1));
        // The last bin holds its upper edge.
        let below =
            |v: f64, closed: bool| sorted.partition_point(|&x| if closed { x <= v } else { x < v });
        let held = below(to, bin + 1 == bins) - below(from, false);
        let share = 100.0 * held as f64 / total;
        xs.extend([from, to]);
        ys.extend([share, share]);
    }
    xs.push(high);
    ys.push(0.0);
    [xs, ys]
}

/// The normal curve with the median and the middle half of the values, as a share for each bin.
fn normal(sorted: &[f64], [low, high]: [f64; 2], bins: usize) -> Option<Curve> {
    // The middle half of a normal distribution is 1.349 standard deviations wide.
    let sigma = (quantile(sorted, 0.75) - quantile(sorted, 0.25)) / 1.349;
    let middle = quantile(sorted, 0.5);
    if !(sigma > 0.0 && sigma.is_finite()) {
        return None;
    }
    let bin = (high - low) / bins as f64;
    let x: Vec<f64> = (0..=200)
        .map(|i| low + (high - low) * f64::from(i) / 200.0)
        .collect();
    let density = |x: f64| {
        (-0.5 * ((x - middle) / sigma).powi(2)).exp() / (sigma * std::f64::consts::TAU.sqrt())
    };
    let y = x.iter().map(|&x| 100.0 * bin * density(x)).collect();
    Some([x, y])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bins_hold_every_value_once() {
        let values: Vec<f64> = (0..=1000).map(|i| f64::from(i) / 1000.0).collect();
        let [_, y] = outline(&values, [0.0, 1.0], 25);
        let total: f64 = y[1..y.len() - 1].iter().step_by(2).sum();
        assert!((total - 100.0).abs() < 1e-9, "{total}");
    }

    #[test]
    fn the_normal_curve_has_unit_area() {
        let values: Vec<f64> = (0..=1000).map(|i| f64::from(i) / 1000.0).collect();
        let area =
            normal(&values, [-4.0, 5.0], 50).map(|[_, y]| y.iter().sum::<f64>() * 50.0 / 200.0);
        assert!(area.is_some_and(|a| (a - 100.0).abs() < 0.5));
    }
}
