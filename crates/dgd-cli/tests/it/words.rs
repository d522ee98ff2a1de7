//! Words that machines read: the same wherever they come from.

use crate::bench::Bench;
use dgd_diagnose::{Step, Verdict};
use dgd_effects::catalogue;

#[test]
fn the_diagnoses_of_wells_and_of_systems_answer_in_the_same_words() {
    use dgd_revise::Verdict as OfSystem;
    let twin = |verdict: OfSystem| match verdict {
        OfSystem::Consistent => Verdict::Consistent,
        OfSystem::Explained => Verdict::Explained,
        OfSystem::PartlyExplained => Verdict::PartlyExplained,
        OfSystem::Unexplained => Verdict::Unexplained,
    };
    for verdict in [
        OfSystem::Consistent,
        OfSystem::Explained,
        OfSystem::PartlyExplained,
        OfSystem::Unexplained,
    ] {
        assert_eq!(verdict.name(), twin(verdict).name());
    }
}

#[test]
fn the_catalogue_lists_every_effect_and_step_for_people_and_machines() {
    let bench = Bench::bare();
    let said = bench.dgd("catalogue").done();
    let value = bench.json("catalogue", "dgd.catalogue/1");
    let listed = value["effects"].as_array().unwrap();
    assert_eq!(listed.len(), catalogue().len());
    for (effect, one) in catalogue().iter().zip(listed) {
        let about = effect.about();
        assert_eq!(one["effect"], about.id);
        assert_eq!(one["relation"], about.relation.name());
        assert_eq!(
            one["parameters"].as_array().unwrap().len(),
            about.parameters.len()
        );
        assert!(
            said.contains(about.id) && said.contains(about.title),
            "{said}"
        );
    }
    let steps = Step::ALL.map(Step::name);
    assert_eq!(value["steps"], serde_json::json!(steps));
    assert!(said.contains(&steps.join(", ")), "{said}");
}

#[test]
fn every_step_can_be_left_out_and_help_and_refusal_list_them_all() {
    let bench = Bench::bare();
    let help = bench.dgd("diagnose --help").done();
    let without = "diagnose no.csv --well no.toml --out out --without";
    let refused = bench.dgd(&format!("{without} edge"));
    refused.refused(&["edge"]);
    for step in Step::ALL {
        assert!(help.contains(step.name()), "{help}");
        assert!(refused.err.contains(step.name()), "{}", refused.err);
    }
    let suspected = bench.dgd("diagnose no.csv --well no.toml --out out --suspect gas_in_pumps");
    suspected.refused(&["--suspect", "gas_in_pumps", "gas_in_pump", "line_leak"]);
    // All are taken: what is refused then is the file.
    let all = Step::ALL.map(Step::name).join(",");
    bench
        .dgd(&format!("{without} {all}"))
        .refused(&["no.toml", "cannot be read"]);
}
