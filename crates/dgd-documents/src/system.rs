//! `system.toml`, with the fit that may stand at its end, and the built-in return line as such a system.

use crate::mistaken::{Kind, mistaken};
use crate::reader::parse;
use crate::{DocumentError, Problem};
use dgd_assembly::{Assembly, AssemblyError, System, parse_system};
use dgd_identify::Model;
use std::fmt::Write as _;
use std::ops::Range;
use toml::{Table, Value};

/// Schema of the `[fitted]` table that [`write_fitted_system`] writes.
pub const FITTED_SCHEMA: &str = "dgd.fitted-system/1";

/// A system, and what a fit found of its free parameters.
#[derive(Debug, Clone)]
pub struct SystemDocument {
    /// The checked system.
    pub assembly: Assembly,
    /// The fit, if the document holds one.
    pub fitted: Option<FittedSystem>,
}

/// A fit of a system, as its document keeps it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FittedSystem {
    /// Recording it was fitted to, as the user names it.
    pub recording: String,
    /// How the fit ended, in words.
    pub status: String,
    /// Readings that were fitted.
    pub samples: usize,
    /// Parameters in the order of [`Assembly::parameters`].
    pub parameters: Vec<FittedParameter>,
}

/// A fitted parameter or initial state.
#[derive(Debug, Clone, PartialEq)]
pub struct FittedParameter {
    /// `"line.roughness"`, `"tank.level"`, `"tank.level@2"`.
    pub path: String,
    /// Estimate, SI.
    pub value: f64,
    /// Standard error; infinite if the recording does not tell, 0 if it was held or sits on a bound.
    pub standard_error: f64,
    /// Whether it sits on a bound.
    pub at_bound: bool,
}

impl SystemDocument {
    /// Parameter values in the order of [`Assembly::parameters`]: as fitted, or where a search would start.
    #[must_use]
    pub fn theta(&self) -> Vec<f64> {
        let known = self.fitted.iter().flat_map(|f| &f.parameters);
        self.assembly
            .parameters()
            .iter()
            .map(|p| {
                let mut found = known.clone().filter(|k| k.path == p.path);
                found.next().map_or(p.start, |k| k.value)
            })
            .collect()
    }
}

/// Reads a `system.toml`, with or without the `[fitted]` table of [`write_fitted_system`].
///
/// # Errors
/// [`DocumentError`] with every problem at its line.
///
/// ```
/// let text = r#"
/// connections = ["tank -> valve -> atmosphere"]
/// [components]
/// tank = { kind = "tank", area = 1.0 }
/// valve = { kind = "valve", flow_coefficient = 1e-3 }
/// gauge = { kind = "instrument", measures = "level", of = "tank" }
/// [initial]
/// "tank.level" = 2.0
/// "#;
/// let document = dgd_documents::read_system(text)?;
/// assert_eq!(document.assembly.states(), ["tank.level"]);
/// let error = dgd_documents::read_system(&text.replace("1e-3", "-1")).unwrap_err();
/// assert_eq!(error.places[0].0, 5); // the line
/// # Ok::<(), dgd_documents::DocumentError>(())
/// ```
pub fn read_system(text: &str) -> Result<SystemDocument, DocumentError> {
    let (plain, fitted) = without_fitted(text);
    check_kind(text)?;
    let assembly = Assembly::parse(&plain).map_err(|e| told(text, &e))?;
    let fitted = match fitted {
        Some(span) => Some(read_fitted(text, span, &assembly)?),
        None => None,
    };
    Ok(SystemDocument { assembly, fitted })
}

/// The types of a `system.toml` without a check of what they say: for drawing a system that is not well posed.
///
/// # Errors
/// [`DocumentError`] if it is no TOML or holds keys that no system has.
pub fn read_system_types(text: &str) -> Result<System, DocumentError> {
    check_kind(text)?;
    parse_system(&without_fitted(text).0).map_err(|e| told(text, &e))
}

