use crate::synthetic::{PSI, steady};
use dgd_recording::Channel;
use dgd_screen::{Faults, Reasons, ScreenOptions, screen};

fn spikes(recording: &dgd_recording::Recording, channel: Channel) -> Vec<usize> {
    let screening = screen(recording, 1.0, &ScreenOptions::default()).unwrap();
    let faults = &screening.channel(channel).unwrap().faults;
    (0..faults.len())
        .filter(|i| faults[*i].contains(Faults::SPIKE))
        .collect()
}

#[test]
fn dropouts_to_zero_and_leaps_to_full_scale_are_spikes() {
    let mut recording = steady(3000, 1.0);
    recording.return_flow_m3_s[500..503].fill(0.0);
    recording.return_flow_m3_s[800] = 0.09;
    recording.pump_outlet_pressure_pa[1][900..902].fill(0.0);
    recording.pump_outlet_pressure_pa[1][1200] *= 1.6;
    assert_eq!(
        spikes(&recording, Channel::ReturnFlow),
        [500, 501, 502, 800]
    );
    assert_eq!(
        spikes(&recording, Channel::PumpOutletPressure(1)),
        [900, 901, 1200]
    );
    let screening = screen(&recording, 1.0, &ScreenOptions::default()).unwrap();
    assert_eq!(screening.reasons[800], Reasons::SPIKE);
    // The other outlet transmitter stands in.
    assert!(screening.reasons[900].is_empty() && screening.reasons[1200].is_empty());
    assert_eq!(screening.keep().iter().filter(|k| !**k).count(), 4);
}

/// A mud pump is not stopped and started again at once; a booster that is set to a value and back is no fault.
#[test]
fn an_inflow_that_drops_to_one_value_for_seconds_has_lost_its_signal() {
    let mut recording = steady(3000, 1.0);
    recording.mud_pump_flow_m3_s[500..540].fill(0.0);
    recording.mud_pump_flow_m3_s[800..825].fill(0.15);
    // So long is a stop.
    recording.mud_pump_flow_m3_s[1500..1570].fill(0.0);
    recording.booster_flow_m3_s[700..730].fill(0.0);
    let lost: Vec<usize> = (500..540).chain(800..825).collect();
    assert_eq!(spikes(&recording, Channel::MudPumpFlow), lost);
    let all: Vec<usize> = (700..730).collect();
    assert_eq!(spikes(&recording, Channel::BoosterFlow), all);
    let screening = screen(&recording, 1.0, &ScreenOptions::default()).unwrap();
    let dropouts = &screening.channel(Channel::MudPumpFlow).unwrap().dropouts;
    let found: Vec<(usize, usize)> = dropouts.iter().map(|run| (run.start, run.length)).collect();
    assert_eq!(found, [(500, 40), (800, 25)]);
    // One of a spike's length is lost as well.
    recording.mud_pump_flow_m3_s[2000..2003].fill(0.0);
    let screening = screen(&recording, 1.0, &ScreenOptions::default()).unwrap();
    let dropouts = &screening.channel(Channel::MudPumpFlow).unwrap().dropouts;
    assert_eq!(dropouts.len(), 3);
    // A rate that was set, by the digit, beside a missing sample too.
    recording.booster_flow_m3_s.fill(0.01);
    recording.booster_flow_m3_s[700..730].fill(0.0);
    recording.booster_flow_m3_s[695] = f64::NAN;
    recording.booster_flow_m3_s[735] = f64::NAN;
    assert_eq!(spikes(&recording, Channel::BoosterFlow), [] as [usize; 0]);
}

#[test]
fn short_pumping_and_a_slow_rate_are_no_lost_signal() {
    let mut recording = steady(3000, 1.0);
    let rate = recording.mud_pump_flow_m3_s[0];
    // A slow rate, by the digit.
    recording.mud_pump_flow_m3_s[500..540].fill(0.6 * rate);
    // For a while from rest, and a top-fill over its noisy zero.
    recording.mud_pump_flow_m3_s[1000..2000].fill(0.0);
    recording.mud_pump_flow_m3_s[1500..1550].fill(0.4 * rate);
    for (i, flow) in recording.topfill_flow_m3_s.iter_mut().enumerate() {
        *flow = 1e-5 * (i * 37 % 11) as f64;
    }
    recording.topfill_flow_m3_s[800..845].fill(0.01);
    for channel in [Channel::MudPumpFlow, Channel::TopfillFlow] {
        assert_eq!(spikes(&recording, channel), [] as [usize; 0], "{channel}");
    }
}

#[test]
fn a_spike_beside_a_gap_is_found() {
    let mut recording = steady(1000, 1.0);
    recording.return_flow_m3_s[500..510].fill(f64::NAN);
    recording.return_flow_m3_s[510] = 0.2;
    recording.return_flow_m3_s[300] = 0.2;
    recording.return_flow_m3_s[301..310].fill(f64::NAN);
    let found = spikes(&recording, Channel::ReturnFlow);
    assert_eq!(found, [300, 510]);
}

#[test]
fn what_both_transmitters_show_has_happened() {
    let mut recording = steady(3000, 1.0);
    for outlet in &mut recording.pump_outlet_pressure_pa {
        outlet[700..702].iter_mut().for_each(|p| *p -= 40.0 * PSI);
    }
    assert_eq!(
        spikes(&recording, Channel::PumpOutletPressure(0)),
        [] as [usize; 0]
    );
    recording.pump_outlet_pressure_pa.truncate(1);
    assert_eq!(
        spikes(&recording, Channel::PumpOutletPressure(0)),
        [700, 701]
    );
}

#[test]
fn steps_and_long_excursions_are_no_spikes() {
    let mut recording = steady(3000, 1.0);
    recording.return_flow_m3_s[1000..]
        .iter_mut()
        .for_each(|q| *q += 0.01);
    recording.return_flow_m3_s[2000..2010]
        .iter_mut()
        .for_each(|q| *q -= 0.02);
    assert_eq!(spikes(&recording, Channel::ReturnFlow), [] as [usize; 0]);
}

#[test]
fn turning_a_recording_around_turns_its_spikes_around() {
    let mut recording = steady(3000, 1.0);
    for (at, length, height) in [(400, 1, 0.02), (900, 2, -0.03), (1500, 3, 0.05)] {
        for q in &mut recording.return_flow_m3_s[at..at + length] {
            *q += height;
        }
    }
    let forward = spikes(&recording, Channel::ReturnFlow);
    assert_eq!(forward, [400, 900, 901, 1500, 1501, 1502]);
    recording.return_flow_m3_s.reverse();
    let mut back: Vec<usize> = spikes(&recording, Channel::ReturnFlow)
        .iter()
        .map(|i| 2999 - i)
        .collect();
    back.sort_unstable();
    assert_eq!(back, forward);
}
