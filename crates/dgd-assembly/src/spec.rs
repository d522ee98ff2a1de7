//! The types of `system.toml`.

use crate::record::Portion;
use serde::{Deserialize, Deserializer, Serialize};
use std::collections::BTreeMap;

/// A rig or bench as its file describes it.
///
/// Paths such as `"line.roughness"` name a property of a component; known values, free parameters and inputs are
/// addressed by the same path.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct System {
    /// What it is, for people.
    #[serde(default)]
    pub name: String,
    /// `"time"`: the samples are moments of one run. Anything else (`"depth"`): each sample is a steady state on its own.
    #[serde(default = "time")]
    pub independent: String,
    /// Connections in the direction of flow, `"pit -> pump -> line -> tank"`; `tank.port` names a port.
    pub connections: Vec<String>,
    /// `density` (1000 kg/m³), `viscosity` (0.001 Pa·s), `gravity` (9.80665 m/s²) of the one fluid.
    #[serde(default)]
    pub fluid: BTreeMap<String, Setting>,
    /// Reference sizes `level`, `flow`, `pressure`, `time`, from which effects take their bounds; estimated if absent.
    #[serde(default)]
    pub scale: BTreeMap<String, Setting>,
    /// Components by name.
    pub components: BTreeMap<String, Component>,
    /// What drives the system: property path to channel.
    #[serde(default)]
    pub inputs: BTreeMap<String, Input>,
    /// States at the start of a window: `"tank.level"`, `"volume.pressure"`, `"line.flow"`.
    #[serde(default)]
    pub initial: BTreeMap<String, Initial>,
    /// Parameters to be found: property path to bounds.
    #[serde(default)]
    pub free: BTreeMap<String, Bounds>,
    /// Where the record's samples are.
    #[serde(default)]
    pub record: RecordLayout,
    /// Effects that the textbook laws leave out.
    #[serde(default)]
    pub effects: Vec<EffectSetting>,
}

fn time() -> String {
    "time".into()
}

/// One component: its kind and its properties.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Component {
    /// What it is.
    pub kind: Kind,
    /// Properties by name; which there are depends on the kind ([`Kind::properties`]).
    #[serde(flatten)]
    pub settings: BTreeMap<String, Setting>,
}

/// Kind of a component.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// Open or gas-blanketed tank with a free surface; owns the state `level`.
    Tank,
    /// Full, compressible volume; owns the state `pressure`.
    Volume,
    /// Pipe, hose, drill string, annulus; owns the state `flow` if `inertia = true`.
    Line,
    /// Pump whose head falls with flow (Slettebø 2015, Eq. 2.28 and 3.39).
    CentrifugalPump,
    /// Pump that delivers `coefficient · input` whatever the pressure.
    DisplacementPump,
    /// Valve: resistance with an opening.
    Valve,
    /// Orifice or bit: resistance.
    Orifice,
    /// Given pressure or given flow.
    Boundary,
    /// Where lines meet; no storage.
    Junction,
    /// What is measured.
    Instrument,
}

/// Value of a property.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(
    untagged,
    expecting = "expected a number in SI units, a text (a choice, or a number with its unit such as \"19.5 in\"), true or false, points such as \
                 [[0.0, 0.03], [0.9, 0.04]] in SI units, or named numbers"
)]
pub enum Setting {
    /// `true` or `false`.
    Flag(bool),
    /// A number in SI units.
    Number(f64),
    /// A choice, or a number with a unit such as `"19.5 in"`.
    Text(String),
    /// Points of a curve.
    Points(Vec<[f64; 2]>),
    /// Named numbers (ports and their heights).
    Named(BTreeMap<String, Setting>),
}

/// Channel that drives a property.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Input {
    /// Column of the record, or a name that the record's parts translate.
    pub channel: String,
    /// Between samples.
    #[serde(default)]
    pub between: Between,
    /// Unit of the column; SI if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
}

/// What an input does between its samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Between {
    /// Straight lines.
    #[default]
    Interpolated,
    /// Each value holds until the next (zero-order hold).
    Held,
}

/// State at the start of each window.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(
    untagged,
    expecting = "expected a number in SI units, a text with a number and its unit such as \"25 cm\", { measured = \"instrument\" }, or \
                 { start = .., low = .., high = .. } with numbers in SI units"
)]
pub enum Initial {
    /// Known.
    Given(f64),
    /// Known, with its unit.
    Written(String),
    /// Read off an instrument's first valid sample in the window.
    Measured(Measured),
    /// To be found.
    Free(Bounds),
}

/// `{ measured = "instrument" }`
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Measured {
    /// Instrument.
    pub measured: String,
    /// By how much, SI, the state may be off its reading, which a fit finds for each training window; never part of a file.
    #[serde(skip)]
    pub within: Option<f64>,
}

/// Where a free value starts and within which bounds it is sought.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(
    deny_unknown_fields,
    expecting = "{ start = .., low = .., high = .. } with numbers in SI units"
)]
pub struct Bounds {
    /// First guess.
    #[serde(deserialize_with = "si")]
    pub start: f64,
    /// Least value.
    #[serde(deserialize_with = "si")]
    pub low: f64,
    /// Greatest value.
    #[serde(deserialize_with = "si")]
    pub high: f64,
}

/// A number, told as one without a unit.
fn si<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    #[derive(Deserialize)]
    #[serde(untagged, expecting = "expected a number in SI units, without a unit")]
    enum Number {
        Si(f64),
    }
    let Number::Si(value) = Number::deserialize(from)?;
    Ok(value)
}

/// Where the samples are.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RecordLayout {
    /// Column of the independent variable; without it `step` numbers the samples.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time: Option<String>,
    /// Step between samples where there is no column, in `unit`; 1 if absent, which `dgd` refuses along time.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub step: Option<f64>,
    /// Unit of the column, of `step` and of the windows: of time, s if absent, and read into s; or of another
    /// independent variable, which is shown with it and kept as it is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    /// What is fitted; all samples if absent.
    #[serde(default)]
    pub train: PartLayout,
    /// What is held out; none if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub test: Option<PartLayout>,
}

impl RecordLayout {
    /// The columns that stand for channels in a portion: where the held-out part says nothing of them, those of the training part.
    #[must_use]
    pub fn channels(&self, portion: Portion) -> &BTreeMap<String, String> {
        let own =
            (self.test.as_ref()).filter(|t| portion == Portion::Test && !t.channels.is_empty());
        &own.unwrap_or(&self.train).channels
    }
}

/// One part of the record.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PartLayout {
    /// Windows `[from, to]` of the independent variable, ends included; all samples if empty.
    #[serde(default)]
    pub windows: Vec<[f64; 2]>,
    /// Columns that stand for the channels in this part, `{ u = "uEst", y = "yEst" }`; of the held-out part those of the training part
    /// if empty.
    #[serde(default)]
    pub channels: BTreeMap<String, String>,
}

/// An effect on a component, with what is known of its parameters.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EffectSetting {
    /// Component it acts on.
    pub component: String,
    /// Id in the catalogue.
    pub effect: String,
    /// Known parameters; the others keep their neutral or usual value unless `[free]` holds
    /// `"component.effect.parameter"`.
    #[serde(default)]
    pub parameters: BTreeMap<String, f64>,
}
