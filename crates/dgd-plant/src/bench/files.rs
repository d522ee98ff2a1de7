//! The files of a case: recording and truth.

use super::case::Case;
use super::run::{Record, simulate};
use super::{HELD_OUT, SAMPLING_S};
use std::io::{self, Write};

/// Writes the recording: a row of tags, a row of units, one row a sample; inputs first.
///
/// # Errors
/// What `out` returns.
pub fn write_csv(case: &Case, record: &Record, out: &mut impl Write) -> io::Result<()> {
    let gauges = || case.bench.inputs().iter().chain(case.bench.outputs());
    let tags: Vec<&str> = gauges().map(|g| g.tag).collect();
    let units: Vec<&str> = gauges().map(|g| g.unit).collect();
    writeln!(out, "t,{}\ns,{}", tags.join(","), units.join(","))?;
    let columns = || record.inputs.iter().chain(&record.outputs);
    for i in 0..columns().map(Vec::len).min().unwrap_or(0) {
        write!(out, "{}", i as f64 * SAMPLING_S)?;
        for column in columns() {
            write!(out, ",{}", column[i])?;
        }
        writeln!(out)?;
    }
    Ok(())
}

/// Writes the truth as JSON: what is concealed, where, how strong; the free values of the system description as they truly are; and for
/// each output the floor (what noise and steps alone add, in its unit) and the shift (how far the concealed thing moves it).
///
/// # Errors
/// What `out` returns.
pub fn write_truth(case: &Case, record: &Record, out: &mut impl Write) -> io::Result<()> {
    let list = |pairs: &[(&str, f64)]| {
        let members: Vec<String> = pairs
            .iter()
            .map(|(k, v)| format!("\"{k}\": {v:?}"))
            .collect();
        format!("{{{}}}", members.join(", "))
    };
    let concealed = case.hidden().map_or("null".to_owned(), |hidden| {
        let place = hidden.place();
        let components: Vec<String> = place.components.iter().map(|c| format!("\"{c}\"")).collect();
        format!(
            "{{\"thing\": \"{}\", \"severity\": \"{}\", \"kind\": \"{}\", \"components\": [{}], \"size\": {}}}",
            hidden.name(),
            case.severity.name(),
            place.kind,
            components.join(", "),
            list(&hidden.size())
        )
    });
    let samples = record.quiet_si.first().map_or(0, Vec::len);
    let split = HELD_OUT.min(samples);
    let quiet = case.hidden().map(|_| simulate(&case.with(None)).quiet_si);
    let mut outputs = Vec::new();
    for (i, gauge) in case.bench.outputs().iter().enumerate() {
        let shift = quiet.as_ref().map_or(0.0, |clean| {
            let pairs = record.quiet_si[i].iter().zip(&clean[i]);
            let squares: f64 = pairs.map(|(a, b)| (a - b) * (a - b)).sum();
            (squares / samples.max(1) as f64).sqrt() / gauge.si
        });
        outputs.push(format!(
            "\n    \"{}\": {{\"unit\": \"{}\", \"floor_training\": {:?}, \"floor_held_out\": {:?}, \"shift\": {shift:?}}}",
            gauge.name,
            gauge.unit,
            record.floor(case, i, 0..split),
            record.floor(case, i, split..samples)
        ));
    }
    writeln!(
        out,
        "{{\n  \"id\": \"{}\",\n  \"bench\": \"{}\",\n  \"concealed\": {concealed},\n  \"values\": {},\n  \"outputs\": {{{}\n  }}\n}}",
        case.id,
        case.bench.name(),
        list(&case.values),
        outputs.join(",")
    )
}
