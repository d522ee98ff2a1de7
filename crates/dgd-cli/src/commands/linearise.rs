//! `dgd linearise`: a linear model around an operating point, for control design.

use crate::args::{Global, Linearise};
use crate::failure::Failure;
use crate::load;
use crate::output::{self, Outputs};
use crate::progress::Progress;
use crate::say::{self, TextTable, number};
use crate::system::runs::{self, Run};
use crate::system::{self, Gauge, columns, dimension_of_state, failed, gauges, property, unit_of};
use dgd_assembly::{
    Assembly, AssemblyError, Initial, Linear, RecordLayout, SimulationOptions, Window, linearise,
    steady_state,
};
use dgd_documents::{SystemDocument, read_system, return_line_system};
use dgd_export::{MatValue, write_mat5_values};
use dgd_units::{Dimension, STANDARD_ATMOSPHERE_PA, Unit, split_number};
use serde_json::{Map, Value, json};
use std::path::{Path, PathBuf};

/// A point to linearise around.
struct Point {
    states: Vec<f64>,
    inputs: Vec<f64>,
    /// Readings there.
    outputs: Vec<f64>,
    /// What is left of the rates, in usual sizes a usual time, if it was sought as a steady state.
    residual: Option<f64>,
}

pub(crate) fn run(arguments: &Linearise, global: &Global) -> Result<String, Failure> {
    let progress = Progress::new(global);
    let (document, path, written) = described(arguments)?;
    let assembly = &document.assembly;
    let theta = document.theta();
    let [json_path, mat_path, system_path] =
        ["linear.json", "linear.mat", "system.toml"].map(|name| arguments.out.join(name));
    let mut outputs = vec![&json_path, &mat_path];
    outputs.extend(written.as_ref().map(|_| &system_path));
    progress.stage("linearising", "around the operating point");
    let point = match (arguments.at_time, &arguments.recording) {
        (Some(time), Some(recording)) => {
            recorded_point(assembly, &theta, &path, recording, time, &progress)?
        }
        _ => {
            let recorded = arguments.described.system.is_some();
            given_point(assembly, &theta, &path, &arguments.at, recorded)?
        }
    };
    outputs.iter().try_for_each(|file| output::check(file))?;
    let wrong = |e| failed(&path, &path, &e);
    let linear = linearise(assembly, &theta, &point.states, &point.inputs).map_err(wrong)?;
    let finite = [&linear.a, &linear.b, &linear.c, &linear.d];
    if finite.into_iter().flatten().any(|v| !v.is_finite()) {
        let reason = "has no linear model at this operating point: pressures or flows cannot be solved there";
        return Err(Failure::input(&path, reason));
    }
    let discrete = match arguments.step {
        Some(step) => Some(linear.discrete(step).map_err(|e| Failure::Arguments {
            reason: format!("--step: {e}"),
        })?),
        None => None,
    };
    let title = system::title(assembly, &path);
    let mut value = as_json(assembly, &title, &point, &linear, discrete.as_ref());
    let matrices = as_mat(assembly, &point, &linear, discrete.as_ref());
    progress.stage("writing", &arguments.out.display().to_string());
    let mut staged = Outputs::new();
    staged.add_bytes(&json_path, say::json(&value))?;
    staged.add(&mat_path, |w| {
        Ok(write_mat5_values(&matrices, "linear", w)?)
    })?;
    if let Some(written) = &written {
        staged.add_bytes(&system_path, written)?;
    }
    staged.keep()?;
    let seconds = progress.seconds();
    drop(progress);
    if global.json {
        value["seconds"] = json!(seconds);
        return Ok(say::json(&value));
    }
    let well = arguments.described.system.is_none();
    Ok(tell(&title, assembly, &point, &linear, &outputs, well))
}

