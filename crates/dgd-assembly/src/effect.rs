//! What an effect is: its description, and how it alters the law of the component it sits on.

use crate::Dual;
use crate::spec::Kind;

/// Description of an effect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct About {
    /// Name in files and paths.
    pub id: &'static str,
    /// In words.
    pub title: &'static str,
    /// Kinds of component it can sit on.
    pub kinds: &'static [Kind],
    /// Governing equation.
    pub equation: &'static str,
    /// Book or paper, with section or equation.
    pub source: &'static str,
    /// What a recording must hold to show it.
    pub excited_by: &'static str,
    /// Effects (ids) it is mistaken for, each with the test that separates them.
    pub confusable: &'static [(&'static str, &'static str)],
    /// Parameters, the strength first.
    pub parameters: &'static [ParameterAbout],
}

/// Parameter of an effect. Its SI bounds are `low` and `high` times the size of the component it sits on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ParameterAbout {
    /// Name in files and paths.
    pub name: &'static str,
    /// Meaning.
    pub meaning: &'static str,
    /// What the numbers are multiples of.
    pub size: Size,
    /// Least value.
    pub low: f64,
    /// Greatest value.
    pub high: f64,
    /// Value that changes nothing (of a strength), or the usual value (of a shape).
    pub neutral: f64,
    /// A strength of this size is of interest: where a search starts.
    pub usual: f64,
}

/// What a parameter's bounds are multiples of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Size {
    /// A bare number.
    One,
    /// The tank's usual level, m.
    Level,
    /// The usual flow, m³/s.
    Flow,
    /// The usual pressure difference, Pa.
    Pressure,
    /// The usual time, s.
    Time,
    /// One in the instrument's reading at the usual quantity.
    Reading,
}

/// Usual sizes in an assembly, from which effects take their bounds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scale {
    /// m
    pub level_m: f64,
    /// m³/s
    pub flow_m3_s: f64,
    /// Pa
    pub pressure_pa: f64,
    /// s
    pub time_s: f64,
    /// Size of the instrument's reading.
    pub reading: f64,
}

impl Scale {
    /// The size a parameter is a multiple of.
    #[must_use]
    pub fn of(&self, size: Size) -> f64 {
        match size {
            Size::One => 1.0,
            Size::Level => self.level_m,
            Size::Flow => self.flow_m3_s,
            Size::Pressure => self.pressure_pa,
            Size::Time => self.time_s,
            Size::Reading => self.reading,
        }
    }
}

/// The moment as a component sees it.
#[derive(Debug, Clone, Copy)]
pub struct Now<'a> {
    /// Time (or independent variable) since the start of the record: [`Window::origin`](crate::Window::origin), s.
    pub t_s: f64,
    /// Density of the fluid, kg/m³.
    pub density_kg_m3: f64,
    /// Dynamic viscosity, Pa·s.
    pub viscosity_pa_s: f64,
    /// Gravity, m/s².
    pub gravity_m_s2: f64,
    /// Usual sizes.
    pub scale: &'a Scale,
    /// The component's properties in the order of [`Kind::properties`].
    pub own: &'a [f64],
    /// The effect's parameters, in the order of its description.
    pub p: &'a [f64],
    /// The effect's own states.
    pub x: &'a [f64],
}

/// What a component went through at a moment, for the rates of an effect's states.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Drive {
    /// The input (speed, opening, pump input, boundary value), as the effects before this one leave it.
    pub input: f64,
    /// Flow through it; net flow out of a boundary; inflow of a tank, m³/s.
    pub flow_m3_s: f64,
}

/// Flows of a tank, which effects may change.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Balance {
    /// Level, m.
    pub level_m: f64,
    /// Height of the brim, m.
    pub brim_m: f64,
    /// Surface area, m².
    pub area_m2: f64,
    /// Inflow from above and below, m³/s.
    pub inflow_m3_s: f64,
    /// Outflow, m³/s.
    pub outflow_m3_s: f64,
    /// Over the brim below its hard limit, m³/s; effects add.
    pub overflow_m3_s: f64,
    /// Lost to nowhere, m³/s; effects add.
    pub lost_m3_s: f64,
    /// Passed on to the tank below, m³/s; effects add.
    pub passed_on_m3_s: f64,
    /// Share of the overflow that the tank below catches; effects add.
    pub caught: f64,
}

