//! Numbers for people: litres a minute, bar and hours from names that carry SI units.

use crate::axis::written;
use dgd_units::Legible;

/// How a quantity is shown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Unit {
    /// Shown value for one SI unit.
    pub factor: f64,
    /// Symbol; empty for a ratio.
    pub symbol: &'static str,
    /// A moment or a duration that reads better in hours and minutes.
    pub clock: bool,
}

/// Splits a name such as `rate_m3_s` into what it is called and how it is shown.
pub(super) fn split(name: &str) -> (String, Unit) {
    let Legible { stem, factor, unit } = Legible::of(name);
    let symbol = match unit {
        "kg/m3" => "kg/m³",
        "m3" => "m³",
        "m2" => "m²",
        other => other,
    };
    let moment = ["onset", "duration", "lasts", "after", "from", "growth"].contains(&stem);
    let clock = symbol == "s" && moment;
    let unit = Unit {
        factor,
        symbol,
        clock,
    };
    (readable(stem), unit)
}

/// Underscores become spaces, names of Greek letters the letters.
fn readable(stem: &str) -> String {
    stem.replace("delta_", "Δ")
        .split('_')
        .map(|word| match word {
            "tau" => "τ",
            "rho" => "ρ",
            "mu" => "μ",
            "Δrho" => "Δρ",
            "Δp" => "Δp",
            other => other,
        })
        .collect::<Vec<_>>()
        .join(" ")
}

impl Unit {
    fn with_symbol(self, text: String) -> String {
        if self.symbol.is_empty() || text == "–" {
            text
        } else {
            format!("{text}\u{a0}{}", self.symbol)
        }
    }

    /// Two significant digits, for a limit.
    pub(super) fn value(self, si: f64) -> String {
        if self.clock {
            return clock(si);
        }
        self.with_symbol(significant(si * self.factor, 2))
    }

    /// Three digits without the unit, for a column that has it in its head.
    pub(super) fn number(self, si: f64) -> String {
        significant(si * self.factor, 3)
    }

    /// An estimate with as many decimals as its interval bears.
    pub(super) fn estimate(self, si: f64, ci95: (f64, f64)) -> String {
        if self.clock {
            return clock(si);
        }
        let value = si * self.factor;
        let decimals = if ci95.0 == ci95.1 && value.fract() == 0.0 {
            Some(0)
        } else {
            self.decimals(si, ci95)
        };
        self.with_symbol(decimal(value, decimals))
    }

    /// The interval, `114 to 138 L/min`; one of a few values has none.
    pub(super) fn interval(self, si: f64, (low, high): (f64, f64)) -> Option<String> {
        if !(low.is_finite() && high.is_finite()) || low == high {
            return None;
        }
        if self.clock {
            return Some(format!("{} to {}", clock(low), clock(high)));
        }
        let decimals = self.decimals(si, (low, high));
        let [low, high] = [low, high].map(|end| decimal(end * self.factor, decimals));
        Some(self.with_symbol(format!("{low} to {high}")))
    }

    /// One or two digits of the interval's half width.
    fn decimals(self, si: f64, (low, high): (f64, f64)) -> Option<usize> {
        let half = 0.5 * (high - low).abs() * self.factor;
        let value = (si * self.factor).abs();
        if !(half.is_finite() && value.is_finite() && half > 0.0) || half < 1e-5 * value {
            return None;
        }
        // 0.2 is known to 0.01 or so, 0.6 to 0.1.
        let lead = half.log10().floor();
        let wanted = if half < 3.0 * 10f64.powf(lead) {
            1.0
        } else {
            0.0
        } - lead;
        (0_u8..10)
            .find(|&d| f64::from(d) >= wanted)
            .map(usize::from)
    }
}

fn decimal(value: f64, decimals: Option<usize>) -> String {
    match decimals {
        Some(decimals) if value.is_finite() && value.abs() < 1e7 => written(value, decimals),
        _ => significant(value, 3),
    }
}

/// A value with so many significant digits, a dash if it is none.
pub(super) fn significant(value: f64, digits: u8) -> String {
    if !value.is_finite() {
        return "–".to_owned();
    }
    if value == 0.0 {
        return "0".to_owned();
    }
    let lead = value.abs().log10().floor();
    if !(-4.0..7.0).contains(&lead) {
        return crate::axis::short(value);
    }
    let wanted = f64::from(digits) - 1.0 - lead;
    let decimals = (0_u8..10).find(|&d| f64::from(d) >= wanted).unwrap_or(9);
    written(value, usize::from(decimals))
}

/// Natural logarithm of a Bayes factor.
pub(super) fn evidence(value: f64) -> String {
    if value.is_finite() && value.abs() < 1e6 {
        written(value, usize::from(value.abs() < 9.95))
    } else {
        significant(value, 3)
    }
}

/// A share as whole per cent; what is not quite all or nothing is not rounded to it.
pub(super) fn percent(share: f64) -> String {
    let value = 100.0 * share;
    if !value.is_finite() {
        "–".to_owned()
    } else if value > 99.0 && value < 99.95 {
        format!("{value:.1}\u{a0}%")
    } else if (99.95..100.0).contains(&value) {
        ">\u{a0}99.9\u{a0}%".to_owned()
    } else if value > 0.0 && value < 0.1 {
        "<\u{a0}0.1\u{a0}%".to_owned()
    } else if value.abs() < 1.0 && value != 0.0 {
        format!("{}\u{a0}%", written(value, 1))
    } else {
        format!("{}\u{a0}%", written(value.clamp(-9999.0, 9999.0), 0))
    }
}

