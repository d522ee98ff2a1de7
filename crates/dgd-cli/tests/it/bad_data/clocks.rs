//! Clocks that skip, run back or apart, and other rates.

use super::rig::{Diagnosed, PRESSURES, Rig, line_of, strings};

#[test]
fn a_clock_in_another_unit_is_told() {
    for (wrong, words) in [
        ("min", "the riser level moves 0.0177 times"),
        ("h", "the samples are 3,600 s apart"),
    ] {
        let rig = Rig::sound().saying("unit = \"s\"", &format!("unit = \"{wrong}\""));
        rig.fitted()
            .suspects(line_of("time"), &[words, "as s they would be 1 s apart"]);
    }
    let ran = Rig::sound().saying("unit = \"s\"", "unit = \"ms\"").fit();
    ran.refused(&[
        "the samples are 0.001 s apart; as s they would be 1 s apart",
        "delays",
    ]);
}

#[test]
fn a_clock_that_skips_leaves_a_gap() {
    let rig = Rig::sound().each(&["t"], |i, t| if i < 3000 { t } else { t + 1000.0 });
    let fitted = rig.fitted();
    fitted.right(1.0);
    assert!(
        fitted.err.contains("1 gap, 1000 samples missing"),
        "{}",
        fitted.err
    );
}

#[test]
fn a_gap_of_twenty_hours_costs_a_diagnosis_nothing() {
    let apart = Rig::sound().each(&["t"], |i, t| if i < 3600 { t } else { t + 72_000.0 });
    let (apart, sound) = (apart.diagnosed(), Rig::sound().diagnosed());
    assert_eq!(apart.claimed(), sound.claimed());
    let hurdles = |of: &Diagnosed| -> Vec<f64> {
        let findings = of.json["findings"].as_array().unwrap();
        findings
            .iter()
            .map(|f| f["hurdle_ln"].as_f64().unwrap())
            .collect()
    };
    // Twenty-two hours would raise them to nearly three times as much.
    for (apart, sound) in hurdles(&apart).iter().zip(hurdles(&sound)) {
        assert!((apart / sound - 1.0).abs() < 0.1, "{apart} for {sound}");
    }
    // Held out is a fifth of what was recorded, and nothing of the gap.
    let windows = apart.json["held_out_s"].as_array().unwrap();
    let (mut held, gap) = (0.0, 3600.0..75_600.0);
    for window in windows {
        let [from, to] = [0, 1].map(|k| window[k].as_f64().unwrap());
        held += to - from;
        assert!(to <= gap.start || from >= gap.end - 1.0, "{from} to {to}");
    }
    assert!((1200.0..2600.0).contains(&held), "{windows:?}");
}

#[test]
fn a_clock_that_is_set_back_or_years_forward_is_refused_with_the_place() {
    let back = Rig::sound().each(&["t"], |i, t| if i < 3000 { t } else { t - 500.0 });
    for ran in [back.fit(), back.simulate(), back.diagnose().1] {
        ran.refused(&["jumps back by 499 s after 2999 s", "split the file there"]);
    }
    let years = Rig::sound().each(&["t"], |i, t| if i < 3000 { t } else { t + 3e7 });
    years
        .fit()
        .refused(&["the largest jump is at 2999 s", "split the file there"]);
}

#[test]
fn a_recording_that_is_there_twice_counts_once() {
    let mut rig = Rig::sound();
    for column in &mut rig.table.columns {
        let tail = column.values[3000..].to_vec();
        column.values.truncate(4000);
        column.values.extend(tail);
    }
    let fitted = rig.fitted();
    fitted.right(0.0);
    assert!(
        fitted.err.contains("1000 samples repeat a time stamp"),
        "{}",
        fitted.err
    );
}

