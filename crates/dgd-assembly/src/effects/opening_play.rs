//! The valve stays where it is until its play is taken up.

use super::follower::Follower;
use super::played;
use crate::effect::{About, ParameterAbout, Size};
use crate::spec::Kind;

pub(crate) static THIS: Follower = Follower {
    about: &ABOUT,
    rate: |now, z, set| (played(now.p[0], z, set) - z) / (MEMORY * now.scale.time_s),
    input: |now, z, set| played(now.p[0], z, set),
};

static ABOUT: About = About {
    id: "opening_play",
    title: "the valve stays where it is until its play is taken up",
    kinds: &[Kind::Valve, Kind::Orifice],
    equation: "z = min(max(z, z_set − play/2), z_set + play/2)",
    source: "Krasnosel'skii, M. A. and Pokrovskii, A. V., Systems with Hysteresis (1989), the play; Choudhury, M. A. A. S., Thornhill, N. F. and Shah, S. L., Control Engineering Practice 13 (2005), of valves",
    excited_by: "an opening that turns, by more than the play",
    confusable: &[
        (
            "opening_lag",
            "a late valve reaches its command: long holds separate",
        ),
        (
            "opening_characteristic",
            "a characteristic is the same upwards and downwards: the same opening from both sides separates",
        ),
    ],
    parameters: &[ParameterAbout {
        name: "play",
        meaning: "width of the play",
        size: Size::One,
        low: 0.0,
        high: 0.2,
        neutral: 0.0,
        usual: 0.02,
    }],
};

/// Share of the usual time in which the state takes over where the valve has been pushed to: shorter than the time between two
/// turns, and long enough for the integrator.
const MEMORY: f64 = 0.02;

#[cfg(test)]
mod tests {
    use super::played;

    #[test]
    fn a_valve_with_play_stays_behind_on_either_way_and_stands_while_it_turns() {
        let mut z = 0.5;
        let mut follow = |set| {
            z = played(0.1, z, set);
            z
        };
        let way = [0.6, 0.7, 0.68, 0.62, 0.5, 0.52];
        let found = way.map(&mut follow);
        let expected = [0.55, 0.65, 0.65, 0.65, 0.55, 0.55];
        for (a, b) in found.iter().zip(expected) {
            assert!((a - b).abs() < 1e-12, "{found:?}");
        }
        assert_eq!(played(0.0, 0.3, 0.7), 0.7);
    }
}
