//! Writes the seed corpus: `cargo run --example seeds` in this folder. The same bytes every time, nobody's data.

use dgd_documents::{
    Base, FittedParameter, FittedSystem, ModelDocument, read_model, read_system, read_well,
    return_line_system, write_fitted_system, write_model, write_model_document,
};
use dgd_effects::{
    AppliedEffect, AugmentedModel, Curves, FRICTION_TERMS, HEAD_TERMS, Scale, catalogue,
};
use dgd_export::{
    CsvOptions, MatValue, McapOptions, write_csv, write_mat5, write_mat5_values, write_mat73,
    write_mcap,
};
use dgd_recording::{Column, Table};
use flate2::read::ZlibDecoder;
use mcap::{Compression, WriteOptions, records::MessageHeader};
use std::collections::BTreeMap;
use std::error::Error;
use std::io::{Cursor, Read};
use std::path::Path;

type Outcome<T> = Result<T, Box<dyn Error>>;

fn main() -> Outcome<()> {
    mat()?;
    csv()?;
    mcap()?;
    documents()
}

fn save(target: &str, name: &str, bytes: &[u8]) -> Outcome<()> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("seeds")
        .join(target);
    std::fs::create_dir_all(&folder)?;
    Ok(std::fs::write(folder.join(name), bytes)?)
}

/// Channels of Table 2.1, as little of them as a reader needs.
fn table(rows: u32) -> Table {
    let column = |tag: &str, unit: &str, from: f64, slope: f64| Column {
        tag: tag.into(),
        unit: Some(unit.into()),
        values: (0..rows).map(|i| from + slope * f64::from(i % 7)).collect(),
    };
    let mut columns = vec![
        column("t", "s", 0.0, 0.0),
        column("FT1", "gpm", 800.0, 0.5),
        column("PT1", "psia", 530.0, -0.25),
        column("SPM", "%", 60.0, 0.0),
    ];
    columns[0].values = (0..rows).map(f64::from).collect();
    columns[2].values[1] = f64::NAN;
    Table {
        columns,
        origin: Some("2015-06-01T00:00:00Z".into()),
        ..Table::default()
    }
}

fn mat() -> Outcome<()> {
    let mut packed = Vec::new();
    write_mat5(&table(12), "gom", &mut packed)?;
    save("mat5", "struct.mat", &packed)?;
    save("mat5", "plain.mat", &unpacked(&packed)?)?;
    let values = [
        (
            "a".to_owned(),
            MatValue::Matrix {
                rows: 2,
                columns: 5,
                values: (0..10).map(f64::from).collect(),
            },
        ),
        (
            "b".to_owned(),
            MatValue::Matrix {
                rows: 300,
                columns: 1,
                values: vec![0.0; 300],
            },
        ),
    ];
    let mut matrices = Vec::new();
    write_mat5_values(&values, "m", &mut matrices)?;
    save("mat5", "matrices.mat", &matrices)?;
    save("mat5", "matrices_plain.mat", &unpacked(&matrices)?)?;
    save("mat73", "struct.mat", &write_mat73(&table(12), "gom")?)
}

/// A MAT v5 file with its variables inflated.
fn unpacked(file: &[u8]) -> Outcome<Vec<u8>> {
    let mut out = file[..128].to_vec();
    let mut at = 128;
    while at < file.len() {
        let length = u32::from_le_bytes(file[at + 4..at + 8].try_into()?) as usize;
        ZlibDecoder::new(&file[at + 8..at + 8 + length]).read_to_end(&mut out)?;
        at += 8 + length;
    }
    Ok(out)
}

