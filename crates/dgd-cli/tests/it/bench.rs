//! A folder with a made recording, and the binary run in it.

use dgd_recording::{Column, Table};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;
use tempfile::TempDir;

const GPM_M3_S: f64 = 6.3090e-5;
const PSI_PA: f64 = 6_894.757_29;
const P0_PA: f64 = 101_325.0;
pub(crate) const DENSITY_KG_M3: f64 = 1_083.7;
pub(crate) const DEPTH_M: f64 = 351.37;
pub(crate) const DELAY_S: f64 = 9.0;
/// Odd enough to be no part of any other text.
pub(crate) const TAGS: [&str; 9] = [
    "QXMUD17", "QXBST17", "QXTOP17", "QXRET17", "PXINA17", "PXINB17", "PXOUA17", "PXOUB17",
    "NXSPM17",
];

pub(crate) const WELL: &str = r#"[mud]
density = "1083.7 kg/m3"

[geometry]
riser_id = "0.49537 m"
drillpipe_od = "0.16833 m"
return_line_id = "0.15241 m"
pump_inlet_depth = "351.37 m"
pump_outlet_depth = "351.37 m"

[channels]
time = { tag = "t", unit = "s" }
mud_pump_flow = { tag = "QXMUD17", unit = "gpm" }
booster_flow = { tag = "QXBST17", unit = "gpm" }
topfill_flow = { tag = "QXTOP17", unit = "gpm" }
return_flow = { tag = "QXRET17", unit = "gpm" }
pump_inlet_pressure = [{ tag = "PXINA17", unit = "psia" }, { tag = "PXINB17", unit = "psia" }]
pump_outlet_pressure = [{ tag = "PXOUA17", unit = "psia" }, { tag = "PXOUB17", unit = "psia" }]
pump_speed = { tag = "NXSPM17", unit = "%" }
"#;

pub(crate) fn riser_area_m2() -> f64 {
    std::f64::consts::PI / 4.0 * (0.495_37f64.powi(2) - 0.168_33f64.powi(2))
}

fn friction_pa(q: f64) -> f64 {
    2e4 + 1.2e8 * q * q + 4e8 * q.powi(3)
}

fn head_m(w: f64, q: f64) -> f64 {
    0.0688 * w.powf(1.95) - 3.0 * w * q - 2.4e3 * q.powf(1.62)
}

fn column_of(tag: &str, unit: &str) -> Column {
    Column {
        tag: tag.into(),
        unit: Some(unit.into()),
        values: Vec::new(),
    }
}

/// Table 2.1 of a made rig, one row a second.
pub(crate) fn recording(samples: u32) -> Table {
    let mut random = ChaCha8Rng::seed_from_u64(3);
    let weight_pa_m = DENSITY_KG_M3 * 9.806_65;
    let flow = |t: f64| 0.045 + 0.012 * (t / 97.0).sin() + 0.006 * (t / 29.0 + 2.0).cos();
    let level = |t: f64| 150.0 + 14.0 * (t / 613.0).sin() + 2.0 * (t / 131.0).cos();
    let units = [
        "gpm", "gpm", "gpm", "gpm", "psia", "psia", "psia", "psia", "%",
    ];
    let mut columns = vec![column_of("t", "s")];
    columns.extend(
        TAGS.iter()
            .zip(units)
            .map(|(tag, unit)| column_of(tag, unit)),
    );
    for i in 0..samples {
        let t = f64::from(i);
        let (q, h) = (flow(t), level(t));
        let falling_m_s = (level(t + 0.5) - level(t - 0.5)) * riser_area_m2();
        let needed_m = h + friction_pa(q) / weight_pa_m;
        let (mut low, mut high) = (0.0, 120.0);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if head_m(middle, q) < needed_m {
                low = middle;
            } else {
                high = middle;
            }
        }
        // Three uniform draws are near enough to normal: standard deviation 0.5.
        let mut noise = |sd: f64| {
            let sum: f64 = (0..3).map(|_| random.random::<f64>() - 0.5).sum();
            2.0 * sd * sum
        };
        let step = |value: f64, step: f64| (value / step).round() * step;
        let gpm = |q: f64| step(q / GPM_M3_S, 0.5);
        let psia = |p: f64| step(p / PSI_PA, 0.1);
        let inlet_pa = P0_PA + weight_pa_m * (DEPTH_M - h);
        let outlet_pa = P0_PA + weight_pa_m * DEPTH_M + friction_pa(q);
        let row = [
            t,
            gpm(q - falling_m_s - 0.010 + noise(5e-5)),
            gpm(0.008 + noise(5e-5)),
            gpm(0.002 + noise(5e-5)),
            gpm(flow(t - DELAY_S) + noise(5e-5)),
            psia(inlet_pa + noise(700.0)),
            psia(inlet_pa + noise(700.0)),
            psia(outlet_pa + noise(700.0)),
            psia(outlet_pa + noise(700.0)),
            step(high, 0.01),
        ];
        for (column, value) in columns.iter_mut().zip(row) {
            column.values.push(value);
        }
    }
    Table {
        columns,
        ..Table::default()
    }
}

