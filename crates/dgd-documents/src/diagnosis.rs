//! `diagnosis.json`: what a diagnosis says, for machines.

use crate::json::Json;
use dgd_diagnose::{
    Check, CorrectionCurve, Diagnosis, Finding, HeldOut, Outcome, ParameterEstimate, Tested,
};

/// Schema of the document that [`write_diagnosis`] writes.
pub const DIAGNOSIS_SCHEMA: &str = "dgd.diagnosis/1";

/// Writes a diagnosis as JSON: verdict and findings, what was tested, checks and settings.
///
/// The members stand in the README. Series are left out (they go into a table of their own), and so is every
/// number that is not finite: a parameter without a finite estimate, an interval without finite ends. The same
/// diagnosis gives the same bytes.
pub fn write_diagnosis(diagnosis: &Diagnosis) -> String {
    let mut document = Members::default();
    document.text("schema", DIAGNOSIS_SCHEMA);
    document.text("verdict", diagnosis.verdict.name());
    document.list("warnings", diagnosis.warnings.iter().map(Json::text));
    document.list("findings", diagnosis.findings.iter().map(finding));
    document.list(
        "started_from",
        diagnosis.started_from.iter().map(|id| Json::text(*id)),
    );
    document.list("suspected", diagnosis.suspected.iter().map(Json::text));
    let beside = !diagnosis.findings.is_empty();
    let all = diagnosis.tested.iter();
    document.list("tested", all.map(|one| tested(one, beside)));
    document.list("checks", diagnosis.checks.iter().map(check));
    document.list(
        "held_out_s",
        diagnosis
            .held_out_s
            .iter()
            .filter_map(|window| Json::pair(*window)),
    );
    document.put("began", diagnosis.began.map(|at| Json::text(at.rfc3339())));
    let settings = diagnosis
        .settings
        .iter()
        .map(|(name, value)| (name.clone(), Json::text(value)));
    document.put("settings", Some(object(settings)));
    document.object().document()
}

fn finding(finding: &Finding) -> Json {
    let mut members = Members::default();
    members.text("effect", &finding.effect);
    members.put("resembles", finding.resembles.map(Json::text));
    members.text("title", &finding.title);
    members.put(
        "probability",
        Some(Json::Number(share(finding.probability))),
    );
    members.list(
        "alternatives",
        finding.alternatives.iter().map(|(effect, probability)| {
            let mut one = Members::default();
            one.text("effect", effect);
            one.put("probability", Some(Json::Number(share(*probability))));
            one.object()
        }),
    );
    members.text("relation", finding.relation.name());
    let shows_in = finding.shows_in.iter().map(|r| Json::text(r.name()));
    members.list("shows_in", shows_in);
    members.put("shows_in_pair", finding.pair.map(Json::text));
    members.list(
        "intervals_s",
        finding
            .intervals_s
            .iter()
            .filter_map(|interval| Json::pair(*interval)),
    );
    members.text("region", &finding.region);
    let parameters = finding.parameters.iter().filter_map(parameter);
    members.put("parameters", Some(object(parameters)));
    members.put("curve", finding.curve.as_ref().map(curve));
    members.put("held_out", finding.held_out.as_ref().and_then(held_out));
    members.text("equation_before", &finding.equation_before);
    members.text("equation_after", &finding.equation_after);
    members.text("source", &finding.source);
    members.put("evidence_ln", Json::finite(finding.evidence));
    members.put("hurdle_ln", Json::finite(finding.hurdle));
    members.put(
        "separating_test",
        finding.separating_test.as_ref().map(Json::text),
    );
    members.put("same_as", finding.same_as.as_ref().map(Json::text));
    members.object()
}

/// A probability, whatever it was computed from.
fn share(probability: f64) -> f64 {
    if probability.is_nan() {
        0.0
    } else {
        probability.clamp(0.0, 1.0)
    }
}

fn parameter(parameter: &ParameterEstimate) -> Option<(String, Json)> {
    let mut members = Members::default();
    members.put("estimate", Some(Json::finite(parameter.estimate)?));
    members.put("ci95", Json::pair(parameter.ci95));
    members.text("meaning", &parameter.meaning);
    Some((parameter.name.clone(), members.object()))
}

fn curve(curve: &CorrectionCurve) -> Json {
    let mut members = Members::default();
    members.text("along", curve.along);
    members.text("adds", curve.adds);
    members.list("knots", curve.knots.iter().filter_map(|k| Json::pair(*k)));
    members.object()
}

fn held_out(gain: &HeldOut) -> Option<Json> {
    let mut members = Members::default();
    members.text("signal", &gain.signal);
    members.put("rmse_before", Some(Json::finite(gain.rmse_before)?));
    members.put("rmse_after", Some(Json::finite(gain.rmse_after)?));
    members.put("improvement_ci95", Json::pair(gain.improvement_ci95));
    Some(members.object())
}

/// `beside` others that were found.
fn tested(tested: &Tested, beside: bool) -> Json {
    let mut members = Members::default();
    members.text("effect", tested.effect);
    members.text("title", tested.title);
    let (outcome, reason) = match &tested.outcome {
        Outcome::Found => ("found", None),
        Outcome::Resembled => ("resembled", None),
        Outcome::NotSeen if beside && tested.exceeded_its_hurdle() => ("not_needed", None),
        Outcome::NotSeen => ("not_seen", None),
        Outcome::NotTestable(reason) => ("not_testable", Some(reason)),
    };
    members.text("outcome", outcome);
    members.put("reason", reason.map(Json::text));
    members.put("evidence_ln", Json::finite(tested.evidence));
    members.put("admissible", Some(Json::Bool(tested.admissible)));
    members.put("hurdle_ln", Json::finite(tested.hurdle));
    members.text("strength", tested.strength);
    members.put(
        "standard_error",
        tested.standard_error.and_then(Json::finite),
    );
    members.put("detection_limit", tested.limit.and_then(Json::finite));
    members.object()
}

fn check(check: &Check) -> Json {
    let mut members = Members::default();
    members.text("name", &check.name);
    members.put("passed", Some(Json::Bool(check.passed)));
    members.text("detail", &check.detail);
    members.object()
}

/// Members of an object in order.
#[derive(Default)]
struct Members(Vec<(String, Json)>);

impl Members {
    fn text(&mut self, name: &str, text: &str) {
        self.put(name, Some(Json::text(text)));
    }

    fn list(&mut self, name: &str, items: impl Iterator<Item = Json>) {
        self.put(name, Some(Json::List(items.collect())));
    }

    /// A member, unless there is nothing to say.
    fn put(&mut self, name: &str, value: Option<Json>) {
        self.0.extend(value.map(|value| (name.to_owned(), value)));
    }

    fn object(self) -> Json {
        Json::Object(self.0)
    }
}

/// An object of entries whose names are data: of two entries of one name the first counts.
fn object(entries: impl Iterator<Item = (String, Json)>) -> Json {
    let mut members: Vec<(String, Json)> = Vec::new();
    for (name, value) in entries {
        if !members.iter().any(|(known, _)| *known == name) {
            members.push((name, value));
        }
    }
    Json::Object(members)
}
