//! What a proof comes to: on standard output, and as `proof.json`.

use super::summary::{Row, Summary};
use super::{Proof, ablation, answer, detection, informed, measures};
use serde_json::{Value, json};

/// The table on standard output.
pub(crate) fn tell(proof: &Proof) {
    let summaries = proof.summaries;
    let columns: Vec<Vec<measures::Measure>> = summaries.iter().map(measures::measures).collect();
    let Some(first) = columns.first() else { return };
    print!("\n{:<62}", "");
    for s in summaries {
        print!("level {:<38}", s.level);
    }
    println!();
    for (i, measure) in first.iter().enumerate() {
        print!("{:<62}", measure.title);
        for column in &columns {
            let m = &column[i];
            let score = format!("{:>9}  {}", m.score.value(), m.score.basis());
            let target = m.target.map(|t| {
                let sign = match t.met(m.score) {
                    Some(true) => "+",
                    Some(false) => "-",
                    None => " ",
                };
                format!("{sign} {}", t.text(m.score))
            });
            print!("{score:<28}{:<16}", target.unwrap_or_default());
        }
        println!();
    }
    for level in summaries.iter().map(|s| s.level) {
        if proof.steps.iter().any(|s| s.level == level) {
            println!("{}", ablation::words(proof.steps, level));
        }
    }
}

/// `proof.json`
pub(crate) fn json_of(proof: &Proof) -> Value {
    let Proof {
        settings,
        origin,
        summaries,
        rows,
        ..
    } = *proof;
    let target = |m: &measures::Measure| m.target.map(|t| t.text(m.score));
    let level = |s: &Summary| {
        let scores: Vec<Value> = measures::measures(s)
            .iter()
            .map(|m| {
                json!({"measure": m.title, "score": m.score.json(), "target": target(m),
                       "met": m.target.and_then(|t| t.met(m.score))})
            })
            .collect();
        json!({"level": s.level, "scores": scores})
    };
    let case = |r: &Row| {
        let gains: serde_json::Map<String, Value> = answer::SIGNALS
            .iter()
            .zip(r.simulation.iter().flat_map(|s| &s.gains))
            .filter_map(|(name, g)| Some((name, (*g)?)))
            .map(|(name, g)| {
                let value = json!({"rmse_before": g.rmse_before, "rmse_after": g.rmse_after, "samples": g.samples});
                ((*name).to_owned(), value)
            })
            .collect();
        let parameters: Vec<Value> = r
            .marks
            .parameters
            .iter()
            .map(|p| json!({"effect": p.effect, "name": p.name, "relative_error": p.error, "covered": p.covered}))
            .collect();
        json!({
            "level": r.level, "id": r.id, "hours": r.truth.hours, "well": r.truth.well,
            "concealed": r.truth.effects.iter().map(|e| json!({"effect": e.effect, "kind": e.kind, "severity": e.severity})).collect::<Vec<_>>(),
            "verdict": r.answer.as_ref().map(|a| &a.verdict),
            "findings": r.marks.forecasts.iter().zip(r.answer.iter().flat_map(|a| &a.findings))
                .map(|((p, right), f)| json!({"effect": f.effect, "probability": p, "right": right})).collect::<Vec<_>>(),
            "exact": r.marks.exact, "within": r.marks.within, "relation_right": r.marks.relation,
            "overlap": r.marks.overlap, "parameters": parameters, "held_out": gains,
            "held_share": r.simulation.as_ref().map(|s| s.held_share),
            "broken": r.broken, "wall_s": r.wall_s, "peak_mib": r.peak_mib,
            "truth_known": r.informed.as_ref().map(informed::json_of),
        })
    };
    let program = &origin.program;
    json!({
        "schema": "dgd.proof/1",
        "seed": settings.seed, "count": settings.count, "hours": settings.hours, "only": settings.only, "jobs": settings.jobs,
        "short": settings.short, "dgd": program.version, "dgd_sha256": program.sha256, "commit": program.commit, "cores": program.cores,
        "seals": origin.seals.iter().map(|(l, h)| json!({"level": l, "sha256": h})).collect::<Vec<_>>(),
        "levels": summaries.iter().map(level).collect::<Vec<_>>(),
        "detection": detection::json_of(rows),
        "ablation": ablation::json_of(proof.steps),
        "cases": rows.iter().map(case).collect::<Vec<_>>(),
    })
}
