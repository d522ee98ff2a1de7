//! What must hold of the true states.

use std::sync::OnceLock;

use dgd_plant::{Plan, Recording, record};

fn short() -> &'static Recording {
    static SHORT: OnceLock<Recording> = OnceLock::new();
    SHORT.get_or_init(|| record(&Plan::short(Plan::SHORT_SEED)).unwrap())
}

#[test]
fn mud_is_neither_made_nor_lost() {
    let area = Plan::short(1).well.annulus_area_m2();
    let truth = &short().truth;
    let first = truth[0];
    for s in truth {
        let riser = (first.riser_level_m - s.riser_level_m) * area;
        let line = s.line_volume_m3 - first.line_volume_m3;
        let passed = (s.came_in_m3 - first.came_in_m3) - (s.went_out_m3 - first.went_out_m3);
        assert!(
            (riser + line - passed).abs() < 1e-6,
            "{riser} {line} {passed}"
        );
    }
}

#[test]
fn standing_pump_moves_no_mud_but_the_valves_leak() {
    let r = short();
    let mut standing = 0;
    let mut seen = 0;
    for (i, s) in r.truth.iter().enumerate() {
        standing = if s.pump_speed_pct > 0.0 {
            0
        } else {
            standing + 1
        };
        if standing > 30 {
            seen += 1;
            assert!(
                s.pump_flow_m3_s <= 0.0 && s.pump_flow_m3_s > -2e-3,
                "{}",
                s.pump_flow_m3_s
            );
        }
        if standing > 60 {
            let read = r.channels[3][i];
            assert!(read.is_nan() || read.abs() < f64::EPSILON, "{read}");
        }
    }
    assert!(seen > 300, "the pump stood for {seen} s");
}

#[test]
fn line_drains_during_the_stop_and_runs_full_again() {
    let filled: Vec<f64> = short().truth.iter().map(|s| s.line_filled_m).collect();
    let lowest = filled.iter().copied().fold(f64::INFINITY, f64::min);
    assert!(lowest < 345.0, "{lowest}");
    assert!((filled[filled.len() - 1] - 350.3).abs() < 1e-9);
}

#[test]
fn level_stays_in_the_riser_for_85_hours() {
    for s in &crate::ladder::gom().truth {
        assert!(
            (5.0..300.0).contains(&s.riser_level_m),
            "{}",
            s.riser_level_m
        );
    }
}

#[test]
fn most_of_the_running_is_between_30_and_70_percent() {
    let speeds: Vec<f64> = crate::ladder::gom()
        .truth
        .iter()
        .map(|s| s.pump_speed_pct)
        .filter(|&w| w > 0.0)
        .collect();
    let within = speeds.iter().filter(|w| (30.0..=70.0).contains(*w)).count();
    assert!(
        within as f64 > 0.85 * speeds.len() as f64,
        "{within} of {}",
        speeds.len()
    );
}

#[test]
fn refining_the_line_moves_the_level_little() {
    let mut plan = Plan::short(1).with_hours(0.5);
    let coarse = record(&plan).unwrap();
    plan.physics.line.cells = 64;
    let fine = record(&plan).unwrap();
    for (a, b) in coarse.truth.iter().zip(&fine.truth) {
        assert!((a.riser_level_m - b.riser_level_m).abs() < 0.3);
        assert!((a.pump_outlet_pa - b.pump_outlet_pa).abs() < 2e4);
    }
}