/// An effect that the textbook law leaves out.
///
/// Every hook has a neutral default. Parameters at their neutral value must leave the law as it was, to round-off.
/// No hook may panic on any finite number.
pub trait Effect: Sync {
    /// What it is.
    fn about(&self) -> &'static About;

    /// Whether it makes sense at this place.
    fn fits(&self, place: &Place) -> bool {
        let _ = place;
        true
    }

    /// Number of states it adds.
    fn states(&self) -> usize {
        0
    }

    /// Writes its states at rest at `drive`, the start of a window.
    fn start(&self, now: &Now<'_>, drive: &Drive, x: &mut [f64]) {
        let _ = (now, drive, x);
    }

    /// Writes the rates of its states.
    fn rates(&self, now: &Now<'_>, drive: &Drive, rate: &mut [f64]) {
        let _ = (now, drive, rate);
    }

    /// Speed, opening, pump input or boundary value as the component feels it.
    fn input(&self, now: &Now<'_>, value: f64) -> f64 {
        let _ = now;
        value
    }

    /// Changes the samples of the channel that drives the component, of shape `(n,)`, before the run: for what remembers in jumps
    /// where it was told to be. `held`: each holds until the next; otherwise straight lines join them.
    fn command(&self, now: &Now<'_>, held: bool, values: &mut [f64]) {
        let _ = (now, held, values);
    }

    /// Whether [`command`](Self::command) does anything.
    fn has_command(&self) -> bool {
        false
    }

    /// Flow that the base law sees when `q` (m³/s) passes.
    fn through(&self, now: &Now<'_>, q: Dual) -> Dual {
        let _ = now;
        q
    }

    /// Pressure drop (Pa) from inlet to outlet when `q` passes; it must not fall with `q`. `drop` is that without the effect.
    fn drop(&self, now: &Now<'_>, q: Dual, drop: Dual) -> Dual {
        let _ = (now, q);
        drop
    }

    /// Flow of a displacement pump against the pressure rise (Pa); it must not grow with the rise.
    fn delivery(&self, now: &Now<'_>, rise: Dual, flow: Dual) -> Dual {
        let _ = (now, rise);
        flow
    }

    /// Whether [`delivery`](Self::delivery) does anything.
    fn has_delivery(&self) -> bool {
        false
    }

    /// What leaves at the outlet (m³/s) when `q` enters at the inlet.
    fn outlet(&self, now: &Now<'_>, q: f64, inlet_pa: f64) -> f64 {
        let _ = (now, inlet_pa);
        q
    }

    /// Added to the inertia M (kg/m⁴) of a line.
    fn inertia(&self, now: &Now<'_>) -> f64 {
        let _ = now;
        0.0
    }

    /// Whether the line's flow becomes a state.
    fn gives_inertia(&self) -> bool {
        false
    }

    /// Level (m) that a tank's outlets feel.
    fn head(&self, now: &Now<'_>, level: f64) -> f64 {
        let _ = now;
        level
    }

    /// Surface area (m²) of a tank.
    fn area(&self, now: &Now<'_>, level: f64, area: f64) -> f64 {
        let _ = (now, level);
        area
    }

    /// Changes a tank's flows.
    fn balance(&self, now: &Now<'_>, flows: &mut Balance) {
        let _ = (now, flows);
    }

    /// Height (m) of the brim, beyond which what comes is spilled at once.
    fn brim(&self, now: &Now<'_>, brim: f64) -> f64 {
        let _ = now;
        brim
    }

    /// Changes an instrument's readings at the times `t_s` since the start of the record; both of shape `(n,)`.
    fn reading(&self, now: &Now<'_>, t_s: &[f64], values: &mut [f64]) {
        let _ = (now, t_s, values);
    }
}

/// Where an effect might sit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// Tank: it has a finite or free brim.
    pub has_brim: bool,
    /// Tank: a tank lies below, fed by this one.
    pub has_tank_below: bool,
    /// Branch or flow boundary: its outlet feeds a tank or a given pressure, so that what leaves may differ from what enters.
    pub outlet_stores: bool,
    /// Branch: its flow is a state.
    pub has_inertia: bool,
    /// Branch: its flow could be a state (no displacement pump and no other inertia in its series).
    pub may_have_inertia: bool,
    /// It moves in time (and is not a relation between samples).
    pub in_time: bool,
    /// Boundary: it gives a flow, not a pressure.
    pub gives_flow: bool,
    /// Its input is a channel.
    pub driven: bool,
}