/// The system, its file, and its text if it is the built-in one.
fn described(arguments: &Linearise) -> Result<(SystemDocument, PathBuf, Option<String>), Failure> {
    if let Some(path) = &arguments.described.system {
        return Ok((system::read(path)?, path.clone(), None));
    }
    let model = load::read_base_model(&arguments.model)?;
    if let Some(well) = &arguments.described.well {
        let well = load::read_well(well)?;
        if !model.fits_well(&well) {
            tracing::warn!(
                "{} was identified on a well with different mud or geometry; those of the model are used",
                arguments.model.display()
            );
        }
    }
    let text = return_line_system(&model);
    let document =
        read_system(&text).map_err(|e| system::told(&arguments.model, text.clone(), e))?;
    Ok((document, arguments.model.clone(), Some(text)))
}

/// The operating point that --at names, completed by the steady state; a point of a recording may be advised where there can be one.
fn given_point(
    assembly: &Assembly,
    theta: &[f64],
    path: &Path,
    at: &[(String, String)],
    recorded: bool,
) -> Result<Point, Failure> {
    let or = |way: &'static str| if recorded { way } else { "" };
    let (states, inputs) = (assembly.states(), assembly.inputs());
    let mut given_states = vec![None; states.len()];
    let mut given_inputs = vec![None; inputs.len()];
    for (key, text) in at {
        let value = || parse(assembly, key, text).map(Some);
        if let Some(k) = states.iter().position(|s| s == key) {
            given_states[k] = value()?;
        } else if let Some(k) = inputs.iter().position(|i| i == key) {
            given_inputs[k] = value()?;
        } else {
            let known: Vec<&str> = inputs.iter().chain(&states).map(String::as_str).collect();
            return Err(Failure::Arguments {
                reason: format!(
                    "--at {key}: no such input or state, expected one of: {}",
                    known.join(", ")
                ),
            });
        }
    }
    let missing: Vec<String> = inputs
        .iter()
        .zip(&given_inputs)
        .filter(|(_, v)| v.is_none())
        .map(|(name, _)| format!("{name}=..."))
        .collect();
    if !missing.is_empty() {
        return Err(Failure::Arguments {
            reason: format!(
                "the operating point does not give every input; add --at {}{}",
                missing.join(" "),
                or(", or take it from a recording with --at-time")
            ),
        });
    }
    let inputs: Vec<f64> = given_inputs.into_iter().flatten().collect();
    if given_states.iter().all(Option::is_some) {
        let states: Vec<f64> = given_states.into_iter().flatten().collect();
        return Ok(Point {
            outputs: readings(assembly, theta, &states, &inputs)
                .map_err(|e| failed(path, path, &e))?,
            states,
            inputs,
            residual: None,
        });
    }
    let guess: Vec<f64> = states
        .iter()
        .zip(&given_states)
        .map(|(name, given)| given.unwrap_or_else(|| initial(assembly, theta, name)))
        .collect();
    let steady =
        steady_state(assembly, theta, &inputs, &guess).map_err(|e| failed(path, path, &e))?;
    if !steady.found {
        let all: Vec<String> = states.iter().map(|s| format!("{s}=...")).collect();
        return Err(Failure::Input {
            path: path.to_owned(),
            reason: "has no steady state at these inputs (a tank that nothing regulates fills, spills or empties, or an input lies beyond what the \
                     system can hold)"
                .into(),
            help: Some(format!(
                "{}give every state with --at {}{}",
                taken_as_si(assembly, at),
                all.join(" "),
                or(", or take the point from a recording with --at-time")
            )),
        });
    }
    // A state that was given is kept only if it is the steady one.
    for ((name, given), found) in states.iter().zip(&given_states).zip(&steady.state) {
        if let Some(given) = given
            && (given - found).abs() > 1e-6 * given.abs().max(1e-9)
        {
            tracing::warn!(
                "the steady state has {name} = {}, not {}; to linearise away from it, give every state",
                number(*found),
                number(*given)
            );
        }
    }
    Ok(Point {
        states: steady.state,
        outputs: steady.outputs,
        inputs,
        residual: Some(steady.residual),
    })
}

