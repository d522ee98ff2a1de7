//! Axis ranges that outliers cannot stretch, and ticks on round numbers.

use crate::error::ReportError;

/// What an axis shows: its label with the unit, and its range if the data should not choose it.
///
/// The label is all that ties a figure to a unit, so the same function draws SI and masked percent:
/// `Axis::new("Return flow [%]")` or `Axis::new("Return flow [m³/s]")`.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// Quantity and unit, as `Quantity [unit]`.
    pub label: String,
    /// Lower and upper end. `None`: the data's own range without far outliers.
    pub range: Option<[f64; 2]>,
}

impl Axis {
    /// An axis whose range the data choose.
    pub fn new(label: impl Into<String>) -> Self {
        Self {
            label: label.into(),
            range: None,
        }
    }

    /// The same axis with a fixed range.
    #[must_use]
    pub fn within(mut self, low: f64, high: f64) -> Self {
        self.range = Some([low, high]);
        self
    }

    /// The label as the middle of a sentence.
    pub(crate) fn in_sentence(&self) -> String {
        let mut letters = self.label.chars();
        match (letters.next(), letters.clone().next()) {
            // "MSE [-]" stays as it is.
            (Some(first), Some(second)) if !second.is_uppercase() => {
                first.to_lowercase().chain(letters).collect()
            }
            _ => self.label.clone(),
        }
    }
}

/// How the numbers of an axis are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Units {
    Plain,
    /// Values in seconds, written in hours.
    Hours,
}

/// An axis ready to be drawn.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Scale {
    pub low: f64,
    pub high: f64,
    /// Value and text of each tick.
    pub ticks: Vec<(f64, String)>,
    /// A power of ten taken out of all tick texts, like `×10⁶`.
    pub factor: Option<String>,
}

/// No axis reaches further.
const LARGEST: f64 = 1e300;

/// Range of the finite values without far outliers; `None` if there are none.
///
/// The central 99.8 % of the values rule, unless the full range is at most `tolerance` times as wide: then nothing
/// is cut. Fewer than 500 values are never cut.
pub(crate) fn robust_range(values: &mut [f64], tolerance: f64) -> Option<[f64; 2]> {
    let low = values.iter().copied().min_by(f64::total_cmp)?;
    let high = values.iter().copied().max_by(f64::total_cmp)?;
    let n = values.len();
    if n < 500 {
        return Some([low, high]);
    }
    let mut quantile = |cut: usize| *values.select_nth_unstable_by(cut, f64::total_cmp).1;
    let core = [quantile(n / 1000), quantile(n - 1 - n / 1000)];
    let span = core[1] - core[0];
    if span <= 0.0 || high - low <= tolerance * span {
        return Some([low, high]);
    }
    Some([
        low.max(core[0] - 0.1 * span),
        high.min(core[1] + 0.1 * span),
    ])
}

/// The range drawn for data that reach from `low` to `high`: a small margin, and zero if it is near.
pub(crate) fn roomy(range: Option<[f64; 2]>) -> [f64; 2] {
    let Some([low, high]) = range else {
        return [0.0, 1.0];
    };
    // Ends near the largest number would overflow their difference.
    let [mut low, mut high] = [low, high].map(|end| end.clamp(-LARGEST, LARGEST));
    if low > 0.0 && low < 0.2 * high {
        low = 0.0;
    }
    if high < 0.0 && high > 0.2 * low {
        high = 0.0;
    }
    let size = low.abs().max(high.abs());
    // What is next to nothing is drawn as nothing; its products would vanish.
    let some = size > 1e-290;
    // A constant still needs an axis around it.
    if high - low < if some { 1e-6 * size } else { 1.0 } {
        let half = if some { 0.05 * size } else { 1.0 };
        return [low - half, high + half];
    }
    let margin = 0.035 * (high - low);
    [low - margin, high + margin]
}

