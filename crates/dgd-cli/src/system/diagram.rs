//! A system as a diagram: its connections, symbols and instruments.

use super::{unit_of, word};
use crate::failure::Failure;
use crate::output::Outputs;
use crate::say::brief;
use dgd_assembly::{Component, Initial, Kind, Setting, System};
use dgd_report::{
    Diagram, DrawnComponent, DrawnInstrument, DrawnLink, Figure, ReportError, Symbol,
    assembly_drawing,
};
use std::path::Path;

/// The name that connections to the open air go by.
pub(crate) const OPEN_AIR: &str = "atmosphere";
/// Pixels a unit of the drawing.
const PNG_SCALE: f64 = 2.0;
/// Properties written beside a component.
const SHOWN: usize = 3;

/// Draws a system, whether it is well posed or not.
pub(crate) fn draw(system: &System) -> Result<Figure, ReportError> {
    assembly_drawing(&diagram(system))
}

/// Writes the drawing of a system as its ending says.
pub(crate) fn save(system: &System, path: &Path) -> Result<(), Failure> {
    let undrawn = |e: ReportError| Failure::unwritten(path, e);
    let figure = draw(system).map_err(undrawn)?;
    let bytes = if is_png(path)? {
        figure.png(PNG_SCALE).map_err(undrawn)?
    } else {
        figure.svg().into_bytes()
    };
    let mut outputs = Outputs::new();
    outputs.add_bytes(path, bytes)?;
    outputs.keep()
}

/// Whether a picture is wanted as PNG; neither that nor SVG is refused.
pub(crate) fn is_png(path: &Path) -> Result<bool, Failure> {
    let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    match ending.as_deref() {
        Some("svg") => Ok(false),
        Some("png") => Ok(true),
        _ => Err(Failure::Arguments {
            reason: format!(
                "{}: the extension is not an image format; name it .svg or .png",
                path.display()
            ),
        }),
    }
}

fn diagram(system: &System) -> Diagram {
    let mut diagram = Diagram::default();
    let index = |diagram: &mut Diagram, name: &str| -> usize {
        // The open air is everywhere: each mention is drawn where it is.
        let known = diagram.components.iter().position(|c| c.name == name);
        if let Some(known) = known.filter(|_| name != OPEN_AIR) {
            return known;
        }
        diagram.components.push(component(system, name));
        diagram.components.len() - 1
    };
    for connection in &system.connections {
        let ends: Vec<(&str, &str)> = connection
            .split("->")
            .map(|end| end.trim().split_once('.').unwrap_or((end.trim(), "")))
            .collect();
        let mut before: Option<(usize, &str)> = None;
        for &(name, port) in &ends {
            let here = index(&mut diagram, name);
            if let Some((from, leaves)) = before {
                diagram.links.push(DrawnLink {
                    from,
                    to: here,
                    leaves: leaves.to_owned(),
                    enters: port.to_owned(),
                });
            }
            before = Some((here, port));
        }
    }
    for (name, part) in &system.components {
        if part.kind != Kind::Instrument {
            index(&mut diagram, name);
        }
    }
    for (name, part) in system
        .components
        .iter()
        .filter(|(_, p)| p.kind == Kind::Instrument)
    {
        let of = word(part, "of").unwrap_or_default();
        let of = of.split('.').next().unwrap_or_default();
        let drawn = DrawnInstrument {
            letters: letters(word(part, "measures").unwrap_or_default()).to_owned(),
            label: match word(part, "unit") {
                Some(unit) => format!("{name} [{unit}]"),
                None => name.clone(),
            },
        };
        if let Some(on) = diagram.components.iter_mut().find(|c| c.name == of) {
            on.instruments.push(drawn);
        }
    }
    let instruments: usize = diagram.components.iter().map(|c| c.instruments.len()).sum();
    let parts = diagram
        .components
        .iter()
        .filter(|c| c.symbol != Symbol::Atmosphere)
        .count();
    let title = if system.name.is_empty() {
        "The system"
    } else {
        &system.name
    };
    let count = |n: usize, what: &str| format!("{n} {what}{}", if n == 1 { "" } else { "s" });
    diagram.caption = format!(
        "{title}: {}, {}, {}. Blue: what is free.",
        count(parts, "component"),
        count(instruments, "instrument"),
        count(diagram.links.len(), "connection")
    );
    diagram
}

fn component(system: &System, name: &str) -> DrawnComponent {
    let Some(part) = system.components.get(name) else {
        let air = name == OPEN_AIR;
        return DrawnComponent {
            name: name.to_owned(),
            symbol: if air {
                Symbol::Atmosphere
            } else {
                Symbol::Junction
            },
            notes: if air {
                Vec::new()
            } else {
                vec!["is not a component".into()]
            },
            marks: Vec::new(),
            instruments: Vec::new(),
        };
    };
    let mut notes = Vec::new();
    let kind = part.kind.name().replace('_', " ");
    if part.kind != Kind::Junction && !name.contains(&kind) {
        notes.push(kind);
    }
    notes.extend(sizes(system, name, part));
    let prefix = format!("{name}.");
    for (path, input) in &system.inputs {
        if let Some(property) = path.strip_prefix(&prefix) {
            notes.push(format!("{property} from channel {}", input.channel));
        }
    }
    let mut marks = Vec::new();
    let free = system.free.keys().filter_map(|p| p.strip_prefix(&prefix));
    marks.extend(free.map(|property| format!("free: {property}")));
    for (path, initial) in &system.initial {
        if let (Some(state), Initial::Free(_)) = (path.strip_prefix(&prefix), initial) {
            marks.push(format!("free: {state} at the start"));
        }
    }
    let effects = system.effects.iter().filter(|e| e.component == name);
    marks.extend(effects.map(|e| format!("effect: {}", e.effect)));
    DrawnComponent {
        name: name.to_owned(),
        symbol: symbol(part.kind),
        notes,
        marks,
        instruments: Vec::new(),
    }
}

/// The first of the known sizes.
fn sizes(system: &System, name: &str, part: &Component) -> Vec<String> {
    let order = part.kind.properties().iter().map(|p| p.name);
    let words = order.filter_map(|property| {
        let value = match part.settings.get(property)? {
            Setting::Number(v) if *v != 0.0 => {
                let unit = unit_of(system, &format!("{name}.{property}"));
                format!("{} {unit}", brief(*v))
            }
            Setting::Text(text) => text.clone(),
            _ => return None,
        };
        let path = format!("{name}.{property}");
        let known = !system.free.contains_key(&path) && !system.inputs.contains_key(&path);
        known.then(|| format!("{} {}", property.replace('_', " "), value.trim()))
    });
    words.take(SHOWN).collect()
}

fn symbol(kind: Kind) -> Symbol {
    match kind {
        Kind::Tank => Symbol::Tank,
        Kind::Volume => Symbol::Volume,
        Kind::Line => Symbol::Line,
        Kind::CentrifugalPump => Symbol::CentrifugalPump,
        Kind::DisplacementPump => Symbol::DisplacementPump,
        Kind::Valve => Symbol::Valve,
        Kind::Orifice => Symbol::Orifice,
        Kind::Boundary => Symbol::Boundary,
        Kind::Junction | Kind::Instrument => Symbol::Junction,
    }
}

/// Letters of ISA-5.1: measured quantity and transmitter.
fn letters(measures: &str) -> &'static str {
    match measures {
        "level" => "LT",
        "pressure" => "PT",
        "drop" => "PDT",
        "flow" => "FT",
        "head" => "HT",
        "speed" => "ST",
        _ => "T",
    }
}
