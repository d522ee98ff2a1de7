//! `dgd inspect`: what is in a file.

use crate::args::{Global, Inspect};
use crate::failure::Failure;
use crate::load;
use crate::output::Outputs;
use crate::progress::Progress;
use crate::say::{self, TextTable, count, number};
use dgd_ingest::Format;
use dgd_recording::{
    ColumnSurvey, IssueKind, Proposal, ProposedChannel, Table, TableSurvey, propose_channels,
    survey,
};
use serde_json::{Value, json};
use std::fmt::Write as _;

/// Bytes from which a recording is gone through block by block: it is slower, for it takes several passes.
const LONG: u64 = 1 << 30;
/// Issues and gaps shown before the rest is only counted.
const SHOWN: usize = 12;

pub(crate) fn run(arguments: &Inspect, global: &Global) -> Result<String, Failure> {
    let progress = Progress::new(global);
    if let Some(path) = arguments.propose.as_ref().filter(|path| path.exists()) {
        // Somebody may have completed it.
        return Err(Failure::Write {
            path: path.clone(),
            reason: "already exists, and may have been completed by hand".into(),
            help: "propose another file, or remove this one first",
        });
    }
    let inspected = inspect(arguments, &progress)?;
    let proposal = propose_channels(&inspected.found);
    if let Some(path) = &arguments.propose {
        let mut outputs = Outputs::new();
        outputs.add_bytes(path, proposed_well(&proposal))?;
        outputs.keep()?;
    }
    drop(progress);
    if global.json {
        return Ok(say::json(&as_json(&inspected, &proposal)));
    }
    let mut text = format!(
        "{}: {}, {} columns, {} rows\n",
        arguments.recording.display(),
        inspected.format,
        inspected.head.columns.len(),
        count(inspected.rows)
    );
    // Writing to a String cannot fail.
    let _ = tell(&mut text, &inspected, &proposal);
    if let Some(path) = &arguments.propose {
        let _ = writeln!(
            text,
            "\nwrote {}: fill in the geometry and check the channels",
            path.display()
        );
    }
    Ok(text)
}

/// What is in a recording.
struct Inspected {
    format: Format,
    /// The table; of its values nobody asks any more.
    head: Table,
    rows: usize,
    found: TableSurvey,
}

fn inspect(arguments: &Inspect, progress: &Progress) -> Result<Inspected, Failure> {
    let path = &arguments.recording;
    let when = load::When::of(arguments.in_blocks, LONG);
    if let Some(mut blocks) = load::open_blocks(path, when, Some(load::CONVERTED), progress)? {
        return Ok(Inspected {
            found: blocks.survey(progress)?,
            format: blocks.format(),
            rows: blocks.rows(),
            head: blocks.head().clone(),
        });
    }
    let (format, head) = load::read_table(path, progress)?;
    progress.stage("surveying", "the columns");
    Ok(Inspected {
        found: survey(&head),
        format,
        rows: head.rows(),
        head,
    })
}

fn tell(text: &mut String, inspected: &Inspected, proposal: &Proposal) -> std::fmt::Result {
    let (table, found) = (&inspected.head, &inspected.found);
    tell_clock(text, table, found)?;
    if let Some(origin) = &table.origin {
        match origin.strip_suffix("-00:00") {
            Some(local) => writeln!(text, "0 s is {local} (time zone unknown)")?,
            None => writeln!(text, "0 s is {origin}")?,
        }
    }
    write!(text, "\n{}", columns(found))?;
    if !table.issues.is_empty() {
        writeln!(text, "\nissues:")?;
        for issue in table.issues.iter().take(SHOWN) {
            writeln!(text, "  {issue}")?;
        }
        more(text, table.issues.len(), "issues")?;
    }
    tell_proposal(text, proposal)
}

