//! The files of a recording: CSV series, `well.toml`, `PROVENANCE.md`.

use std::io::{self, Write};

use crate::conceal::Dialect;
use crate::config::{CHANNELS, Plan, UNITS};
use crate::constants::INCH_M;
use crate::record::Recording;
use crate::well::Well;

/// Writes samples `range` of the recording: header row, unit row, one row a second, blanks where a value is missing.
///
/// # Errors
/// What `out` returns. A range beyond the recording is cut to it.
pub fn write_csv(
    recording: &Recording,
    range: std::ops::Range<usize>,
    out: &mut impl Write,
) -> io::Result<()> {
    writeln!(out, "t,{}", CHANNELS.join(","))?;
    writeln!(out, "s,{}", UNITS.join(","))?;
    for i in range.start..range.end.min(recording.time_s.len()) {
        write!(out, "{}", recording.time_s[i])?;
        for channel in &recording.channels {
            if channel[i].is_nan() {
                write!(out, ",")?;
            } else {
                write!(out, ",{}", channel[i])?;
            }
        }
        writeln!(out)?;
    }
    Ok(())
}

/// Writes the well description that goes with the recording.
///
/// # Errors
/// What `out` returns.
pub fn write_well_toml(well: &Well, out: &mut impl Write) -> io::Result<()> {
    describe(well, &Dialect::THESIS, &[false; 10], out)
}

/// Writes a well description in a rig's own tags and units, without the channels that are absent.
pub(crate) fn describe(
    well: &Well,
    dialect: &Dialect,
    absent: &[bool; 10],
    out: &mut impl Write,
) -> io::Result<()> {
    let inch = |m: f64| (m / INCH_M * 1000.0).round() / 1000.0;
    write!(
        out,
        r#"# Well and channel description of this recording.
[mud]
density = "{:.3} sg"

[geometry]
riser_id = "{} in"
drillpipe_od = "{} in"
casing_od = "{} in"
return_line_id = "{:.3} in"
pump_inlet_depth = "{:.2} m"
pump_outlet_depth = "{:.2} m"
riser_pressure_sensor_depth = "{:.2} m"

[channels]
time = {{ tag = "{}", unit = "s" }}
"#,
        well.mud_density_kg_m3 / 1000.0,
        inch(well.riser_id_m),
        inch(well.drillpipe_od_m),
        inch(well.casing_od_m),
        inch(well.return_line_id_m),
        well.pump_inlet_depth_m,
        well.pump_outlet_depth_m,
        well.riser_sensor_depth_m,
        dialect.time,
    )?;
    let one =
        |c: usize, unit: &str| format!("{{ tag = \"{}\", unit = \"{unit}\" }}", dialect.tags[c]);
    let flows = [
        "mud_pump_flow",
        "booster_flow",
        "topfill_flow",
        "return_flow",
    ];
    for (c, name) in flows.into_iter().enumerate() {
        writeln!(out, "{name} = {}", one(c, dialect.flow))?;
    }
    for (name, pair) in [
        ("pump_inlet_pressure", [4, 5]),
        ("pump_outlet_pressure", [6, 7]),
    ] {
        let there = pair.into_iter().filter(|&c| !absent[c]);
        let there: Vec<String> = there.map(|c| one(c, dialect.pressure)).collect();
        writeln!(out, "{name} = [{}]", there.join(", "))?;
    }
    if !absent[8] {
        writeln!(out, "riser_pressure = {}", one(8, dialect.pressure))?;
    }
    writeln!(out, "pump_speed = {}", one(9, "%"))
}

/// Writes what the recording is and how to make it again.
///
/// # Errors
/// What `out` returns.
pub fn write_provenance(plan: &Plan, files: &[String], out: &mut impl Write) -> io::Result<()> {
    let samples = plan.samples();
    write!(
        out,
        "# Provenance\n\n\
         Simulated by `dgd-plant` {}, not measured: a stand-in for field data that is confidential.\n\n\
         - Preset `{}`, seed {}, {samples} samples at 1 Hz.\n\
         - Made by `dgd-plant {} --out DIR --seed {} --hours {}`.\n\
         - Time counts seconds from the start of the first series and continues through the others; \
         it jumps where the recorder's clock skipped.\n\
         - Pressures are absolute. A blank is a missing value. Stuck, wild and zero values are left in, as in field data.\n\
         - The well is described in `well.toml`.\n\n",
        env!("CARGO_PKG_VERSION"),
        plan.name,
        plan.seed,
        plan.name,
        plan.seed,
        samples as f64 / 3600.0,
    )?;
    for (file, count) in files.iter().zip(&plan.series) {
        writeln!(out, "- `{file}`: {count} samples")?;
    }
    Ok(())
}
