//! What must hold of every document, sound or hostile: a refusal says why and where, and what
//! is read is written and read again the same.
//!
//! `dgd-documents` includes this file in its tests, so that the stable toolchain holds it too.

use dgd_assembly::effects_for;
use dgd_documents::{
    DocumentError, Problem, line_and_column, read_model, read_model_document, read_system,
    read_system_types, read_well, return_line_system, write_fitted_system, write_model_document,
    write_well,
};
use std::fmt::Debug;

/// A `well.toml`; whether it was read.
///
/// # Panics
/// If one of the above does not hold.
pub fn well(text: &str) -> bool {
    let Some(well) = told(text, read_well(text)) else {
        return false;
    };
    let written = write_well(&well);
    same(&well, &reread(&written, read_well(&written)));
    true
}

/// A `model.toml`, with or without effects; whether it was read.
///
/// # Panics
/// If one of the above does not hold.
pub fn model(text: &str) -> bool {
    let Some(document) = told(text, read_model_document(text)) else {
        return false;
    };
    if let Some(model) = told(text, read_model(text)) {
        // Some models are no well-posed system, but all are told as such.
        let system = return_line_system(&model);
        if let Err(error) = read_system(&system) {
            placed(&system, &error);
        }
    }
    let written = write_model_document(&document);
    same(&document, &reread(&written, read_model_document(&written)));
    true
}

/// A `system.toml`, checked as `dgd system check` does; whether it is well posed.
///
/// # Panics
/// If one of the above does not hold.
pub fn system(text: &str) -> bool {
    if let Err(error) = read_system_types(text) {
        placed(text, &error);
        return false;
    }
    let document = match read_system(text) {
        Ok(document) => document,
        Err(error) => {
            placed(text, &error);
            return false;
        }
    };
    let assembly = &document.assembly;
    let (states, outputs, inputs) = (assembly.states(), assembly.outputs(), assembly.inputs());
    assert_eq!(assembly.accuracies().len(), outputs.len());
    assert_eq!(document.theta().len(), assembly.parameters().len());
    for p in assembly.parameters() {
        assert!(p.low <= p.start && p.start <= p.high, "{p:?}");
    }
    let _ = (assembly.warnings(), assembly.edges(), effects_for(assembly));

    let written = assembly.to_toml();
    let again = match read_system(&written) {
        Ok(again) => again.assembly,
        Err(error) => panic!("what was written is refused: {error}\n{written}"),
    };
    same(assembly.system(), again.system());
    assert_eq!(
        (states, outputs, inputs),
        (again.states(), again.outputs(), again.inputs())
    );
    if let Some(fitted) = &document.fitted
        && let Ok(written) = write_fitted_system(assembly, fitted)
    {
        match read_system(&written) {
            Ok(again) => same(&document.fitted, &again.fitted),
            Err(error) => panic!("what was written is refused: {error}\n{written}"),
        }
    }
    true
}

/// What was read, if it was.
fn told<T>(text: &str, outcome: Result<(T, Vec<Problem>), DocumentError>) -> Option<T> {
    match outcome {
        Ok((value, warnings)) => {
            assert!(
                warnings
                    .iter()
                    .all(|p| p.span.end <= text.len() && !p.message.is_empty())
            );
            Some(value)
        }
        Err(error) => {
            placed(text, &error);
            None
        }
    }
}

fn placed(text: &str, error: &DocumentError) {
    assert!(!error.problems.is_empty(), "refused without a reason");
    assert_eq!(error.problems.len(), error.places.len());
    for (problem, place) in error.problems.iter().zip(&error.places) {
        assert!(!problem.message.is_empty());
        assert!(
            problem.span.start <= problem.span.end && problem.span.end <= text.len(),
            "{problem:?}"
        );
        if error.problems.len() < 20 {
            assert_eq!(*place, line_and_column(text, problem.span.start));
        }
    }
    assert!(error.to_string().starts_with("line "));
}

fn reread<T>(written: &str, outcome: Result<(T, Vec<Problem>), DocumentError>) -> T {
    match outcome {
        Ok((value, warnings)) => {
            assert!(
                warnings.is_empty(),
                "what was written is warned of: {warnings:?}\n{written}"
            );
            value
        }
        Err(error) => panic!("what was written is refused: {error}\n{written}"),
    }
}

/// Equal, NaN equal to NaN.
fn same<T: PartialEq + Debug>(read: &T, again: &T) {
    if read != again {
        assert_eq!(format!("{read:?}"), format!("{again:?}"));
    }
}
