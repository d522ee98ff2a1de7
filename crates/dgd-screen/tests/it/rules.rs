use crate::synthetic::{steady, with_speed};
use dgd_recording::Channel;
use dgd_screen::{Faults, Reasons, ScreenOptions, screen};

#[test]
fn nothing_is_rejected_of_a_sound_recording() {
    let screening = screen(&steady(20_000, 1.0), 1.0, &ScreenOptions::default()).unwrap();
    let rejected: Vec<usize> = (0..20_000)
        .filter(|i| !screening.reasons[*i].is_empty())
        .collect();
    assert_eq!(rejected, [] as [usize; 0]);
    for channel in &screening.channels {
        let at_fault = channel.faults.iter().filter(|f| !f.trusted()).count();
        assert_eq!(at_fault, 0, "{}", channel.channel);
    }
}

#[test]
fn each_rule_of_the_thesis_rejects_its_samples_and_no_other() {
    let mut recording = steady(2000, 1.0);
    recording.pump_speed_pct[100] = 0.0;
    recording.return_flow_m3_s[200] = -1e-4;
    for outlet in &mut recording.pump_outlet_pressure_pa {
        outlet[300] = 2e6;
    }
    recording.return_flow_m3_s[400..410].fill(0.0451);
    recording.return_flow_m3_s[500] = f64::NAN;
    recording.pump_speed_pct[600] = 300.0;
    let screening = screen(&recording, 1.0, &ScreenOptions::thesis()).unwrap();
    let has = |i: usize, reason| screening.reasons[i].contains(reason);
    assert!(has(100, Reasons::PUMP_OFF));
    assert!(has(200, Reasons::NO_FLOW));
    assert!(has(300, Reasons::NO_PRESSURE_RISE));
    assert!((400..410).all(|i| has(i, Reasons::STUCK_RETURN_FLOW)));
    assert!(has(500, Reasons::GAP));
    assert!(has(600, Reasons::OUT_OF_RANGE));
    let rejected = screening.keep().iter().filter(|k| !**k).count();
    assert_eq!(rejected, 15);
}

#[test]
fn first_reasons_add_up_to_what_is_rejected() {
    let recording = with_speed(6000, 1.0, |t| {
        if (2000.0..2600.0).contains(&t) {
            0.0
        } else {
            60.0 + (t / 60.0).sin()
        }
    });
    let screening = screen(&recording, 1.0, &ScreenOptions::default()).unwrap();
    let table = screening.tally();
    let rejected = screening.keep().iter().filter(|k| !**k).count();
    assert_eq!(table.iter().map(|row| row.first).sum::<usize>(), rejected);
    assert!(
        table
            .iter()
            .all(|row| row.alone <= row.first && row.first <= row.total)
    );
    let off = table.iter().find(|row| row.name == "pump off").unwrap();
    assert_eq!((off.total, off.first, off.alone), (600, 600, 0));
    let idle = table.iter().find(|row| row.name == "no flow").unwrap();
    assert_eq!((idle.total, idle.first), (600, 0));
}

#[test]
fn a_restart_settles_and_the_start_of_the_recording_does_not() {
    let recording = with_speed(3000, 1.0, |t| {
        if (1000.0..1200.0).contains(&t) {
            0.0
        } else {
            60.0 + (t / 60.0).sin()
        }
    });
    let screening = screen(&recording, 1.0, &ScreenOptions::default()).unwrap();
    let settling: Vec<usize> = (0..3000)
        .filter(|i| screening.reasons[*i].contains(Reasons::SETTLING))
        .collect();
    assert_eq!(settling, (1200..1320).collect::<Vec<_>>());
    let kept = screening.keep_despite(Reasons::SETTLING);
    assert!(kept[1200..].iter().all(|k| *k) && !kept[1100]);
    let thesis = screen(&recording, 1.0, &ScreenOptions::thesis()).unwrap();
    assert!(
        thesis
            .reasons
            .iter()
            .all(|r| !r.contains(Reasons::SETTLING))
    );
}

