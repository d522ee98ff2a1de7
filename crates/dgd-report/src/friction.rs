//! Figures 3.2 to 3.7: friction in the mud return line.

use crate::axis::{Axis, count, short};
use crate::color::{INK, PAPER, Role, SOFT_INK};
use crate::data::{Curve, Scatter, same_length};
use crate::error::ReportError;
use crate::figure::Figure;
use crate::font::text_width;
use crate::panel::{Cloud, Drawn, Key, LEGEND, Line, Panel, Sign, Stack, draw};
use crate::scene::{Anchor, Pen, Shape};

const HEIGHT: f64 = 360.0;

/// Figure 3.2: every sample, flow across and friction up.
///
/// # Errors
/// [`ReportError::Length`] on unequal slices, [`ReportError::Range`] on an axis range that cannot be drawn.
pub fn all_samples(
    samples: Scatter<'_>,
    flow: &Axis,
    friction: &Axis,
) -> Result<Figure, ReportError> {
    samples.check("samples.y")?;
    let mut panel = Panel::new(friction, HEIGHT);
    panel.clouds.push(cloud(samples, Role::Measured));
    let drawn = draw(&Stack::new(flow, vec![panel]))?;
    let caption = format!(
        "{} against {}: all {} samples.",
        friction.label,
        flow.in_sentence(),
        count(samples.x.len())
    );
    Ok(Figure::new("3.2", caption, drawn))
}

/// Figure 3.3: every sample in red, the kept ones in blue on top.
///
/// # Errors
/// As [`all_samples`].
pub fn kept_samples(
    all: Scatter<'_>,
    kept: Scatter<'_>,
    flow: &Axis,
    friction: &Axis,
) -> Result<Figure, ReportError> {
    all.check("all.y")?;
    kept.check("kept.y")?;
    let mut panel = Panel::new(friction, HEIGHT);
    panel.clouds.push(cloud(all, Role::Rejected));
    panel.clouds.push(Cloud {
        counted: false,
        ..cloud(kept, Role::Model)
    });
    panel.keys = vec![
        dot(
            Role::Rejected,
            format!(
                "Rejected ({})",
                count(all.x.len().saturating_sub(kept.x.len()))
            ),
        ),
        dot(
            Role::Model,
            format!("Kept by the screening ({})", count(kept.x.len())),
        ),
    ];
    let drawn = draw(&Stack::new(flow, vec![panel]))?;
    let caption = format!(
        "{} against {}: the {} samples kept by the screening on top of all {}.",
        friction.label,
        flow.in_sentence(),
        count(kept.x.len()),
        count(all.x.len()),
    );
    Ok(Figure::new("3.3", caption, drawn))
}

/// Figure 3.4: kept samples and the model of equation 3.14.
///
/// # Errors
/// As [`all_samples`].
pub fn friction_fit(
    kept: Scatter<'_>,
    model: Curve<'_>,
    flow: &Axis,
    friction: &Axis,
) -> Result<Figure, ReportError> {
    fit("3.4", "3.14", None, kept, model, flow, friction)
}

/// Figure 3.6: samples with the flow read `delay_s` seconds later, and the model of equation 3.23.
///
/// # Errors
/// As [`all_samples`].
pub fn delayed_friction_fit(
    delay_s: f64,
    shifted: Scatter<'_>,
    model: Curve<'_>,
    flow: &Axis,
    friction: &Axis,
) -> Result<Figure, ReportError> {
    fit("3.6", "3.23", Some(delay_s), shifted, model, flow, friction)
}

/// Figure 3.7: the same samples and the model of equation 3.26.
///
/// # Errors
/// As [`all_samples`].
pub fn final_friction_fit(
    delay_s: f64,
    shifted: Scatter<'_>,
    model: Curve<'_>,
    flow: &Axis,
    friction: &Axis,
) -> Result<Figure, ReportError> {
    fit("3.7", "3.26", Some(delay_s), shifted, model, flow, friction)
}

