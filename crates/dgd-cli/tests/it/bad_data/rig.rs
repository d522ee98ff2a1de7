//! The demo's recording and description, to be spoilt, and what `dgd` makes of them.

use crate::bench::{Bench, Ran, mat5};
use dgd_ingest::ReadOptions;
use dgd_recording::Table;
use serde_json::Value;

const RECORDING: &[u8] = include_bytes!("../../../../../fixtures/demo/recording.mat");
const WELL: &str = include_str!("../../../../../fixtures/demo/well.toml");

/// The demo's recording and description, to be spoilt.
pub(super) struct Rig {
    pub(super) table: Table,
    well: String,
}

impl Rig {
    pub(super) fn sound() -> Self {
        let mut table = dgd_ingest::read(RECORDING, &ReadOptions::default())
            .unwrap()
            .1;
        for column in &mut table.columns {
            // The description alone says the unit, so that it can be wrong.
            column.unit = None;
            column.tag = column.tag.rsplit('.').next().unwrap().to_owned();
        }
        Self {
            table,
            well: WELL.to_owned(),
        }
    }

    /// The other fixture: five hours without an effect but for an influx, described as it is.
    pub(super) fn of_hours() -> Self {
        let recording = include_bytes!("../../../../../fixtures/demo-concealed/recording.mat");
        let well = include_str!("../../../../../fixtures/demo-concealed/well.toml");
        let mut table = dgd_ingest::read(recording, &ReadOptions::default())
            .unwrap()
            .1;
        for column in &mut table.columns {
            column.tag = column.tag.rsplit('.').next().unwrap().to_owned();
        }
        Self {
            table,
            well: well.to_owned(),
        }
    }

    /// The first samples alone.
    pub(super) fn first(samples: usize) -> Self {
        let mut rig = Self::sound();
        for column in &mut rig.table.columns {
            column.values.truncate(samples);
        }
        rig
    }

    pub(super) fn column(&mut self, tag: &str) -> &mut Vec<f64> {
        let mut columns = self.table.columns.iter_mut();
        &mut columns.find(|c| c.tag == tag).unwrap().values
    }

    pub(super) fn each(mut self, tags: &[&str], change: impl Fn(usize, f64) -> f64) -> Self {
        for tag in tags {
            for (i, value) in self.column(tag).iter_mut().enumerate() {
                *value = change(i, *value);
            }
        }
        self
    }

    pub(super) fn swapped(mut self, a: &str, b: &str) -> Self {
        let one = std::mem::take(self.column(a));
        let other = std::mem::replace(self.column(b), one);
        *self.column(a) = other;
        self
    }

    /// What the description says, in other words.
    pub(super) fn saying(mut self, found: &str, instead: &str) -> Self {
        assert!(self.well.contains(found), "{found}");
        self.well = self.well.replace(found, instead);
        self
    }

    /// Every so many samples.
    pub(super) fn every(mut self, step: usize) -> Self {
        for column in &mut self.table.columns {
            column.values = column.values.iter().copied().step_by(step).collect();
        }
        self
    }

    pub(super) fn set_up(&self) -> Bench {
        let bench = Bench::bare();
        bench.write("rig.mat", mat5(&self.table));
        bench.write("well.toml", &self.well);
        bench
    }

    pub(super) fn fit(&self) -> Ran {
        self.set_up().dgd("fit rig.mat --well well.toml --json")
    }

    /// `dgd fit`, which must give an answer.
    #[track_caller]
    pub(super) fn fitted(&self) -> Fitted {
        let ran = self.fit();
        let err = ran.err.clone();
        Fitted {
            json: serde_json::from_str(&ran.done()).unwrap(),
            err,
        }
    }

    /// `dgd simulate` with the sound recording's model.
    pub(super) fn simulate(&self) -> Ran {
        let bench = self.set_up();
        bench.write("sound.mat", mat5(&Self::sound().table));
        bench.write("sound.toml", WELL);
        bench.dgd("fit sound.mat --well sound.toml").done();
        bench.dgd("simulate rig.mat --well well.toml --model model.toml --json")
    }

    /// `dgd diagnose`, which must give an answer.
    #[track_caller]
    pub(super) fn diagnosed(&self) -> Diagnosed {
        let (_, ran) = self.diagnose();
        let err = ran.err.clone();
        Diagnosed {
            json: serde_json::from_str(&ran.done()).unwrap(),
            err,
        }
    }

    pub(super) fn diagnose(&self) -> (Bench, Ran) {
        let bench = self.set_up();
        let ran = bench.dgd("diagnose rig.mat --well well.toml --out d --json");
        (bench, ran)
    }
}

pub(super) struct Fitted {
    pub(super) json: Value,
    pub(super) err: String,
}

impl Fitted {
    pub(super) fn delay_s(&self) -> f64 {
        self.json["delay"]["best_s"].as_f64().unwrap()
    }