/// Writes a system with the values of a fit: the `system.toml` as it was described, starts included, and in a table `[fitted]` the
/// values and what the fit says of their doubt. A diagnosis of it begins where that of the description would.
///
/// # Errors
/// [`AssemblyError`] if the values do not belong to the system.
pub fn write_fitted_system(
    assembly: &Assembly,
    fitted: &FittedSystem,
) -> Result<String, AssemblyError> {
    let values: Vec<f64> = fitted.parameters.iter().map(|p| p.value).collect();
    assembly.with_values(&values)?;
    let system = assembly.to_toml();
    let mut out = String::from(
        "# A system with the values of a fit. The values under [fitted] are used; [free] and [initial] keep the starting values.\n",
    );
    // Writing to a String cannot fail.
    let _ = write!(
        out,
        "{system}\n[fitted]\nschema = \"{FITTED_SCHEMA}\"\nrecording = {}\nstatus = {}\nsamples = {}\n\n[fitted.parameters]\n",
        Value::from(fitted.recording.as_str()),
        Value::from(fitted.status.as_str()),
        fitted.samples
    );
    for p in &fitted.parameters {
        let _ = writeln!(
            out,
            "{} = {{ value = {}, standard_error = {}, at_bound = {} }}",
            Value::from(p.path.as_str()),
            Value::from(p.value),
            Value::from(p.standard_error),
            p.at_bound
        );
    }
    Ok(out)
}

/// The built-in two-state return line (Eqs. 3.45-3.46) as a system.
///
/// States are the level in the riser above the pump inlet, m (the thesis counts its depth downwards), and the flow of the line,
/// m³/s; inputs the flow into the riser, m³/s, and the pump's speed, %; outputs level, return flow, inlet and outlet
/// pressure.
#[must_use]
pub fn return_line_system(model: &Model) -> String {
    let line = model.return_line();
    let (friction, pump) = (&line.friction, &line.pump);
    let check = line.non_return_valve;
    format!(
        r#"# The two-state return line: riser, subsea pump, mud return line (Slettebø 2015, Eqs. 3.45-3.46, M of Eq. 2.46).
name = "mud return line"
connections = ["inflow -> riser", "riser -> pump -> line -> atmosphere"]

[fluid]
density = {density:?}

[components]
inflow = {{ kind = "boundary", flow = 0.0 }}
riser = {{ kind = "tank", area = {area:?}, brim = {inlet:?} }}
pump = {{ kind = "centrifugal_pump", c0 = {c0:?}, c1 = {c1:?}, c2 = {c2:?}, n0 = {n0:?}, n2 = {n2:?}, check_valve = {check} }}
line = {{ kind = "line", length = {outlet:?}, flow_area = {bore:?}, elevation = {outlet:?}, friction = "polynomial", constant = {b:?}, linear = {c:?}, quadratic = {d:?}, cubic = {e:?}, inertia = true, column = "riser" }}
level = {{ kind = "instrument", measures = "level", of = "riser", unit = "m" }}
return_flow = {{ kind = "instrument", measures = "flow", of = "line", unit = "m3/s" }}
inlet_pressure = {{ kind = "instrument", measures = "pressure", of = "pump.inlet", unit = "Pa" }}
outlet_pressure = {{ kind = "instrument", measures = "pressure", of = "pump.outlet", unit = "Pa" }}

[inputs]
"inflow.flow" = {{ channel = "inflow", unit = "m3/s" }}
"pump.speed" = {{ channel = "pump_speed", unit = "%" }}

[initial]
"riser.level" = {half:?}
"line.flow" = 0.0
"#,
        density = line.density_kg_m3,
        area = line.riser_area_m2,
        inlet = line.inlet_depth_m,
        outlet = line.outlet_depth_m,
        bore = line.line_area_m2,
        c0 = pump.c0,
        c1 = pump.c1,
        c2 = pump.c2,
        n0 = pump.n0,
        n2 = pump.n2,
        b = friction.b_pa,
        c = friction.c_pa_s_m3,
        d = friction.d_pa_s2_m6,
        e = friction.e_pa_s3_m9,
        half = 0.5 * line.inlet_depth_m,
    )
}

/// The text with its `[fitted]` tables blanked, so that lines keep their numbers, and where the first of them stands.
fn without_fitted(text: &str) -> (String, Option<Range<usize>>) {
    let (mut plain, mut first, mut inside, mut at) =
        (String::with_capacity(text.len()), None, false, 0);
    for line in text.split_inclusive('\n') {
        if let Some(head) = line.trim_start().strip_prefix('[') {
            let name = head.trim_start_matches('[').trim_start();
            inside = name
                .strip_prefix("fitted")
                .is_some_and(|rest| rest.trim_start().starts_with([']', '.']));
            if inside && first.is_none() {
                first = Some(at..at + line.trim_end().len());
            }
        }
        if inside {
            plain.extend(line.chars().filter(|c| *c == '\n'));
        } else {
            plain.push_str(line);
        }
        at += line.len();
    }
    (plain, first)
}