#[test]
fn one_bad_reading_of_the_speed_neither_stops_nor_starts_the_pump() {
    for bad in [0.0, -99.0] {
        let recording = with_speed(3600, 1.0, |t| {
            if (t % 110.0 - 50.0).abs() < 0.5 {
                bad
            } else {
                60.0 + (t / 60.0).sin()
            }
        });
        let screening = screen(&recording, 1.0, &ScreenOptions::default()).unwrap();
        let marked = |reason: Reasons| {
            screening
                .reasons
                .iter()
                .filter(|r| r.contains(reason))
                .count()
        };
        assert_eq!(marked(Reasons::SETTLING), 0, "{bad}");
        let kept = screening.keep().iter().filter(|keep| **keep).count();
        assert!(kept > 3400, "{bad}: {kept}");
    }
    // One that is far too high, shortly before a stop.
    let recording = with_speed(3000, 1.0, |t| match t {
        950.0 => 999.0,
        t if t < 1000.0 => 60.0 + (t / 60.0).sin(),
        _ => 0.0,
    });
    let screening = screen(&recording, 1.0, &ScreenOptions::default()).unwrap();
    let stopping = screening
        .reasons
        .iter()
        .filter(|r| r.contains(Reasons::STOPPING))
        .count();
    assert_eq!(stopping, 0);
}

#[test]
fn a_pump_that_runs_down_is_left_out_and_one_that_is_throttled_is_not() {
    let recording = with_speed(3000, 1.0, |t| {
        let running = if t < 800.0 { 60.0 } else { 45.0 };
        // Down by 3 % a second from 1000 s.
        let down = if t < 1200.0 { 1000.0 } else { f64::INFINITY };
        (running - 3.0 * (t - down).max(0.0)).max(0.0) + if t < 800.0 { 0.0 } else { 1e-9 * t }
    });
    let stopping = |options: &ScreenOptions| -> Vec<usize> {
        let screening = screen(&recording, 1.0, options).unwrap();
        (0..3000)
            .filter(|i| screening.reasons[*i].contains(Reasons::STOPPING))
            .collect()
    };
    // Below seven tenths of 45 % at 31.5 %, and below 0.5 % at 1015 s.
    assert_eq!(
        stopping(&ScreenOptions::default()),
        (1005..1015).collect::<Vec<_>>()
    );
    assert_eq!(stopping(&ScreenOptions::thesis()), Vec::<usize>::new());
}

#[test]
fn one_silent_transmitter_of_two_costs_no_sample() {
    let mut recording = steady(2000, 1.0);
    recording.pump_inlet_pressure_pa[0][500..700].fill(f64::NAN);
    recording.pump_outlet_pressure_pa[1][900..950].fill(f64::NAN);
    recording.mud_pump_flow_m3_s[40..60].fill(f64::NAN);
    let screening = screen(&recording, 1.0, &ScreenOptions::default()).unwrap();
    assert!(screening.keep().iter().all(|k| *k));
    let inlet = screening.channel(Channel::PumpInletPressure(0)).unwrap();
    assert_eq!(inlet.count(Faults::MISSING), 200);
    let mud_pump = screening.channel(Channel::MudPumpFlow).unwrap();
    assert!(mud_pump.valid().iter().take(60).skip(40).all(|v| !v));
    recording.pump_inlet_pressure_pa[1][600] = f64::NAN;
    let screening = screen(&recording, 1.0, &ScreenOptions::default()).unwrap();
    assert_eq!(screening.reasons[600], Reasons::GAP);
    assert!(screening.inlet_pressure_pa[600].is_nan());
}

#[test]
fn reasons_read_as_words() {
    assert_eq!(Reasons::NONE.to_string(), "usable");
    let both = Reasons::PUMP_OFF | Reasons::NO_FLOW;
    assert_eq!(both.to_string(), "pump off, no flow");
    assert!(both.intersects(Reasons::NO_FLOW) && !both.contains(Reasons::GAP));
}
