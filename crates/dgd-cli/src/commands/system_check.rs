//! `dgd system check`: is it well posed, and what is in it.

use crate::args::{Check, Global};
use crate::failure::Failure;
use crate::load::read_text;
use crate::output;
use crate::say::{self, TextTable, number};
use crate::system::diagram::{self, OPEN_AIR};
use crate::system::{self, gauges, unit_of};
use dgd_assembly::{Assembly, Hypothesis, Kind, System, effects_for};
use dgd_documents::SystemDocument;
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::fmt::Write as _;

pub(crate) fn run(arguments: &Check, global: &Global) -> Result<String, Failure> {
    let path = &arguments.system;
    let source = read_text(path)?;
    if let Some(draw) = &arguments.draw {
        diagram::is_png(draw)?;
        output::check(draw)?;
        // What is not well posed is drawn too: a picture shows what is loose.
        let types = dgd_documents::read_system_types(&source);
        diagram::save(
            &types.map_err(|e| system::told(path, source.clone(), e))?,
            draw,
        )?;
    }
    let document =
        dgd_documents::read_system(&source).map_err(|e| system::told(path, source, e))?;
    let found = Found::of(&document.assembly);
    if global.json {
        return Ok(say::json(&as_json(arguments, &document, &found)));
    }
    Ok(tell(arguments, &document, &found))
}

/// The equations that the check matched, and what could sit on the system.
struct Found {
    branches: Vec<String>,
    junctions: Vec<String>,
    effects: Vec<Hypothesis>,
}

impl Found {
    fn of(assembly: &Assembly) -> Self {
        let components = &assembly.system().components;
        let kind = |place: &str| {
            let name = place.split('.').next().unwrap_or(place);
            components.get(name).map(|c| c.kind)
        };
        let mut branches = Vec::new();
        let mut junctions = BTreeSet::new();
        for edge in assembly.edges() {
            let mut places = vec![edge.to];
            if edge.kind.is_branch() {
                branches.push(edge.component);
                places.push(edge.from);
            }
            // Tanks, volumes and boundaries give their pressure.
            let free = |place: &String| {
                place != OPEN_AIR
                    && !matches!(
                        kind(place),
                        Some(Kind::Tank | Kind::Volume | Kind::Boundary)
                    )
            };
            junctions.extend(places.into_iter().filter(free));
        }
        Self {
            branches,
            junctions: junctions.into_iter().collect(),
            effects: effects_for(assembly),
        }
    }
}

fn tell(arguments: &Check, document: &SystemDocument, found: &Found) -> String {
    let mut text = String::new();
    // Writing to a String cannot fail.
    let _ = tell_into(&mut text, arguments, document, found);
    text
}

fn tell_into(
    text: &mut String,
    arguments: &Check,
    document: &SystemDocument,
    found: &Found,
) -> std::fmt::Result {
    let assembly = &document.assembly;
    let described = assembly.system();
    let (branches, junctions) = (found.branches.len(), found.junctions.len());
    let all = branches + junctions;
    writeln!(
        text,
        "{}: well posed",
        system::title(assembly, &arguments.system)
    )?;
    writeln!(
        text,
        "{all} unknowns (flows through {branches} branches, pressures at {junctions} junctions) match {all} equations\n(one law per branch, one \
         mass balance per junction); none is in excess.\n"
    )?;
    tell_states(text, assembly)?;
    tell_inputs(text, described)?;
    tell_outputs(text, assembly)?;
    tell_free(text, assembly)?;
    tell_effects(text, found)?;
    let warnings = assembly.warnings();
    if !warnings.is_empty() {
        writeln!(text)?;
    }
    for warning in warnings {
        writeln!(text, "warning: {warning}")?;
    }
    if let Some(draw) = &arguments.draw {
        writeln!(text, "\ndrew {}", draw.display())?;
    }
    Ok(())
}

fn tell_states(text: &mut String, assembly: &Assembly) -> std::fmt::Result {
    let described = assembly.system();
    let states = assembly.states();
    if described.independent != "time" {
        return writeln!(
            text,
            "static: each sample along {} is a steady state\n",
            described.independent
        );
    }
    if states.is_empty() {
        return writeln!(text, "no states: each sample is a steady state\n");
    }
    let mut table = TextTable::new(["state", "starts at", "unit"]);
    for state in &states {
        table.row([
            state.clone(),
            start(assembly, state),
            unit_of(described, state),
        ]);
    }
    counted(text, states.len(), "state", &table)
}

