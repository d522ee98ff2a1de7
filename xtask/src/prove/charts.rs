//! The pictures of the proof.

use super::answer::EFFECTS;
use super::stats::Tally;
use super::summary::{NOTHING, Named, Row, SIGNAL_TITLES, Summary, confusion};
use super::svg::{Anchor, BLUE, FAINT, GREEN, GRID, INK, RED, Svg, shade};
use super::targets;
use super::truth::{SEVERITIES, SIZES};

const BLUE_RGB: [u8; 3] = [0x1f, 0x6f, 0xb2];
const RED_RGB: [u8; 3] = [0xb8, 0x44, 0x2a];

/// Readable name of an effect.
pub(crate) fn words(id: &str) -> String {
    id.replace('_', " ")
}

/// Share named against severity, one panel a level.
pub(crate) fn detection(levels: &[Summary]) -> String {
    const W: f64 = 350.0;
    const H: f64 = 210.0;
    let mut svg = Svg::new(
        W * levels.len() as f64,
        H + 70.0,
        "Share of single effects named, against severity",
    );
    for (k, summary) in levels.iter().enumerate() {
        let left = W * k as f64 + 46.0;
        let x = |size: f64| {
            left + (size / SIZES[0]).log10() / (SIZES[4] / SIZES[0]).log10() * (W - 76.0) + 8.0
        };
        let y = |share: f64| 28.0 + (1.0 - share) * H;
        svg.text(
            (left, 16.0),
            Anchor::Start,
            INK,
            &format!("level {}", summary.level),
        );
        for share in [0.0, 0.25, 0.5, 0.75, 1.0] {
            svg.line((left, y(share)), (left + W - 60.0, y(share)), GRID, 1.0);
            let label = format!("{:.0} %", 100.0 * share);
            svg.text((left - 5.0, y(share) + 4.0), Anchor::End, FAINT, &label);
        }
        for (severity, size) in SEVERITIES.iter().zip(SIZES) {
            svg.text((x(size), H + 44.0), Anchor::Middle, INK, severity);
            svg.text(
                (x(size), H + 58.0),
                Anchor::Middle,
                FAINT,
                &format!("× {size}"),
            );
        }
        targets_of(&mut svg, summary.level, &x, &y);
        let line = |pick: fn(&Named) -> Tally| -> Vec<(f64, f64)> {
            let shares = summary.by_severity.iter().map(|n| pick(n).share());
            shares
                .zip(SIZES)
                .filter_map(|(share, size)| Some((x(size), y(share?))))
                .collect()
        };
        svg.polyline(&line(|n| n.within), GREEN, "2 3");
        svg.polyline(&line(|n| n.hit), FAINT, "6 3");
        svg.polyline(&line(|n| n.exact), BLUE, "none");
        for (named, size) in summary.by_severity.iter().zip(SIZES) {
            let (Some(share), Some((low, high))) = (named.exact.share(), named.exact.interval())
            else {
                continue;
            };
            svg.line((x(size), y(low)), (x(size), y(high)), BLUE, 1.2);
            svg.dot((x(size), y(share)), 3.4, BLUE, 1.0);
        }
    }
    svg.finish()
}

/// Targets by severity, as short strokes.
fn targets_of(svg: &mut Svg, level: u8, x: &impl Fn(f64) -> f64, y: &impl Fn(f64) -> f64) {
    let all = SEVERITIES.iter().zip(SIZES);
    for (severity, size) in all {
        if let Some(target) = super::measures::named_target(level, severity) {
            let at = y(target);
            svg.line((x(size) - 13.0, at), (x(size) + 13.0, at), RED, 2.0);
        }
    }
}

/// Effect by severity, exact of so many, one block a level.
pub(crate) fn heat(levels: &[Summary]) -> String {
    const CELL: (f64, f64) = (50.0, 19.0);
    const LEFT: f64 = 175.0;
    let block = CELL.0 * 5.0 + 26.0;
    let names = &EFFECTS[..24];
    let mut svg = Svg::new(
        LEFT + block * levels.len() as f64,
        48.0 + CELL.1 * names.len() as f64 + 6.0,
        "Single effects named exactly, by effect and severity",
    );
    for (row, name) in names.iter().enumerate() {
        let y = 44.0 + CELL.1 * row as f64;
        svg.text((LEFT - 8.0, y + 13.5), Anchor::End, INK, &words(name));
    }
    for (k, summary) in levels.iter().enumerate() {
        let left = LEFT + block * k as f64;
        svg.text(
            (left, 14.0),
            Anchor::Start,
            INK,
            &format!("level {}", summary.level),
        );
        for (column, severity) in SEVERITIES.iter().enumerate() {
            let x = left + CELL.0 * column as f64;
            svg.text((x + CELL.0 / 2.0, 34.0), Anchor::Middle, FAINT, severity);
            for (row, name) in names.iter().enumerate() {
                let y = 44.0 + CELL.1 * row as f64;
                let key = ((*name).to_owned(), column);
                let named = summary.by_both.get(&key).copied().unwrap_or_default();
                cell(&mut svg, (x, y), CELL, named);
            }
        }
    }
    svg.finish()
}

