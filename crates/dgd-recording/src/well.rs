//! The well a recording was taken on (Table 2.2) and its channel map (Table 2.1).

use crate::Channel;
use dgd_units::{Dimension, STANDARD_ATMOSPHERE_PA, STANDARD_GRAVITY_M_S2, Unit};
use std::f64::consts::PI;

/// A well: its mud, its geometry and the channels of its recordings.
#[derive(Debug, Clone, PartialEq)]
pub struct Well {
    /// Mud density ρ, kg/m³.
    pub mud_density_kg_m3: f64,
    /// Diameters and depths.
    pub geometry: Geometry,
    /// Which column of the recording is which channel.
    pub channels: ChannelMap,
}

/// Diameters and depths of Table 2.2, m. Depths are below the rotary table.
#[derive(Debug, Clone, PartialEq)]
pub struct Geometry {
    /// Inner diameter of the riser.
    pub riser_id_m: f64,
    /// Outer diameter of the drill pipe in it.
    pub drillpipe_od_m: f64,
    /// Outer diameter of the casing below, where known.
    pub casing_od_m: Option<f64>,
    /// Inner diameter of the mud return line.
    pub return_line_id_m: f64,
    /// Inner diameter of the booster line, where known.
    pub booster_line_id_m: Option<f64>,
    /// Depth of the subsea pump's inlet, h_SPMin.
    pub pump_inlet_depth_m: f64,
    /// Depth of the subsea pump's outlet, h_SPMout.
    pub pump_outlet_depth_m: f64,
    /// Depth of the riser pressure transmitter PT 5, where there is one.
    pub riser_pressure_sensor_depth_m: Option<f64>,
}

impl Geometry {
    /// Cross-section A_a of the annulus between riser and drill pipe, m².
    pub fn riser_area_m2(&self) -> f64 {
        PI / 4.0 * (self.riser_id_m.powi(2) - self.drillpipe_od_m.powi(2))
    }

    /// Cross-section A_MRL of the return line, m².
    pub fn line_area_m2(&self) -> f64 {
        PI / 4.0 * self.return_line_id_m.powi(2)
    }
}

/// Why a well is refused.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum WellError {
    /// A number that no well can have.
    #[error("`{name}` of the well is {found}, expected {expected}")]
    Number {
        /// The field.
        name: &'static str,
        /// Its value.
        found: f64,
        /// What it may be.
        expected: &'static str,
    },
    /// A channel whose description is refused.
    #[error(transparent)]
    Channel(#[from] ChannelError),
}

/// Why a channel map is refused.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ChannelError {
    /// A unit of something that the channel does not measure.
    #[error("`{channel}` is in `{unit}`, a unit of {}, expected a unit of {expected} such as `{}`", unit.dimension, expected.example())]
    Unit {
        /// The channel.
        channel: Channel,
        /// Its unit.
        unit: Unit,
        /// What the channel measures.
        expected: Dimension,
    },
    /// A clock that is not in a unit of time.
    #[error("the clock is in `{unit}`, a unit of {}, expected a unit of time such as `s`", unit.dimension)]
    Clock {
        /// Its unit.
        unit: Unit,
    },
    /// Stamps that are late by no number of seconds, or a constant that is none: the channel would be blank.
    #[error("`{name}` of `{channel}` is {found}, expected a finite number")]
    NotFinite {
        /// The channel.
        channel: Channel,
        /// The field, `late_s` or `si`.
        name: &'static str,
        /// Its value.
        found: f64,
    },
}

impl Well {
    /// Checks density, diameters, depths and channels, which a [`Well`] made by hand may have as it likes.
    ///
    /// # Errors
    /// [`WellError::Number`] if one is no positive number, or the drill pipe does not fit into the riser,
    /// [`WellError::Channel`] as [`ChannelMap::check`] has it.
    pub fn check(&self) -> Result<(), WellError> {
        let Geometry {
            riser_id_m,
            drillpipe_od_m,
            casing_od_m,
            return_line_id_m,
            booster_line_id_m,
            pump_inlet_depth_m,
            pump_outlet_depth_m,
            riser_pressure_sensor_depth_m,
        } = self.geometry;
        let needed = [
            ("mud_density_kg_m3", self.mud_density_kg_m3),
            ("riser_id_m", riser_id_m),
            ("drillpipe_od_m", drillpipe_od_m),
            ("return_line_id_m", return_line_id_m),
            ("pump_inlet_depth_m", pump_inlet_depth_m),
            ("pump_outlet_depth_m", pump_outlet_depth_m),
        ]
        .map(|(name, value)| (name, Some(value)));
        let known = [
            ("casing_od_m", casing_od_m),
            ("booster_line_id_m", booster_line_id_m),
            (
                "riser_pressure_sensor_depth_m",
                riser_pressure_sensor_depth_m,
            ),
        ];
        for (name, value) in needed.into_iter().chain(known) {
            if let Some(found) = value
                && !(found > 0.0 && found.is_finite())
            {
                let expected = "a positive number";
                return Err(WellError::Number {
                    name,
                    found,
                    expected,
                });
            }
        }
        if drillpipe_od_m >= riser_id_m {
            return Err(WellError::Number {
                name: "drillpipe_od_m",
                found: drillpipe_od_m,
                expected: "less than `riser_id_m`",
            });
        }
        Ok(self.channels.check()?)
    }

