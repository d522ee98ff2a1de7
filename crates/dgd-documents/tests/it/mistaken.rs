//! A document given for one of another kind.

use crate::model::MODEL;
use crate::well::GOM;
use dgd_documents::{
    DocumentError, read_model, read_model_document, read_system, read_system_types, read_well,
};

const SYSTEM: &str = include_str!("../../../dgd-assembly/examples/two_tanks.toml");

/// The one problem, with what is said to mend it.
#[track_caller]
fn told<T: std::fmt::Debug>(outcome: Result<T, DocumentError>) -> (usize, String, String) {
    let error = outcome.unwrap_err();
    assert_eq!(error.problems.len(), 1, "{error}");
    let problem = &error.problems[0];
    let help = problem.help.clone().unwrap_or_default();
    (error.places[0].0, problem.message.clone(), help)
}

#[test]
fn one_kind_given_for_another_is_told_once_at_what_gives_it_away() {
    let line_of = |text: &str, part: &str| text.lines().position(|l| l.contains(part)).unwrap() + 1;
    let (line, message, help) = told(read_well(MODEL));
    assert_eq!(
        message,
        "this is a model of the return line, expected a well description"
    );
    assert_eq!(line, line_of(MODEL, "[well]"));
    assert!(help.contains("[mud], [geometry] and [channels]"), "{help}");
    let (line, message, help) = told(read_model(GOM));
    assert_eq!(
        message,
        "this is a well description, expected a model of the return line"
    );
    assert_eq!(line, line_of(GOM, "[mud]"));
    assert!(help.contains("`dgd fit` writes one"), "{help}");
    assert_eq!(told(read_model_document(GOM)).1, message);
    for outcome in [told(read_system(GOM)), told(read_system_types(GOM))] {
        assert_eq!(
            outcome.1,
            "this is a well description, expected the description of a system"
        );
        assert!(outcome.2.contains("[components]"), "{}", outcome.2);
    }
    assert_eq!(
        told(read_well(SYSTEM)).1,
        "this is the description of a system, expected a well description"
    );
    assert_eq!(
        told(read_model(SYSTEM)).1,
        "this is the description of a system, expected a model of the return line"
    );
}

#[test]
fn a_document_with_a_mark_of_its_own_kind_is_read_as_that_kind() {
    // Half a well description with a stray section of a model: its own gaps are told.
    let both = "[mud]\ndensity = \"1.08 sg\"\n[friction]\n";
    let error = read_well(both).unwrap_err();
    assert!(
        error.to_string().contains("[geometry] is missing"),
        "{error}"
    );
    // Nothing that gives it away.
    let neither = read_well("[odd]\n").unwrap_err();
    assert!(
        neither.to_string().contains("[mud] is missing"),
        "{neither}"
    );
}
