use crate::synthetic::{GPM, PSI, counted, steady, with_speed};
use dgd_recording::Channel;
use dgd_screen::{Faults, Reasons, ScreenOptions, screen};

#[test]
fn a_frozen_flow_meter_is_found_from_its_first_to_its_last_sample() {
    for step_s in [0.1, 1.0, 10.0] {
        let mut recording = steady(4000, step_s);
        let held = recording.return_flow_m3_s[1000];
        recording.return_flow_m3_s[1000..1080].fill(held);
        recording.return_flow_m3_s[999] += 50.0 * GPM / 10.0;
        recording.return_flow_m3_s[1080] += 50.0 * GPM / 10.0;
        let screening = screen(&recording, step_s, &ScreenOptions::default()).unwrap();
        let flow = screening.channel(Channel::ReturnFlow).unwrap();
        assert_eq!(flow.stuck.len(), 1, "{step_s} s");
        assert_eq!((flow.stuck[0].start, flow.stuck[0].length), (1000, 80));
        let rejected = screening.keep().iter().filter(|k| !**k).count();
        assert_eq!(rejected, 80, "{step_s} s");
    }
}

#[test]
fn a_flow_at_rest_while_the_pump_is_off_is_not_stuck() {
    let recording = with_speed(3000, 1.0, |t| if t < 1500.0 { 55.0 } else { 0.0 });
    let screening = screen(&recording, 1.0, &ScreenOptions::default()).unwrap();
    let flow = screening.channel(Channel::ReturnFlow).unwrap();
    assert_eq!(flow.stuck, []);
}

#[test]
fn a_meter_that_freezes_before_the_pump_stops_is_stuck_from_its_first_sample() {
    let mut recording = with_speed(3000, 1.0, |t| if t < 1500.0 { 55.0 } else { 0.0 });
    let held = recording.return_flow_m3_s[1440];
    recording.return_flow_m3_s[1440..1700].fill(held);
    let screening = screen(&recording, 1.0, &ScreenOptions::default()).unwrap();
    let flow = screening.channel(Channel::ReturnFlow).unwrap();
    assert_eq!(flow.stuck.len(), 1);
    assert_eq!((flow.stuck[0].start, flow.stuck[0].length), (1440, 260));
}

#[test]
fn coarse_quantisation_repeats_honestly() {
    let mut recording = steady(20_000, 1.0);
    // A meter that shows only every 100 gpm repeats itself most of the time.
    for q in &mut recording.return_flow_m3_s {
        *q = (*q / (100.0 * GPM)).round() * 100.0 * GPM;
    }
    let screening = screen(&recording, 1.0, &ScreenOptions::default()).unwrap();
    let flow = screening.channel(Channel::ReturnFlow).unwrap();
    assert!(flow.repeat_share > 0.5, "{}", flow.repeat_share);
    assert!(flow.shortest_stuck > 20, "{}", flow.shortest_stuck);
    assert_eq!(flow.stuck, []);
}

#[test]
fn a_slowly_updated_meter_is_not_stuck_until_it_stops() {
    let mut recording = steady(20_000, 1.0);
    for i in 0..20_000 {
        recording.return_flow_m3_s[i] = recording.return_flow_m3_s[i - i % 10];
    }
    let screening = screen(&recording, 1.0, &ScreenOptions::default()).unwrap();
    assert!(screening.keep().iter().all(|k| *k));
    recording.return_flow_m3_s[5000..5300].fill(0.0451);
    let screening = screen(&recording, 1.0, &ScreenOptions::default()).unwrap();
    assert_eq!(screening.keep().iter().filter(|k| !**k).count(), 300);
}

#[test]
fn a_stuck_transmitter_of_two_leaves_sample_and_mean_alone() {
    let mut recording = steady(6000, 1.0);
    for p in &mut recording.pump_outlet_pressure_pa[1] {
        *p += 6.0 * PSI;
    }
    let whole = recording.mean_outlet_pressure_pa();
    recording.pump_outlet_pressure_pa[0][2000..2200].fill(590.0 * PSI);
    let screening = screen(&recording, 1.0, &ScreenOptions::default()).unwrap();
    assert!(screening.keep().iter().all(|k| *k));
    let stuck = screening.channel(Channel::PumpOutletPressure(0)).unwrap();
    assert_eq!(stuck.count(Faults::STUCK), 200);
    // Leaving the stuck one out plainly would have put the mean 3 psi too high.
    for (i, p) in whole.iter().enumerate().take(2200).skip(2000) {
        assert!(
            (screening.outlet_pressure_pa[i] - p).abs() < 1.5 * PSI,
            "{i}"
        );
    }
}

#[test]
fn a_lone_stuck_transmitter_costs_its_samples() {
    let mut recording = steady(6000, 1.0);
    recording.pump_inlet_pressure_pa.truncate(1);
    recording.pump_outlet_pressure_pa.truncate(1);
    recording.pump_inlet_pressure_pa[0][1000..1100].fill(352.2 * PSI);
    recording.pump_outlet_pressure_pa[0][2000..2200].fill(590.0 * PSI);
    let screening = screen(&recording, 1.0, &ScreenOptions::default()).unwrap();
    assert!((1000..1100).all(|i| screening.reasons[i] == Reasons::STUCK_INLET_PRESSURE));
    assert!((2000..2200).all(|i| screening.reasons[i] == Reasons::STUCK_OUTLET_PRESSURE));
    assert_eq!(screening.keep().iter().filter(|k| !**k).count(), 300);
}