/// A value with or without its unit.
fn parse(assembly: &Assembly, key: &str, text: &str) -> Result<f64, Failure> {
    let wrong = |reason: String| Failure::Arguments {
        reason: format!("--at {key}={text}: {reason}"),
    };
    let (value, unit) = split_number(text).map_err(|e| wrong(e.to_string()))?;
    let property = property(assembly.system(), key);
    let unit = match (property, dimension(assembly, key)) {
        _ if unit.is_empty() => Ok(None),
        (Some(property), _) if property.dimension.is_some() => property.unit_of(unit).map(Some),
        (_, Some(dimension)) => Unit::parse_as(unit, dimension).map(Some),
        (_, None) => return Err(wrong("it has no unit here; write the number alone".into())),
    };
    let unit = unit.map_err(|e| wrong(e.to_string()))?;
    let value = unit.map_or(value, |unit| unit.to_si(value));
    match property.and_then(|p| p.refusal(value)) {
        Some(refusal) => Err(wrong(format!("it {refusal}"))),
        None => Ok(value),
    }
}

/// Of a state, of a property, of the channel that drives a component by any signal.
fn dimension(assembly: &Assembly, key: &str) -> Option<Dimension> {
    let Some(property) = property(assembly.system(), key) else {
        let (component, state) = key.split_once('.')?;
        assembly.system().components.get(component)?;
        return dimension_of_state(state);
    };
    let channel = || assembly.input_unit(key).map(|unit| unit.dimension);
    property.dimension.or_else(channel)
}

/// What was given without a unit, as it was taken: a flow of 3000 was meant in l/min.
fn taken_as_si(assembly: &Assembly, at: &[(String, String)]) -> String {
    let bare = |text: &str| split_number(text).is_ok_and(|(_, unit)| unit.is_empty());
    let taken: Vec<String> = at
        .iter()
        .filter(|(_, text)| bare(text))
        .filter_map(|(key, text)| {
            let dimension = dimension(assembly, key).filter(|d| *d != Dimension::Number)?;
            Some(format!("{key}={text} in {}", Unit::si(dimension).symbol))
        })
        .collect();
    if taken.is_empty() {
        return String::new();
    }
    format!("check the units ({} was taken); or ", taken.join(", "))
}

/// Where a state would start, as a guess.
fn initial(assembly: &Assembly, theta: &[f64], state: &str) -> f64 {
    let free = assembly.parameters();
    if let Some(k) = free.iter().position(|p| p.initial && p.path == state) {
        return theta[k];
    }
    match assembly.system().initial.get(state) {
        Some(Initial::Given(value)) => *value,
        Some(Initial::Written(text)) => parse(assembly, state, text).unwrap_or(0.0),
        Some(Initial::Free(bounds)) => bounds.start,
        // A pressure of nothing is no guess.
        _ if state.ends_with(".pressure") => STANDARD_ATMOSPHERE_PA,
        _ => 0.0,
    }
}

/// Inputs as recorded and states as simulated at a time.
fn recorded_point(
    assembly: &Assembly,
    theta: &[f64],
    path: &Path,
    recording: &Path,
    time: f64,
    progress: &Progress,
) -> Result<Point, Failure> {
    let recorded = columns::read(recording, path, assembly, progress)?;
    let runs = runs::simulate(
        assembly,
        theta,
        &recorded,
        &SimulationOptions::default(),
        (path, recording),
    )?;
    let span = |run: &Run| {
        (
            run.window.time.first().copied(),
            run.window.time.last().copied(),
        )
    };
    let within = |run: &Run| match span(run) {
        (Some(from), Some(to)) => (from..=to).contains(&time),
        _ => false,
    };
    let Some(run) = runs.iter().find(|run| within(run)) else {
        let known: Vec<String> = runs
            .iter()
            .filter_map(|run| Some((span(run).0?, span(run).1?)))
            .map(|(from, to)| format!("{} to {}", say::number(from), say::number(to)))
            .collect();
        return Err(Failure::input(
            recording,
            format!(
                "has no window at --at-time {time}, expected {}",
                known.join(" or ")
            ),
        ));
    };
    let (window, simulation) = (&run.window, &run.simulation);
    let nearest = (0..window.time.len())
        .min_by(|&a, &b| {
            (window.time[a] - time)
                .abs()
                .total_cmp(&(window.time[b] - time).abs())
        })
        .unwrap_or(0);
    let point = Point {
        states: simulation.states.iter().map(|s| s[nearest]).collect(),
        inputs: window.inputs.iter().map(|u| u[nearest]).collect(),
        outputs: simulation.outputs.iter().map(|y| y[nearest]).collect(),
        residual: None,
    };
    if point.states.iter().any(|v| !v.is_finite()) {
        let why = system::trouble(simulation.status).unwrap_or_default();
        let reason = format!("cannot be simulated up to --at-time {time}: {why}");
        return Err(Failure::input(recording, reason));
    }
    Ok(point)
}