fn tell_clock(text: &mut String, table: &Table, found: &TableSurvey) -> std::fmt::Result {
    match (&found.clock_in_seconds(), found.time_column) {
        (Some(Ok(clock)), Some(index)) => {
            let hours = (clock.span_s.1 - clock.span_s.0) / 3600.0;
            let tag = &found.columns[index].tag;
            let unit = if found.counts_days() { " in days" } else { "" };
            writeln!(
                text,
                "clock: `{tag}`{unit}, every {} s, {} h",
                number(clock.step_s),
                number(hours)
            )?;
            for issue in clock.issues() {
                writeln!(text, "  {issue}")?;
            }
            for gap in clock.gaps.iter().take(SHOWN) {
                writeln!(
                    text,
                    "  gap from {} s to {} s",
                    number(gap.from_s),
                    number(gap.to_s)
                )?;
            }
            more(text, clock.gaps.len(), "gaps")
        }
        (Some(Err(error)), _) => writeln!(text, "clock: {error}"),
        _ if table
            .issues
            .iter()
            .any(|issue| issue.kind == IssueKind::Skipped) =>
        {
            writeln!(
                text,
                "clock: no column that was read looks like time; if a skipped column holds the times, write them as in 2024-10-26 15:27:49"
            )
        }
        _ => writeln!(
            text,
            "clock: no column looks like time; write `time = {{ interval = \"1 s\" }}` in the well description"
        ),
    }
}

fn columns(found: &TableSurvey) -> String {
    let mut columns = TextTable::new([
        "column",
        "unit",
        "samples",
        "missing",
        "min",
        "median",
        "max",
        "step",
        "repeats",
        "longest run",
    ]);
    for column in &found.columns {
        let [low, median, high] = (column.range)
            .map_or([const { String::new() }; 3], |(a, b, c)| {
                [a, b, c].map(number)
            });
        columns.row([
            column.tag.clone(),
            column.unit_written.clone().unwrap_or_else(|| "?".into()),
            count(column.samples),
            count(column.missing),
            low,
            median,
            high,
            column.quantum.map_or(String::new(), number),
            format!("{:.0} %", 100.0 * column.repeated_share),
            column.longest_run.map_or(String::new(), |r| {
                format!("{} x {}", count(r.length), number(r.value))
            }),
        ]);
    }
    columns.render()
}

fn tell_proposal(text: &mut String, proposal: &Proposal) -> std::fmt::Result {
    writeln!(text, "\nproposed channels (check before use):")?;
    for channel in &proposal.channels {
        let tag = &channel.tag;
        writeln!(
            text,
            "  {:<22} {tag} [{}]: {}",
            channel.channel, channel.unit, channel.reason
        )?;
    }
    if !proposal.missing.is_empty() {
        writeln!(text, "  nothing found for: {}", proposal.missing.join(", "))?;
    }
    proposal
        .doubts
        .iter()
        .try_for_each(|doubt| writeln!(text, "  doubt: {doubt}"))
}

fn more(text: &mut String, all: usize, what: &str) -> std::fmt::Result {
    if all > SHOWN {
        writeln!(text, "  and {} more {what}", all - SHOWN)
    } else {
        Ok(())
    }
}

