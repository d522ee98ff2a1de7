//! The thesis's ladder: what chapter 3 found in the field data appears in the stand-in.

use std::sync::OnceLock;

use dgd_plant::{Plan, Recording, record};

use crate::solver::screen;

/// The full recording, made once.
pub(crate) fn gom() -> &'static Recording {
    static GOM: OnceLock<Recording> = OnceLock::new();
    GOM.get_or_init(|| record(&Plan::gom(Plan::GOM_SEED)).unwrap())
}

#[test]
fn friction_ladder_of_the_full_recording_has_the_signs_and_sizes_of_section_3_3() {
    let s = screen(gom());
    let (now, mse_now) = s.quadratic(0);
    let (late, mse_late) = s.quadratic(13);
    let (cubic, mse_cubic) = s.cubic(13);
    assert!(
        now[0] < 0.0 && late[0] < 0.0,
        "C = {} and {}",
        now[0],
        late[0]
    );
    assert!(cubic[1] > 0.0 && cubic[2] > 0.0, "D, E = {cubic:?}");
    // Thesis: 21.89 / 14.79 = 1.48 and 14.61 / 14.79 = 0.988.
    assert!(
        (1.3..1.7).contains(&(mse_now / mse_late)),
        "{}",
        mse_now / mse_late
    );
    assert!(
        (0.97..1.0).contains(&(mse_cubic / mse_late)),
        "{}",
        mse_cubic / mse_late
    );
}

#[test]
fn best_delay_of_the_full_recording_is_13_s() {
    assert_eq!(screen(gom()).best_delay(), 13);
}

#[test]
fn screening_keeps_about_a_sixth_of_the_full_recording() {
    let s = screen(gom());
    let kept = s.keep.iter().filter(|&&k| k).count();
    // Thesis: 52,579 of 305,820.
    assert!((50_000..57_000).contains(&kept), "{kept}");
}

#[test]
fn pump_of_the_full_recording_is_convex_until_the_exponents_are_free() {
    let s = screen(gom());
    let (c, mse) = s.head(13, 2.0, 2.0);
    assert!(c[2] < 0.0, "c2 = {}", c[2]);
    let (n0, n2, free) = s.exponents(13);
    // Thesis: 1.3907 / 0.071 = 19.6.
    assert!(
        (15.0..30.0).contains(&(mse / free)),
        "{} at {n0}, {n2}",
        mse / free
    );
}

#[test]
fn short_recording_has_the_same_ladder() {
    let s = screen(&record(&Plan::short(Plan::SHORT_SEED)).unwrap());
    let (now, mse_now) = s.quadratic(0);
    let (late, mse_late) = s.quadratic(13);
    let (cubic, mse_cubic) = s.cubic(13);
    assert!(now[0] < 0.0 && late[0] < 0.0);
    assert!(cubic[1] > 0.0 && cubic[2] > 0.0, "{cubic:?}");
    assert!(mse_now > 1.3 * mse_late && mse_cubic < mse_late);
    assert!((12..=14).contains(&s.best_delay()));
    let (c, mse) = s.head(13, 2.0, 2.0);
    assert!(c[2] < 0.0);
    assert!(mse > 8.0 * s.exponents(13).2);
}

#[test]
fn signs_hold_for_the_first_eight_seeds() {
    for seed in 1..=8 {
        let s = screen(&record(&Plan::gom(seed)).unwrap());
        assert!(
            s.quadratic(0).0[0] < 0.0 && s.quadratic(13).0[0] < 0.0,
            "{seed}"
        );
        let (cubic, _) = s.cubic(13);
        assert!(cubic[1] > 0.0 && cubic[2] > 0.0, "{seed}: {cubic:?}");
        let (c, mse) = s.head(13, 2.0, 2.0);
        let (_, n2, free) = s.exponents(13);
        assert!(
            c[2] < 0.0 && n2 > 1.0 && mse > 8.0 * free,
            "{seed}: {c:?}, {}",
            mse / free
        );
    }
}
