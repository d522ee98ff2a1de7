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
    let panels = [
        TimePanel {
            axis: level_axis.clone(),
            title: "",
            series: &level.series(),
        },
        TimePanel {
            axis: flow_axis.clone(),
            title: "",
            series: inputs,
        },
    ];
    let caption =
        "Simulation of the riser level, with the measured flows that drive it below.".to_owned();
    stacked("4.1", caption, &panels, &[], &[230.0, 150.0])
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
    let panels = [
        TimePanel {
            axis: flow_axis.clone(),
            title: "",
            series: &flow.series(),
        },
        TimePanel {
            axis: speed_axis.clone(),
            title: "",
            series: &[series("Pump speed (input)", Role::Input(0), speed)],
        },
    ];
    let caption =
        "Simulation of the flow through the subsea pump, with the pump speed below.".to_owned();
    stacked("4.2", caption, &panels, &[], &[230.0, 130.0])
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
    let panels = [
        TimePanel {
            axis: flow_axis.clone(),
            title: "Dynamic, eq. 3.46",
            series: &above.series(),
        },
        TimePanel {
            axis: flow_axis.clone(),
            title: "Static, eq. 4.2",
            series: &below.series(),
        },
    ];
    let caption = "Simulation of the flow through the subsea pump with the dynamic equation 3.46 (above) and the \
                   static equation 4.2 (below)."
        .to_owned();
    stacked("4.3", caption, &panels, &[], &[190.0, 190.0])
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
    let panels = [
        TimePanel {
            axis: level_axis.clone(),
            title: "",
            series: &level.series(),
        },
        TimePanel {
            axis: flow_axis.clone(),
            title: "",
            series: &flow.series(),
        },
    ];
    let caption = "Simulation of the complete dynamics of equations 3.45 and 3.46: riser level (above) and flow \
                   through the subsea pump (below)."
        .to_owned();
    stacked("4.4", caption, &panels, &[], &[200.0, 200.0])
}