fn as_json(inspected: &Inspected, proposal: &Proposal) -> Value {
    let (table, found) = (&inspected.head, &inspected.found);
    let column = |c: &ColumnSurvey| {
        json!({
            "tag": c.tag,
            "unit_written": c.unit_written,
            "unit": c.unit.map(|u| u.symbol),
            "samples": c.samples,
            "missing": c.missing,
            "min": c.range.map(|r| r.0),
            "median": c.range.map(|r| r.1),
            "max": c.range.map(|r| r.2),
            "quantum": c.quantum,
            "repeated_share": c.repeated_share,
            "longest_run": c.longest_run.map(|r| json!({ "start": r.start, "length": r.length, "value": r.value })),
        })
    };
    let clock = match &found.clock_in_seconds() {
        None => Value::Null,
        Some(Err(error)) => json!({ "error": error.to_string() }),
        Some(Ok(clock)) => json!({
            "column": found.time_column.map(|i| &found.columns[i].tag),
            "step_s": clock.step_s,
            "from_s": clock.span_s.0,
            "to_s": clock.span_s.1,
            "missing": clock.missing,
            "duplicates": clock.duplicates,
            "crowded": clock.crowded,
            "backward": clock.backward,
            "jitter_s": clock.jitter_s,
            "gaps": clock.gaps.iter().map(|g| json!([g.from_s, g.to_s])).collect::<Vec<_>>(),
        }),
    };
    let channels = proposal.channels.iter();
    json!({
        "schema": "dgd.inspect/1",
        "format": inspected.format.to_string(),
        "rows": inspected.rows,
        "origin": table.origin,
        "clock": clock,
        "columns": found.columns.iter().map(column).collect::<Vec<_>>(),
        "issues": table.issues.iter().map(ToString::to_string).collect::<Vec<_>>(),
        "proposal": {
            "channels": channels.map(|c| json!({ "channel": c.channel, "tag": c.tag, "unit": c.unit, "unit_assumed": c.unit_assumed, "reason": c.reason })).collect::<Vec<_>>(),
            "missing": proposal.missing,
            "doubts": proposal.doubts,
        },
    })
}

/// The channel map as TOML, under a geometry to fill in.
fn proposed_well(proposal: &Proposal) -> String {
    let mut text = String::from(
        "\
# Proposed from the recording. Replace every `?`, and check every channel.
# A quantity is a string with a unit: \"19.5 in\", \"13 5/8 in\", \"1080 kg/m3\".
[mud]
density = \"? sg\"

[geometry]
riser_id = \"? in\"             # inner diameter of the riser
drillpipe_od = \"? in\"         # outer diameter of the drill pipe in it
return_line_id = \"? in\"       # inner diameter of the mud return line
pump_inlet_depth = \"? m\"      # subsea pump inlet below the rotary table
pump_outlet_depth = \"? m\"     # its outlet below the rotary table
# if known:
# riser_pressure_sensor_depth = \"? m\"
# casing_od = \"? in\"
# booster_line_id = \"? in\"

[channels]
# A channel without a transmitter is a constant, such as topfill_flow = \"30 gpm\".
",
    );
    let mut names: Vec<&str> = proposal.channels.iter().map(|c| c.channel).collect();
    names.dedup();
    for name in names {
        let of_name = proposal.channels.iter().filter(|c| c.channel == name);
        let sources: Vec<String> = (of_name.clone()).map(proposed_source).collect();
        let list = sources.join(", ");
        let assumed = of_name.clone().find_map(|c| c.unit_assumed.as_deref());
        let assumed = assumed.map_or_else(String::new, |why| {
            // The file's words, and a comment ends with its line.
            let why = why.replace(char::is_control, " ");
            format!("  # unit assumed: {why}")
        });
        let _ = if several(name) {
            writeln!(text, "{name} = [{list}]{assumed}")
        } else {
            writeln!(text, "{name} = {list}{assumed}")
        };
    }
    for missing in &proposal.missing {
        let (unit, what) = match *missing {
            "time" => ("s", "or, for even samples, time = { interval = \"1 s\" }"),
            "mud_pump_flow" => (
                "gpm",
                "into the drill string; strokes have unit = \"spm\", stroke = \"? L\"",
            ),
            "booster_flow" => ("gpm", "into the riser's foot"),
            "topfill_flow" => ("gpm", "into the riser's top"),
            "return_flow" => ("gpm", "out of the return line, at the rig"),
            "pump_inlet_pressure" => ("psia", "at the subsea pump's inlet"),
            "pump_outlet_pressure" => ("psia", "at the subsea pump's outlet"),
            _ => (
                "%",
                "of the subsea pump, in percent of full speed; a tachometer has unit = \"rpm\", full = \"? rpm\"",
            ),
        };
        let _ = writeln!(
            text,
            "# {missing} = {{ tag = \"?\", unit = \"{unit}\" }}  # {what}"
        );
    }
    text
}

