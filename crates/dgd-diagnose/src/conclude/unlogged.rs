//! Whether a pump that is not logged may be what looks like a large gain of a flow meter, or like an influx.

use crate::diagnosis::Finding;
use crate::record::Record;
use crate::selection::Named;
use dgd_recording::{Channel, STANDING_M3_S};

/// Share by which strokes and meters may be off together; one of a liner or a gallon may be off by more. Set by hand.
const GAIN: f64 = 0.15;
/// Rate of a pump rather than of a kick, m³/s. Set by hand.
const PUMPED_M3_S: f64 = 0.01;

/// A pump whose flow reads 0 throughout.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Unlogged(Channel);

impl Unlogged {
    /// The first of mud pump and booster that never shows a flow.
    pub(super) fn in_record(record: &Record) -> Option<Self> {
        let pumps = [
            (Channel::MudPumpFlow, &record.filled.mud_pump),
            (Channel::BoosterFlow, &record.filled.booster),
        ];
        let rests = |flow: &[f64]| flow.iter().all(|q| q.abs() <= STANDING_M3_S);
        let mut idle = pumps.into_iter().filter(|(_, flow)| rests(flow));
        idle.next().map(|(channel, _)| Self(channel))
    }

    /// Whether it may be what a cause is taken for: more comes back than is logged as pumped in.
    pub(super) fn may_be(named: &Named) -> bool {
        let strength = named
            .applied
            .parameters
            .first()
            .copied()
            .unwrap_or_default();
        match named.applied.effect.about().id {
            "return_flow_gain" => strength > GAIN,
            "inflow_gain" => strength < -GAIN,
            "influx" => strength >= PUMPED_M3_S,
            _ => false,
        }
    }

    /// Says so of a finding.
    pub(super) fn tell(self, finding: &mut Finding) {
        finding.same_as = Some(format!(
            "a pump that is not logged: `{}` reads 0 throughout",
            self.0.name()
        ));
    }
}

#[cfg(test)]
mod tests {
    use super::Unlogged;
    use crate::test_rig::{found, named, steady};
    use dgd_recording::Channel;

    #[test]
    fn a_pump_without_a_flow_is_told_of_what_it_may_be() {
        let mut record = steady(10);
        let idle = Unlogged::in_record;
        assert_eq!(idle(&record), None);
        record.filled.booster.fill(0.0);
        let found_idle = idle(&record);
        assert_eq!(found_idle, Some(Unlogged(Channel::BoosterFlow)));
        let mut finding = found("influx", 0.9);
        found_idle
            .into_iter()
            .for_each(|idle| idle.tell(&mut finding));
        let told = finding.same_as.unwrap_or_default();
        assert_eq!(
            told,
            "a pump that is not logged: `booster_flow` reads 0 throughout"
        );
        record.filled.booster[7] = 0.02;
        assert_eq!(idle(&record), None);
    }

    #[test]
    fn more_that_comes_back_than_a_meter_or_a_kick_makes_may_be_a_pump() {
        for (id, strength, may_be) in [
            ("return_flow_gain", 0.3, true),
            ("return_flow_gain", 0.1, false),
            ("return_flow_gain", -0.3, false),
            ("inflow_gain", -0.3, true),
            ("inflow_gain", 0.3, false),
            ("influx", 0.02, true),
            ("influx", 0.004, false),
            ("lost_circulation", 0.02, false),
        ] {
            assert_eq!(
                Unlogged::may_be(&named(id, &[strength])),
                may_be,
                "{id} {strength}"
            );
        }
    }
}