/// Readings at a point: those of a run that starts there.
fn readings(
    assembly: &Assembly,
    theta: &[f64],
    states: &[f64],
    inputs: &[f64],
) -> Result<Vec<f64>, AssemblyError> {
    let mut system = assembly.system().clone();
    let given = assembly.states().into_iter().zip(states);
    system.initial = given.map(|(name, v)| (name, Initial::Given(*v))).collect();
    system.record = RecordLayout::default();
    let window = Window {
        time: vec![0.0, 1e-6],
        inputs: inputs.iter().map(|u| vec![*u; 2]).collect(),
        readings: vec![Vec::new(); assembly.outputs().len()],
        origin: None,
    };
    let run = Assembly::new(system)?.simulate(
        &theta[..assembly.free_properties()],
        &window,
        0,
        &SimulationOptions::default(),
    )?;
    Ok(run.outputs.iter().map(|y| y[0]).collect())
}

fn rows(values: &[f64], columns: usize) -> Vec<&[f64]> {
    values.chunks(columns.max(1)).collect()
}

fn as_json(
    assembly: &Assembly,
    title: &str,
    point: &Point,
    linear: &Linear,
    discrete: Option<&Linear>,
) -> Value {
    let named = |names: &[String], values: &[f64]| -> Value {
        let pairs = names.iter().zip(values);
        Value::Object(
            pairs
                .map(|(n, v)| (n.clone(), json!(v)))
                .collect::<Map<_, _>>(),
        )
    };
    let units = Units::of(assembly, linear);
    let (n, m) = (linear.states.len(), linear.inputs.len());
    let matrices = |l: &Linear| {
        json!({
            "A": rows(&l.a, n), "B": rows(&l.b, m), "C": rows(&l.c, n), "D": rows(&l.d, m),
            "poles": l.poles().iter().map(|(re, im)| json!([re, im])).collect::<Vec<_>>(),
            "time_constants_s": l.time_constants(),
        })
    };
    let mut continuous = matrices(linear);
    continuous["rates"] = json!(linear.rates);
    let discrete = discrete.map(|l| {
        let mut value = matrices(l);
        value["step_s"] = json!(l.step_s);
        value
    });
    json!({
        "schema": "dgd.linear/1",
        "system": title,
        "states": linear.states,
        "state_units": units.states,
        "inputs": linear.inputs,
        "input_units": units.inputs,
        "outputs": linear.outputs,
        "output_units": units.outputs,
        "operating_point": {
            "states": named(&linear.states, &point.states),
            "inputs": named(&linear.inputs, &point.inputs),
            "outputs": named(&linear.outputs, &point.outputs),
            "steady": point.residual.is_some(),
            "residual": point.residual,
        },
        "continuous": continuous,
        "discrete": discrete,
    })
}

/// Units of the numbers: SI, or what a reading without a unit of the catalogue is recorded in.
struct Units {
    states: Vec<String>,
    inputs: Vec<String>,
    outputs: Vec<String>,
}

impl Units {
    fn of(assembly: &Assembly, linear: &Linear) -> Self {
        let system = assembly.system();
        let input = |path: &String| {
            let si = unit_of(system, path);
            if !si.is_empty() {
                return si;
            }
            // What drives a component that takes any signal is read in the unit of its channel, and carried in SI.
            dimension(assembly, path)
                .map_or("", Dimension::si_symbol)
                .to_owned()
        };
        Self {
            states: linear.states.iter().map(|n| unit_of(system, n)).collect(),
            inputs: linear.inputs.iter().map(input).collect(),
            outputs: gauges(assembly).iter().map(Gauge::carried).collect(),
        }
    }
}

