//! The page's section on how small an effect is still named, against what any test could do.

use super::charts::words;
use super::detection::{
    GROUPS, Reach, Seen, Source, bins, by_effect, by_group, limit_sigmas, seen, unmeasured,
};
use super::page::{Cell, figure, put, table};
use super::stats::{isotonic, normal_share};
use super::summary::Row;
use super::svg::{Anchor, BLUE, FAINT, GREEN, GRID, INK, RED, Svg};
use super::targets::LIMIT_FACTOR;

/// Nothing, where nothing is measured.
pub(crate) fn section(html: &mut String, rows: &[Row]) {
    let seen = seen(rows);
    if seen.is_empty() {
        return;
    }
    let limit = limit_sigmas();
    figure(
        html,
        "Against the limit of the recording",
        &chart(&seen),
        &format!(
            "Share of single effects named, by their true strength in standard errors that a fit of it has on that very recording. Dots: cases by \
             doubling of their size, with the 95 % interval and the number of cases; lines: the rising curve that fits best; grey and dashed level one, blue level two. \
             Green: a test that knows the effect's form and may raise a false alarm on one clean recording in fifty over the whole catalogue (Neyman and Pearson 1933): it \
             needs z = Φ⁻¹(1 − 0.02/24) = {limit:.2} standard errors for even odds, its curve is Φ(x − z). Red: twice that, the target for even odds. Cases beyond the axis stand \
             at its end."
        ),
    );
    let by_interval = seen.iter().filter(|s| s.source == Source::Interval).count();
    put!(
        html,
        "<p class=\"quiet\">The standard error is the Cramér-Rao bound of the strength beside the base model, as the blind run tells it; for the {by_interval} cases whose \
         strength is no amplitude (delays, time constants, heave) it is the width of the 95 % interval of the fit that knows the truth over 3.92, which is \
         widened for the error of the form. {} single effects are left out: the recording cannot show them, or nothing gives an error.</p>",
        unmeasured(rows)
    );
    let cells: Vec<Vec<Cell>> = by_group(&seen).iter().map(group).collect();
    let head = [
        "effects by where they show",
        "level",
        "named",
        "even odds at, standard errors",
        "over the limit",
        "",
    ];
    table(html, &head, &cells);
    let cells: Vec<Vec<Cell>> = by_effect(&seen).iter().map(effect).collect();
    let head = [
        "effect",
        "level",
        "named",
        "smallest named",
        "in standard errors",
        "largest missed",
        "limit, median",
        "even odds over the limit",
        "",
    ];
    table(html, &head, &cells);
    put!(
        html,
        "<p class=\"quiet\">Strengths in SI; a gain counts from one, an area from what the well description says, a yield stress as the pressure drop in the limit of slow flow, leaks at \
         10 bar. The limit is z standard errors, the median over the recordings of a row. Even odds lie where the rising curve of the row passes one half; ≤ and ≥: below \
         its smallest or above its largest case. With few cases in a row, a single one decides.</p>"
    );
}

fn group(e: &Reach) -> Vec<Cell> {
    vec![
        Cell::Name(e.name.into()),
        Cell::Text(e.level.to_string()),
        Cell::Text(format!("{} of {}", e.named.right, e.named.of)),
        Cell::Number(e.bounded(e.factor() * limit_sigmas())),
        Cell::Number(e.factor_text()),
        target(e),
    ]
}

fn target(e: &Reach) -> Cell {
    let text = match e.within() {
        Some(_) => format!("≤ {LIMIT_FACTOR:.0}"),
        None => "no case near it".into(),
    };
    Cell::Target(e.within(), text)
}

fn effect(e: &Reach) -> Vec<Cell> {
    let sigmas = |s: Option<&Seen>| s.map_or("–".into(), |s| short(s.sigmas()));
    vec![
        Cell::Name(words(e.name)),
        Cell::Text(e.level.to_string()),
        Cell::Text(format!("{} of {}", e.named.right, e.named.of)),
        Cell::Number(e.smallest_named.map_or("–".into(), |s| short(s.strength))),
        Cell::Text(sigmas(e.smallest_named)),
        Cell::Text(sigmas(e.largest_missed)),
        Cell::Number(short(e.limit)),
        Cell::Number(e.factor_text()),
        target(e),
    ]
}

/// Three digits, whatever the size.
fn short(value: f64) -> String {
    if (0.01..1e5).contains(&value.abs()) {
        let digits = (2.0 - value.abs().log10().floor()).max(0.0);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "0 to 4 by the range above"
        )]
        let digits = digits as usize;
        format!("{value:.digits$}")
    } else {
        format!("{value:.2e}")
    }
}

