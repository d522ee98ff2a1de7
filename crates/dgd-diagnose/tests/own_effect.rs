//! An effect of one's own, registered from outside the catalogue's crate: named, modelled and found no more. The catalogue is the
//! process's, so this stands by itself.
#![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

use dgd_diagnose::{Options, Verdict, diagnose};
use dgd_effects::{
    About, Action, Component, Effect, Parameter, RegisterError, Relation, Role, Search, Setting,
    catalogue, register,
};
use dgd_identify::prepare;
use dgd_plant::{Cause, Foreign, Kind, Level, Order, Severity, conceal, record, write_case};
use dgd_recording::Recording;
use dgd_screen::ScreenOptions;

/// A topfill meter that reads too little by a constant flow, which the plant conceals and the catalogue does not hold.
struct TopfillOffset;

static ABOUT: About = About {
    id: "topfill_offset",
    title: "the topfill meter is off by a constant flow",
    component: Component::Instrument,
    relation: Relation::RiserMassBalance,
    equation_without: None,
    equation: "A dh/dt = q_mud_pump + q_booster + q_topfill + q_0 - q",
    source: "a meter's zero; Slettebø 2015, Eq. 3.45",
    excited_by: "any recording",
    confusable: &[(
        "inflow_gain",
        "stop the mud pump: an offset stays, a gain goes",
    )],
    parameters: &[Parameter {
        name: "offset_m3_s",
        meaning: "truth less reading",
        role: Role::Amplitude,
        low: -0.01,
        high: 0.01,
        usual: 1e-3,
        ..Parameter::BASE
    }],
    search: Search::BASE,
};

impl Effect for TopfillOffset {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn begin(&self, p: &[f64], _: &Setting) -> Action {
        let offset = p[0];
        Box::new(move |_, changes| changes.inflow_m3_s += offset)
    }
}

#[test]
fn an_effect_of_ones_own_is_named_modelled_and_then_found_no_more() {
    register(&TopfillOffset).unwrap();
    let taken = RegisterError::Taken { id: ABOUT.id };
    assert_eq!(register(&TopfillOffset), Err(taken));
    let order = Order {
        seed: 304,
        level: Level::One,
        kind: Kind::Foreign,
        severity: Some(Severity::Strong),
        effect: Some("topfill_offset"),
        hours: None,
        viscosity: 1.0,
    };
    let mut case = conceal(&order, 0);
    case.plan.series = vec![case.plan.samples().min(14_400)];
    let Cause::Foreign(Foreign::TopfillOffset(truth)) = case.plan.causes[0] else {
        panic!("{:?}", case.plan.causes);
    };
    let (mut file, mut toml) = (Vec::new(), Vec::new());
    write_case(&case, &record(&case.plan).unwrap(), &mut file).unwrap();
    dgd_plant::write_case_well_toml(&case, &mut toml).unwrap();
    let (well, _) = dgd_documents::read_well(std::str::from_utf8(&toml).unwrap()).unwrap();
    let (_, table) = dgd_ingest::read(&file, &dgd_ingest::ReadOptions::default()).unwrap();
    let (recording, _) = Recording::from_table(table, &well).unwrap();
    let (recording, step_s, _) = recording.onto_grid().unwrap();
    let prepared = prepare(recording, step_s, &ScreenOptions::default()).unwrap();

    let found = diagnose(&well, &prepared, &Options::default(), &mut |_| {}).unwrap();
    assert_eq!(found.verdict, Verdict::Explained);
    let [one] = &found.findings[..] else {
        panic!("{:?}", found.findings);
    };
    assert_eq!(
        (one.effect.as_str(), one.relation),
        ("topfill_offset", Relation::RiserMassBalance)
    );
    let size = &one.parameters[0];
    assert!(
        size.ci95.0 <= truth && truth <= size.ci95.1,
        "{truth}: {size:?}"
    );
    let gain = one.held_out.as_ref().unwrap();
    assert!(gain.improvement_ci95.0 > 0.0, "{gain:?}");
    assert_eq!(found.tested.len(), catalogue().len());

    let options = Options {
        start: found.after.effects.clone(),
        ..Options::default()
    };
    let again = diagnose(&well, &prepared, &options, &mut |_| {}).unwrap();
    assert_eq!(again.verdict, Verdict::Consistent, "{:?}", again.findings);
}