#[test]
fn stamps_without_seconds_are_refused_with_the_way_round() {
    let minutes = |t: f64| 60.0 * (t / 60.0).floor();
    let lost = Rig::sound().each(&["t"], |_, t| minutes(t));
    // At the end of summer time an hour comes again.
    let autumn = Rig::sound().each(&["t"], |_, t| {
        minutes(if t < 5000.0 { t } else { t - 3600.0 })
    });
    for ran in [lost.fit(), lost.diagnose().1, autumn.fit()] {
        ran.refused(&[
            "60 consecutive samples share each time stamp",
            "interval = \"1 s\"",
        ]);
    }
    // Ten a second tell as much as one a second.
    at_ten_hertz(1800)
        .each(&["t"], |_, t| t.floor())
        .fitted()
        .right(2.0);
}

#[test]
fn rows_from_the_newest_to_the_oldest_give_the_same_answer() {
    let mut newest_first = Rig::sound();
    for column in &mut newest_first.table.columns {
        column.values.reverse();
    }
    let [ordered, reversed] = [Rig::sound(), newest_first].map(|rig| rig.fitted().json);
    assert_eq!(ordered["delay_sweep"], reversed["delay_sweep"]);
    assert_eq!(ordered["friction"], reversed["friction"]);
    assert_eq!(ordered["pump"], reversed["pump"]);
}

#[test]
fn an_interval_that_the_clock_contradicts_is_told() {
    let said = |step: &str| {
        let interval = format!("time = {{ interval = \"{step}\" }}");
        Rig::sound().saying("time = { tag = \"t\", unit = \"s\" }", &interval)
    };
    said("5 s").fitted().warns("are taken to be 5 s apart");
    let right = said("1 s").fitted();
    assert!(!right.err.contains("taken to be"), "{}", right.err);
}

#[test]
fn stamps_that_are_missing_cost_their_samples_alone() {
    Rig::sound()
        .each(&["t"], |i, t| if i % 3 == 1 { f64::NAN } else { t })
        .fitted()
        .right(2.0);
}

fn late(tags: &[&str], by: usize) -> Rig {
    later(Rig::sound(), tags, by)
}

fn later(mut rig: Rig, tags: &[&str], by: usize) -> Rig {
    for tag in tags {
        let column = rig.column(tag);
        let first = column[0];
        column.splice(0..0, std::iter::repeat_n(first, by));
        let keep = column.len() - by;
        column.truncate(keep);
    }
    rig
}

#[test]
fn channels_on_different_clocks_are_told() {
    late(&["FT4"], 20)
        .fitted()
        .warns("the best delay, 30 s, is the last of the range: sweep further up");
    late(&PRESSURES, 30)
        .fitted()
        .warns("the return flow is 17 s ahead of the pressures, which is impossible for a meter");
    late(&["SPM"], 30)
        .fitted()
        .warns("the head moves 30 s before the recorded pump speed");
}

/// Whoever asks for causes hears of the clocks too: of flows that come after what they do to the riser, or a speed after its head.
#[test]
fn a_diagnosis_tells_that_the_channels_may_not_share_one_clock() {
    for (tags, doubt) in [
        (
            &["FT1", "FT2", "FT3"][..],
            "with the inflow read 25 s later than recorded",
        ),
        (
            &["SPM"][..],
            "the head moves 30 s before the recorded pump speed",
        ),
    ] {
        let rig = late(tags, 30);
        rig.fitted().warns(doubt);
        let told = rig.diagnosed();
        let warnings = strings(&told.json["warnings"]);
        assert!(warnings.iter().any(|w| w.contains(doubt)), "{warnings:?}");
        assert!(told.err.contains(doubt), "{}", told.err);
    }
    let sound = Rig::sound().diagnosed();
    assert_eq!(strings(&sound.json["warnings"]), Vec::<&str>::new());
    // A string that fills and drains makes the inflow late; that is no clock.
    let early = Rig::sound().fitted();
    early.suspects_nothing();
}

