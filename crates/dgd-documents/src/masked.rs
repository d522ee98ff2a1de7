//! What `dgd mask` passes on, and what its owner keeps.

use crate::model::float;
use crate::reader::{Notes, Section, parse};
use crate::{DocumentError, Problem};
use dgd_mask::{MaskedEstimate, MaskedModel};
use dgd_units::{Dimension, FullScale, MaskReferences};
use std::fmt::Write as _;

/// Writes a masked model: percentages only.
pub fn write_masked_model(model: &MaskedModel) -> String {
    let mut text = String::new();
    // Writing to a String cannot fail.
    let _ = write_into(&mut text, model);
    text
}

fn write_into(text: &mut String, model: &MaskedModel) -> std::fmt::Result {
    writeln!(
        text,
        "# Identified return-line model in percent of undisclosed references."
    )?;
    writeln!(
        text,
        "# Flow q, friction F, head H and riser level h are in %; pump speed w in % of full speed."
    )?;
    writeln!(
        text,
        "schema = \"dgd.masked-model/1\"\nsamples = {}\n",
        model.kept
    )?;
    writeln!(
        text,
        "# F = sum of value * q^power; odd in q, but for power 0"
    )?;
    writeln!(
        text,
        "[friction]\nrmse_pct = {}",
        float(model.friction_rmse_pct)
    )?;
    for term in &model.friction {
        writeln!(text, "\n[[friction.term]]\npower = {}", term.power)?;
        estimate(text, &term.coefficient)?;
    }
    writeln!(
        text,
        "\n[return_flow_meter]\ndelay_s = {}",
        float(model.delay_s)
    )?;
    writeln!(text, "\n# H = c0 w^n0 - c1 w q - c2 q^n2")?;
    writeln!(
        text,
        "[pump]\nn0 = {}\nn2 = {}\nrmse_pct = {}",
        float(model.n0),
        float(model.n2),
        float(model.head_rmse_pct)
    )?;
    for (index, c) in model.pump.iter().enumerate() {
        writeln!(text, "\n[pump.c{index}]")?;
        estimate(text, c)?;
    }
    writeln!(
        text,
        "\n# dh/dt = level_rate_per_s (q - q_in);  in steady flow H = level_in_head h + friction_in_head F + depth_in_head_pct"
    )?;
    writeln!(
        text,
        "[balance]\nlevel_rate_per_s = {}",
        float(model.level_rate_per_s)
    )?;
    writeln!(
        text,
        "level_in_head = {}\nfriction_in_head = {}\ndepth_in_head_pct = {}",
        float(model.level_in_head),
        float(model.friction_in_head),
        float(model.depth_in_head_pct)
    )
}

fn estimate(text: &mut String, estimate: &MaskedEstimate) -> std::fmt::Result {
    writeln!(text, "value = {}", float(estimate.value))?;
    estimate.standard_error.map_or(Ok(()), |error| {
        writeln!(text, "standard_error = {}", float(error))
    })
}

/// Writes the values that stand for 100 %. Whoever has them can undo the masking.
pub fn write_references(references: &MaskReferences) -> String {
    let [flow, friction, head, level] = references.disclose();
    format!(
        "# CONFIDENTIAL: the 100 % values of a masked recording. Anyone who has them can reverse the masking.\nflow = \"{flow} m3/s\"\nfriction = \
         \"{friction} Pa\"\nhead = \"{head} m\"\nlevel = \"{level} m\"\n"
    )
}

/// Reads what [`write_references`] writes, in any unit.
///
/// # Errors
/// [`DocumentError`] with every problem found; no message shows a value.
pub fn read_references(source: &str) -> Result<(MaskReferences, Vec<Problem>), DocumentError> {
    let document = parse(source)?;
    let notes = Notes::confidential();
    let root = Section::new("", 0..source.len(), document.get_ref(), &notes);
    let flow = root.need_positive("flow", Dimension::FlowRate, "1000 gpm");
    let friction = root.need_positive("friction", Dimension::Pressure, "5 bar");
    let head = root.need_positive("head", Dimension::Length, "300 m");
    let level = root.need_positive("level", Dimension::Length, "200 m");
    root.warn_of_unread();
    let references = match (flow, friction, head, level) {
        (Some(flow_m3_s), Some(friction_pa), Some(head_m), Some(level_m)) => {
            MaskReferences::new(FullScale {
                flow_m3_s,
                friction_pa,
                head_m,
                level_m,
            })
            .map_err(|error| notes.problem(0..source.len(), error.to_string(), None))
            .ok()
        }
        _ => None,
    };
    notes.conclude(source, references)
}
