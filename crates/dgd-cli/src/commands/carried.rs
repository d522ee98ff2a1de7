//! The effects of a model on another recording than the one that it was identified on.

use dgd_documents::ModelDocument;
use dgd_effects::{AppliedEffect, Setting};
use dgd_identify::Prepared;
use dgd_recording::Well;
use std::path::{Path, PathBuf};

/// Takes the effects of `document`, read from `model`, to `recordings`, screened as `prepared`, where they are none of those
/// that it was identified on, of this `well`; says what that makes of effects that set in at some time, and which of them grow.
pub(super) fn carry_over(
    document: &mut ModelDocument,
    model: &Path,
    recordings: &[PathBuf],
    (well, prepared): (&Well, &Prepared),
) -> Option<String> {
    let known = document.model()?.data.recordings.clone();
    let another = !known.is_empty() && !recordings.iter().any(|path| is_among(&known, path));
    let augmented = document.augmented.as_mut().filter(|_| another)?;
    let here = Setting::of(well, &prepared.recording, &prepared.inlet_pressure_pa);
    let carried = augmented.carry_over(&here);
    let grows = match augmented.span_s {
        Some(_) => "grows here as fast as there",
        None => "grows to its strength here, however long it takes",
    };
    let told = [
        (carried.growing, grows),
        (carried.ongoing, "acts from the start here"),
        (carried.over, "is over here"),
    ]
    .into_iter()
    .filter(|(ids, _)| !ids.is_empty())
    .map(|(ids, what)| format!("{} {what}", ids.join(", ")));
    let told: Vec<String> = told.collect();
    (!told.is_empty()).then(|| {
        format!(
            "{} was identified on {}: {}",
            model.display(),
            known.join(", "),
            told.join("; ")
        )
    })
}

/// Whether a recording is one of those `known` by name, in whichever format; a name may be followed by a window.
fn is_among(known: &[String], path: &Path) -> bool {
    // A browser's second copy is `day (1).csv`: only what ends the name is a window.
    let without_window = |name: &str| {
        let (file, _) = name.strip_suffix(')')?.rsplit_once(" (")?;
        Some(file.to_owned())
    };
    let Some(own) = path.file_stem() else {
        return false;
    };
    let is_own = |name: &str| Path::new(name).file_stem() == Some(own);
    let mut names = known.iter();
    names.any(|name| is_own(name) || without_window(name).is_some_and(|name| is_own(&name)))
}

/// The effects of a model as a diagnosis of a recording with these times starts from them.
pub(super) fn effects_here(document: ModelDocument, time_s: &[f64]) -> Vec<AppliedEffect> {
    let span_s = match time_s {
        [from, .., to] => (*from, *to),
        _ => (0.0, 0.0),
    };
    let model = document.augmented;
    model.map_or_else(Vec::new, |model| model.effects_over(span_s))
}

#[cfg(test)]
mod tests {
    use super::is_among;
    use std::path::Path;

    #[test]
    fn a_recording_is_known_by_its_name_in_any_format_and_window() {
        let known = [
            "day_a.csv".to_owned(),
            "day_b.mat (200 to 900 s)".to_owned(),
            "rig (1).csv".to_owned(),
            "rig (2).csv (0 to 60 s)".to_owned(),
        ];
        for same in [
            "day_a.csv",
            "else/day_a.mcap",
            "day_b.mat",
            "rig (1).mat",
            "rig (2).csv",
        ] {
            assert!(is_among(&known, Path::new(same)), "{same}");
        }
        for other in ["day_c.csv", "rig.csv", "rig (3).csv"] {
            assert!(!is_among(&known, Path::new(other)), "{other}");
        }
    }
}