#[test]
fn an_idle_inflow_is_not_stuck_and_a_frozen_one_rejects_nothing() {
    let mut recording = steady(6000, 1.0);
    recording.booster_flow_m3_s[3000..4000].fill(0.0);
    recording.mud_pump_flow_m3_s[1000..1300].fill(500.0 * GPM);
    let screening = screen(&recording, 1.0, &ScreenOptions::default()).unwrap();
    let stuck = |channel| screening.channel(channel).unwrap().count(Faults::STUCK);
    assert_eq!(stuck(Channel::TopfillFlow), 0);
    assert_eq!(stuck(Channel::BoosterFlow), 0);
    assert!((300..310).contains(&stuck(Channel::MudPumpFlow)));
    assert!(screening.keep().iter().all(|k| *k));
}

#[test]
fn a_booster_or_top_fill_that_rests_for_most_of_a_recording_is_pumped_at_one_rate() {
    let mut recording = steady(6000, 1.0);
    let steps = |flow: &mut Vec<f64>, to: usize| {
        for (k, hour) in flow[..to].chunks_mut(1000).enumerate() {
            hour.fill((100.0 + 10.0 * k as f64) * GPM);
        }
    };
    steps(&mut recording.booster_flow_m3_s, 3500);
    steps(&mut recording.topfill_flow_m3_s, 2000);
    steps(&mut recording.mud_pump_flow_m3_s, 3500);
    let screening = screen(&recording, 1.0, &ScreenOptions::default()).unwrap();
    let stuck = |channel| screening.channel(channel).unwrap().count(Faults::STUCK);
    assert_eq!(stuck(Channel::BoosterFlow), 0);
    assert!(stuck(Channel::TopfillFlow) > 1900);
    assert!(stuck(Channel::MudPumpFlow) > 3400);
}

/// Strokes are counted by the minute: a steady pump has one count for long, and goes from it to the next.
#[test]
fn a_pump_that_is_counted_by_strokes_is_not_stuck_until_it_leaps() {
    let (recording, stroke) = counted();
    let stuck = |recording: &dgd_recording::Recording| {
        let screening = screen(recording, 1.0, &ScreenOptions::default()).unwrap();
        let faults = |i: usize| screening.channel(Channel::MudPumpFlow).unwrap().faults[i];
        (0..6000)
            .filter(|i| faults(*i).contains(Faults::STUCK))
            .count()
    };
    assert_eq!(stuck(&recording), 0);
    let frozen = |to: usize, last: usize| {
        let mut recording = recording.clone();
        let at = recording.mud_pump_flow_m3_s[999];
        recording.mud_pump_flow_m3_s[1000..to].fill(at);
        recording.mud_pump_flow_m3_s[to..last].fill(at + 4.0 * stroke);
        stuck(&recording)
    };
    // It froze at its count, and the pump went on meanwhile; to the end, nothing tells.
    assert!(frozen(2500, 2700) >= 1500, "{}", frozen(2500, 2700));
    assert!(frozen(6000, 6000) >= 5000, "{}", frozen(6000, 6000));
    let mut gap = recording.clone();
    let at = gap.mud_pump_flow_m3_s[999];
    gap.mud_pump_flow_m3_s[1000..2500].fill(at);
    gap.mud_pump_flow_m3_s[2500..2600].fill(f64::NAN);
    assert!(stuck(&gap) >= 1500, "{}", stuck(&gap));
    // A pump that runs down and up again leaves its count for good.
    for ramp in [20, 60] {
        let mut stops = recording.clone();
        for k in 0..3 {
            let from = 1500 * k + 1000;
            let down = |i: usize| ((125 * (ramp - i)) / ramp) as f64 * stroke;
            for i in 0..ramp {
                stops.mud_pump_flow_m3_s[from + i] = down(i + 1);
                stops.mud_pump_flow_m3_s[from + ramp + 200 + i] = down(ramp - i - 1);
            }
            stops.mud_pump_flow_m3_s[from + ramp..from + ramp + 200].fill(0.0);
            stops.mud_pump_flow_m3_s[from - 700..from].fill(125.0 * stroke);
        }
        assert_eq!(stuck(&stops), 0, "{ramp}");
    }
}

/// A code such as -248 in a flow in L/min is within what a return flow may read.
#[test]
fn no_pump_runs_backwards() {
    let mut recording = steady(600, 1.0);
    let code = -248.0 / 60e3;
    for flow in [
        &mut recording.mud_pump_flow_m3_s,
        &mut recording.booster_flow_m3_s,
        &mut recording.return_flow_m3_s,
    ] {
        flow[300..320].fill(code);
        flow[400] = -0.001;
    }
    let screening = screen(&recording, 1.0, &ScreenOptions::default()).unwrap();
    let outside = |channel| {
        screening
            .channel(channel)
            .unwrap()
            .count(Faults::OUT_OF_RANGE)
    };
    assert_eq!(outside(Channel::MudPumpFlow), 20);
    assert_eq!(outside(Channel::BoosterFlow), 20);
    assert_eq!(outside(Channel::ReturnFlow), 0);
}