    /// Riser level h_r, m below the rotary table, from the inlet pressure, Pa absolute (Eq. 4.1).
    pub fn level_m(&self, inlet_pressure_pa: f64) -> f64 {
        let head = (inlet_pressure_pa - STANDARD_ATMOSPHERE_PA) / self.weight_pa_m();
        self.geometry.pump_inlet_depth_m - head
    }

    /// Inlet pressure, Pa absolute, under mud that stands at a level, m below the rotary table (Eq. 4.1).
    pub fn inlet_pressure_pa(&self, level_m: f64) -> f64 {
        STANDARD_ATMOSPHERE_PA + self.weight_pa_m() * (self.geometry.pump_inlet_depth_m - level_m)
    }

    /// Pump head ΔH, m of mud, from the pressures at its two sides, Pa (Eq. 2.27).
    pub fn head_m(&self, inlet_pressure_pa: f64, outlet_pressure_pa: f64) -> f64 {
        (outlet_pressure_pa - inlet_pressure_pa) / self.weight_pa_m()
    }

    /// Friction of the full return line, Pa, from the outlet pressure, Pa absolute (Eq. 3.13).
    pub fn line_friction_pa(&self, outlet_pressure_pa: f64) -> f64 {
        let column = self.weight_pa_m() * self.geometry.pump_outlet_depth_m;
        outlet_pressure_pa - column - STANDARD_ATMOSPHERE_PA
    }

    /// ρg, the pressure of a metre of mud, Pa/m.
    pub fn weight_pa_m(&self) -> f64 {
        self.mud_density_kg_m3 * STANDARD_GRAVITY_M_S2
    }
}

/// Which columns hold the channels of Table 2.1.
#[derive(Debug, Clone, PartialEq)]
pub struct ChannelMap {
    /// The clock.
    pub time: TimeSource,
    /// q_p, flow of the mud pumps (FT 1).
    pub mud_pump_flow: ChannelSource,
    /// q_bp, flow of the booster pump (FT 2).
    pub booster_flow: ChannelSource,
    /// q_tf, flow filled in at the riser's top (FT 3).
    pub topfill_flow: ChannelSource,
    /// q_MRL, flow out of the return line at the rig (FT 4).
    pub return_flow: ChannelSource,
    /// Pressure at the subsea pump's inlet; redundant transmitters (PT 1, PT 2).
    ///
    /// The mean is over all of them. A diagnosis compares the first two with each other; a third is only in the mean.
    pub pump_inlet_pressure: Vec<ChannelSource>,
    /// Pressure at the subsea pump's outlet; redundant transmitters (PT 3, PT 4). More than two as at the inlet.
    pub pump_outlet_pressure: Vec<ChannelSource>,
    /// Riser pressure (PT 5), where there is a transmitter.
    pub riser_pressure: Option<ChannelSource>,
    /// ω_ssp, speed (set-point) of the subsea pump, %.
    pub pump_speed: ChannelSource,
}

impl ChannelMap {
    /// Checks that every channel is in a unit of what it measures, and that its numbers are finite.
    ///
    /// # Errors
    /// [`ChannelError`] for the clock or the first channel that is not.
    ///
    /// ```
    /// use dgd_recording::{ChannelError, ChannelMap, ChannelSource};
    /// # use dgd_units::{Unit, UnitError};
    /// fn in_psi(mut map: ChannelMap) -> Result<(), UnitError> {
    ///     map.return_flow = ChannelSource::column("FT4", Unit::parse("psi")?);
    ///     assert!(matches!(map.check(), Err(ChannelError::Unit { .. })));
    ///     Ok(())
    /// }
    /// ```
    pub fn check(&self) -> Result<(), ChannelError> {
        if let TimeSource::Column { unit, .. } = self.time
            && unit.dimension != Dimension::Time
        {
            return Err(ChannelError::Clock { unit });
        }
        for (channel, source) in self.sources() {
            let expected = channel.dimension();
            let mut units = source.columns().map(|(_, unit)| unit);
            if let Some(unit) = units.find(|unit| unit.dimension != expected) {
                return Err(ChannelError::Unit {
                    channel,
                    unit,
                    expected,
                });
            }
            let (name, found) = match source {
                ChannelSource::Column { late_s, .. } => ("late_s", *late_s),
                ChannelSource::Constant { si } => ("si", *si),
            };
            if !found.is_finite() {
                return Err(ChannelError::NotFinite {
                    channel,
                    name,
                    found,
                });
            }
        }
        Ok(())
    }

