//! What an archive leaves out, and which causes that makes up.
//!
//! A historian that keeps a few readings and draws straight lines between them cuts short what the level does within minutes: in the mass balance
//! that is mud which moves to and fro. A deadband on the pump's speed leaves the head to move without it.

use crate::diagnosis::{Archived, Finding};
use crate::selection::Named;

/// Effects that move mud to and fro in the riser.
const TO_AND_FRO: [&str; 4] = [
    "u_tube",
    "annulus_area",
    "pipe_displacement",
    "booster_line_storage",
];
/// Effects by which the head moves without the speed.
const OF_THE_HEAD: [&str; 2] = ["gas_in_pump", "pump_wear"];

impl Archived {
    /// Whether anything can be made up.
    fn any(self) -> bool {
        self.pressures || self.speed
    }

    /// Whether what was left out can make up an effect: where flows and pressures lie on lines, any.
    pub(super) fn speaks_against(self, named: &Named) -> bool {
        let id = named.applied.id();
        self.pressures && (self.flows || TO_AND_FRO.contains(&id))
            || self.speed && OF_THE_HEAD.contains(&id)
    }

    /// Says so of a finding: of what it can make up, and of what the catalogue does not hold.
    pub(super) fn tell(self, named: &Named, finding: &mut Finding) {
        let can = self.speaks_against(named) || named.applied.is_correction();
        if self.any() && can {
            finding
                .also_same_as("what an archive left out of the recording: see the warnings".into());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Archived;
    use crate::test_rig::{found, named};
    use dgd_effects::catalogue;

    #[test]
    fn what_is_left_out_speaks_against_what_it_can_make_up() {
        let against = |archived: Archived| -> Vec<&str> {
            let ids = catalogue().iter().map(|effect| effect.about());
            let spoken = ids.filter(|about| {
                let parameters: Vec<f64> = about.parameters.iter().map(|p| p.low).collect();
                archived.speaks_against(&named(about.id, &parameters))
            });
            spoken.map(|about| about.id).collect()
        };
        let [pressures, flows, speed] = [
            (true, false, false),
            (false, true, false),
            (false, false, true),
        ]
        .map(|(pressures, flows, speed)| Archived {
            pressures,
            flows,
            speed,
        });
        assert_eq!(against(Archived::default()), [""; 0]);
        assert_eq!(against(flows), [""; 0]);
        let mut to_and_fro = against(pressures);
        to_and_fro.sort_unstable();
        assert_eq!(
            to_and_fro,
            [
                "annulus_area",
                "booster_line_storage",
                "pipe_displacement",
                "u_tube"
            ]
        );
        let mut of_the_head = against(speed);
        of_the_head.sort_unstable();
        assert_eq!(of_the_head, ["gas_in_pump", "pump_wear"]);
        let both = Archived {
            flows: true,
            ..pressures
        };
        assert_eq!(against(both).len(), catalogue().len());
    }

    #[test]
    fn it_is_told_of_what_it_can_make_up() {
        let told = |archived: Archived, id: &str| {
            let mut finding = found(id, 0.9);
            archived.tell(&named(id, &[0.1; 4]), &mut finding);
            finding.same_as
        };
        let pressures = Archived {
            pressures: true,
            ..Archived::default()
        };
        assert!(told(pressures, "u_tube").is_some_and(|told| told.contains("an archive left out")));
        assert_eq!(told(pressures, "pump_wear"), None);
        assert_eq!(told(Archived::default(), "u_tube"), None);
    }
}