/// A time range whose ends lie a hair from a tick is drawn to the tick: 14,000 to 19,999 s shows 20,000.
pub(crate) fn to_ticks([low, high]: [f64; 2], wanted: f64, units: Units) -> [f64; 2] {
    let unit = if units == Units::Hours { 3600.0 } else { 1.0 };
    let step = unit * nice_step((high - low) / unit / wanted.max(1.0), units);
    let near = 0.005 * (high - low);
    let (below, above) = ((low / step).floor() * step, (high / step).ceil() * step);
    [
        if low - below < near { below } else { low },
        if above - high < near { above } else { high },
    ]
}

/// Checks a range the caller gave.
pub(crate) fn given(axis: &Axis) -> Result<Option<[f64; 2]>, ReportError> {
    match axis.range {
        Some([low, high])
            if !(low.is_finite() && high.is_finite() && high > low && (high - low).is_finite()) =>
        {
            Err(ReportError::Range {
                label: axis.label.clone(),
                low,
                high,
            })
        }
        other => Ok(other),
    }
}

impl Scale {
    /// A frame around nothing: no ticks.
    pub(crate) fn blank(range: [f64; 2]) -> Self {
        Self {
            low: range[0],
            high: range[1],
            ticks: Vec::new(),
            factor: None,
        }
    }

    /// About `wanted` ticks from `low` to `high`.
    pub(crate) fn new([low, high]: [f64; 2], wanted: f64, units: Units) -> Self {
        let unit = if units == Units::Hours { 3600.0 } else { 1.0 };
        let (from, to) = (low / unit, high / unit);
        let step = nice_step((to - from) / wanted.max(1.0), units);
        let size = from.abs().max(to.abs());
        let exponent = if size >= 1e5 || (size < 1e-2 && size > 0.0) {
            3.0 * (size.log10() / 3.0).floor()
        } else {
            0.0
        };
        let scale = 10f64.powf(exponent);
        let decimals = decimals_of(step / scale);
        let first = (from / step).ceil();
        let ticks = (0..60)
            .map(|i| (first + f64::from(i)) * step)
            .take_while(|&value| value <= to + 1e-9 * step)
            .map(|value| (value * unit, written(value / scale, decimals)))
            .collect();
        let factor = (exponent != 0.0).then(|| format!("×10{}", raised(exponent)));
        Self {
            low,
            high,
            ticks,
            factor,
        }
    }
}

fn nice_step(raw: f64, units: Units) -> f64 {
    if !(raw.is_finite() && raw > 0.0) {
        return 1.0;
    }
    let hours = [3.0, 6.0, 12.0, 24.0, 48.0];
    if units == Units::Hours
        && raw > 2.4
        && let Some(&step) = hours.iter().find(|&&step| raw < 1.4 * step)
    {
        return step;
    }
    let power = 10f64.powf(raw.log10().floor());
    let lead = raw / power;
    // The nearest, so that the count stays within a factor 1.6 of what was wanted.
    let nice = [(1.5, 1.0), (3.2, 2.0), (7.5, 5.0)]
        .into_iter()
        .find(|(below, _)| lead < *below)
        .map_or(10.0, |n| n.1);
    nice * power
}

fn decimals_of(step: f64) -> usize {
    (0..9)
        .find(|&d| {
            let scaled = step * 10f64.powi(d);
            (scaled - scaled.round()).abs() < 1e-6 * scaled
        })
        .and_then(|d| usize::try_from(d).ok())
        .unwrap_or(9)
}

/// A number with a true minus sign.
pub(crate) fn written(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    if text
        .trim_start_matches('-')
        .chars()
        .all(|c| matches!(c, '0' | '.'))
    {
        return text.trim_start_matches('-').to_owned();
    }
    text.replace('-', "−")
}

/// Four significant digits, for a number in a label or caption.
pub(crate) fn short(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return written(value, 0);
    }
    let lead = value.abs().log10().floor();
    if !(-4.0..6.0).contains(&lead) {
        return format!(
            "{}·10{}",
            written(value / 10f64.powf(lead), 2),
            raised(lead)
        );
    }
    let decimals = (0..8).find(|&d| f64::from(d) >= 3.0 - lead).unwrap_or(8);
    let text = written(value, usize::try_from(decimals).unwrap_or(0));
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