    pub(super) fn warnings(&self) -> Vec<&str> {
        strings(&self.json["warnings"])
    }

    /// The model is the sound recording's: same delay within `slack_s`, friction at 0.05 m3/s within 3 %.
    #[track_caller]
    pub(super) fn right(&self, slack_s: f64) -> &Self {
        let sound = Rig::sound().fitted();
        assert!(
            (self.delay_s() - sound.delay_s()).abs() <= slack_s,
            "{:#}",
            self.json
        );
        let ratio = self.friction_pa() / sound.friction_pa();
        assert!((0.97..1.03).contains(&ratio), "{ratio}");
        self
    }

    pub(super) fn friction_pa(&self) -> f64 {
        let terms = self.json["model"]["friction"].as_array().unwrap();
        let term = |t: &Value| {
            let power: i32 = t["power"].as_u64().unwrap().try_into().unwrap();
            t["estimate"]["value"].as_f64().unwrap() * 0.05f64.powi(power)
        };
        terms.iter().map(term).sum()
    }

    /// One suspicion, told alike on the terminal and in JSON, at this line and with these words.
    #[track_caller]
    pub(super) fn suspects(&self, line: usize, parts: &[&str]) {
        suspicion(&self.warnings(), &self.err, line, parts);
    }

    #[track_caller]
    pub(super) fn warns(&self, part: &str) {
        let told = self.warnings();
        assert!(
            told.iter().any(|w| w.contains(part)),
            "`{part}` is not in: {told:#?}"
        );
    }

    #[track_caller]
    pub(super) fn suspects_nothing(&self) -> &Self {
        let told = self.warnings();
        assert!(
            told.iter().all(|w| !w.starts_with("well.toml:")),
            "{told:#?}"
        );
        self
    }
}

/// A diagnosis.
pub(super) struct Diagnosed {
    pub(super) json: Value,
    pub(super) err: String,
}

impl Diagnosed {
    /// One suspicion, told alike on the terminal and in JSON, at this line and with these words.
    #[track_caller]
    pub(super) fn suspects(&self, line: usize, parts: &[&str]) {
        suspicion(&strings(&self.json["warnings"]), &self.err, line, parts);
    }

    /// Among the findings is this effect, with a parameter within so much of a value.
    #[track_caller]
    pub(super) fn finds(&self, effect: &str, parameter: &str, value: f64, slack: f64) -> &Self {
        let found = self.json["findings"].as_array().unwrap();
        let one = found.iter().find(|f| f["effect"] == effect);
        let one = one.unwrap_or_else(|| panic!("{effect} is not in {found:#?}"));
        let estimate = one["parameters"][parameter]["estimate"].as_f64().unwrap();
        assert!((estimate - value).abs() <= slack, "{effect}: {estimate}");
        self
    }

    /// What would show the same, by the effects of which there is something to be told.
    pub(super) fn same_as(&self) -> Vec<(&str, &str)> {
        let found = self.json["findings"].as_array().unwrap();
        (found.iter())
            .filter_map(|f| Some((f["effect"].as_str()?, f["same_as"].as_str()?)))
            .collect()
    }

    /// Every finding that is more likely there than not.
    pub(super) fn claimed(&self) -> Vec<&str> {
        self.found_at(0.5)
    }

    /// Every finding of that probability or more.
    pub(super) fn found_at(&self, probability: f64) -> Vec<&str> {
        let found = self.json["findings"].as_array().unwrap();
        let likely = |f: &&Value| f["probability"].as_f64().unwrap() >= probability;
        let likely = found.iter().filter(likely);
        likely.map(|f| f["effect"].as_str().unwrap()).collect()
    }
}

#[track_caller]
fn suspicion(told: &[&str], err: &str, line: usize, parts: &[&str]) {
    let place = format!("well.toml:{line}: ");
    let found: Vec<&&str> = told
        .iter()
        .filter(|w| w.starts_with("well.toml:"))
        .collect();
    assert_eq!(found.len(), 1, "{told:#?}");
    assert!(found[0].starts_with(&place), "{}", found[0]);
    for part in parts {
        assert!(found[0].contains(part), "`{part}` is not in: {}", found[0]);
    }
    assert!(err.contains(*found[0]), "{err}");
}

pub(super) fn strings(list: &Value) -> Vec<&str> {
    list.as_array()
        .unwrap()
        .iter()
        .map(|w| w.as_str().unwrap())
        .collect()
}

pub(super) const PRESSURES: [&str; 5] = ["PT1", "PT2", "PT3", "PT4", "PT5"];
pub(super) const CHANNELS: [&str; 10] = [
    "FT1", "FT2", "FT3", "FT4", "PT1", "PT2", "PT3", "PT4", "PT5", "SPM",
];

pub(super) fn line_of(part: &str) -> usize {
    WELL.lines().position(|l| l.contains(part)).unwrap() + 1
}
