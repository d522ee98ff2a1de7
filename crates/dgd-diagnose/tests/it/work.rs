//! What a diagnosis costs, in counts: its time goes with them, and they change with the code alone.

use super::rig::{case, recorded, tried};
use dgd_diagnose::Work;

/// The counts over so many hours of a case.
fn cost(effect: Option<&'static str>, hours: usize) -> Work {
    let mut case = case(301, effect);
    case.plan.series = vec![hours * 3600];
    let (well, recording, step_s) = recorded(&case);
    tried(&well, recording, step_s).unwrap().work
}

/// Counts that were told before. Another library of mathematical functions may move one by a hundredth.
fn assert_still(found: Work, [samples_run, hypotheses, fits]: [u64; 3]) {
    let counts = [
        ("samples run", found.samples_run, samples_run),
        ("hypotheses", found.hypotheses, hypotheses),
        ("fits", found.fits, fits),
    ];
    for (name, now, before) in counts {
        let moved = now.abs_diff(before) * 100 > before;
        assert!(!moved, "{name}: {now}, were {before}; {found:?}");
    }
}

#[test]
fn a_diagnosis_costs_what_it_did() {
    // More is slower and wants a reason; fewer are to be written down here. With the noise of a sample, not of a reading, more late meters are
    // worth a look to the second. A valley that is followed further runs the first one per cent longer. The likeliest point of a grid is
    // weighed twice, so that no signature need be held meanwhile. Where nothing is named, what remains beside stiff curves takes two fits. Beside
    // what is named in the mass balance, clocks of channels' own take forty. Whether the line's flow is laminar
    // takes two fits, and two more where something is named. What sets in is weighed as what ends where it stands out.
    assert_still(cost(None, 4), [5_181_750, 1062, 124]);
    assert_still(cost(Some("influx"), 4), [13_118_565, 2238, 317]);
}

#[test]
fn twice_the_recording_costs_about_twice_and_not_four_times() {
    let [short, long] = [4, 8].map(|hours| cost(None, hours).samples_run);
    assert!(long < 3 * short, "{short} and {long}");
}