fn csv() -> Outcome<()> {
    let mut text = Vec::new();
    write_csv(&table(8), &CsvOptions::default(), &mut text)?;
    save("csv", "own.csv", &text)?;
    save(
        "csv",
        "semicolons.csv",
        b"time;a [gpm];b\r\n59:59,9;1,5;\"x\"\r\n00:00,0;\"2,5\";3\r\n00:00,1;-999,25;\r\n",
    )?;
    save("csv", "dates.csv", b"rig 7\nDate,Time,x (psi)\n2024-10-22,23:59:59,1e3\n2024-10-23,00:00:00,-2.5E-2\n2024-10-23,00:00:01,N/A\n")?;
    save(
        "csv",
        "stamps.csv",
        "\u{feff}T [°C];\"a \"\"b\"\"\"\n2024-10-22T00:00:00.5Z;1\n;\n2024-10-22T00:00:01.5Z;2\n"
            .as_bytes(),
    )?;
    save(
        "csv",
        "day_first.csv",
        b"22.10.2024 15:27\t1\t2\n22.10.2024 15:28\t1\t2\n22.10.2024 15:30\t\t2\n",
    )?;
    save(
        "csv",
        "epoch.csv",
        b"timestamp,v\n1729600000000,1\n1729600001000,2\n1729600009000,3\n",
    )?;
    save(
        "csv",
        "slashes.csv",
        b"Date/Time,x\n10/26/2024 11:59:59 PM,1\n10/27/2024 12:00:00 AM,2\n10/27/2024 12:00:01 am,3\n",
    )?;
    save(
        "csv",
        "compact.csv",
        b"stamp;a;b\n20241026003002;1 250,5;3\n20241026003001;1 249,5;\n20241026003000;1 248,5;2\n",
    )?;
    save(
        "csv",
        "months.csv",
        b"Time,q (gpm)\n26-Oct-24 11:59 PM,\"1,250.5\"\n27-Oct-24 12:00 AM,\"1,249.0\"\n27-Oct-24 12:01 AM,3\n",
    )?;
    save(
        "csv",
        "readings.csv",
        b"Tag,Timestamp,Value,Units,Quality\nFT1,2024-10-26 10:00:00,800,gpm,Good\nPT1,2024-10-26 10:00:00,530,psia,Good\nFT1,2024-10-26 10:00:01,801.5,gpm,Bad\nFT1,2024-10-26 10:00:02,802,gpm,Good\nPT1,2024-10-26 10:00:02,529,psia,Good\n",
    )?;
    save(
        "csv",
        "pairs.csv",
        b"Time FT1,FT1 (gpm),Time PT1,PT1\n2024-10-26 10:00:00,800,2024-10-26 10:00:00.5,530\n2024-10-26 10:00:01,801,2024-10-26 10:00:04,529\n2024-10-26 10:00:02,802,,\n",
    )?;
    save(
        "csv",
        "headers.csv",
        b"t,a (bar),b (psi)\n0,1,2\n1,3,4\nt,b (psi),a (bar)\n2,6,5\n3,8,7\n\nTime,a\n(s),(psi)\n4,9\n",
    )?;
    save("csv", "bare.csv", b"0 1\n1,2,3\n2,3,4\n3,4\n\n4,5,6,7\n")
}

