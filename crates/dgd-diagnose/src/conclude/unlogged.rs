//! Whether a pump that is not logged may be what looks like a large gain of a flow meter, or like an influx.

use super::clock::in_balance;
use crate::diagnosis::Finding;
use crate::record::Record;
use crate::selection::Named;
use dgd_effects::{PUMPED_M3_S, Place};
use dgd_recording::{Channel, ChannelMap, ChannelSource, STANDING_M3_S};

/// Share by which strokes and meters may be off together; one of a liner or a gallon may be off by more. Set by hand.
const GAIN: f64 = 0.15;

/// Share of the recording that an influx acts in from which on it does not come and go. Set by hand.
const MOSTLY: f64 = 0.6;

/// A pump whose flow reads 0 throughout, or is described as 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Unlogged {
    channel: Channel,
    metered: bool,
}

impl Unlogged {
    /// The first of mud pump and booster whose meter never shows a flow, or that has none: `0 gpm` is what is written where a tag is not known.
    pub(super) fn in_record(record: &Record, channels: &ChannelMap) -> Option<Self> {
        let pumps = [
            (
                Channel::MudPumpFlow,
                &channels.mud_pump_flow,
                &record.filled.mud_pump,
            ),
            (
                Channel::BoosterFlow,
                &channels.booster_flow,
                &record.filled.booster,
            ),
        ];
        let mut idle = pumps
            .into_iter()
            .filter(|(.., flow)| flow.iter().all(|q| q.abs() <= STANDING_M3_S));
        idle.next().map(|(channel, source, _)| Self {
            channel,
            metered: matches!(source, ChannelSource::Column { .. }),
        })
    }

    /// Whether it may be what a cause is taken for: all along more comes back than is logged as pumped in. A kick comes and goes, but once.
    pub(super) fn may_be_any(record: &Record, named: &[Named]) -> bool {
        let is_pumped = |n: &&Named| n.applied.id() == "influx" && strength(n) >= PUMPED_M3_S;
        let several = named.iter().filter(is_pumped).count() > 1;
        several || named.iter().any(|n| Self::may_be(record, n))
    }

    fn may_be(record: &Record, named: &Named) -> bool {
        let strength = strength(named);
        let acts_s = || {
            record
                .told
                .between_s(named.applied.interval_s(record.setting.span_s))
        };
        match named.applied.id() {
            "return_flow_gain" => strength > GAIN,
            "inflow_gain" => strength < -GAIN,
            "influx" => strength >= PUMPED_M3_S && acts_s() > MOSTLY * record.told_s(),
            _ => false,
        }
    }

    /// Says so of a finding: of one that it upsets, and of a correction by which more flows in than is logged.
    pub(super) fn tell(self, named: &Named, upset: bool, finding: &mut Finding) {
        let more = (named.applied.curve()).is_some_and(|curve| {
            curve.place == Place::Balance && curve.knots.iter().sum::<f64>() > 0.0
        });
        if more || upset && in_balance(named) {
            let told = self.told();
            finding.also_same_as(format!("a pump that is not logged: {told}"));
        }
    }

    /// That it may be so, and what to do then.
    pub(super) fn warning(self) -> String {
        format!(
            "is a pump not logged? {}, and more comes back all along than is logged as pumped in. If it ran, give its flow {} in the \
             well description",
            self.told(),
            if self.metered {
                "another column"
            } else {
                "its column"
            }
        )
    }

    fn told(self) -> String {
        let is = if self.metered {
            "reads 0 throughout"
        } else {
            "is described as 0"
        };
        format!("`{}` {is}", self.channel.name())
    }
}