pub(crate) fn mat5(table: &Table) -> Vec<u8> {
    let mut bytes = Vec::new();
    dgd_export::write_mat5(table, "recording", &mut bytes).unwrap();
    bytes
}

/// What the binary did.
#[derive(Debug)]
pub(crate) struct Ran {
    pub(crate) status: i32,
    pub(crate) out: String,
    pub(crate) err: String,
}

impl Ran {
    /// A signal that ended it is status -1.
    pub(crate) fn of(output: &std::process::Output) -> Self {
        Self {
            status: output.status.code().unwrap_or(-1),
            out: String::from_utf8_lossy(&output.stdout).into_owned(),
            err: String::from_utf8_lossy(&output.stderr).into_owned(),
        }
    }

    /// Standard output of a run that must have succeeded.
    #[track_caller]
    pub(crate) fn done(self) -> String {
        assert_eq!(self.status, 0, "{}", self.err);
        self.out
    }

    /// Asserts status 2, nothing on standard output, and every part in the message.
    #[track_caller]
    pub(crate) fn refused(&self, parts: &[&str]) {
        assert_eq!(self.status, 2, "{self:?}");
        assert_eq!(self.out, "");
        for part in parts {
            assert!(self.err.contains(part), "`{part}` is not in: {}", self.err);
        }
        assert!(!self.err.contains("panicked"), "{}", self.err);
    }
}

pub(crate) struct Bench {
    folder: TempDir,
}

impl Bench {
    /// `rig.mat` and `well.toml`.
    pub(crate) fn new() -> Self {
        let bench = Self::bare();
        bench.write("rig.mat", mat5(&recording(4000)));
        bench.write("well.toml", WELL);
        bench
    }

    pub(crate) fn bare() -> Self {
        Self {
            folder: tempfile::tempdir().unwrap(),
        }
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub(crate) fn write(&self, name: &str, bytes: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), bytes).unwrap();
    }

    pub(crate) fn bytes(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap()
    }

    pub(crate) fn text(&self, name: &str) -> String {
        String::from_utf8(self.bytes(name)).unwrap()
    }

    /// Runs `dgd` here; arguments are parted by blanks.
    pub(crate) fn dgd(&self, arguments: &str) -> Ran {
        run_in(self.folder.path(), arguments.split_whitespace())
    }

    /// Runs it with `--json` and checks the schema.
    #[track_caller]
    pub(crate) fn json(&self, arguments: &str, schema: &str) -> Value {
        let said = self.dgd(&format!("{arguments} --json")).done();
        let value: Value = serde_json::from_str(&said).unwrap();
        assert_eq!(value["schema"], schema);
        value
    }

    /// Names in the folder, sorted.
    pub(crate) fn names(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.folder.path()).unwrap();
        let mut names: Vec<String> = entries
            .map(|e| e.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }
}

pub(crate) fn run_in<'a>(folder: &Path, arguments: impl IntoIterator<Item = &'a str>) -> Ran {
    let output = Command::new(env!("CARGO_BIN_EXE_dgd"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .unwrap();
    Ran {
        status: output.status.code().unwrap(),
        out: String::from_utf8(output.stdout).unwrap(),
        err: String::from_utf8(output.stderr).unwrap(),
    }
}
