//! A return flow meter that reads too much or too little, in proportion.
//!
//! The parameter is carried as the gain less 1, so that 0 changes nothing; it is reported as the gain.

use crate::{
    About, Action, Belief, Component, Effect, Parameter, Relation, Role, Search, Setting, Shown,
};
use dgd_units::Unit;

/// See the module.
pub(super) struct ReturnFlowGain;

static ABOUT: About = About {
    id: "return_flow_gain",
    title: "the return flow meter has a proportional error",
    component: Component::Instrument,
    relation: Relation::RiserMassBalance,
    equation_without: Some("q_meter = q"),
    equation: "q_meter = gain q",
    source: "proportional error of a meter; D, E, c1 and c2 of Slettebø 2015, Eqs. 2.28 and 3.26, absorb it, the mass balance (Eq. 3.45) does not",
    excited_by: "flow through the riser at any rate",
    confusable: &[
        (
            "inflow_gain",
            "run the booster alone: the mud pump then cannot be at fault",
        ),
        (
            "annulus_area",
            "hold the level: an area error shows only while the level moves",
        ),
    ],
    parameters: &[Parameter {
        name: "gain",
        meaning: "reading over truth",
        role: Role::Amplitude,
        low: -0.8,
        high: 1.0,
        usual: 0.03,
        shown: Shown::Gain,
        ..Parameter::BASE
    }],
    search: Search {
        least: Some(6e-3),
        belief: Belief {
            hurdle: 6.0,
            scale: 3.0,
        },
        ..Search::BASE
    },
};

impl Effect for ReturnFlowGain {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn begin(&self, p: &[f64], _: &Setting) -> Action {
        let gain = 1.0 + p[0];
        Box::new(move |_, changes| changes.meter_gain *= gain)
    }

    fn same_as(&self, p: &[f64], _: &Setting) -> Option<String> {
        gallons(1.0 + p[0]).map(str::to_owned)
    }

    fn memory_s(&self, _: &[f64]) -> f64 {
        0.0
    }
}

/// What a gain tells of the gallons of a flow, if it is the ratio of the two.
pub(super) fn gallons(gain: f64) -> Option<&'static str> {
    /// Share by which a gain may miss the ratio.
    const NEAR: f64 = 0.01;
    let [us, imperial] = ["gpm", "impgpm"].map(|unit| Unit::parse(unit).ok().map(|u| u.factor));
    let ratio = us? / imperial?;
    let is = |ratio: f64| (gain / ratio - 1.0).abs() < NEAR;
    if is(ratio) {
        Some("a flow in imperial gallons (impgpm) described as US gallons (gpm)")
    } else if is(1.0 / ratio) {
        Some("a flow in US gallons (gpm) described as imperial gallons (impgpm)")
    } else {
        None
    }
}