fn strength(named: &Named) -> f64 {
    let strength = named.applied.parameters.first();
    strength.copied().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

    use super::Unlogged;
    use crate::record::Record;
    use crate::relations::Applied;
    use crate::selection::Named;
    use crate::test_rig::{found, named, recorded, steady};
    use dgd_effects::{Curve, KNOTS, Place, Quantity};
    use dgd_recording::{Channel, ChannelSource};
    use dgd_units::Unit;

    /// By a description in which the booster is a column.
    fn idle(record: &Record) -> Option<Unlogged> {
        let mut channels = recorded(record, 0.0).0.channels;
        channels.booster_flow = ChannelSource::column("FT2", Unit::parse("m3/s").unwrap());
        Unlogged::in_record(record, &channels)
    }

    #[test]
    fn a_meter_without_a_flow_is_a_pump_that_may_run() {
        let mut record = steady(10);
        assert_eq!(idle(&record), None);
        record.filled.booster.fill(0.0);
        let booster = |metered| Unlogged {
            channel: Channel::BoosterFlow,
            metered,
        };
        assert_eq!(idle(&record), Some(booster(true)));
        let mut well = recorded(&record, 0.0).0;
        well.channels.booster_flow = ChannelSource::Constant { si: 0.0 };
        let described = Unlogged::in_record(&record, &well.channels);
        assert_eq!(described, Some(booster(false)));
        let warning = described.unwrap().warning();
        assert!(
            warning.contains("`booster_flow` is described as 0") && warning.contains("its column"),
            "{warning}"
        );
        record.filled.booster[7] = 0.02;
        assert_eq!(idle(&record), None);
    }

    #[test]
    fn more_that_comes_back_than_a_meter_or_a_kick_makes_may_be_a_pump() {
        let record = steady(100);
        let all = record.told_s();
        for (id, parameters, may_be) in [
            ("return_flow_gain", [0.3, 0.0, 0.0, 0.0], true),
            ("return_flow_gain", [0.1, 0.0, 0.0, 0.0], false),
            ("return_flow_gain", [-0.3, 0.0, 0.0, 0.0], false),
            ("inflow_gain", [-0.3, 0.0, 0.0, 0.0], true),
            ("inflow_gain", [0.3, 0.0, 0.0, 0.0], false),
            ("influx", [0.02, 0.1 * all, 0.8 * all, 0.1], true),
            ("influx", [0.02, 0.1 * all, 0.4 * all, 0.1], false),
            ("influx", [0.004, 0.1 * all, 0.8 * all, 0.1], false),
            ("lost_circulation", [0.02, 0.0, 0.0, 0.0], false),
        ] {
            let one = named(id, &parameters);
            assert_eq!(
                Unlogged::may_be(&record, &one),
                may_be,
                "{id} {parameters:?}"
            );
            assert_eq!(Unlogged::may_be_any(&record, &[one]), may_be);
        }
        // It is pumped now and then.
        let kick = |rate: f64, from: f64| named("influx", &[rate, from * all, 0.2 * all, 0.1]);
        let any = |named: &[Named]| Unlogged::may_be_any(&record, named);
        assert!(any(&[kick(0.015, 0.1), kick(0.014, 0.6)]));
        assert!(!any(&[kick(0.015, 0.1), kick(0.004, 0.6)]));
    }

    #[test]
    fn it_is_told_of_what_it_upsets_and_of_more_that_flows_in_beside_what_is_told_already() {
        let pump = Unlogged {
            channel: Channel::BoosterFlow,
            metered: true,
        };
        let told = |named: &Named, upset: bool, before: Option<&str>| {
            let mut finding = found("influx", 0.9);
            finding.same_as = before.map(str::to_owned);
            pump.tell(named, upset, &mut finding);
            finding.same_as.unwrap_or_default()
        };
        let says = "a pump that is not logged: `booster_flow` reads 0 throughout";
        let kick = named("influx", &[0.02, 0.0, 900.0, 0.1]);
        assert_eq!(told(&kick, true, None), says);
        assert_eq!(
            told(&kick, true, Some("a kick")),
            format!("a kick; or {says}")
        );
        assert_eq!(told(&kick, false, None), "");
        assert_eq!(told(&named("pump_wear", &[0.1, 0.0]), true, None), "");
        let curve = |place: Place, flow: f64| Named {
            applied: Applied::from(&Curve::new(
                place,
                Quantity::Time,
                (0.0, 1e4),
                vec![flow; KNOTS],
            )),
            ..named("influx", &[0.0; 4])
        };
        assert_eq!(told(&curve(Place::Balance, 1e-3), false, None), says);
        assert_eq!(told(&curve(Place::Balance, -1e-3), false, None), "");
        assert_eq!(told(&curve(Place::InletReading, 1e3), false, None), "");
    }
}
