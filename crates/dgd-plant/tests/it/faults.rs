//! Instrument faults: as many as stated, where stated, and independent of each other.

use dgd_plant::{FaultKind, Plan, record};

use crate::ladder::gom;

/// Faults of a kind, and how many the plan leads to expect.
fn counted(kind: FaultKind) -> (f64, f64) {
    let plan = Plan::gom(Plan::GOM_SEED);
    let days = plan.samples() as f64 / 86_400.0;
    let rate: f64 = plan
        .faults
        .iter()
        .map(|f| match kind {
            FaultKind::Stuck => f.stuck_per_day,
            FaultKind::Spike => f.spikes_per_day,
            FaultKind::Missing => f.missing_per_day,
            _ => f.zeros_per_day,
        })
        .sum();
    let found = gom().faults.iter().filter(|f| f.kind == kind).count();
    (found as f64, rate * days)
}

#[test]
fn faults_appear_at_the_stated_rates() {
    for kind in [
        FaultKind::Stuck,
        FaultKind::Spike,
        FaultKind::Missing,
        FaultKind::Zero,
    ] {
        let (found, expected) = counted(kind);
        // Poisson: three standard deviations.
        assert!(
            (found - expected).abs() < 3.0 * expected.sqrt(),
            "{kind:?}: {found}, {expected}"
        );
    }
}

#[test]
fn every_missing_value_is_a_logged_fault_and_the_other_way_round() {
    let r = gom();
    let mut logged: Vec<Vec<bool>> = r.channels.iter().map(|c| vec![false; c.len()]).collect();
    for f in r.faults.iter().filter(|f| f.kind == FaultKind::Missing) {
        logged[f.channel.unwrap()][f.first..f.first + f.count].fill(true);
    }
    for (values, logged) in r.channels.iter().zip(&logged) {
        assert!(values.iter().zip(logged).all(|(v, &l)| v.is_nan() == l));
    }
}

#[test]
fn the_clock_skips_where_planned_and_nowhere_else() {
    let plan = Plan::gom(Plan::GOM_SEED);
    let r = gom();
    let skips: Vec<f64> = r
        .time_s
        .windows(2)
        .filter(|w| w[1] - w[0] > 1.0)
        .map(|w| w[1] - w[0] - 1.0)
        .collect();
    let planned: Vec<f64> = plan.historian.gaps_s.iter().map(|g| g.1).collect();
    assert_eq!(skips, planned);
}

#[test]
fn flow_rests_for_long_where_the_historian_files_by_exception() {
    let r = gom();
    let flow = &r.channels[3];
    let share = |first: usize, count: usize| {
        let part = &flow[first..first + count];
        part.windows(2).filter(|w| w[0] == w[1]).count() as f64 / count as f64
    };
    let by_exception = r
        .faults
        .iter()
        .find(|f| f.kind == FaultKind::Exception && f.count > 10_000)
        .unwrap();
    assert!(share(by_exception.first, by_exception.count) > 0.95);
    assert!(share(0, 10_000) < 0.2);
}

#[test]
fn a_noisier_flow_meter_leaves_the_other_channels_as_they_were() {
    let plan = Plan::short(7).with_hours(0.3);
    let mut noisy = plan.clone();
    noisy.transmitters[3].noise *= 5.0;
    let (a, b) = (record(&plan).unwrap(), record(&noisy).unwrap());
    assert_eq!(a.truth, b.truth);
    for c in (0..10).filter(|&c| c != 3) {
        assert!(
            a.channels[c]
                .iter()
                .zip(&b.channels[c])
                .all(|(x, y)| x.to_bits() == y.to_bits()),
            "channel {c}"
        );
    }
    assert_ne!(a.channels[3], b.channels[3]);
}