fn raised(exponent: f64) -> String {
    format!("{exponent:.0}")
        .chars()
        .map(|c| match c {
            '-' => '⁻',
            '1' => '¹',
            '2' => '²',
            '3' => '³',
            '0' => '⁰',
            other => {
                char::from_u32(u32::from(other) - u32::from('4') + u32::from('⁴')).unwrap_or(other)
            }
        })
        .collect()
}

/// A count in groups of three.
pub(crate) fn count(n: usize) -> String {
    let digits = n.to_string();
    let mut out = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            out.push(',');
        }
        out.push(digit);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(low: f64, high: f64) -> Vec<String> {
        Scale::new([low, high], 6.0, Units::Plain)
            .ticks
            .into_iter()
            .map(|t| t.1)
            .collect()
    }

    #[test]
    fn ticks_are_round_and_inside() {
        assert_eq!(texts(-3.0, 113.0), ["0", "20", "40", "60", "80", "100"]);
        assert_eq!(texts(0.0, 1.0), ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        assert_eq!(texts(-1.0, 1.0), ["−1.0", "−0.5", "0.0", "0.5", "1.0"]);
        assert_eq!(
            texts(14_000.0, 20_000.0),
            [
                "14000", "15000", "16000", "17000", "18000", "19000", "20000"
            ]
        );
    }

    #[test]
    fn large_and_small_values_share_a_power_of_ten() {
        let scale = Scale::new([0.0, 3.0e6], 6.0, Units::Plain);
        assert_eq!(scale.factor.as_deref(), Some("×10⁶"));
        assert_eq!(scale.ticks[1], (5.0e5, "0.5".to_owned()));
        assert_eq!(
            Scale::new([0.0, 4e-5], 6.0, Units::Plain).factor.as_deref(),
            Some("×10⁻⁶")
        );
    }

    #[test]
    fn long_times_are_written_in_hours() {
        let scale = Scale::new([0.0, 85.0 * 3600.0], 7.0, Units::Hours);
        assert_eq!(scale.ticks[1], (12.0 * 3600.0, "12".to_owned()));
    }

    #[test]
    fn far_outliers_do_not_stretch_the_range() {
        let mut values: Vec<f64> = (0..10_000).map(|i| f64::from(i) / 100.0).collect();
        values.extend([1e6, -1e6]);
        let range = robust_range(&mut values, 1.3).map(|[a, b]| a > -15.0 && b < 115.0);
        assert_eq!(range, Some(true));
        assert_eq!(robust_range(&mut [1.0, 1e9], 1.3), Some([1.0, 1e9]));
        assert_eq!(robust_range(&mut [], 1.3), None);
    }

    #[test]
    fn a_constant_gets_an_axis_around_it() {
        assert_eq!(roomy(Some([0.0, 0.0])), [-1.0, 1.0]);
        let [low, high] = roomy(Some([5.0, 5.0]));
        assert!(low < 5.0 && high > 5.0);
    }

    #[test]
    fn no_range_makes_endless_ticks() {
        for range in [
            roomy(Some([f64::MIN, f64::MAX])),
            [1e15, 1e15 + 1.0],
            [0.0, 5e-324],
            [0.0, f64::MIN_POSITIVE],
        ] {
            let scale = Scale::new(range, 6.0, Units::Plain);
            assert!(scale.ticks.len() <= 60 && (scale.high - scale.low).is_finite());
        }
    }

    #[test]
    fn numbers_in_words() {
        assert_eq!(short(14.7912), "14.79");
        assert_eq!(short(13.0), "13");
        assert_eq!(short(0.071), "0.071");
        assert_eq!(short(-2.5e9), "−2.50·10⁹");
        assert_eq!(count(305_820), "305,820");
        assert_eq!(count(12), "12");
    }
}
