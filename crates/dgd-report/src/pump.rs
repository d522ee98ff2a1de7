//! Figures 3.9 and 3.11: pump curves over the samples near each speed.

use crate::axis::{Axis, short};
use crate::color::{sequence, tone};
use crate::data::{Curve, Scatter};
use crate::error::ReportError;
use crate::figure::Figure;
use crate::panel::{Cloud, Key, Line, Panel, Sign, Stack, draw};
use crate::scene::Pen;

/// Most speeds that keep colours apart.
const MOST_SPEEDS: usize = 16;

/// One pump speed: the samples near it and the model's curve, flow across and head up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpeedFamily<'a> {
    /// Pump speed, percent of full speed.
    pub speed_pct: f64,
    /// Samples within the tolerance of this speed.
    pub samples: Scatter<'a>,
    /// The model at this speed.
    pub model: Curve<'a>,
}

/// Figure 3.9: the model of equation 3.31 at a set of speeds, with the samples within `tolerance_pct` of each.
///
/// # Errors
/// [`ReportError::Length`] on unequal slices, [`ReportError::TooMany`] above 16 speeds, [`ReportError::Range`] on an
/// axis range that cannot be drawn.
pub fn first_pump_curves(
    families: &[SpeedFamily<'_>],
    tolerance_pct: f64,
    flow: &Axis,
    head: &Axis,
) -> Result<Figure, ReportError> {
    curves("3.9", "equation 3.31", families, tolerance_pct, flow, head)
}

/// Figure 3.11: the same with the optimised exponents of equation 3.39.
///
/// # Errors
/// As [`first_pump_curves`].
pub fn final_pump_curves(
    families: &[SpeedFamily<'_>],
    tolerance_pct: f64,
    flow: &Axis,
    head: &Axis,
) -> Result<Figure, ReportError> {
    curves(
        "3.11",
        "equation 3.39 with optimised exponents",
        families,
        tolerance_pct,
        flow,
        head,
    )
}

fn curves(
    number: &str,
    model: &str,
    families: &[SpeedFamily<'_>],
    tolerance_pct: f64,
    flow: &Axis,
    head: &Axis,
) -> Result<Figure, ReportError> {
    if families.len() > MOST_SPEEDS {
        return Err(ReportError::TooMany {
            what: "speeds",
            found: families.len(),
            most: MOST_SPEEDS,
        });
    }
    let mut order: Vec<&SpeedFamily<'_>> = families.iter().collect();
    order.sort_by(|a, b| a.speed_pct.total_cmp(&b.speed_pct));
    let whole =
        (order.iter()).all(|family| short(family.speed_pct) == format!("{:.0}", family.speed_pct));
    let decimals = usize::from(!whole);
    let mut panel = Panel::new(head, 380.0);
    let mut keys = Vec::new();
    let steps = u32::try_from(order.len().saturating_sub(1).max(1)).unwrap_or(1);
    for (step, family) in (0_u32..).zip(order) {
        family.samples.check("samples.y")?;
        family.model.check("model.y")?;
        let color = sequence(f64::from(step) / f64::from(steps));
        panel.clouds.push(Cloud {
            x: family.samples.x,
            y: family.samples.y,
            color,
            shade: false,
            counted: true,
        });
        // Paler than its samples, which would vanish on it.
        let pen = Pen::new(tone(color, 0.6), 2.2);
        let line = Line::new(family.model.x, family.model.y, pen);
        panel.lines.push(Line {
            counted: false,
            ..line
        });
        keys.push(Key {
            sign: Sign::Line(Pen::new(color, 2.6)),
            text: format!("{:.decimals$} %", family.speed_pct),
        });
    }
    // The highest curve belongs to the highest speed: so does the top of the legend.
    keys.reverse();
    let mut stack = Stack::new(flow, vec![panel]);
    stack.side = (!keys.is_empty()).then(|| ("Pump speed".to_owned(), keys));
    let drawn = draw(&stack)?;
    let caption = format!(
        "{} against {} at {} pump speeds: the fitted model of {model} (lines) and the samples within ±{} % of each \
         speed (dots of the same colour).",
        head.label,
        flow.in_sentence(),
        families.len(),
        short(tolerance_pct),
    );
    Ok(Figure::new(number, caption, drawn))
}