/// Whatever is not on the clock of the others, no area, string or pipe is made of it, and what flows in is still seen.
#[test]
fn a_diagnosis_tells_which_channels_have_a_clock_of_their_own_and_names_no_cause_for_it() {
    let flows = ["FT1", "FT2", "FT3"];
    for (tags, told) in [
        (
            &flows[..1],
            "the mud pump's flow is logged 20 s late (`late = \"20 s\"`",
        ),
        (
            &flows,
            "the flows pumped in are logged 20 s late (`late = \"20 s\"`",
        ),
        (
            &["PT1", "PT2", "PT5"],
            "the pressures of the pump inlet and the riser are logged 18 s late",
        ),
    ] {
        let found = later(Rig::of_hours(), tags, 20).diagnosed();
        let mut causes = found.claimed();
        causes.retain(|id| *id != "unknown");
        assert_eq!(causes, ["influx"], "{told}: {:#}", found.json["findings"]);
        let same_as = found.same_as();
        assert!(
            same_as
                .iter()
                .all(|(id, same)| *id == "unknown" && same.contains(told))
        );
        assert!(!same_as.is_empty(), "{told}");
        let warnings = strings(&found.json["warnings"]);
        let asked = |w: &&str| {
            w.contains("do the channels share one clock?")
                && w.contains(told.split(" (").next().unwrap())
        };
        assert!(warnings.iter().any(asked), "{told}: {warnings:?}");
        let checks = found.json["checks"].as_array().unwrap();
        let one_clock = checks
            .iter()
            .find(|c| c["name"] == "the channels share one clock");
        assert_eq!(one_clock.unwrap()["passed"], false, "{told}");
    }
    let sound = Rig::of_hours().diagnosed();
    assert!(!sound.json["checks"].to_string().contains("share one clock"));
}

/// What the warning names mends it: the same findings as on one clock, but for a gain that is hardly likelier than not there.
#[test]
fn channels_on_another_clock_are_put_back_by_what_the_well_description_says() {
    // What flows in is 5 s on its way, which no clock tells from a meter that is early.
    let flows = ["FT1", "FT2", "FT3"];
    for (tags, late_s) in [(&flows[..], 25), (&["SPM"][..], 30)] {
        let warned = late(tags, 30).fitted();
        let mend = format!("one clock? If not, set `late = \"{late_s} s\"` beside");
        warned.warns(&mend);
        let mut rig = late(tags, 30);
        for tag in tags {
            let said = format!("tag = \"{tag}\", late = \"{late_s} s\"");
            rig = rig.saying(&format!("tag = \"{tag}\""), &said);
        }
        rig.fitted().right(0.0).suspects_nothing();
        let found = rig.diagnosed();
        let sound = Rig::sound().diagnosed();
        assert_eq!(found.found_at(0.9), sound.found_at(0.9));
        assert_eq!(sound.found_at(0.9).len(), 2);
        assert_eq!(strings(&found.json["warnings"]), Vec::<&str>::new());
        // Read in blocks where all share one clock, whole here.
        rig.simulate().done();
    }
}

#[test]
fn a_meter_whose_clock_runs_fast_is_told() {
    let mut rig = Rig::sound();
    let column = rig.column("FT4");
    let before = column.clone();
    for (i, value) in column.iter_mut().enumerate() {
        *value = before.get(i + i / 50).copied().unwrap_or(f64::NAN);
    }
    rig.fitted()
        .warns("ahead of the pressures, which is impossible for a meter");
}

/// Every tenth of a second, in between by straight lines.
fn at_ten_hertz(samples: usize) -> Rig {
    let mut fast = Rig::first(samples);
    for column in &mut fast.table.columns {
        let between = |w: &[f64]| {
            (0..10)
                .map(|k| w[0] + f64::from(k) / 10.0 * (w[1] - w[0]))
                .collect::<Vec<f64>>()
        };
        column.values = column.values.windows(2).flat_map(between).collect();
    }
    fast
}