fn read_fitted(
    text: &str,
    span: Range<usize>,
    assembly: &Assembly,
) -> Result<FittedSystem, DocumentError> {
    let wrong = |message: String| {
        let help = "fit again, or remove the table [fitted]".to_owned();
        let problem = Problem {
            span: span.clone(),
            message,
            help: Some(help),
        };
        DocumentError::new(text, vec![problem])
    };
    let document: Table = text.parse().map_err(|e: toml::de::Error| {
        let problem = Problem {
            span: e.span().unwrap_or(0..0),
            message: e.message().to_owned(),
            help: None,
        };
        DocumentError::new(text, vec![problem])
    })?;
    let Some(table) = document.get("fitted").and_then(Value::as_table) else {
        return Err(wrong("`fitted` is not a table".into()));
    };
    let schema = table.get("schema").and_then(Value::as_str).unwrap_or("");
    if schema != FITTED_SCHEMA {
        return Err(wrong(format!(
            "`fitted.schema` is `{schema}`, expected `{FITTED_SCHEMA}`"
        )));
    }
    let word = |key: &str| {
        let value = table.get(key).and_then(Value::as_str);
        value.unwrap_or_default().to_owned()
    };
    let samples = table.get("samples").and_then(Value::as_integer);
    let none = Table::new();
    let written = table.get("parameters").and_then(Value::as_table);
    let known = assembly.parameters();
    let mut parameters = Vec::new();
    for (path, entry) in written.unwrap_or(&none) {
        let Some(bounds) = known.iter().find(|p| p.path == *path) else {
            return Err(wrong(format!(
                "`fitted.parameters` has `{path}`, which is not free in the system"
            )));
        };
        let number = |key: &str| match entry.get(key) {
            Some(Value::Float(v)) => Some(*v),
            #[expect(clippy::cast_precision_loss, reason = "a number written by hand")]
            Some(Value::Integer(v)) => Some(*v as f64),
            _ => None,
        };
        let value = number("value").filter(|v| (bounds.low..=bounds.high).contains(v));
        let Some(value) = value else {
            return Err(wrong(format!(
                "the fitted value of `{path}` is {}, expected a number from {} to {}",
                number("value").map_or("absent".into(), |v| v.to_string()),
                bounds.low,
                bounds.high
            )));
        };
        parameters.push(FittedParameter {
            path: path.clone(),
            value,
            standard_error: number("standard_error").unwrap_or(f64::INFINITY),
            at_bound: entry.get("at_bound").and_then(Value::as_bool) == Some(true),
        });
    }
    parameters
        .sort_by_key(|found: &FittedParameter| known.iter().position(|p| p.path == found.path));
    Ok(FittedSystem {
        recording: word("recording"),
        status: word("status"),
        samples: samples
            .and_then(|s| usize::try_from(s).ok())
            .unwrap_or_default(),
        parameters,
    })
}

/// Refuses a document that is plainly of another kind.
fn check_kind(text: &str) -> Result<(), DocumentError> {
    match parse(text) {
        Ok(document) => mistaken(text, document.get_ref(), Kind::System),
        // What is no TOML is told by the reader of systems.
        Err(_) => Ok(()),
    }
}

/// An assembly's problems with their lines as spans.
fn told(text: &str, error: &AssemblyError) -> DocumentError {
    let problems = match error {
        AssemblyError::Syntax {
            line,
            column,
            message,
        } => {
            let start = span_of(text, Some(*line)).start;
            let offset: usize = text[start..]
                .chars()
                .take(column.saturating_sub(1))
                .map(char::len_utf8)
                .sum();
            vec![Problem {
                span: start + offset..start + offset,
                message: message.clone(),
                help: None,
            }]
        }
        AssemblyError::IllPosed(problems) => problems
            .0
            .iter()
            .map(|p| Problem {
                span: span_of(text, p.line),
                message: format!("{}: {}", p.path, p.message),
                help: (!p.mend.is_empty()).then(|| p.mend.clone()),
            })
            .collect(),
        other => vec![Problem {
            span: 0..0,
            message: other.to_string(),
            help: None,
        }],
    };
    DocumentError::new(text, problems)
}

/// Bytes of a line, without the blanks around it; the start of the text if it is not known.
fn span_of(text: &str, line: Option<usize>) -> Range<usize> {
    let Some(index) = line.and_then(|l| l.checked_sub(1)) else {
        return 0..0;
    };
    let mut start = 0;
    for (number, line) in text.split_inclusive('\n').enumerate() {
        if number == index {
            let blank = line.len() - line.trim_start().len();
            return start + blank..start + line.trim_end().len().max(blank);
        }
        start += line.len();
    }
    text.len()..text.len()
}