fn as_mat(
    assembly: &Assembly,
    point: &Point,
    linear: &Linear,
    discrete: Option<&Linear>,
) -> Vec<(String, MatValue)> {
    let units = Units::of(assembly, linear);
    let (n, m, k) = (
        linear.states.len(),
        linear.inputs.len(),
        linear.outputs.len(),
    );
    let matrix = |rows: usize, columns: usize, values: &[f64]| MatValue::Matrix {
        rows,
        columns,
        values: values.to_vec(),
    };
    let column = |values: &[f64]| matrix(values.len(), 1, values);
    let of = |l: &Linear| -> Vec<(String, MatValue)> {
        let poles = l.poles();
        let flat: Vec<f64> = poles.iter().flat_map(|(re, im)| [*re, *im]).collect();
        vec![
            ("A".into(), matrix(n, n, &l.a)),
            ("B".into(), matrix(n, m, &l.b)),
            ("C".into(), matrix(k, n, &l.c)),
            ("D".into(), matrix(k, m, &l.d)),
            ("poles".into(), matrix(poles.len(), 2, &flat)),
            ("time_constants_s".into(), column(&l.time_constants())),
        ]
    };
    let mut all = of(linear);
    all.extend([
        ("states".into(), MatValue::Texts(linear.states.clone())),
        ("inputs".into(), MatValue::Texts(linear.inputs.clone())),
        ("outputs".into(), MatValue::Texts(linear.outputs.clone())),
        ("state_units".into(), MatValue::Texts(units.states)),
        ("input_units".into(), MatValue::Texts(units.inputs)),
        ("output_units".into(), MatValue::Texts(units.outputs)),
        ("x0".into(), column(&point.states)),
        ("u0".into(), column(&point.inputs)),
        ("y0".into(), column(&point.outputs)),
        ("rates".into(), column(&linear.rates)),
    ]);
    if let Some(discrete) = discrete {
        let mut fields = of(discrete);
        let step = discrete.step_s.unwrap_or(f64::NAN);
        fields.push(("step_s".into(), matrix(1, 1, &[step])));
        all.push(("discrete".into(), MatValue::Fields(fields)));
    }
    all
}

/// - `well`: whether it is the built-in system of a well, whose level `dgd simulate --well` counts downwards.
fn tell(
    title: &str,
    assembly: &Assembly,
    point: &Point,
    linear: &Linear,
    outputs: &[&PathBuf],
    well: bool,
) -> String {
    let described = assembly.system();
    let mut table = TextTable::new(["at", "value", "unit"]);
    let states = linear.states.iter().zip(&point.states);
    for (name, value) in linear.inputs.iter().zip(&point.inputs).chain(states) {
        table.row([name.clone(), number(*value), unit_of(described, name)]);
    }
    let mut poles = String::new();
    if !linear.states.is_empty() {
        poles = format!("\n{}", dynamics(linear).render());
    }
    let steady = match point.residual {
        Some(_) => "a steady state",
        None if linear.states.is_empty() => "without states: the matrix D is all there is",
        None => "as given; rates need not be zero there",
    };
    let levels = if well {
        "a level is the height above the floor of its tank; `dgd simulate --well` gives the riser level as depth below the rotary table\n"
    } else {
        ""
    };
    let files: Vec<String> = outputs.iter().map(|p| p.display().to_string()).collect();
    format!(
        "{title}: {}, {}, {}\noperating point ({steady})\n{}{levels}{poles}\nwrote {}\n",
        say::counted(linear.states.len(), "state"),
        say::counted(linear.inputs.len(), "input"),
        say::counted(linear.outputs.len(), "output"),
        table.render(),
        files.join(", ")
    )
}

/// Poles with their time constants.
fn dynamics(linear: &Linear) -> TextTable {
    let mut poles = TextTable::new(["pole, 1/s", "imaginary", "time constant, s"]);
    for ((re, im), constant) in linear.poles().iter().zip(linear.time_constants()) {
        let imaginary = if *im == 0.0 {
            String::new()
        } else {
            number(*im)
        };
        let constant = if constant.is_finite() {
            number(constant)
        } else {
            "integrator".to_owned()
        };
        poles.row([number(*re), imaginary, constant]);
    }
    poles
}
