//! How rigs name their channels, and in what units they file them.

use crate::constants::{ATMOSPHERE_PA, GPM_M3_S, PSI_PA};

/// File format of a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// MAT v5: one struct `gom`.
    Mat,
    /// Header row and unit row.
    Csv,
    /// One JSON channel `/rig`, a message a sample.
    Mcap,
}

impl Form {
    /// Ending of the file name.
    pub fn ending(self) -> &'static str {
        match self {
            Self::Mat => "mat",
            Self::Csv => "csv",
            Self::Mcap => "mcap",
        }
    }
}

/// Tags and units.
#[derive(Debug, Clone, PartialEq)]
pub struct Dialect {
    /// Tag of the time.
    pub time: &'static str,
    /// Tags of the channels, in the order of [`crate::CHANNELS`].
    pub tags: [&'static str; 10],
    /// Unit of flow.
    pub flow: &'static str,
    /// Unit of pressure as the well description says it.
    pub pressure: &'static str,
    /// Unit of pressure in the recording's own unit row, which may leave open what it counts from.
    pub pressure_row: &'static str,
    /// Unit of flow over m³/s.
    flow_m3_s: f64,
    /// Unit of pressure over Pa.
    pressure_pa: f64,
    gauge: bool,
}

impl Dialect {
    /// As in Table 2.1 of the thesis.
    pub(crate) const THESIS: Self = Self {
        time: "t",
        tags: crate::config::CHANNELS,
        flow: "gpm",
        pressure: "psia",
        pressure_row: "psi",
        flow_m3_s: GPM_M3_S,
        pressure_pa: PSI_PA,
        gauge: false,
    };

    /// The dialects there are.
    pub(crate) const ALL: [Self; 4] = [
        Self::THESIS,
        Self {
            pressure: "psig",
            gauge: true,
            ..Self::THESIS
        },
        Self {
            time: "time_s",
            tags: [
                "Q_MP",
                "Q_BST",
                "Q_TF",
                "Q_RET",
                "P_IN_A",
                "P_IN_B",
                "P_OUT_A",
                "P_OUT_B",
                "P_RISER",
                "SMP_SPEED",
            ],
            flow: "L/min",
            pressure: "bara",
            pressure_row: "bar",
            flow_m3_s: 1e-3 / 60.0,
            pressure_pa: 1e5,
            gauge: false,
        },
        Self {
            time: "t",
            tags: [
                "mudpump", "booster", "topfill", "mrl_flow", "inlet1", "inlet2", "outlet1",
                "outlet2", "riser_p", "speed",
            ],
            flow: "m3/h",
            pressure: "kPag",
            pressure_row: "kPa",
            flow_m3_s: 1.0 / 3600.0,
            pressure_pa: 1e3,
            gauge: true,
        },
    ];

    /// Unit of channel `c` in the recording's own unit row.
    pub(crate) fn row_unit(&self, c: usize) -> &'static str {
        match c {
            0..=3 => self.flow,
            9 => "%",
            _ => self.pressure_row,
        }
    }

    /// A reading of channel `c` in gpm, psi absolute or %, as this rig files it.
    pub(crate) fn file(&self, c: usize, reading: f64) -> f64 {
        let tidy = |x: f64| (x * 1e4).round() / 1e4;
        match c {
            _ if self.flow == "gpm" && !self.gauge => reading,
            0..=3 if self.flow == "gpm" => reading,
            0..=3 => tidy(reading * GPM_M3_S / self.flow_m3_s),
            9 => reading,
            // A dead transmitter says zero in whatever unit it speaks.
            _ if reading == 0.0 => 0.0,
            _ => {
                let zero = if self.gauge { ATMOSPHERE_PA } else { 0.0 };
                tidy((reading * PSI_PA - zero) / self.pressure_pa)
            }
        }
    }
}