fn mcap() -> Outcome<()> {
    let mut log = Cursor::new(Vec::new());
    write_mcap(&table(6), &McapOptions::default(), &mut log)?;
    save("mcap", "own.mcap", &log.into_inner())?;
    let ways = [
        ("plain", None),
        ("lz4", Some(Compression::Lz4)),
        ("zstd", Some(Compression::Zstd)),
    ];
    for (name, compression) in ways {
        // Without checksums and index, so that changes reach the messages.
        let mut log = WriteOptions::new()
            .compression(compression)
            .compression_threads(0)
            .calculate_chunk_crcs(false)
            .calculate_data_section_crc(false)
            .calculate_summary_section_crc(false)
            .emit_statistics(false)
            .emit_summary_offsets(false)
            .emit_message_indexes(false)
            .emit_chunk_indexes(false)
            .chunk_size(Some(400))
            .create(Cursor::new(Vec::new()))?;
        let schema =
            log.add_schema("s", "jsonschema", br#"{"properties":{"a":{"unit":"gpm"}}}"#)?;
        let mut channels = Vec::new();
        for (topic, encoding) in [("/a", "json"), ("/b", "json"), ("/c", "protobuf")] {
            channels.push(log.add_channel(schema, topic, encoding, &BTreeMap::new())?);
        }
        for i in 0..12_u64 {
            let header = MessageHeader {
                channel_id: channels[[0, 1, 0, 2][(i % 4) as usize]],
                sequence: 0,
                log_time: i * 1_000_000_000,
                publish_time: 0,
            };
            let text = format!(r#"{{"a":{i},"b":[1,-2e3,{{"c":null}}],"s":"x\"y\u00e6"}}"#);
            log.write_to_known_channel(&header, text.as_bytes())?;
        }
        log.finish()?;
        save(
            "mcap",
            &format!("{name}.mcap"),
            &log.into_inner().into_inner(),
        )?;
    }
    Ok(())
}

/// Documents that the tests of `dgd-documents` hold; seeds are the same, with what else a reader may meet.
const MODEL: &str = include_str!("../../dgd-documents/tests/data/model.toml");

const WELL: &str = include_str!("../../dgd-documents/tests/data/well.toml");

/// Depth as the independent variable, a junction, a curve, ports, an effect and everything with its unit.
const EFFECTS: &str = r#"connections = ["source -> well -> intake -> split -> drain -> atmosphere", "split -> feed -> tank", "tank.low -> choke -> atmosphere"]

[fluid]
density = "1.08 sg"
viscosity = "20 cP"

[scale]
level = 2.0

[components]
source = { kind = "boundary", flow = "600 l/min" }
well = { kind = "volume", volume = 3.0, bulk_modulus = 1.5e9 }
split = { kind = "junction" }
drain = { kind = "valve", flow_coefficient = 1e-4 }
feed = { kind = "valve", flow_coefficient = 1e-4 }
intake = { kind = "valve", flow_coefficient = 1e-4 }
tank = { kind = "tank", area = "1 m2", brim = 3.0, ports = { low = 0.4 } }
choke = { kind = "orifice", discharge_coefficient = 0.62, area = 1e-4 }
gauge = { kind = "instrument", measures = "level", of = "tank", channel = "LT", unit = "cm", accuracy = 0.5, low = 0.0, high = 300.0 }

[inputs]
"drain.opening" = { channel = "ZT" }

[initial]
"tank.level" = { measured = "gauge" }
"well.pressure" = "2 bar"

[free]
"gauge.reading_offset.offset" = { start = 0.0, low = -0.1, high = 0.1 }

[record]
step = 2.0
train = { windows = [[0.0, 10.0], [20.0, 30.0]], channels = { LT = "level" } }

[[effects]]
component = "gauge"
effect = "reading_offset"
"#;

/// A document with some of its texts changed, each of which must be in it once.
fn changed(document: &str, changes: &[(&str, &str)]) -> Outcome<String> {
    let mut document = document.to_owned();
    for (from, to) in changes {
        if document.matches(from).count() != 1 {
            return Err(format!("`{from}` is not in the document once").into());
        }
        document = document.replace(from, to);
    }
    Ok(document)
}

fn documents() -> Outcome<()> {
    let full = changed(
        WELL,
        &[
            (
                "pump_inlet_depth",
                "booster_line_id = \"4 in\"\npump_inlet_depth",
            ),
            ("outlet_depth = \"350.30 m\"", "outlet_depth = \"1149 ft\""),
            ("\"FT2\", unit = \"gpm\"", "\"FT2\", unit = \"l/min\""),
            (
                "\"FT4\", unit = \"gpm\"",
                "\"FT4\", unit = \"m3/h\", late = \"-1.5 s\"",
            ),
            ("\"PT2\", unit = \"psia\"", "\"PT2\", unit = \"barg\""),
            ("\"PT3\", unit = \"psia\"", "\"PT3\", unit = \"kPa\""),
            (
                "pump_speed",
                "riser_pressure = { tag = \"PT5\", unit = \"psia\" }\npump_speed",
            ),
        ],
    )?;
    read_well(&full)?;
    save("well", "full.toml", full.as_bytes())?;
    let lean = full
        .lines()
        .filter(|l| {
            !l.starts_with("casing")
                && !l.starts_with("booster_line")
                && !l.starts_with("riser_pressure")
        })
        .map(|l| {
            if l.starts_with("time") {
                "time = { interval = \"1 s\" }"
            } else {
                l
            }
        });
    let lean = lean.collect::<Vec<_>>().join("\n");
    read_well(&lean)?;
    save("well", "lean.toml", lean.as_bytes())?;

    let by_hand = changed(
        MODEL,
        &[
            (
                "active_constraints = []",
                "active_constraints = [\"c1\"]\nmse_m2 = nan",
            ),
            ("\"a.csv\", \"b.csv\"", "\"a.csv\""),
            ("gap = 12\n", ""),
        ],
    )?;
    let (model, _) = read_model(&by_hand)?;
    save("model", "by_hand.toml", by_hand.as_bytes())?;
    save("model", "written.toml", write_model(&model).as_bytes())?;
    let effects = catalogue().iter().step_by(3).map(|effect| AppliedEffect {
        id: effect.about().id.into(),
        parameters: effect.about().parameters.iter().map(|p| p.usual).collect(),
    });
    let augmented = AugmentedModel {
        curves: Curves {
            scale: Scale {
                flow_m3_s: 0.06,
                speed_pct: 55.0,
                laminar: None,
            },
            friction: [1e4; FRICTION_TERMS],
            head: [-2.5e3; HEAD_TERMS],
        },
        speed_range_pct: (20.0, 80.0),
        ratio_range: (0.0, 0.001),
        span_s: None,
        inlet_range_pa: None,
        effects: effects.collect(),
    };
    let base = Base::WellOnly {
        density_kg_m3: model.density_kg_m3,
        geometry: model.geometry.clone(),
    };
    let document = ModelDocument {
        base,
        augmented: Some(augmented),
    };
    save(
        "model",
        "augmented.toml",
        write_model_document(&document).as_bytes(),
    )?;

    let tanks = include_str!("../../dgd-assembly/examples/two_tanks.toml");
    save("system", "two_tanks.toml", tanks.as_bytes())?;
    let pump_loop = include_str!("../../dgd-assembly/examples/pump_loop.toml");
    save("system", "pump_loop.toml", pump_loop.as_bytes())?;
    save(
        "system",
        "return_line.toml",
        return_line_system(&model).as_bytes(),
    )?;
    save("system", "effects.toml", EFFECTS.as_bytes())?;
    read_system(EFFECTS)?;
    let assembly = read_system(pump_loop)?.assembly;
    let parameters = assembly.parameters().into_iter().map(|p| FittedParameter {
        path: p.path,
        value: p.start,
        standard_error: 1e-6,
        at_bound: false,
    });
    let fitted = FittedSystem {
        recording: "a.csv".into(),
        status: "converged".into(),
        samples: 400,
        parameters: parameters.collect(),
    };
    save(
        "system",
        "fitted.toml",
        write_fitted_system(&assembly, &fitted)?.as_bytes(),
    )
}
