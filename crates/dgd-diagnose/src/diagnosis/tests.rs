//! Claims about names that machines read.

use crate::{Step, Verdict};

#[test]
fn every_step_and_every_verdict_has_a_name_of_its_own() {
    let verdicts = [
        Verdict::Consistent,
        Verdict::Explained,
        Verdict::PartlyExplained,
        Verdict::Unexplained,
    ];
    for (names, join) in [
        (Step::ALL.map(Step::name).to_vec(), '-'),
        (verdicts.map(Verdict::name).to_vec(), '_'),
    ] {
        for (k, name) in names.iter().enumerate() {
            assert!(!names[..k].contains(name), "{name} twice");
            assert!(!name.is_empty());
            assert!(
                name.chars().all(|c| c.is_ascii_lowercase() || c == join),
                "{name}"
            );
        }
    }
}
