//! No document makes a reader panic, and a refusal always says why and where.

use super::{augmented::example, model::MODEL, well::GOM};
use dgd_documents::{
    DocumentError, Problem, read_model, read_model_document, read_references, read_well,
};
use proptest::prelude::*;

/// Values of every type, right and wrong, to put in the place of others.
const VALUES: [&str; 16] = [
    "0",
    "-1",
    "9223372036854775808",
    "0xff",
    "1e999",
    "nan",
    "-inf",
    "true",
    "1979-05-27",
    "\"\"",
    "\"19.5 in\"",
    "\"-1e308 km\"",
    "\"1/0 in\"",
    "[]",
    "[{ tag = \"x\", unit = \"gpm\" }, 3]",
    "{ interval = \"1 s\", tag = \"\" }",
];

fn refusal_is_told<T>(
    source: &str,
    outcome: Result<(T, Vec<Problem>), DocumentError>,
) -> Result<(), TestCaseError> {
    let problems = match outcome {
        Ok((_, warnings)) => warnings,
        Err(error) => {
            prop_assert!(!error.problems.is_empty());
            prop_assert_eq!(error.problems.len(), error.places.len());
            let lines = source.lines().count().max(1) + 1;
            prop_assert!(
                error
                    .places
                    .iter()
                    .all(|(line, _)| (1..=lines).contains(line))
            );
            for (problem, place) in error.problems.iter().zip(&error.places) {
                let alone = dgd_documents::line_and_column(source, problem.span.start);
                prop_assert_eq!(*place, alone);
            }
            error.problems
        }
    };
    prop_assert!(problems.iter().all(|p| p.span.end <= source.len()));
    Ok(())
}

fn read_all(source: &str) -> Result<(), TestCaseError> {
    refusal_is_told(source, read_well(source))?;
    refusal_is_told(source, read_model(source))?;
    refusal_is_told(source, read_model_document(source))?;
    refusal_is_told(source, read_references(source))
}

/// One document of each kind.
fn source(which: usize) -> String {
    match which {
        0 => GOM.to_owned(),
        1 => MODEL.to_owned(),
        _ => example(),
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]

    #[test]
    fn no_text_makes_a_reader_panic(text in "[\\[\\]a-z_=\"{}0-9. \n,'æ-]{0,120}") {
        read_all(&text)?;
    }

    #[test]
    fn no_damaged_bytes_make_a_reader_panic(
        which in 0..3_usize,
        damage in proptest::collection::vec((0usize..4000, any::<u8>()), 1..4),
    ) {
        let mut bytes = source(which).into_bytes();
        for (at, byte) in damage {
            let at = at % bytes.len();
            bytes[at] = byte;
        }
        read_all(&String::from_utf8_lossy(&bytes))?;
    }

    #[test]
    fn no_exchanged_value_makes_a_reader_panic(
        which in 0..3_usize,
        damage in proptest::collection::vec((0usize..90, 0..VALUES.len()), 1..4),
    ) {
        let source = source(which);
        let mut lines: Vec<String> = source.lines().map(str::to_owned).collect();
        for (line, value) in damage {
            let line = line % lines.len();
            if let Some((key, _)) = lines[line].clone().split_once(" = ") {
                lines[line] = format!("{key} = {}", VALUES[value]);
            }
        }
        read_all(&lines.join("\n"))?;
    }

    #[test]
    fn no_lost_or_doubled_line_makes_a_reader_panic(
        which in 0..3_usize,
        damage in proptest::collection::vec((0usize..90, 0usize..90, any::<bool>()), 1..4),
    ) {
        let source = source(which);
        let mut lines: Vec<&str> = source.lines().collect();
        for (from, to, copy) in damage {
            let (from, to) = (from % lines.len(), to % lines.len());
            let line = if copy { lines[from] } else { lines.remove(from) };
            lines.insert(to.min(lines.len()), line);
        }
        read_all(&lines.join("\n"))?;
    }
}
