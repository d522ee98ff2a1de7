//! Figures of return-line identification as SVG and PNG, and a page to show them on.
//!
//! Start at the function of the figure wanted, such as [`all_samples`] or [`complete_dynamics`]; each takes plain
//! slices and [`Axis`] labels and returns a [`Figure`]. [`Page`] sets figures, tables and formulas as one
//! self-contained HTML file. [`diagnosis_page`] writes the report of a diagnosis. [`assembly_drawing`] draws components
//! and their connections.
//!
//! Absent: no estimation, and no unit conversion in the figures (what is given is drawn, the axis label names its unit), no files, no
//! fonts of the machine. A value that is not finite is never drawn, an axis is not stretched by far outliers, and the
//! caption says how many samples a figure leaves out.
//!
//! ```
//! use dgd_report::{Axis, delay_sweep};
//!
//! let figure = delay_sweep(&[0.0, 1.0, 2.0], &[3.0, 1.0, 2.0], &Axis::new("Mean squared error [%²]"))?;
//! assert!(figure.caption().ends_with("The smallest is 1 at 1 s."));
//! assert!(figure.svg().starts_with("<svg"));
//! assert_eq!(&figure.png(1.0)?[1..4], b"PNG");
//! # Ok::<(), dgd_report::ReportError>(())
//! ```
#![deny(missing_docs)]

mod axis;
mod color;
mod data;
mod diagnosis;
mod drawing;
mod error;
mod figure;
mod font;
mod formula;
mod friction;
mod page;
mod panel;
mod pump;
mod ranking;
mod raster;
mod scene;
mod search;
mod series;
mod simulation;
mod svg;
mod thin;
mod xml;

pub use axis::Axis;
pub use color::Role;
pub use data::{Curve, Interval, Scatter, Series};
pub use diagnosis::diagnosis_page;
pub use drawing::{Diagram, DrawnComponent, DrawnInstrument, DrawnLink, Symbol, assembly_drawing};
pub use error::ReportError;
pub use figure::Figure;
pub use friction::{
    all_samples, delay_sweep, delayed_friction_fit, final_friction_fit, friction_fit, kept_samples,
};
pub use page::{Page, Table};
pub use pump::{SpeedFamily, final_pump_curves, first_pump_curves};
pub use ranking::{MOST_ROWS, Ranked, WithinBounds, ranking, within_bounds};
pub use raster::MAX_PIXELS;
pub use search::{CostGrid, SearchPath, exponent_search};
pub use series::{Residuals, TimePanel, residual_histogram, series_over, time_series};
pub use simulation::{Compared, complete_dynamics, dynamic_and_static, return_flow, riser_level};

/// The example of the README is compiled and run with the tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
