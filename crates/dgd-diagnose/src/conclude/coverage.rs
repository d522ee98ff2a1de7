//! Whether the recording can judge each relation for long enough that nothing seen means nothing there.

use crate::diagnosis::Check;
use crate::layout::{BALANCE_BLOCKS, Section};
use crate::record::Record;
use crate::relations::{Rows, is_full, is_topped};
use dgd_recording::Channel;

/// Share of what is read that a relation must be judged in; a sound recording judges friction and mass balance nearly all along. Set by hand.
const LEAST: f64 = 0.5;
/// Share of the blocks below which a reading is scarce. Set by hand.
const SCARCE: f64 = 0.9;

/// The relation that is judged for too short a time.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Unjudged {
    relation: &'static str,
    /// What is seen in it alone.
    causes: &'static str,
    judged_h: f64,
    of_h: f64,
    /// The channel that it lacks most often, if it lacks one, and the share of the blocks that have it.
    lacks: Option<(Channel, f64)>,
}

impl Unjudged {
    /// Those of a recording whose relations have these rows.
    pub(super) fn of(record: &Record, rows: &Rows) -> Vec<Self> {
        let inlet = (Channel::PumpInletPressure(0), &record.inlet);
        let flow = (Channel::ReturnFlow, &record.flow);
        let friction = [flow, (Channel::PumpOutletPressure(0), &record.outlet)];
        let balance = [
            inlet,
            flow,
            (Channel::MudPumpFlow, &record.mud_pump),
            (Channel::BoosterFlow, &record.booster),
            (Channel::TopfillFlow, &record.topfill),
        ];
        let m = record.per_block;
        let told: Vec<usize> = (0..record.blocks)
            .filter(|b| {
                let from_s = record.t_s[b * m];
                record.told.between_s((from_s, from_s + record.block_s())) > 0.0
            })
            .collect();
        let has = |channel: Channel, values: &[f64], b: usize| match channel {
            Channel::TopfillFlow => is_topped(record, b),
            _ => is_full(record, values, b),
        };
        let of = |section: Section, relation, causes, channels: &[(Channel, &Vec<f64>)]| {
            let blocks = if section == Section::Balance {
                BALANCE_BLOCKS
            } else {
                1
            };
            let judged = rows.of_section(section).iter().filter(|row| **row).count();
            let judged_s = (judged * blocks) as f64 * record.block_s();
            let share = |(channel, values): &(Channel, &Vec<f64>)| {
                let whole = told.iter().filter(|b| has(*channel, values, **b)).count();
                (*channel, whole as f64 / told.len().max(1) as f64)
            };
            let lacks = channels
                .iter()
                .map(share)
                .min_by(|a, b| a.1.total_cmp(&b.1));
            (judged_s < LEAST * record.told_s()).then(|| Self {
                relation,
                causes,
                judged_h: judged_s / 3600.0,
                of_h: record.told_s() / 3600.0,
                lacks: lacks.filter(|(_, share)| *share < SCARCE),
            })
        };
        let line = of(
            Section::Friction,
            "return line's friction",
            "restrictions, gels and drifts",
            &friction,
        );
        let riser = of(
            Section::Balance,
            "riser's mass balance",
            "kicks, losses and gains of meters",
            &balance,
        );
        line.into_iter().chain(riser).collect()
    }

    /// What is not judged, and what to look for.
    pub(super) fn warning(&self) -> String {
        let Self {
            relation,
            causes,
            judged_h,
            of_h,
            lacks,
        } = self;
        let lacks = lacks.map_or_else(String::new, |(channel, share)| {
            format!(
                ". Of its readings `{channel}` is the scarcest, usable in {:.0} % of that time: is it missing, irregular, or repeating one value (`dgd inspect`)?",
                100.0 * share
            )
        });
        format!(
            "the {relation} can be judged in {judged_h:.1} of {of_h:.1} h only: {causes} at other times are not seen{lacks}"
        )
    }

    /// That the answer holds for that time only.
    pub(super) fn check(&self) -> Check {
        let Self {
            relation,
            judged_h,
            of_h,
            ..
        } = self;
        Check {
            name: "each relation can be judged for long".into(),
            passed: false,
            detail: format!(
                "{relation}: {judged_h:.1} of {of_h:.1} h; limits hold for that time only"
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

    use super::Unjudged;
    use crate::relations::{Blocks, Rows};
    use crate::test_rig::{Hidden, drilled};
    use dgd_recording::Channel;

    #[test]
    fn a_relation_that_is_hardly_judged_is_told_with_what_it_lacks() {
        let mut record = drilled(Hidden::default());
        let told =
            |record: &_| Unjudged::of(record, &Rows::of(record, &Blocks::under(record, &[])));
        assert_eq!(told(&record), []);
        let n = record.booster.len();
        record.booster[2 * n / 3..].fill(f64::NAN);
        assert_eq!(told(&record), []);
        record.booster[n / 8..].fill(f64::NAN);
        let [one] = &told(&record)[..] else {
            panic!("{:?}", told(&record));
        };
        let (channel, share) = one.lacks.unwrap();
        assert_eq!(
            (one.relation, channel),
            ("riser's mass balance", Channel::BoosterFlow)
        );
        assert!((0.1..0.15).contains(&share), "{one:?}");
        assert!(one.judged_h < 0.15 * one.of_h, "{one:?}");
        record.outlet[n / 8..].fill(f64::NAN);
        assert_eq!(told(&record).len(), 2);
    }
}
