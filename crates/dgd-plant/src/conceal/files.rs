//! The files of a case: recording, well description, truth.

use std::io::{self, Write};

use crate::conceal::case::Case;
use crate::conceal::dialect::Form;
use crate::instrument::FaultKind;
use crate::record::Recording;

/// The columns as they are filed: time first, then the channels that are there, every `sampling_s`.
struct Columns {
    tags: Vec<&'static str>,
    units: Vec<&'static str>,
    values: Vec<Vec<f64>>,
}

fn columns(case: &Case, recording: &Recording) -> Columns {
    let every = case.sampling_s.max(1);
    let rows = || (0..recording.time_s.len()).step_by(every);
    let mut out = Columns {
        tags: vec![case.dialect.time],
        units: vec!["s"],
        values: vec![rows().map(|i| recording.time_s[i]).collect()],
    };
    for c in (0..10).filter(|&c| !case.absent[c]) {
        out.tags.push(case.dialect.tags[c]);
        out.units.push(case.dialect.row_unit(c));
        let channel = &recording.channels[c];
        out.values
            .push(rows().map(|i| case.dialect.file(c, channel[i])).collect());
    }
    out
}

/// Writes the recording of a case in its own format and units.
///
/// # Errors
/// What `out` returns.
pub fn write_case(case: &Case, recording: &Recording, out: &mut impl Write) -> io::Result<()> {
    let columns = columns(case, recording);
    match case.form {
        Form::Csv => csv(&columns, out),
        Form::Mat => mat(&columns, out),
        Form::Mcap => mcap(&columns, out),
    }
}

fn csv(columns: &Columns, out: &mut impl Write) -> io::Result<()> {
    writeln!(out, "{}", columns.tags.join(","))?;
    writeln!(out, "{}", columns.units.join(","))?;
    for i in 0..columns.values[0].len() {
        for (c, values) in columns.values.iter().enumerate() {
            if c > 0 {
                write!(out, ",")?;
            }
            if !values[i].is_nan() {
                write!(out, "{}", values[i])?;
            }
        }
        writeln!(out)?;
    }
    Ok(())
}

fn length(n: usize) -> io::Result<u32> {
    u32::try_from(n).map_err(|_| io::Error::other("a part of the file is 4 GiB or more"))
}

/// A MAT v5 data element: type, length, data, padding to eight bytes.
fn element(kind: u32, data: &[u8], out: &mut Vec<u8>) -> io::Result<()> {
    out.extend(kind.to_le_bytes());
    out.extend(length(data.len())?.to_le_bytes());
    out.extend(data);
    out.resize(out.len().next_multiple_of(8), 0);
    Ok(())
}

fn matrix(class: u32, rows: usize, name: &str, body: &[u8]) -> io::Result<Vec<u8>> {
    const MI_INT8: u32 = 1;
    const MI_INT32: u32 = 5;
    const MI_UINT32: u32 = 6;
    let mut out = Vec::new();
    element(MI_UINT32, &[class.to_le_bytes(), [0; 4]].concat(), &mut out)?;
    let size = [length(rows)?.to_le_bytes(), 1_u32.to_le_bytes()].concat();
    element(MI_INT32, &size, &mut out)?;
    element(MI_INT8, name.as_bytes(), &mut out)?;
    out.extend(body);
    Ok(out)
}

/// One struct `gom` of columns, uncompressed.
fn mat(columns: &Columns, out: &mut impl Write) -> io::Result<()> {
    const MI_INT8: u32 = 1;
    const MI_DOUBLE: u32 = 9;
    const MI_MATRIX: u32 = 14;
    const MX_STRUCT: u32 = 2;
    const MX_DOUBLE: u32 = 6;
    const WIDTH: usize = 32;
    let mut body = Vec::new();
    // The width of the names is a small element: length and type share a word.
    body.extend((4_u32 << 16 | 5).to_le_bytes());
    body.extend(length(WIDTH)?.to_le_bytes());
    let mut names = Vec::new();
    for tag in &columns.tags {
        let end = names.len() + WIDTH;
        names.extend(tag.as_bytes());
        names.resize(end, 0);
    }
    element(MI_INT8, &names, &mut body)?;
    for values in &columns.values {
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        let mut data = Vec::new();
        element(MI_DOUBLE, &bytes, &mut data)?;
        element(
            MI_MATRIX,
            &matrix(MX_DOUBLE, values.len(), "", &data)?,
            &mut body,
        )?;
    }
    let mut whole = b"MATLAB 5.0 MAT-file, written by dgd-plant".to_vec();
    whole.resize(116, b' ');
    whole.extend([0; 8]);
    whole.extend([0, 1, b'I', b'M']);
    element(MI_MATRIX, &matrix(MX_STRUCT, 1, "gom", &body)?, &mut whole)?;
    out.write_all(&whole)
}

/// An MCAP record: opcode, length, content.
fn mcap_record(opcode: u8, content: &[u8], out: &mut impl Write) -> io::Result<()> {
    out.write_all(&[opcode])?;
    out.write_all(&(content.len() as u64).to_le_bytes())?;
    out.write_all(content)
}

fn mcap_text(text: &str, out: &mut Vec<u8>) -> io::Result<()> {
    out.extend(length(text.len())?.to_le_bytes());
    out.extend(text.as_bytes());
    Ok(())
}