    /// The channels that are columns of the file, each with its tag, in the order of [`Recording::series`](crate::Recording::series); one that is the sum of
    /// several comes as often.
    pub fn tags(&self) -> Vec<(Channel, &str)> {
        let tagged = self
            .sources()
            .flat_map(|(channel, source)| source.columns().map(move |(tag, _)| (channel, tag)));
        tagged.collect()
    }

    /// The first channel whose samples bear another clock's stamps, if there is one.
    pub fn off_clock(&self) -> Option<Channel> {
        let mut sources = self.sources();
        let found = sources.find(|(_, source)| source.late_s() != 0.0);
        found.map(|(channel, _)| channel)
    }

    /// Every channel with its source, in the order of [`Recording::series`](crate::Recording::series).
    fn sources(&self) -> impl Iterator<Item = (Channel, &ChannelSource)> {
        let inlets = self.pump_inlet_pressure.iter().enumerate();
        let outlets = self.pump_outlet_pressure.iter().enumerate();
        [
            (Channel::MudPumpFlow, &self.mud_pump_flow),
            (Channel::BoosterFlow, &self.booster_flow),
            (Channel::TopfillFlow, &self.topfill_flow),
            (Channel::ReturnFlow, &self.return_flow),
        ]
        .into_iter()
        .chain(inlets.map(|(n, source)| (Channel::PumpInletPressure(n), source)))
        .chain(outlets.map(|(n, source)| (Channel::PumpOutletPressure(n), source)))
        .chain((self.riser_pressure.iter()).map(|source| (Channel::RiserPressure, source)))
        .chain([(Channel::PumpSpeed, &self.pump_speed)])
    }
}

/// Where the clock comes from.
#[derive(Debug, Clone, PartialEq)]
pub enum TimeSource {
    /// A column.
    Column {
        /// Its name in the file.
        tag: String,
        /// Its unit.
        unit: Unit,
    },
    /// The recording has no time stamps; its samples are this far apart, s.
    Interval {
        /// Seconds from sample to sample.
        step_s: f64,
    },
}

/// Where a channel comes from.
#[derive(Debug, Clone, PartialEq)]
pub enum ChannelSource {
    /// A column.
    Column {
        /// Its name in the file.
        tag: String,
        /// Its unit.
        unit: Unit,
        /// Seconds by which its stamps are late: a sample at t tells of t - `late_s`, as where its logger's clock is
        /// ahead of the others'; below 0 if they are early, 0 on the clock of the file.
        late_s: f64,
        /// Columns that are added to it, as those of further mud pumps; late by as much.
        added: Vec<Added>,
    },
    /// No transmitter: this SI value throughout.
    Constant {
        /// The value, SI.
        si: f64,
    },
}

/// A column that is added to another one, in its own unit.
#[derive(Debug, Clone, PartialEq)]
pub struct Added {
    /// Its name in the file.
    pub tag: String,
    /// Its unit.
    pub unit: Unit,
}

impl ChannelSource {
    /// A column on the clock of the file.
    pub fn column(tag: impl Into<String>, unit: Unit) -> Self {
        Self::Column {
            tag: tag.into(),
            unit,
            late_s: 0.0,
            added: Vec::new(),
        }
    }

    /// The columns that make it, each with its unit; none of a constant.
    pub(crate) fn columns(&self) -> impl Iterator<Item = (&str, Unit)> {
        let all = match self {
            Self::Column {
                tag, unit, added, ..
            } => Some((tag, unit, added)),
            Self::Constant { .. } => None,
        };
        all.into_iter().flat_map(|(tag, unit, added)| {
            let added = added.iter().map(|one| (one.tag.as_str(), one.unit));
            std::iter::once((tag.as_str(), *unit)).chain(added)
        })
    }

    /// Seconds by which its stamps are late.
    pub(crate) fn late_s(&self) -> f64 {
        match self {
            Self::Column { late_s, .. } => *late_s,
            Self::Constant { .. } => 0.0,
        }
    }
}