fn cell(svg: &mut Svg, (x, y): (f64, f64), (w, h): (f64, f64), named: Named) {
    let middle = (x + w / 2.0, y + h - 5.5);
    let Some(share) = named.exact.share() else {
        svg.rect((x + 1.0, y + 1.0), (w - 2.0, h - 2.0), "#f5f7f9");
        return;
    };
    // White and a red edge would read as empty; a miss is a pale red.
    let fill = if share > 0.0 {
        shade(BLUE_RGB, 0.15 + 0.75 * share)
    } else {
        shade(RED_RGB, 0.22)
    };
    svg.rect((x + 1.0, y + 1.0), (w - 2.0, h - 2.0), &fill);
    let ink = if share > 0.55 { "#ffffff" } else { INK };
    let text = format!("{}/{}", named.exact.right, named.exact.of);
    svg.text(middle, Anchor::Middle, ink, &text);
}

/// What was concealed, down, against what was said, across; all levels together.
pub(crate) fn matrix(rows: &[Row]) -> String {
    const CELL: f64 = 20.0;
    const LEFT: f64 = 175.0;
    const TOP: f64 = 150.0;
    let mut names: Vec<&str> = EFFECTS.to_vec();
    names.push(NOTHING);
    let counts = confusion(rows);
    let totals = |name: &str| {
        let sorts = rows.iter().filter(|r| r.answer.is_some());
        sorts
            .filter(|r| r.sort() != super::truth::Sort::Pair)
            .filter(|r| r.truth.names().next().unwrap_or(NOTHING) == name)
            .count()
    };
    let size = CELL * names.len() as f64;
    let mut svg = Svg::new(
        LEFT + size + 46.0,
        TOP + size + 8.0,
        "Confusion matrix: effect concealed by effect named",
    );
    svg.text(
        (LEFT - 8.0, TOP - 8.0),
        Anchor::End,
        FAINT,
        "concealed ↓   said →",
    );
    svg.text(
        (LEFT + size + 24.0, TOP - 8.0),
        Anchor::Middle,
        FAINT,
        "cases",
    );
    for (i, name) in names.iter().enumerate() {
        let at = CELL * i as f64;
        let said = if *name == NOTHING {
            "nothing found"
        } else {
            name
        };
        let concealed = match *name {
            NOTHING => "nothing (clean)",
            "unknown" => "outside the catalogue",
            other => other,
        };
        svg.text(
            (LEFT - 8.0, TOP + at + 14.0),
            Anchor::End,
            INK,
            &words(concealed),
        );
        svg.turned(
            (LEFT + at + 13.5, TOP - 6.0),
            -60.0,
            Anchor::Start,
            INK,
            &words(said),
        );
        svg.line((LEFT, TOP + at), (LEFT + size, TOP + at), GRID, 0.6);
        svg.line((LEFT + at, TOP), (LEFT + at, TOP + size), GRID, 0.6);
        let total = totals(name);
        svg.text(
            (LEFT + size + 24.0, TOP + at + 14.0),
            Anchor::Middle,
            FAINT,
            &total.to_string(),
        );
        for (j, claim) in names.iter().enumerate() {
            let key = ((*name).to_owned(), (*claim).to_owned());
            let Some(count) = counts.get(&key) else {
                continue;
            };
            let (x, y) = (LEFT + CELL * j as f64, TOP + at);
            let share = *count as f64 / total.max(1) as f64;
            let full = if i == j { BLUE_RGB } else { RED_RGB };
            // Silence about what is there is a lesser fault than a wrong name.
            let full = if i != j && *claim == NOTHING {
                [0x87, 0x94, 0xa1]
            } else {
                full
            };
            let square = (CELL - 1.0, CELL - 1.0);
            svg.rect((x + 0.5, y + 0.5), square, &shade(full, 0.2 + 0.8 * share));
            let ink = if share > 0.45 { "#ffffff" } else { INK };
            svg.text(
                (x + CELL / 2.0, y + 14.0),
                Anchor::Middle,
                ink,
                &count.to_string(),
            );
        }
    }
    svg.finish()
}

