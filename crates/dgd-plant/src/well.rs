//! Geometry of the well and its mud weight.

use std::f64::consts::PI;

use crate::constants::INCH_M;

/// The well as the driller's file describes it. Depths run downwards from the rotary table.
#[derive(Debug, Clone, PartialEq)]
pub struct Well {
    /// Mud density, kg/m³.
    pub mud_density_kg_m3: f64,
    /// Inner diameter of the riser, m.
    pub riser_id_m: f64,
    /// Outer diameter of the drill pipe inside the riser, m.
    pub drillpipe_od_m: f64,
    /// Outer diameter of the casing, m; described in `well.toml`, not used by the plant.
    pub casing_od_m: f64,
    /// Inner diameter of the mud return line, m.
    pub return_line_id_m: f64,
    /// Depth of the subsea pump's inlet, m.
    pub pump_inlet_depth_m: f64,
    /// Depth of the subsea pump's outlet, m; the return line is this long.
    pub pump_outlet_depth_m: f64,
    /// Depth of the riser pressure sensor, m.
    pub riser_sensor_depth_m: f64,
    /// Depth of the wellhead, where the riser begins, m.
    pub wellhead_depth_m: f64,
}

impl Well {
    /// The Gulf of Mexico well of the thesis's Table 2.2.
    pub fn gom() -> Self {
        Self {
            mud_density_kg_m3: 1080.0,
            riser_id_m: 19.5 * INCH_M,
            drillpipe_od_m: 6.625 * INCH_M,
            casing_od_m: 13.625 * INCH_M,
            return_line_id_m: 6.0 * INCH_M,
            pump_inlet_depth_m: 350.30,
            pump_outlet_depth_m: 350.30,
            riser_sensor_depth_m: 352.10,
            wellhead_depth_m: 1510.0,
        }
    }

    /// Cross-section between riser and drill pipe, m².
    pub fn annulus_area_m2(&self) -> f64 {
        PI / 4.0 * (self.riser_id_m.powi(2) - self.drillpipe_od_m.powi(2))
    }

    /// Cross-section of the return line, m².
    pub fn return_line_area_m2(&self) -> f64 {
        PI / 4.0 * self.return_line_id_m.powi(2)
    }
}