/// `90 to 95 %`, a dash where an end is none.
pub(super) fn percent_interval((low, high): (f64, f64)) -> String {
    if !(low.is_finite() && high.is_finite()) {
        return "–".to_owned();
    }
    let (low, high) = (percent(low), percent(high));
    format!("{} to {high}", low.trim_end_matches("\u{a0}%"))
}

/// A relative change in per cent, with its sign.
pub(super) fn percent_change(share: f64) -> String {
    let size = percent(share.abs());
    // `< 0.1 %` has no sign.
    match share {
        _ if size.starts_with('<') => size,
        s if s > 0.0 => format!("+{size}"),
        s if s < 0.0 => format!("−{size}"),
        _ => size,
    }
}

/// Both ends of a change.
pub(super) fn percent_changes((low, high): (f64, f64)) -> String {
    if !(low.is_finite() && high.is_finite()) {
        return "–".to_owned();
    }
    format!("{} to {}", percent_change(low), percent_change(high))
}

/// Seconds as people say them: `234 s`, `41 min`, `2 h 51 min`.
pub(super) fn clock(seconds: f64) -> String {
    if !seconds.is_finite() {
        return "–".to_owned();
    }
    let sign = if seconds < 0.0 { "−" } else { "" };
    let s = seconds.abs().min(1e10);
    if s < 600.0 {
        return format!("{sign}{s:.0}\u{a0}s");
    }
    let minutes = (s / 60.0).round();
    let (hours, rest) = ((minutes / 60.0).floor(), minutes % 60.0);
    if hours < 1.0 {
        format!("{sign}{minutes:.0}\u{a0}min")
    } else if rest < 0.5 {
        format!("{sign}{hours:.0}\u{a0}h")
    } else {
        format!("{sign}{hours:.0}\u{a0}h\u{a0}{rest:.0}\u{a0}min")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Spaces that do not break, as plain ones.
    fn plain(text: &str) -> String {
        text.replace('\u{a0}', " ")
    }

    #[test]
    fn a_name_gives_its_words_and_unit() {
        let (name, unit) = split("delta_rho_kg_m3");
        assert_eq!((name.as_str(), unit.symbol), ("Δρ", "kg/m³"));
        let (name, unit) = split("J_m3_s_pa");
        assert_eq!((name.as_str(), unit.symbol), ("J", "L/min/bar"));
        let (name, unit) = split("K");
        assert_eq!((name.as_str(), unit.symbol, unit.factor), ("K", "", 1.0));
        assert!(split("onset_s").1.clock && !split("delay_s").1.clock);
        assert_eq!(split("_s").0, " s");
        let shown = |name: &str, si: f64| plain(&split(name).1.value(si));
        assert_eq!(shown("tau_gel_pa", 5.12), "5.1 Pa");
        assert_eq!(shown("bias_pa", 8830.0), "0.088 bar");
        assert_eq!(shown("head_loss_fraction", 0.0044), "0.44 %");
        assert_eq!(shown("relative_mu_change", 0.095), "9.5 %");
    }

    #[test]
    fn the_interval_decides_how_many_decimals_an_estimate_bears() {
        let flow = split("rate_m3_s").1;
        let ci = (0.0019, 0.0023);
        assert_eq!(plain(&flow.estimate(0.0021, ci)), "126 L/min");
        assert_eq!(
            flow.interval(0.0021, ci).map(|i| plain(&i)).as_deref(),
            Some("114 to 138 L/min")
        );
        assert_eq!(flow.interval(0.0021, (f64::NAN, 1.0)), None);
        let gain = split("gain").1;
        assert_eq!(gain.estimate(0.985_12, (0.982, 0.988)), "0.985");
        let density = split("delta_rho_kg_m3").1;
        assert_eq!(plain(&density.estimate(-41.3, (-60.0, -20.0))), "−41 kg/m³");
    }

    #[test]
    fn one_of_a_few_values_has_no_interval() {
        let choice = split("toward_end").1;
        assert_eq!(choice.estimate(1.0, (1.0, 1.0)), "1");
        assert_eq!(choice.interval(1.0, (1.0, 1.0)), None);
    }

    #[test]
    fn what_is_no_number_is_a_dash() {
        assert_eq!(split("x_pa").1.estimate(f64::NAN, (0.0, 1.0)), "–");
        assert_eq!(percent(f64::INFINITY), "–");
        assert_eq!(clock(f64::NAN), "–");
    }

    #[test]
    fn shares_are_not_rounded_to_certainty() {
        assert_eq!(plain(&percent(0.9996)), "> 99.9 %");
        assert_eq!(plain(&percent(0.994)), "99.4 %");
        assert_eq!(plain(&percent(0.0004)), "< 0.1 %");
        assert_eq!(plain(&percent(1.0)), "100 %");
        assert_eq!(plain(&percent(-0.035)), "−4 %");
        assert_eq!(plain(&percent_interval((0.902, 0.953))), "90 to 95 %");
    }

    #[test]
    fn times_in_words() {
        assert_eq!(plain(&clock(234.0)), "234 s");
        assert_eq!(plain(&clock(10_260.0)), "2 h 51 min");
        assert_eq!(plain(&clock(7199.0)), "2 h");
        assert_eq!(plain(&clock(3000.0)), "50 min");
    }
}