fn tell_inputs(text: &mut String, described: &System) -> std::fmt::Result {
    let mut table = TextTable::new(["input", "channel", "between samples", "unit"]);
    for (path, input) in &described.inputs {
        let unit = input
            .unit
            .clone()
            .unwrap_or_else(|| unit_of(described, path));
        let between = format!("{:?}", input.between).to_lowercase();
        table.row([path.clone(), input.channel.clone(), between, unit]);
    }
    counted(text, described.inputs.len(), "input", &table)?;
    let open = system::at_default(described);
    if !open.is_empty() {
        writeln!(
            text,
            "at its default, fully open: {}; what is recorded belongs under [inputs]\n",
            open.join(", ")
        )?;
    }
    Ok(())
}

fn tell_outputs(text: &mut String, assembly: &Assembly) -> std::fmt::Result {
    let mut table = TextTable::new(["output", "measures", "channel", "unit"]);
    let gauges = gauges(assembly);
    let count = gauges.len();
    for gauge in gauges {
        table.row([gauge.name, gauge.measures, gauge.channel, gauge.symbol]);
    }
    counted(text, count, "output", &table)
}

fn tell_free(text: &mut String, assembly: &Assembly) -> std::fmt::Result {
    let parameters = assembly.parameters();
    let mut table = TextTable::new(["free", "starts at", "from", "to", "unit"]);
    for p in &parameters {
        let name = if p.initial {
            format!("{} at the start", p.path)
        } else {
            p.path.clone()
        };
        table.row([
            name,
            number(p.start),
            number(p.low),
            number(p.high),
            unit_of(assembly.system(), &p.path),
        ]);
    }
    counted(text, parameters.len(), "free parameter", &table)
}

fn tell_effects(text: &mut String, found: &Found) -> std::fmt::Result {
    let count = say::counted(found.effects.len(), "effect");
    writeln!(text, "{count} could act on it")?;
    let mut table = TextTable::new(["component", "effects"]);
    for (component, ids) in by_component(found) {
        for (row, some) in ids.chunks(4).enumerate() {
            let name = if row == 0 { component } else { "" };
            table.row([name.to_owned(), some.join(", ")]);
        }
    }
    write!(text, "{}", table.render())
}

/// How many there are, and the table of them if there are any.
fn counted(text: &mut String, count: usize, what: &str, table: &TextTable) -> std::fmt::Result {
    let table = if count == 0 {
        String::new()
    } else {
        table.render()
    };
    writeln!(text, "{}\n{table}", say::counted(count, what))
}

fn by_component(found: &Found) -> Vec<(&str, Vec<&'static str>)> {
    let mut groups: Vec<(&str, Vec<&'static str>)> = Vec::new();
    for effect in &found.effects {
        match groups.iter_mut().find(|g| g.0 == effect.component) {
            Some(group) => group.1.push(effect.effect),
            None => groups.push((&effect.component, vec![effect.effect])),
        }
    }
    groups
}

/// Where a state starts, in words.
fn start(assembly: &Assembly, state: &str) -> String {
    use dgd_assembly::Initial;
    match assembly.system().initial.get(state) {
        Some(Initial::Given(value)) => number(*value),
        Some(Initial::Written(text)) => text.clone(),
        Some(Initial::Measured(measured)) => format!("as {} reads", measured.measured),
        Some(Initial::Free(bounds)) => {
            format!("free, {} to {}", number(bounds.low), number(bounds.high))
        }
        None if state.ends_with(".level") => "as measured".into(),
        None => "at rest with its surroundings".into(),
    }
}

fn as_json(arguments: &Check, document: &SystemDocument, found: &Found) -> Value {
    let assembly = &document.assembly;
    let described = assembly.system();
    let parameters = assembly.parameters();
    json!({
        "schema": "dgd.system-check/1",
        "system": system::title(assembly, &arguments.system),
        "independent": described.independent,
        "well_posed": true,
        "equations": found.branches.len() + found.junctions.len(),
        "unknowns": {
            "flows": found.branches,
            "pressures": found.junctions,
        },
        "states": assembly.states(),
        "inputs": assembly.inputs(),
        "at_default": system::at_default(described),
        "outputs": gauges(assembly).iter()
            .map(|g| json!({ "name": g.name, "measures": g.measures, "channel": g.channel, "unit": g.symbol })).collect::<Vec<_>>(),
        "free": parameters.iter()
            .map(|p| json!({ "path": p.path, "start": p.start, "low": p.low, "high": p.high, "initial": p.initial,
                             "unit": unit_of(described, &p.path) })).collect::<Vec<_>>(),
        "fitted": document.fitted.is_some(),
        "effects": found.effects.iter()
            .map(|h| json!({ "component": h.component, "effect": h.effect, "title": h.law.about().title })).collect::<Vec<_>>(),
        "warnings": assembly.warnings().iter().map(ToString::to_string).collect::<Vec<_>>(),
        "drawing": arguments.draw.as_ref().map(|d| d.display().to_string()),
    })
}
