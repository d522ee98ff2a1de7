//! Figures 4.1 to 4.4: simulated against measured.

use crate::axis::Axis;
use crate::color::Role;
use crate::data::{Curve, Series};
use crate::error::ReportError;
use crate::figure::Figure;
use crate::series::{TimePanel, stacked};

/// A state measured and simulated, each over its own time in seconds (`x`).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Compared<'a> {
    /// Time, s, and measured value.
    pub measured: Curve<'a>,
    /// Time, s, and simulated value.
    pub simulated: Curve<'a>,
}

impl<'a> Compared<'a> {
    fn series(&self) -> [Series<'a>; 2] {
        [
            series("Measured", Role::Measured, self.measured),
            series("Simulated", Role::Model, self.simulated),
        ]
    }

    fn check(&self, names: [&'static str; 2]) -> Result<(), ReportError> {
        self.measured.check(names[0])?;
        self.simulated.check(names[1])
    }
}

fn series<'a>(label: &'a str, role: Role, curve: Curve<'a>) -> Series<'a> {
    Series {
        label,
        role,
        time_s: curve.x,
        value: curve.y,
    }
}

/// Label, words above, and lines of a panel.
type Part<'p, 'a> = (&'p Axis, &'p str, &'p [Series<'a>]);

/// Two panels under one another.
fn two(
    number: &str,
    caption: &str,
    parts: [Part<'_, '_>; 2],
    heights: [f64; 2],
) -> Result<Figure, ReportError> {
    let panels = parts.map(|(axis, title, series)| TimePanel {
        axis: axis.clone(),
        title,
        series,
    });
    stacked(number, caption.to_owned(), &panels, &[], &heights)
}

/// Figure 4.1: riser level, with the flows that drive it below.
///
/// # Errors
/// [`ReportError::Length`] on unequal slices, [`ReportError::TooMany`] above 12 input flows, [`ReportError::Range`]
/// on an axis range that cannot be drawn.
pub fn riser_level(
    level: &Compared<'_>,
    inputs: &[Series<'_>],
    level_axis: &Axis,
    flow_axis: &Axis,
) -> Result<Figure, ReportError> {
    level.check(["level.measured.y", "level.simulated.y"])?;
    two(
        "4.1",
        "Simulation of the riser level (depth below the rotary table), with the measured input flows below.",
        [(level_axis, "", &level.series()), (flow_axis, "", inputs)],
        [230.0, 150.0],
    )
}

/// Figure 4.2: flow through the subsea pump, with the pump speed below.
///
/// # Errors
/// As [`riser_level`].
pub fn return_flow(
    flow: &Compared<'_>,
    speed: Curve<'_>,
    flow_axis: &Axis,
    speed_axis: &Axis,
) -> Result<Figure, ReportError> {
    flow.check(["flow.measured.y", "flow.simulated.y"])?;
    speed.check("speed.y")?;
    two(
        "4.2",
        "Simulation of the flow through the subsea pump, with the pump speed below.",
        [
            (flow_axis, "", &flow.series()),
            (
                speed_axis,
                "",
                &[series("Pump speed (input)", Role::Input(0), speed)],
            ),
        ],
        [230.0, 130.0],
    )
}

/// Figure 4.3: the flow from the dynamic equation 3.46 above, from the static equation 4.2 below.
///
/// # Errors
/// As [`riser_level`].
pub fn dynamic_and_static(
    measured: Curve<'_>,
    dynamic: Curve<'_>,
    steady: Curve<'_>,
    flow_axis: &Axis,
) -> Result<Figure, ReportError> {
    let above = Compared {
        measured,
        simulated: dynamic,
    };
    let below = Compared {
        measured,
        simulated: steady,
    };
    above.check(["measured.y", "dynamic.y"])?;
    below.check(["measured.y", "steady.y"])?;
    two(
        "4.3",
        "Simulation of the flow through the subsea pump with the dynamic equation 3.46 (above) and the \
                   static equation 4.2 (below).",
        [
            (flow_axis, "Dynamic, eq. 3.46", &above.series()),
            (flow_axis, "Static, eq. 4.2", &below.series()),
        ],
        [190.0, 190.0],
    )
}

/// Figure 4.4: riser level and flow from the complete dynamics of equations 3.45 and 3.46.
///
/// # Errors
/// As [`riser_level`].
pub fn complete_dynamics(
    level: &Compared<'_>,
    flow: &Compared<'_>,
    level_axis: &Axis,
    flow_axis: &Axis,
) -> Result<Figure, ReportError> {
    level.check(["level.measured.y", "level.simulated.y"])?;
    flow.check(["flow.measured.y", "flow.simulated.y"])?;
    two(
        "4.4",
        "Simulation of the complete dynamics of equations 3.45 and 3.46: riser level (above, as depth below the rotary table) and flow \
                   through the subsea pump (below).",
        [
            (level_axis, "", &level.series()),
            (flow_axis, "", &flow.series()),
        ],
        [200.0, 200.0],
    )
}
