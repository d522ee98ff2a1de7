use crate::synthetic::{PSI, steady};
use dgd_recording::{Channel, Recording};
use dgd_screen::{Faults, Reasons, ScreenOptions, Screening, screen};

fn screened(recording: &Recording) -> Screening {
    screen(recording, 1.0, &ScreenOptions::default()).unwrap()
}

fn disagreeing(screening: &Screening, n: usize) -> usize {
    let channel = Channel::PumpInletPressure(n);
    screening.channel(channel).unwrap().count(Faults::DISAGREES)
}

/// A hump of half a minute, too smooth for a spike.
fn hump(series: &mut [f64], at: usize, height: f64) {
    for (k, p) in series[at..at + 30].iter_mut().enumerate() {
        *p += height * (std::f64::consts::PI * (k as f64 + 0.5) / 30.0).sin();
    }
}

#[test]
fn the_transmitter_that_leaves_for_a_short_while_is_the_liar() {
    let mut recording = steady(6000, 1.0);
    hump(&mut recording.pump_inlet_pressure_pa[1], 3000, 12.0 * PSI);
    let screening = screened(&recording);
    assert_eq!(disagreeing(&screening, 0), 0);
    assert!((20..=30).contains(&disagreeing(&screening, 1)));
    assert!(screening.keep().iter().all(|k| *k));
}

#[test]
fn a_hump_that_both_show_is_no_disagreement() {
    let mut recording = steady(6000, 1.0);
    for inlet in &mut recording.pump_inlet_pressure_pa {
        hump(inlet, 3000, 12.0 * PSI);
    }
    let screening = screened(&recording);
    assert_eq!(disagreeing(&screening, 0) + disagreeing(&screening, 1), 0);
}

#[test]
fn where_neither_is_clearly_the_liar_the_sample_goes() {
    let mut recording = steady(6000, 1.0);
    hump(&mut recording.pump_inlet_pressure_pa[0], 3000, 10.0 * PSI);
    hump(&mut recording.pump_inlet_pressure_pa[1], 3000, -10.0 * PSI);
    let screening = screened(&recording);
    assert_eq!(screening.reasons[3015], Reasons::INLETS_DISAGREE);
}

#[test]
fn a_step_of_one_transmitter_is_left_for_the_diagnosis() {
    for height in [2.0, 10.0, 50.0] {
        let mut recording = steady(6000, 1.0);
        recording.pump_inlet_pressure_pa[0][3017..]
            .iter_mut()
            .for_each(|p| *p += height * PSI);
        let screening = screened(&recording);
        assert_eq!(
            disagreeing(&screening, 0) + disagreeing(&screening, 1),
            0,
            "{height} psi"
        );
        assert!(screening.keep().iter().all(|k| *k));
    }
}

#[test]
fn two_of_three_outvote_the_third() {
    let mut recording = steady(6000, 1.0);
    let third = recording.pump_inlet_pressure_pa[0].clone();
    recording.pump_inlet_pressure_pa.push(third);
    hump(&mut recording.pump_inlet_pressure_pa[2], 3000, 12.0 * PSI);
    let screening = screened(&recording);
    assert_eq!(disagreeing(&screening, 0) + disagreeing(&screening, 1), 0);
    assert!(disagreeing(&screening, 2) >= 20);
}

#[test]
fn swapping_transmitters_swaps_their_faults_and_nothing_else() {
    let mut recording = steady(6000, 1.0);
    hump(&mut recording.pump_inlet_pressure_pa[1], 3000, 12.0 * PSI);
    recording.pump_inlet_pressure_pa[0][1000] = 0.0;
    recording.pump_inlet_pressure_pa[0][4000..4100].fill(351.0 * PSI);
    let one = screened(&recording);
    recording.pump_inlet_pressure_pa.swap(0, 1);
    let other = screened(&recording);
    assert_eq!(one.reasons, other.reasons);
    for n in 0..2 {
        let faults = |s: &Screening, n| {
            s.channel(Channel::PumpInletPressure(n))
                .unwrap()
                .faults
                .clone()
        };
        assert_eq!(faults(&one, n), faults(&other, 1 - n));
    }
    for (a, b) in one.inlet_pressure_pa.iter().zip(&other.inlet_pressure_pa) {
        let same = (a - b).abs() < 1e-6 || (a.is_nan() && b.is_nan());
        assert!(same, "{a} and {b} Pa");
    }
    let finite = one.inlet_pressure_pa.iter().filter(|p| p.is_finite());
    assert!(2 * finite.count() > one.inlet_pressure_pa.len());
}

/// Read every four seconds, two seconds after one another, with 6 psi between them.
#[test]
fn the_mean_of_transmitters_that_are_never_read_at_one_sample_does_not_step() {
    let mut recording = steady(6000, 1.0);
    let middle = recording.pump_inlet_pressure_pa[0].clone();
    for (n, inlet) in recording.pump_inlet_pressure_pa.iter_mut().enumerate() {
        *inlet = middle.iter().map(|p| p + 6.0 * n as f64 * PSI).collect();
        let lost = (0..6000).filter(|i| i % 4 != 2 * n);
        lost.for_each(|i| inlet[i] = f64::NAN);
    }
    let mean = screened(&recording).inlet_pressure_pa;
    let read = mean.iter().zip(&middle).filter(|(p, _)| p.is_finite());
    let off: Vec<f64> = read.map(|(p, middle)| (p - middle) / PSI).collect();
    assert_eq!(off.len(), 3000);
    assert!(off.iter().all(|off| (off - 3.0).abs() < 0.5), "{off:?}");
}
