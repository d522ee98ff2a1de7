//! What the commands on systems share: descriptions and recordings in, runs, drawings, parts of a page.

pub(crate) mod columns;
pub(crate) mod diagram;
pub(crate) mod measure;
pub(crate) mod page;
pub(crate) mod quantity;
pub(crate) mod runs;

use crate::failure::Failure;
use crate::load::read_text;
use dgd_assembly::{
    Assembly, AssemblyError, Component, FitStatus, Kind, Property, RunStatus, Setting, Size, System,
};
use dgd_documents::{DocumentError, SystemDocument};
use dgd_recording::Column;
use dgd_units::{Dimension, Unit};
use std::path::{Path, PathBuf};

/// Reads a description with the fit it may hold, and tells what is odd about it.
pub(crate) fn read(path: &Path) -> Result<SystemDocument, Failure> {
    let source = read_text(path)?;
    let document = dgd_documents::read_system(&source).map_err(|e| told(path, source, e))?;
    for warning in document.assembly.warnings() {
        tracing::warn!("{}: {warning}", path.display());
    }
    Ok(document)
}

/// A document's problems, with its lines.
pub(crate) fn told(path: &Path, source: String, error: DocumentError) -> Failure {
    Failure::Document {
        path: path.to_owned(),
        source,
        error,
    }
}

/// The one recording and the description that a command on a system takes.
pub(crate) fn open<'a>(
    path: &Path,
    recordings: &'a [PathBuf],
) -> Result<(&'a Path, SystemDocument), Failure> {
    Ok((single(recordings)?, read(path)?))
}

fn single(recordings: &[PathBuf]) -> Result<&Path, Failure> {
    match recordings {
        [one] => Ok(one),
        several => Err(Failure::Arguments {
            reason: format!(
                "--system takes one recording, {} were given; split one recording with `windows` under [record.train] and [record.test]",
                several.len()
            ),
        }),
    }
}

/// A failure of the assembly on a recording: what of it is the recording's fault names that file.
pub(crate) fn failed(system: &Path, recording: &Path, error: &AssemblyError) -> Failure {
    let path = match error {
        AssemblyError::Column { .. }
        | AssemblyError::Length { .. }
        | AssemblyError::Times { .. }
        | AssemblyError::NoReadings { .. }
        | AssemblyError::Window { .. }
        | AssemblyError::Input(_) => recording,
        _ => system,
    };
    Failure::input(path, error)
}

/// What a system is called: its name, or that of its file.
pub(crate) fn title(assembly: &Assembly, path: &Path) -> String {
    let name = &assembly.system().name;
    if name.is_empty() {
        file_name(path)
    } else {
        name.clone()
    }
}

/// A file's name without its folder: results do not depend on who ran them where.
pub(crate) fn file_name(path: &Path) -> String {
    let name = path.file_name().unwrap_or(path.as_os_str());
    name.to_string_lossy().into_owned()
}

/// Tag and unit of the independent variable in a table.
pub(crate) fn clock(assembly: &Assembly) -> (&str, Option<String>) {
    match assembly.system().independent.as_str() {
        "time" => ("t", Some("s".to_owned())),
        other => (other, assembly.system().record.unit.clone()),
    }
}

/// The property of a component that a path stands for, if it is none of its states.
pub(crate) fn property(system: &System, path: &str) -> Option<&'static Property> {
    let (component, name) = path.split_once('.')?;
    let kind = system.components.get(component)?.kind;
    kind.properties().iter().find(|p| p.name == name)
}

/// A column of a table.
pub(crate) fn column(tag: &str, unit: Option<String>, values: Vec<f64>) -> Column {
    Column {
        tag: tag.to_owned(),
        unit,
        values,
    }
}

/// A file beside another, with another ending.
pub(crate) fn beside(path: &Path, ending: &str) -> PathBuf {
    path.with_extension(ending)
}

/// An instrument as people read it.
#[derive(Debug, Clone)]
pub(crate) struct Gauge {
    pub(crate) name: String,
    pub(crate) channel: String,
    pub(crate) measures: String,
    /// Unit of the column, if it is one that is converted.
    unit: Option<Unit>,
    /// Symbol of the unit that the reading is shown in; empty if it is its own.
    pub(crate) symbol: String,
}

impl Gauge {
    /// A reading of the assembly in the instrument's own unit.
    pub(crate) fn shown(&self, si: f64) -> f64 {
        self.unit.map_or(si, |u| u.from_si(si))
    }

    /// A difference of readings in the instrument's own unit.
    pub(crate) fn difference(&self, si: f64) -> f64 {
        self.unit.map_or(si, |u| si / u.factor)
    }

    /// Unit in which the assembly carries the reading: SI of what is converted.
    pub(crate) fn carried(&self) -> String {
        self.unit.map_or_else(
            || self.symbol.clone(),
            |unit| unit.dimension.si_symbol().to_owned(),
        )
    }

    /// `level [m]`
    pub(crate) fn label(&self) -> String {
        if self.symbol.is_empty() {
            self.name.clone()
        } else {
            format!("{} [{}]", self.name, self.symbol)
        }
    }

    /// `0.1 m`
    pub(crate) fn with_unit(&self, value: &str) -> String {
        format!("{value} {}", self.symbol).trim_end().to_owned()
    }
}

/// The instruments in the order of the outputs.
pub(crate) fn gauges(assembly: &Assembly) -> Vec<Gauge> {
    let system = assembly.system();
    let outputs = assembly.outputs().into_iter();
    outputs
        .map(|name| gauge(system, &name, system.components.get(&name)))
        .collect()
}

