//! A model as text.

use super::{Base, MODEL_SCHEMA, ModelDocument};
use crate::augmented::write_augmented;
use crate::well::{lengths_of, quoted};
use dgd_identify::{Estimate, Model};
use dgd_recording::Geometry;
use std::fmt::Write as _;

/// Letters and units of the friction law's terms (Eqs. 3.14, 3.26), by power.
const TERMS: [(&str, &str); 4] = [
    ("B", "Pa"),
    ("C", "Pa/(m3/s)"),
    ("D", "Pa/(m3/s)^2"),
    ("E", "Pa/(m3/s)^3"),
];

/// Writes a model document; [`read_model_document`](super::read_model_document) gives the same one back, to the last bit.
///
/// That holds for what can be simulated: see [`write_model`] for the base; scales above 0, finite
/// coefficients, ranges with their lower end first, effects of the catalogue with as many
/// finite parameters as it says.
pub fn write_model_document(document: &ModelDocument) -> String {
    let mut text = String::new();
    // Writing to a String cannot fail.
    let _ = match &document.base {
        Base::Identified(model) => write_into(&mut text, model),
        Base::WellOnly {
            density_kg_m3,
            geometry,
        } => write_head(&mut text, *density_kg_m3, geometry),
    };
    if let Some(augmented) = &document.augmented {
        let _ = write_augmented(&mut text, augmented);
    }
    text
}

/// Writes a model; [`read_model`](super::read_model) gives the same model back, to the last bit.
///
/// That holds for every model that can be simulated: finite parameters, exponents of at
/// least 1, distinct powers of 0 to 3 by rising power, distinct reasons in
/// [`DataUsed::rejected`](dgd_identify::DataUsed::rejected). Statistics may be NaN or infinite.
pub fn write_model(model: &Model) -> String {
    let mut text = String::new();
    // Writing to a String cannot fail.
    let _ = write_into(&mut text, model);
    text
}

fn write_head(text: &mut String, density_kg_m3: f64, geometry: &Geometry) -> std::fmt::Result {
    writeln!(
        text,
        "# Identified return-line model: `dgd simulate` reads it."
    )?;
    writeln!(
        text,
        "# h' = (q - q_in)/A_a,  M q' = rho g H(w, q) - F(q) - rho g h   (Eqs. 3.45-3.46)"
    )?;
    writeln!(text, "schema = \"{MODEL_SCHEMA}\"\n\n[well]")?;
    writeln!(text, "density = \"{density_kg_m3} kg/m3\"")?;
    for (key, length_m) in lengths_of(geometry) {
        writeln!(text, "{key} = \"{length_m} m\"")?;
    }
    Ok(())
}

fn write_into(text: &mut String, model: &Model) -> std::fmt::Result {
    write_head(text, model.density_kg_m3, &model.geometry)?;
    let friction = &model.friction;
    writeln!(
        text,
        "\n# F(q) = sum of value * q^power, Pa with q in m3/s; odd in q, but for B"
    )?;
    writeln!(
        text,
        "[friction]\nmse_pa2 = {}\nr2 = {}",
        float(friction.mse_pa2),
        float(friction.r2)
    )?;
    writeln!(
        text,
        "samples = {}\ncondition = {}",
        friction.samples,
        float(friction.condition)
    )?;
    if friction.terms.is_empty() {
        writeln!(text, "term = []")?;
    }
    for term in &friction.terms {
        let (letter, unit) = TERMS
            .get(usize::from(term.power))
            .copied()
            .unwrap_or(("?", "?"));
        writeln!(
            text,
            "\n[[friction.term]] # {letter}, {unit}\npower = {}",
            term.power
        )?;
        write_estimate(text, &term.coefficient)?;
    }
    writeln!(
        text,
        "\n# Delay of the meter behind the flow through the pump: q_meter(t) = q(t - delay)"
    )?;
    writeln!(
        text,
        "[return_flow_meter]\ndelay_s = {}",
        float(model.delay_s)
    )?;
    let pump = &model.pump;
    writeln!(
        text,
        "\n# H = c0 w^n0 - c1 w q - c2 q^n2, m of mud with w in % and q in m3/s"
    )?;
    writeln!(
        text,
        "[pump]\nn0 = {}\nn2 = {}",
        float(pump.n0),
        float(pump.n2)
    )?;
    let active: Vec<String> = pump.active_constraints.iter().map(|c| quoted(c)).collect();
    writeln!(text, "active_constraints = [{}]", active.join(", "))?;
    writeln!(
        text,
        "mse_m2 = {}\nr2 = {}",
        float(pump.mse_m2),
        float(pump.r2)
    )?;
    writeln!(
        text,
        "samples = {}\ncondition = {}",
        pump.samples,
        float(pump.condition)
    )?;
    for (name, estimate) in [("c0", &pump.c0), ("c1", &pump.c1), ("c2", &pump.c2)] {
        writeln!(text, "\n[pump.{name}]")?;
        write_estimate(text, estimate)?;
    }
    let data = &model.data;
    let recordings: Vec<String> = data.recordings.iter().map(|r| quoted(r)).collect();
    writeln!(
        text,
        "\n[data]\nrecordings = [{}]\nsamples = {}",
        recordings.join(", "),
        data.samples
    )?;
    writeln!(
        text,
        "kept = {}\nstep_s = {}",
        data.kept,
        float(data.step_s)
    )?;
    if !data.rejected.is_empty() {
        writeln!(
            text,
            "\n[data.rejected] # a sample may be counted under several reasons"
        )?;
        for (reason, count) in &data.rejected {
            writeln!(text, "{} = {count}", quoted(reason))?;
        }
    }
    Ok(())
}

fn write_estimate(text: &mut String, estimate: &Estimate) -> std::fmt::Result {
    writeln!(text, "value = {}", float(estimate.value))?;
    match estimate.standard_error {
        Some(error) => writeln!(text, "standard_error = {}", float(error)),
        None => Ok(()),
    }
}

/// Shortest digits that read back the same, as a TOML float.
pub(crate) fn float(value: f64) -> String {
    // Rust writes `NaN`, TOML `nan`; `inf` and exponents are the same in both.
    format!("{value:?}").to_lowercase()
}
