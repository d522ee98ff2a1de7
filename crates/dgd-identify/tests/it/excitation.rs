//! Where the recording excites too little, a poorer law and a warning.

use super::rig::{Rig, friction_pa, head_m};
use dgd_identify::Identification;

/// Speed and flow rest; only the meters' noise moves.
fn resting(flow_noise_m3_s: f64) -> Identification {
    let rig = Rig {
        swing: 0.0,
        samples: 4000,
        flow_noise_m3_s,
        ..Rig::default()
    };
    rig.identify()
}

fn warned(found: &Identification, words: &str) -> bool {
    found.warnings.iter().any(|w| w.contains(words))
}

#[test]
fn a_resting_recording_gives_the_textbook_law_and_says_so_whatever_the_noise() {
    let (w, q) = (55.0, 0.045);
    for noise in [2e-5, 1e-4, 5e-4, 2e-3] {
        let found = resting(noise);
        let line = found.model.return_line();
        let powers: Vec<u8> = found.model.friction.terms.iter().map(|t| t.power).collect();
        assert_eq!(powers, [2], "noise {noise}");
        let off = line.friction.loss_pa(q) / friction_pa(q) - 1.0;
        assert!(off.abs() < 0.01, "noise {noise}: friction off by {off}");
        let off = line.pump.head_m(w, q) / head_m(w, q) - 1.0;
        assert!(off.abs() < 0.001, "noise {noise}: head off by {off}");
        assert_eq!((line.pump.n0, line.pump.n2), (2.0, 2.0));
        assert!(warned(&found, "B + D q^2 + E q^3"), "{:?}", found.warnings);
        assert!(warned(&found, "D q^2 was fitted"), "{:?}", found.warnings);
        assert!(warned(
            &found,
            "cannot be determined: the flow hardly changes"
        ));
        assert!(warned(&found, "the exponents were not found"));
        assert_eq!(found.model.pump.active_constraints, ["c1 > 0", "c2 > 0"]);
        line.check().unwrap();
    }
}

#[test]
fn a_quiet_resting_pump_is_fitted_with_its_speed_alone() {
    let found = resting(2e-5);
    assert!(
        warned(&found, "c0 w^2 alone was fitted"),
        "{:?}",
        found.warnings
    );
    let pump = &found.model.pump;
    assert_eq!((pump.c1.value, pump.c2.value), (0.0, 0.0));
    assert_eq!(pump.c1.standard_error, None);
    assert!(pump.c0.standard_error.unwrap() > 0.0);
    assert_eq!(pump.samples, found.model.friction.samples);
    // Noise of the head of two means of 1 kPa: √2 · 1 kPa / ρg = 0.1335 m.
    assert!(
        (pump.mse_m2.sqrt() / 0.1335 - 1.0).abs() < 0.05,
        "{}",
        pump.mse_m2
    );
}

#[test]
fn a_small_swing_gives_up_the_cube_alone() {
    let rig = Rig {
        swing: 0.05,
        ..Rig::default()
    };
    let found = rig.identify();
    let powers: Vec<u8> = found.model.friction.terms.iter().map(|t| t.power).collect();
    assert_eq!(powers, [0, 2]);
    assert_eq!(found.model.delay_s, 12.0);
    assert!(warned(&found, "B + D q^2 was fitted"));
}
