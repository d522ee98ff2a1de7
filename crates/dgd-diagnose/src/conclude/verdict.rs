//! The one word for what was found.

use crate::diagnosis::{Finding, Tested, Verdict, beside};

/// The verdict on findings and what was tested beside them.
///
/// - `suspects`: what alone was asked about; nothing if everything was.
/// - `sound`: whether with the findings no output runs worse where no fit has looked, and no relation keeps more than noise.
pub(super) fn verdict(
    findings: &[Finding],
    tested: &[Tested],
    suspects: &[String],
    sound: bool,
) -> Verdict {
    // What was only suspected may be less likely than not, and then is nothing that was left out; nor is a swell that nobody asked about.
    let asked = |f: &Finding| suspects.is_empty() || suspects.contains(&f.effect);
    let left_out = || findings.iter().filter(|f| f.is_likely() && asked(f));
    if left_out().next().is_none() {
        // Suspects that explain nothing leave open what stands out beside them; and more than noise is something, though nobody can tell what.
        let open = if suspects.is_empty() {
            findings.is_empty() && !sound
        } else {
            beside(tested, suspects).next().is_some()
        };
        return if open {
            Verdict::Unexplained
        } else {
            Verdict::Consistent
        };
    }
    if left_out().all(Finding::is_unknown) {
        Verdict::Unexplained
    } else if left_out().any(Finding::is_unknown) || !sound {
        Verdict::PartlyExplained
    } else {
        Verdict::Explained
    }
}

#[cfg(test)]
mod tests {
    use super::verdict;
    use crate::diagnosis::{Finding, Outcome, Tested, Verdict};
    use crate::test_rig::found;
    use dgd_effects::find;

    /// An effect that stands out, or not, beside what was asked about.
    fn standing(evidence: f64) -> Option<Tested> {
        let about = find("return_flow_gain")?.about();
        Some(Tested {
            effect: about.id,
            title: about.title,
            outcome: Outcome::NotSeen,
            evidence,
            strength: "gain",
            admissible: true,
            hurdle: 6.0,
            standard_error: None,
            limit: None,
        })
    }

    #[test]
    fn names_explain_what_is_not_named_does_not_and_what_is_left_explains_in_part() {
        let said = |found: &[Finding], sound| verdict(found, &[], &[], sound);
        let both = [found("gas_in_pump", 0.9), found("unknown", 0.9)];
        assert_eq!(said(&[], true), Verdict::Consistent);
        assert_eq!(said(&[], false), Verdict::Unexplained);
        assert_eq!(said(&both[..1], true), Verdict::Explained);
        assert_eq!(said(&both[..1], false), Verdict::PartlyExplained);
        assert_eq!(said(&both[1..], true), Verdict::Unexplained);
        assert_eq!(said(&both, true), Verdict::PartlyExplained);
    }

    #[test]
    fn of_suspects_only_what_was_asked_counts_and_what_stands_out_beside_them_is_left_open() {
        let suspects = ["gel_strength".to_owned()];
        let said = |found: &[Finding], beside: f64| {
            let tested: Vec<Tested> = standing(beside).into_iter().collect();
            verdict(found, &tested, &suspects, true)
        };
        let [unlikely, swell, gel] = [
            ("gel_strength", 0.2),
            ("heave", 0.99),
            ("gel_strength", 0.9),
        ]
        .map(|(effect, probability)| found(effect, probability));
        let all = [unlikely, swell, gel];
        assert_eq!(said(&all[2..], 285.0), Verdict::Explained);
        assert_eq!(said(&all[..1], 0.0), Verdict::Consistent);
        assert_eq!(said(&all[..1], 285.0), Verdict::Unexplained);
        assert_eq!(said(&all[..2], 285.0), Verdict::Unexplained);
        assert_eq!(said(&all[1..], 0.0), Verdict::Explained);
    }
}