/// One channel `/rig` of JSON samples; no chunks, no index, no checksums.
fn mcap(columns: &Columns, out: &mut impl Write) -> io::Result<()> {
    const MAGIC: &[u8] = b"\x89MCAP0\r\n";
    const START_NS: u64 = 1_700_000_000_000_000_000;
    out.write_all(MAGIC)?;
    let mut header = Vec::new();
    mcap_text("", &mut header)?;
    mcap_text("dgd-plant", &mut header)?;
    mcap_record(0x01, &header, out)?;

    let mut properties = Vec::new();
    for (tag, unit) in columns.tags.iter().zip(&columns.units).skip(1) {
        properties.push(format!(
            "\"{tag}\":{{\"type\":\"number\",\"unit\":\"{unit}\",\"description\":\"{unit}\"}}"
        ));
    }
    let schema = format!(
        "{{\"type\":\"object\",\"properties\":{{{}}}}}",
        properties.join(",")
    );
    let mut record = 1_u16.to_le_bytes().to_vec();
    mcap_text("Sample", &mut record)?;
    mcap_text("jsonschema", &mut record)?;
    mcap_text(&schema, &mut record)?;
    mcap_record(0x03, &record, out)?;

    let mut channel = 0_u16.to_le_bytes().to_vec();
    channel.extend(1_u16.to_le_bytes());
    mcap_text("/rig", &mut channel)?;
    mcap_text("json", &mut channel)?;
    channel.extend(0_u32.to_le_bytes());
    mcap_record(0x04, &channel, out)?;

    let mut message = Vec::new();
    for (i, time_s) in columns.values[0].iter().enumerate() {
        let at_ns = START_NS + 1_000_000_000 * crate::constants::index(*time_s, 100_000_000) as u64;
        message.clear();
        message.extend(0_u16.to_le_bytes());
        message.extend(length(i)?.to_le_bytes());
        message.extend(at_ns.to_le_bytes());
        message.extend(at_ns.to_le_bytes());
        for (c, values) in columns.values.iter().enumerate().skip(1) {
            let open = if c == 1 { '{' } else { ',' };
            if values[i].is_nan() {
                write!(message, "{open}\"{}\":null", columns.tags[c])?;
            } else {
                write!(message, "{open}\"{}\":{}", columns.tags[c], values[i])?;
            }
        }
        message.push(b'}');
        mcap_record(0x05, &message, out)?;
    }
    // No check of the data section, then a footer without a summary.
    mcap_record(0x0F, &[0; 4], out)?;
    mcap_record(0x02, &[0; 20], out)?;
    out.write_all(MAGIC)
}

/// Writes the well description of a case: what the crew believes, not what is true.
///
/// # Errors
/// What `out` returns.
pub fn write_case_well_toml(case: &Case, out: &mut impl Write) -> io::Result<()> {
    crate::write::describe(&case.plan.well, &case.dialect, &case.absent, out)
}

/// Writes the truth of a case as JSON: what is hidden, where and when, and which readings were stuck.
///
/// # Errors
/// What `out` returns.
pub fn write_truth(case: &Case, recording: &Recording, out: &mut impl Write) -> io::Result<()> {
    let pairs = |list: &[(&str, f64)]| {
        let members: Vec<String> = list
            .iter()
            .map(|(name, value)| {
                if *name == "sensor" {
                    format!("\"{name}\": {value}")
                } else {
                    format!("\"{name}\": {value:?}")
                }
            })
            .collect();
        format!("{{{}}}", members.join(", "))
    };
    let mut effects = Vec::new();
    for h in &case.hidden {
        let mut members = vec![
            format!("\"effect\": \"{}\"", h.effect),
            format!("\"severity\": \"{}\"", h.severity.name()),
            format!("\"params\": {}", pairs(&h.params)),
            h.interval_s.map_or_else(
                || "\"interval\": null".into(),
                |(from, to)| format!("\"interval\": [{from:?}, {to:?}]"),
            ),
        ];
        if let Some((from, to)) = h.again_s {
            members.push(format!("\"again\": [{from:?}, {to:?}]"));
        }
        if let Some(kind) = h.kind {
            members.push(format!("\"kind\": \"{kind}\""));
        }
        if !h.extra.is_empty() {
            members.push(format!("\"extra\": {}", pairs(&h.extra)));
        }
        let relation: Vec<String> = h.relation.iter().map(|r| format!("\"{r}\"")).collect();
        members.push(format!("\"relation\": [{}]", relation.join(", ")));
        effects.push(format!("\n    {{{}}}", members.join(", ")));
    }
    let names = [
        "q_mp", "q_bst", "q_tf", "q_mrl", "p_in1", "p_in2", "p_out1", "p_out2", "p_riser", "w",
    ];
    let stuck: Vec<String> = recording
        .faults
        .iter()
        .filter(|f| f.kind == FaultKind::Stuck)
        .filter_map(|f| {
            let name = names.get(f.channel?)?;
            Some(format!("[\"{name}\", {}, {}]", f.first, f.first + f.count))
        })
        .collect();
    writeln!(
        out,
        "{{\n  \"id\": \"{}\",\n  \"hours\": {},\n  \"well\": \"{}\",\n  \"effects\": [{}],\n  \"stuck\": [{}]\n}}",
        case.id,
        case.plan.samples() as f64 / 3600.0,
        case.plan.name,
        effects.join(","),
        stuck.join(", "),
    )
}