/// A column as a source; a tachometer needs the full speed that is 100 %.
fn proposed_source(proposed: &ProposedChannel) -> String {
    let quote = |s: &str| Value::from(s).to_string();
    let full = if proposed.channel == "pump_speed" && proposed.unit != "%" {
        format!(", full = {}", quote(&format!("? {}", proposed.unit)))
    } else {
        String::new()
    };
    let (tag, unit) = (quote(&proposed.tag), quote(&proposed.unit));
    format!("{{ tag = {tag}, unit = {unit}{full} }}")
}

/// Whether a channel is a list of redundant transmitters.
fn several(channel: &str) -> bool {
    channel.starts_with("pump_inlet") || channel.starts_with("pump_outlet")
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may fail by panic")]
mod tests {
    use super::*;
    use dgd_recording::Column;

    fn inspected(columns: &[(&str, Option<&str>, f64)]) -> Inspected {
        let column = |(tag, unit, step): &(&str, Option<&str>, f64)| Column {
            tag: (*tag).into(),
            unit: unit.map(str::to_owned),
            values: (0..3601).map(|k| 45_591.0 + step * f64::from(k)).collect(),
        };
        let head = Table {
            columns: columns.iter().map(column).collect(),
            ..Table::default()
        };
        Inspected {
            format: Format::Csv,
            rows: head.rows(),
            found: survey(&head),
            head,
        }
    }

    #[test]
    fn a_proposed_well_says_which_units_are_assumed_and_asks_for_the_full_speed() {
        let inspected = inspected(&[
            ("t", Some("s"), 1.0),
            ("FT1", None, 0.5),
            ("FT4", Some("l/min"), 0.5),
            ("PT1", None, 0.5),
            ("PT2", Some("bara"), 0.5),
            ("SSP rpm", Some("rpm"), 0.5),
        ]);
        let well = proposed_well(&propose_channels(&inspected.found));
        let line = |key: &str| {
            let mut lines = well.lines();
            lines.find(|l| l.starts_with(key)).unwrap_or(key).to_owned()
        };
        let assumed = "  # unit assumed: the file names none";
        assert_eq!(line("time"), r#"time = { tag = "t", unit = "s" }"#);
        assert_eq!(
            line("mud_pump_flow"),
            format!(r#"mud_pump_flow = {{ tag = "FT1", unit = "gpm" }}{assumed}"#)
        );
        assert_eq!(
            line("return_flow"),
            r#"return_flow = { tag = "FT4", unit = "l/min" }"#
        );
        assert!(line("pump_inlet_pressure").ends_with(assumed));
        assert_eq!(
            line("pump_speed"),
            r#"pump_speed = { tag = "SSP rpm", unit = "rpm", full = "? rpm" }"#
        );
        // Whoever fills nothing in is told that too.
        let refused = dgd_documents::read_well(&well).unwrap_err();
        assert!(
            refused.to_string().contains("`full` is not filled in"),
            "{refused}"
        );
    }

    #[test]
    fn the_placeholder_for_a_speed_mentions_a_tachometer() {
        let well = proposed_well(&propose_channels(&inspected(&[("t", None, 1.0)]).found));
        let line = well.lines().find(|l| l.starts_with("# pump_speed"));
        assert!(
            line.unwrap().contains(r#"unit = "rpm", full = "? rpm""#),
            "{well}"
        );
    }

    #[test]
    fn a_clock_in_days_is_told_in_seconds() {
        let inspected = inspected(&[("t", None, 1.0 / 86_400.0), ("FT4", None, 0.5)]);
        let proposal = propose_channels(&inspected.found);
        let mut text = String::new();
        tell(&mut text, &inspected, &proposal).unwrap();
        assert!(
            text.starts_with("clock: `t` in days, every 1 s, 1 h\n"),
            "{text}"
        );
        let step_s = as_json(&inspected, &proposal)["clock"]["step_s"].as_f64();
        assert!((step_s.unwrap() - 1.0).abs() < 1e-6);
    }
}