/// One panel a group, both levels in each.
fn chart(seen: &[Seen]) -> String {
    const W: f64 = 400.0;
    const H: f64 = 170.0;
    const ENDS: (f64, f64) = (0.25, 256.0);
    let mut svg = Svg::new(
        2.0 * W,
        2.0 * (H + 78.0),
        "Share of single effects named, against their size in standard errors",
    );
    for (k, group) in GROUPS.iter().enumerate() {
        let left = W * (k % 2) as f64 + 46.0;
        let top = (H + 78.0) * (k / 2) as f64 + 26.0;
        let wide = W - 76.0;
        let x = |sigmas: f64| {
            let share = (sigmas.clamp(ENDS.0, ENDS.1) / ENDS.0).log2() / (ENDS.1 / ENDS.0).log2();
            left + share * wide
        };
        let y = |share: f64| top + (1.0 - share) * H;
        svg.text((left, top - 10.0), Anchor::Start, INK, group);
        for share in [0.0, 0.25, 0.5, 0.75, 1.0] {
            svg.line((left, y(share)), (left + wide, y(share)), GRID, 1.0);
            let label = format!("{:.0} %", 100.0 * share);
            svg.text((left - 5.0, y(share) + 4.0), Anchor::End, FAINT, &label);
        }
        for sigmas in [0.25, 1.0, 4.0, 16.0, 64.0, 256.0] {
            svg.line((x(sigmas), y(0.0)), (x(sigmas), y(0.0) + 4.0), FAINT, 1.0);
            svg.text(
                (x(sigmas), y(0.0) + 16.0),
                Anchor::Middle,
                FAINT,
                &sigmas.to_string(),
            );
        }
        svg.text(
            (left + wide / 2.0, y(0.0) + 32.0),
            Anchor::Middle,
            INK,
            "true strength / standard error",
        );
        let limit = limit_sigmas();
        let ideal: Vec<(f64, f64)> = (0..=80)
            .map(|i| ENDS.0 * (f64::from(i) / 8.0).exp2())
            .map(|s| (x(s), y(normal_share(s - limit))))
            .collect();
        svg.polyline(&ideal, GREEN, "2 3");
        svg.line((x(limit), y(0.0)), (x(limit), y(1.0)), GREEN, 1.2);
        let twice = x(LIMIT_FACTOR * limit);
        svg.line((twice, y(0.0)), (twice, y(1.0)), RED, 1.2);
        for level in [1, 2] {
            let own = || {
                seen.iter()
                    .filter(|s| s.group == *group && s.level == level)
            };
            let (colour, dash, shift) = if level == 1 {
                (FAINT, "6 3", -2.5)
            } else {
                (BLUE, "none", 2.5)
            };
            let points: Vec<(f64, bool)> = own().map(|s| (s.sigmas(), s.named)).collect();
            let curve: Vec<(f64, f64)> = isotonic(&points)
                .iter()
                .filter_map(|s| Some((*s, s.tally.share()?)))
                .flat_map(|(s, share)| [(x(s.from), y(share)), (x(s.to), y(share))])
                .collect();
            svg.polyline(&curve, colour, dash);
            for (sigmas, named) in bins(own()) {
                let (Some(share), Some((low, high))) = (named.share(), named.interval()) else {
                    continue;
                };
                let at = x(sigmas) + shift;
                svg.line((at, y(low)), (at, y(high)), colour, 1.0);
                svg.dot((at, y(share)), 3.2, colour, 1.0);
                let label = named.of.to_string();
                let side = if level == 1 {
                    (at - 5.0, Anchor::End)
                } else {
                    (at + 5.0, Anchor::Start)
                };
                let lift = if share > 0.5 { 13.0 } else { -6.0 };
                svg.text((side.0, y(share) + lift), side.1, colour, &label);
            }
        }
    }
    svg.finish()
}

#[cfg(test)]
mod tests {
    use super::super::detection::tests::influx;
    use super::*;

    #[test]
    fn the_section_holds_curve_limit_and_table_and_stays_away_without_cases() {
        let mut html = String::new();
        section(&mut html, &[influx(8.0, 0.9), influx(2.0, 0.2)]);
        assert!(html.contains("3.14 standard errors"), "{html}");
        assert!(html.contains("influx") && html.contains("1 of 2"));
        // Even odds in the middle of 2 and 8, over 3.14.
        assert!(html.contains("1.27"), "{html}");
        let mut none = String::new();
        section(&mut none, &[]);
        assert_eq!(none, "");
    }

    #[test]
    fn strengths_are_written_with_three_digits() {
        assert_eq!(short(0.0421), "0.0421");
        assert_eq!(short(12.345), "12.3");
        assert_eq!(short(34567.0), "34567");
        assert_eq!(short(2.5e-8), "2.50e-8");
    }
}