/// Share right against probability stated, one panel a level.
pub(crate) fn reliability(levels: &[Summary]) -> String {
    const W: f64 = 330.0;
    const SIDE: f64 = 230.0;
    let mut svg = Svg::new(
        W * levels.len() as f64,
        SIDE + 72.0,
        "Calibration: share of findings right, against their probability",
    );
    for (k, summary) in levels.iter().enumerate() {
        let left = W * k as f64 + 50.0;
        let x = |p: f64| left + p * SIDE;
        let y = |p: f64| 28.0 + (1.0 - p) * SIDE;
        svg.text(
            (left, 16.0),
            Anchor::Start,
            INK,
            &format!("level {}", summary.level),
        );
        svg.reliability_frame(x, y);
        svg.turned(
            (left - 36.0, y(0.5)),
            -90.0,
            Anchor::Middle,
            INK,
            "share right",
        );
        let bins = summary.reliability();
        let points: Vec<_> = bins
            .iter()
            .filter_map(|(p, tally)| Some((x(*p), y(tally.share()?))))
            .collect();
        svg.polyline(&points, BLUE, "none");
        for (p, tally) in bins {
            let (Some(share), Some((low, high))) = (tally.share(), tally.interval()) else {
                continue;
            };
            svg.line((x(p), y(low)), (x(p), y(high)), BLUE, 1.2);
            svg.dot((x(p), y(share)), 3.6, BLUE, 1.0);
            // Beside its point, and inside the square.
            let (dx, anchor) = if p > 0.85 {
                (-6.0, Anchor::End)
            } else {
                (6.0, Anchor::Start)
            };
            let lift = if share > 0.5 { 14.0 } else { -6.0 };
            let label = tally.of.to_string();
            svg.text((x(p) + dx, y(share) + lift), anchor, FAINT, &label);
        }
    }
    svg.finish()
}

/// Held-out error after over before, a dot a case, on a logarithmic scale.
pub(crate) fn gains(levels: &[Summary]) -> String {
    const LEFT: f64 = 200.0;
    const WIDTH: f64 = 460.0;
    const LANE: f64 = 30.0;
    const ENDS: (f64, f64) = (0.02, 4.0);
    let lanes = SIGNAL_TITLES.len() * levels.len();
    let mut svg = Svg::new(
        LEFT + WIDTH + 20.0,
        LANE * lanes as f64 + 52.0,
        "Held-out error after over before, by signal",
    );
    let x = |ratio: f64| {
        let share = (ratio.clamp(ENDS.0, ENDS.1) / ENDS.0).ln() / (ENDS.1 / ENDS.0).ln();
        LEFT + share * WIDTH
    };
    let bottom = 8.0 + LANE * lanes as f64;
    for ratio in [0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 4.0] {
        let (stroke, width) = if ratio == 1.0 {
            (FAINT, 1.4)
        } else {
            (GRID, 1.0)
        };
        svg.line((x(ratio), 8.0), (x(ratio), bottom), stroke, width);
        svg.text(
            (x(ratio), bottom + 16.0),
            Anchor::Middle,
            FAINT,
            &ratio.to_string(),
        );
    }
    svg.text(
        (LEFT + WIDTH / 2.0, bottom + 34.0),
        Anchor::Middle,
        INK,
        "error after / error before (left of 1 is better)",
    );
    let mut lane = 0.0;
    for (i, title) in SIGNAL_TITLES.iter().enumerate() {
        for summary in levels {
            let y = 8.0 + LANE * (lane + 0.5);
            let label = format!("{title}, level {}", summary.level);
            svg.text((LEFT - 10.0, y + 4.0), Anchor::End, INK, &label);
            for (n, ratio) in summary.gains[i].iter().enumerate() {
                // Spread a little, always the same way, so that equal ones show.
                let jitter = ((n * 7) % 11) as f64 - 5.0;
                let colour = if *ratio > targets::WORSE { RED } else { BLUE };
                svg.dot((x(*ratio), y + jitter), 2.6, colour, 0.55);
            }
            if let Some(median) = super::stats::median(&summary.gains[i]) {
                svg.line((x(median), y - 11.0), (x(median), y + 11.0), INK, 2.0);
            }
            lane += 1.0;
        }
    }
    svg.finish()
}