fn gauge(system: &System, name: &str, component: Option<&Component>) -> Gauge {
    let text = |key: &str| component.and_then(|c| word(c, key)).map(ToOwned::to_owned);
    let measures = text("measures").unwrap_or_default();
    let written = text("unit");
    let unit = written
        .as_deref()
        .and_then(|u| Unit::parse(u).ok())
        .filter(|u| u.dimension != Dimension::Number);
    // A gain of its own makes the reading anything.
    let own = ["gain", "offset"].iter().any(|key| {
        let path = format!("{name}.{key}");
        component.is_some_and(|c| c.settings.contains_key(*key))
            || system.free.contains_key(&path)
            || system.inputs.contains_key(&path)
    });
    let symbol = written.unwrap_or_else(|| {
        let si = match measures.as_str() {
            _ if own => "",
            "level" | "head" => "m",
            "pressure" | "drop" => "Pa",
            "flow" => "m3/s",
            _ => "",
        };
        si.to_owned()
    });
    Gauge {
        name: name.to_owned(),
        channel: text("channel").unwrap_or_else(|| name.to_owned()),
        measures,
        unit,
        symbol: if symbol == "1" { String::new() } else { symbol },
    }
}

/// Openings of valves that are neither given nor sought nor recorded: the valves are fully open.
pub(crate) fn at_default(system: &System) -> Vec<String> {
    let valves = system.components.iter();
    let valves =
        valves.filter(|(_, c)| c.kind == Kind::Valve && !c.settings.contains_key("opening"));
    let paths = valves.map(|(name, _)| format!("{name}.opening"));
    let known = |path: &String| system.inputs.contains_key(path) || system.free.contains_key(path);
    paths.filter(|path| !known(path)).collect()
}

/// A property that is a word.
pub(crate) fn word<'a>(component: &'a Component, key: &str) -> Option<&'a str> {
    match component.settings.get(key) {
        Some(Setting::Text(text)) => Some(text),
        _ => None,
    }
}

/// Unit of what a path of the assembly stands for: a property, a state, or an initial state.
pub(crate) fn unit_of(system: &System, path: &str) -> String {
    let (path, _) = path.split_once('@').unwrap_or((path, ""));
    let mut keys = path.split('.');
    let (Some(component), Some(property)) = (keys.next(), keys.next()) else {
        return String::new();
    };
    if let Some(parameter) = keys.next() {
        return unit_of_effect(system, component, property, parameter);
    }
    let kind = system.components.get(component).map(|c| c.kind);
    let known = kind.and_then(|k| k.properties().iter().find(|p| p.name == property));
    let symbol = match known {
        Some(property) => property.unit,
        None if component == "fluid" && property == "density" => "kg/m3",
        None if component == "fluid" && property == "viscosity" => "Pa.s",
        None => dimension_of_state(property).map_or("", Dimension::si_symbol),
    };
    let plain = ["1", "any", "as the reading", "reading per SI"];
    if plain.contains(&symbol) {
        String::new()
    } else {
        symbol.to_owned()
    }
}

/// Unit of a parameter of an effect; empty for a bare number.
fn unit_of_effect(system: &System, component: &str, effect: &str, parameter: &str) -> String {
    let about = dgd_assembly::effects::find(effect).map(dgd_assembly::Effect::about);
    let parameter = about.and_then(|a| a.parameters.iter().find(|p| p.name == parameter));
    let si = match parameter.map(|p| p.size) {
        Some(Size::Level) => "m",
        Some(Size::Flow) => "m3/s",
        Some(Size::Pressure) => "Pa",
        Some(Size::Time) => "s",
        Some(Size::Reading) => {
            return gauge(system, component, system.components.get(component)).carried();
        }
        Some(Size::One) | None => "",
    };
    // Times and lengths along something else than time are in its own unit.
    if si == "s" && system.independent != "time" {
        return system.record.unit.clone().unwrap_or_default();
    }
    si.into()
}

/// What a free value is sought within.
pub(crate) fn bounds(assembly: &Assembly, path: &str) -> (f64, f64) {
    let known = assembly.parameters();
    (known.iter().find(|k| k.path == path))
        .map_or((f64::NEG_INFINITY, f64::INFINITY), |k| (k.low, k.high))
}

/// Dimension of a state by the last part of its path.
pub(crate) fn dimension_of_state(name: &str) -> Option<Dimension> {
    match name {
        "level" => Some(Dimension::Length),
        "pressure" => Some(Dimension::Pressure),
        "flow" => Some(Dimension::FlowRate),
        _ => None,
    }
}

/// How a run ended, if it did not reach its end.
pub(crate) fn trouble(status: RunStatus) -> Option<String> {
    match status {
        RunStatus::Finished => None,
        RunStatus::Stopped(status) => Some(format!("the integrator gave up: {status:?}")),
        RunStatus::NotSolved => Some("pressures and flows could not be solved".into()),
        other => Some(format!("{other:?}")),
    }
}

/// How a fit ended, in words.
pub(crate) fn ending(status: FitStatus) -> &'static str {
    match status {
        FitStatus::Converged => "converged",
        FitStatus::IterationLimit => "stopped at its limit of steps",
        FitStatus::NoProgress => "stopped where no step improved it, which is not a minimum",
        FitStatus::NoStart => "no start could be simulated",
        FitStatus::NothingFree => "nothing is free",
        _ => "ended otherwise",
    }
}
