//! The bytes.

use dgd_plant::{Plan, record, write_csv, write_provenance, write_well_toml};

fn csv(seed: u64) -> Vec<u8> {
    let plan = Plan::short(seed).with_hours(0.5);
    let r = record(&plan).unwrap();
    let mut out = Vec::new();
    write_csv(&r, 0..plan.samples(), &mut out).unwrap();
    out
}

#[test]
fn one_seed_gives_one_file_and_another_seed_another() {
    assert_eq!(csv(4), csv(4));
    assert_ne!(csv(4), csv(5));
}

#[test]
fn csv_has_a_header_a_unit_row_a_row_a_sample_and_blanks_for_missing_values() {
    let mut plan = Plan::short(1).with_hours(0.5);
    for f in &mut plan.faults {
        f.missing_per_day = 500.0;
    }
    let r = record(&plan).unwrap();
    let mut out = Vec::new();
    write_csv(&r, 100..400, &mut out).unwrap();
    let text = String::from_utf8(out).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines[0], "t,FT1,FT2,FT3,FT4,PT1,PT2,PT3,PT4,PT5,SPM");
    assert_eq!(lines[1], "s,gpm,gpm,gpm,gpm,psi,psi,psi,psi,psi,%");
    assert_eq!(lines.len(), 302);
    assert!(lines[2].starts_with("100,"));
    let mut blanks = 0;
    for (line, i) in lines[2..].iter().zip(100..) {
        let cells: Vec<&str> = line.split(',').collect();
        assert_eq!(cells.len(), 11);
        for (cell, channel) in cells[1..].iter().zip(&r.channels) {
            match cell.parse::<f64>() {
                Ok(v) => assert_eq!(v.to_bits(), channel[i].to_bits()),
                Err(_) => {
                    assert!(cell.is_empty() && channel[i].is_nan());
                    blanks += 1;
                }
            }
        }
    }
    assert!(blanks > 0);
}

#[test]
fn well_description_carries_table_2_2() {
    let mut out = Vec::new();
    write_well_toml(&Plan::gom(1).well, &mut out).unwrap();
    let text = String::from_utf8(out).unwrap();
    for line in [
        "density = \"1.080 sg\"",
        "riser_id = \"19.5 in\"",
        "drillpipe_od = \"6.625 in\"",
        "casing_od = \"13.625 in\"",
        "return_line_id = \"6.000 in\"",
        "pump_inlet_depth = \"350.30 m\"",
        "riser_pressure_sensor_depth = \"352.10 m\"",
        "return_flow = { tag = \"FT4\", unit = \"gpm\" }",
        "pump_outlet_pressure = [{ tag = \"PT3\", unit = \"psia\" }, { tag = \"PT4\", unit = \"psia\" }]",
        "riser_pressure = { tag = \"PT5\", unit = \"psia\" }",
        "pump_speed = { tag = \"SPM\", unit = \"%\" }",
    ] {
        assert!(text.lines().any(|l| l == line), "{line}");
    }
}

#[test]
fn provenance_names_a_command_that_makes_the_same_series() {
    let plan = Plan::gom(9);
    let files: Vec<String> = (1..=4).map(|i| format!("gom{i}.csv")).collect();
    let mut out = Vec::new();
    write_provenance(&plan, &files, &mut out).unwrap();
    let text = String::from_utf8(out).unwrap();
    let hours = text
        .split("--hours ")
        .nth(1)
        .unwrap()
        .split('`')
        .next()
        .unwrap();
    assert!(text.contains("seed 9") && text.contains("`gom4.csv`: 74820 samples"));
    assert_eq!(
        Plan::gom(9).with_hours(hours.parse().unwrap()).series,
        plan.series
    );
}