#[test]
fn steps_from_a_tenth_of_a_second_to_half_a_minute_give_one_answer() {
    let fast = at_ten_hertz(1800).fitted();
    let step_s = fast.json["step_s"].as_f64().unwrap();
    assert!((step_s - 0.1).abs() < 1e-9, "{step_s}");
    assert!((fast.delay_s() - 13.0).abs() < 1.5, "{}", fast.delay_s());
    fast.suspects_nothing();
    for (step, slack_s) in [(2, 2.0), (5, 5.0), (10, 10.0)] {
        Rig::sound()
            .every(step)
            .fitted()
            .right(slack_s)
            .suspects_nothing();
    }
    Rig::sound().every(30).fitted().suspects_nothing();
}

/// Pressures of every tenth second, the others left empty.
fn sparse(rig: Rig) -> Rig {
    rig.each(&PRESSURES, |i, p| if i % 10 == 0 { p } else { f64::NAN })
}

/// Pressures of every tenth second, held until the next.
fn held(mut rig: Rig) -> Rig {
    for tag in PRESSURES {
        let column = rig.column(tag);
        for i in 0..column.len() {
            column[i] = column[i - i % 10];
        }
    }
    rig
}

#[test]
fn mixed_rates_held_or_left_empty_give_the_same_answer() {
    let empty = sparse(Rig::sound()).fitted();
    empty.right(3.0).warns("`PT1` has a value at only");
    held(Rig::sound()).fitted().right(5.0);
}

/// The sound recording's late meter, 12.0 s in its first hour, to a few seconds; in two hours of it, the line that drains and the gain too.
#[test]
fn a_diagnosis_at_other_rates_names_the_same_causes() {
    let late = |rig: Rig, slack_s| {
        rig.diagnosed()
            .finds("return_flow_delay", "delay_s", 12.0, slack_s);
    };
    late(at_ten_hertz(2200), 1.5);
    late(held(Rig::first(3600)), 5.0);
    late(sparse(Rig::first(3600)), 5.0);
    let slow = Rig::sound().every(10).diagnosed();
    slow.finds("return_flow_delay", "delay_s", 12.0, 5.0)
        .finds("line_drainage", "rate_m_s", 0.036, 0.004)
        // The stand-in's return meter reads 4 to 5 % too little where most mud flows: a gain of the two flows, whichever has it.
        .finds("inflow_gain", "gain", 1.048, 0.012);
    assert_eq!(slow.claimed().len(), 3, "{:#}", slow.json["findings"]);
}

/// `dgd diagnose` of the demo with what is left of its return flow by a deadband.
#[test]
fn a_historians_deadband_is_doubted_aloud() {
    let doubts = |least: f64| {
        let last = std::cell::Cell::new(f64::NAN);
        let kept = |_, value: f64| {
            if !((value - last.get()).abs() < least) {
                last.set(value);
            }
            last.get()
        };
        let told = Rig::first(3600).each(&["FT4"], kept).diagnosed();
        let warnings = strings(&told.json["warnings"]);
        let doubt = |w: &&str| {
            w.contains("return_flow `FT4` is constant") && w.contains("confirm any finding")
        };
        warnings.iter().any(|w| doubt(w) && told.err.contains(*w))
    };
    assert!(doubts(40.0) && !doubts(5.0));
}

/// `dgd diagnose` of the demo, every so many-th sample.
#[test]
fn samples_far_apart_are_doubted_aloud() {
    for (step, doubted) in [(5, false), (10, true), (30, true)] {
        let (bench, ran) = Rig::sound().every(step).diagnose();
        assert_eq!(
            ran.err.contains("confirm any finding"),
            doubted,
            "{step}: {}",
            ran.err
        );
        if doubted {
            ran.done();
            let told = bench.text("d/diagnosis.json");
            assert!(told.contains(&format!("a sample every {step} s")), "{step}");
        }
    }
}
