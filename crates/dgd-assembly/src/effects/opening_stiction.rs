//! The valve sticks, and slips when its command has gone far enough.

use crate::effect::{About, Effect, Now, ParameterAbout, Place, Size};
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "opening_stiction",
    title: "the valve sticks until its command is a band away, then slips part of the way",
    kinds: &[Kind::Valve, Kind::Orifice],
    equation: "z = z_set − (1 − slip) band sign(z_set − z⁻) where abs(z_set − z⁻) > band; z = z⁻ elsewhere",
    source: "He, Q. P., Wang, J., Pottmann, M. and Qin, S. J., Industrial & Engineering Chemistry Research 46 (2007), the model of two parameters; Choudhury, M. A. A. S., Thornhill, N. F. and Shah, S. L., Control Engineering Practice 13 (2005)",
    excited_by: "small moves of the opening, of the band and below, between large ones",
    confusable: &[
        (
            "opening_play",
            "play is taken up without a jump: a slow ramp of the opening separates",
        ),
        (
            "opening_lag",
            "a late valve reaches its command: long holds separate",
        ),
    ],
    parameters: &[
        ParameterAbout {
            name: "band",
            meaning: "distance of the command at which it lets go",
            size: Size::One,
            low: 0.0,
            high: 0.2,
            neutral: 0.0,
            usual: 0.02,
        },
        ParameterAbout {
            name: "slip",
            meaning: "share of the band that it then slips",
            size: Size::One,
            low: 0.05,
            high: 1.0,
            neutral: 0.5,
            usual: 0.5,
        },
    ],
};

impl Effect for This {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn fits(&self, place: &Place) -> bool {
        place.driven && place.in_time
    }

    fn has_command(&self) -> bool {
        true
    }

    fn command(&self, now: &Now<'_>, held: bool, values: &mut [f64]) {
        let (band, slip) = (now.p[0].max(0.0), now.p[1].clamp(0.0, 1.0));
        let mut z = values.first().copied().unwrap_or_default();
        for value in values {
            z = stuck(band, slip, held, z, *value);
            *value = z;
        }
    }
}

/// Where the valve that stood at `z` is once its command has come to `set`: in one jump if it is held between samples, otherwise
/// evenly.
fn stuck(band: f64, slip: f64, held: bool, z: f64, set: f64) -> f64 {
    let away = set - z;
    if !(away.abs() > band) {
        return z;
    }
    let jump = slip * band;
    // Along a ramp it slips each time that the command is a band away: so often, and the rest it stays behind.
    let slips = ((away.abs() - band) / jump).ceil();
    if held || !slips.is_finite() {
        return set - (band - jump) * away.signum();
    }
    z + slips * jump * away.signum()
}

#[cfg(test)]
mod tests {
    use super::stuck;

    fn close(found: &[f64], expected: &[f64]) {
        for (a, b) in found.iter().zip(expected) {
            assert!((a - b).abs() < 1e-12, "{found:?}");
        }
    }

    #[test]
    fn a_sticking_valve_does_not_follow_a_trim_and_jumps_beyond_it() {
        let mut z = 0.5;
        let way = [0.55, 0.59, 0.61, 0.55, 0.5, 0.46];
        // f_S = 0.1 and f_D = 0.04: from 0.61 it stops at 0.57, and holds until the command is below 0.47.
        let found = way.map(|set| {
            z = stuck(0.1, 0.6, true, z, set);
            z
        });
        close(&found, &[0.5, 0.5, 0.57, 0.57, 0.57, 0.5]);
    }

    #[test]
    fn along_a_ramp_it_goes_in_steps_of_the_slip_however_often_the_ramp_is_sampled() {
        let once = stuck(0.1, 0.5, false, 0.2, 0.73);
        let mut often = 0.2;
        for k in 0..=5300u32 {
            often = stuck(0.1, 0.5, false, often, 0.2 + 1e-4 * f64::from(k));
        }
        close(&[once, often], &[0.65, 0.65]);
        assert!((0.73 - once).abs() <= 0.1);
    }

    #[test]
    fn without_a_band_it_follows_and_without_a_slip_it_is_play() {
        close(&[stuck(0.0, 0.6, false, 0.3, 0.7)], &[0.7]);
        close(&[stuck(0.05, 0.0, false, 0.3, 0.7)], &[0.65]);
        close(&[super::super::played(0.1, 0.3, 0.7)], &[0.65]);
    }
}