fn fit(
    number: &str,
    equation: &str,
    delay_s: Option<f64>,
    samples: Scatter<'_>,
    model: Curve<'_>,
    flow: &Axis,
    friction: &Axis,
) -> Result<Figure, ReportError> {
    samples.check("samples.y")?;
    model.check("model.y")?;
    let pen = Pen::new(Role::Model.color(), 2.6);
    let mut panel = Panel::new(friction, HEIGHT);
    panel.clouds.push(cloud(samples, Role::Measured));
    panel.lines.push(Line {
        rim: true,
        counted: false,
        ..Line::new(model.x, model.y, pen)
    });
    panel.keys = vec![
        dot(
            Role::Measured,
            format!("Kept samples ({})", count(samples.x.len())),
        ),
        Key {
            sign: Sign::Line(pen),
            text: format!("Model, eq. {equation}"),
        },
    ];
    let drawn = draw(&Stack::new(flow, vec![panel]))?;
    let read = delay_s.map_or_else(String::new, |d| format!(", flow read {} s later", short(d)));
    let caption = format!(
        "{} against {}{read}: {} kept samples and the least-squares fit of the model of equation {equation}.",
        friction.label,
        flow.in_sentence(),
        count(samples.x.len()),
    );
    Ok(Figure::new(number, caption, drawn))
}

/// Figure 3.5: mean squared error of the fit against the time delay, the smallest marked.
///
/// - `delay_s`: delays tried, s, shape `(n,)`, increasing.
/// - `mse`: error at each, shape `(n,)`, in the unit of the axis `error`; not finite where a fit failed.
///
/// # Errors
/// As [`all_samples`].
pub fn delay_sweep(delay_s: &[f64], mse: &[f64], error: &Axis) -> Result<Figure, ReportError> {
    same_length("mse", delay_s, mse)?;
    let mut panel = Panel::new(error, HEIGHT - 40.0);
    panel.foot = 0.13;
    panel.empty = "No delay was tried";
    let pen = Pen::new(Role::Model.color(), 1.8);
    panel.lines.push(Line {
        dots: true,
        ..Line::new(delay_s, mse, pen)
    });
    let mut drawn = draw(&Stack::new(&Axis::new("Time delay [s]"), vec![panel]))?;
    let best = delay_s
        .iter()
        .zip(mse)
        .filter(|(d, e)| d.is_finite() && e.is_finite())
        .min_by(|a, b| a.1.total_cmp(b.1))
        .map(|(&d, &e)| (d, e));
    let mut caption = format!(
        "{} of the fit against the time delay [s] of the flow.",
        error.label
    );
    if let Some((delay, least)) = best {
        mark(&mut drawn, delay, least);
        caption = format!(
            "{caption} The smallest is {} at {} s.",
            short(least),
            short(delay)
        );
    }
    Ok(Figure::new("3.5", caption, drawn))
}

/// A ring around the smallest error, a dotted line to its delay, and both in words.
fn mark(drawn: &mut Drawn, delay: f64, least: f64) {
    let Some(frame) = drawn
        .frames
        .first()
        .copied()
        .filter(|f| f.holds(delay, least))
    else {
        return;
    };
    let [x, y] = frame.place(delay, least);
    let dotted = Pen {
        color: SOFT_INK,
        width: 1.2,
        dash: Some([2.0, 3.0]),
    };
    drawn.scene.line([x, y + 6.0], [x, frame.bottom()], dotted);
    let centre = [x, y];
    let ring = Pen::new(INK, 2.0);
    drawn.scene.shapes.push(Shape::Circle {
        centre,
        radius: 6.0,
        fill: Some(PAPER),
        pen: Some(ring),
    });
    let fill = Some(Role::Model.color());
    drawn.scene.shapes.push(Shape::Circle {
        centre,
        radius: 3.2,
        fill,
        pen: None,
    });
    let words = format!("Smallest: {} at {} s", short(least), short(delay));
    let half = text_width(&words, LEGEND, true) / 2.0;
    let (from, to) = (frame.left + half + 8.0, frame.right() - half - 8.0);
    let middle = if from < to { x.clamp(from, to) } else { x };
    // Off the dotted line: the words stand to one side of it, where there is room.
    let side = if x + 10.0 + 2.0 * half < frame.right() {
        x + 10.0 + half
    } else {
        (x - 10.0 - half).min(middle)
    };
    drawn.scene.bold(
        [side, (y + 26.0).min(frame.bottom() - 8.0)],
        &words,
        LEGEND,
        INK,
        Anchor::Middle,
    );
}

fn cloud(samples: Scatter<'_>, role: Role) -> Cloud<'_> {
    Cloud {
        x: samples.x,
        y: samples.y,
        color: role.color(),
        shade: true,
        counted: true,
    }
}

fn dot(role: Role, text: String) -> Key {
    Key {
        sign: Sign::Dot(role.color()),
        text,
    }
}
