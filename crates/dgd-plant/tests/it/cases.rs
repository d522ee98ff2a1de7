//! Which cases an order makes, and how they are filed.

use dgd_plant::{
    Case, EFFECTS, Kind, Level, Order, PASSING, RECURRING, Severity, conceal, record, write_case,
    write_case_well_toml, write_truth,
};

use crate::conceal::{close, order, param};

#[test]
fn same_order_gives_the_same_bytes_and_another_seed_others() {
    let files = |seed: u64, index: usize| {
        let order = Order {
            seed,
            level: Level::Two,
            kind: Kind::Mix,
            severity: None,
            effect: None,
            hours: None,
            viscosity: 1.0,
        };
        let case = conceal(&order, index);
        let r = record(&case.plan).unwrap();
        let mut out = Vec::new();
        write_case(&case, &r, &mut out).unwrap();
        write_case_well_toml(&case, &mut out).unwrap();
        write_truth(&case, &r, &mut out).unwrap();
        out
    };
    assert_eq!(files(5, 3), files(5, 3));
    assert_ne!(files(5, 3), files(6, 3));
    assert_ne!(files(5, 3), files(5, 4));
}

#[test]
fn severities_scale_the_same_draw() {
    let size = |severity| {
        let case = conceal(
            &Order {
                severity: Some(severity),
                ..order(Kind::Single, Some("influx"))
            },
            0,
        );
        param(&case, "rate_m3_s")
    };
    let moderate = size(Severity::Moderate);
    assert!((0.0017..0.0027).contains(&moderate));
    for severity in Severity::ALL {
        close(size(severity), severity.factor() * moderate, 1e-9);
        assert_eq!(Severity::named(severity.name()), Some(severity));
    }
    assert_eq!(Severity::named("huge"), None);
}

#[test]
fn mix_holds_its_shares_and_goes_through_all_effects_and_severities() {
    let mix = Order {
        severity: None,
        ..order(Kind::Mix, None)
    };
    let cases: Vec<Case> = (0..200).map(|i| conceal(&mix, i)).collect();
    let with = |n: usize| cases.iter().filter(|c| c.hidden.len() == n).count();
    let unknown = cases
        .iter()
        .filter(|c| c.hidden.iter().any(|h| h.effect == "unknown"))
        .count();
    assert_eq!((with(0), with(2), unknown), (30, 30, 20));
    assert_eq!(with(1) - unknown, 120);
    let mut seen: Vec<(&str, &str)> = cases
        .iter()
        .filter(|c| c.hidden.len() == 1 && c.hidden[0].effect != "unknown")
        .map(|c| (c.hidden[0].effect, c.hidden[0].severity.name()))
        .collect();
    seen.sort_unstable();
    seen.dedup();
    assert_eq!(seen.len(), EFFECTS.len() * Severity::ALL.len());
    for c in cases.iter().filter(|c| c.hidden.len() == 2) {
        assert_ne!(c.hidden[0].effect, c.hidden[1].effect);
    }
}

#[test]
fn several_are_three_or_four_and_each_another() {
    let cases: Vec<Case> = (0..48)
        .map(|i| conceal(&order(Kind::Several, None), i))
        .collect();
    let with = |n: usize| cases.iter().filter(|c| c.hidden.len() == n).count();
    assert!(with(3) > 10 && with(4) > 10 && with(3) + with(4) == 48);
    for (case, first) in cases.iter().zip(EFFECTS.iter().cycle()) {
        assert_eq!(case.hidden[0].effect, *first);
        let mut names: Vec<&str> = case.hidden.iter().map(|h| h.effect).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), case.hidden.len());
        assert_eq!(case.plan.causes.len(), case.hidden.len());
    }
}

#[test]
fn what_passes_ends_within_the_recording_and_what_recurs_comes_twice() {
    for (kind, ids) in [
        (Kind::Passing, &PASSING[..]),
        (Kind::Recurring, &RECURRING[..]),
    ] {
        for (index, id) in ids.iter().cycle().take(4 * ids.len()).enumerate() {
            let case = conceal(&order(kind, None), index);
            let [hidden] = &case.hidden[..] else {
                panic!("{:?}", case.hidden);
            };
            assert_eq!(hidden.effect, *id);
            let end_s = case.plan.samples() as f64;
            let (from, to) = hidden.interval_s.unwrap();
            assert!(from > 0.1 * end_s && to - from > 0.09 * end_s);
            let last = match hidden.again_s {
                Some((begins, ends)) => {
                    assert_eq!(kind, Kind::Recurring);
                    assert_eq!(ends - begins, to - from);
                    assert!(begins - to > 0.09 * end_s);
                    ends
                }
                None => {
                    assert_eq!(kind, Kind::Passing);
                    to
                }
            };
            assert!(last < 0.91 * end_s, "{last} of {end_s}");
        }
    }
}

#[test]
fn level_two_lacks_transmitters_and_samples_slower_at_times() {
    let two = Order {
        level: Level::Two,
        ..order(Kind::Clean, None)
    };
    let cases: Vec<Case> = (0..60).map(|i| conceal(&two, i)).collect();
    for s in [1, 2, 5] {
        assert!(cases.iter().any(|c| c.sampling_s == s));
    }
    for c in [5, 6, 7, 8] {
        assert!(cases.iter().any(|case| case.absent[c]));
    }
    assert!(
        cases
            .iter()
            .all(|c| c.absent.iter().filter(|&&a| a).count() <= 1)
    );
}

#[test]
fn every_form_opens_as_its_reader_expects() {
    let two = Order {
        level: Level::Two,
        ..order(Kind::Clean, None)
    };
    for (ending, magic) in [
        ("mat", &b"MATLAB 5.0 MAT-file"[..]),
        ("mcap", &b"\x89MCAP0\r\n"[..]),
        ("csv", &b"t"[..]),
    ] {
        let case = (0..40)
            .map(|i| conceal(&two, i))
            .find(|c| c.form.ending() == ending)
            .unwrap();
        let r = record(&case.plan).unwrap();
        let mut out = Vec::new();
        write_case(&case, &r, &mut out).unwrap();
        assert!(out.starts_with(magic), "{ending}");
        if ending == "csv" {
            let rows = r.time_s.len().div_ceil(case.sampling_s);
            let text = String::from_utf8(out).unwrap();
            assert_eq!(text.lines().count(), rows + 2);
            let columns = 11 - case.absent.iter().filter(|&&a| a).count();
            assert!(text.lines().all(|l| l.split(',').count() == columns));
        }
        let mut toml = Vec::new();
        write_case_well_toml(&case, &mut toml).unwrap();
        let toml = String::from_utf8(toml).unwrap();
        for c in 0..10 {
            let there = toml.contains(&format!("\"{}\"", case.dialect.tags[c]));
            assert_eq!(there, !case.absent[c], "{}", case.dialect.tags[c]);
        }
    }
}

#[test]
fn what_shows_only_around_a_standstill_gets_one_at_level_two_too() {
    for effect in ["gel_strength", "line_drainage", "booster_line_storage"] {
        for index in 0..6 {
            let two = Order {
                level: Level::Two,
                ..order(Kind::Single, Some(effect))
            };
            let r = record(&conceal(&two, index).plan).unwrap();
            let stood = r.truth.iter().any(|s| s.pump_speed_pct <= 0.0);
            assert!(stood, "{effect} {index}");
        }
    }
}
