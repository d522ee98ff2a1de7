//! A recording's columns by tag, as the windows of a system.

mod doubts;

use super::{Gauge, failed, file_name, gauges};
use crate::failure::Failure;
use crate::load;
use crate::progress::Progress;
use crate::say::counted;
use dgd_assembly::{Assembly, HeldOut, Portion, Record, Window};
use dgd_recording::{Column, Table};
use dgd_units::{Dimension, Unit};
use std::borrow::Cow;
use std::path::Path;

/// A recording cut into the windows of a system.
pub(crate) struct Recorded {
    pub(crate) train: Vec<Window>,
    pub(crate) test: Vec<HeldOut>,
    /// What was wrong in the file and lived with.
    pub(crate) issues: Vec<String>,
    /// Why nothing can be fitted to it, where no instrument has a column.
    unread: Option<Failure>,
}

impl Recorded {
    /// Samples in all windows.
    pub(crate) fn samples(&self) -> usize {
        let all = self.train.iter().chain(self.test.iter().map(|t| &t.window));
        all.map(|w| w.time.len()).sum()
    }

    /// Itself, if an instrument has a column to be fitted to.
    pub(crate) fn measured(mut self) -> Result<Self, Failure> {
        self.unread.take().map_or(Ok(self), Err)
    }
}

/// Reads a recording of any format; only the columns that the system names count.
pub(crate) fn read(
    path: &Path,
    system: &Path,
    assembly: &Assembly,
    progress: &Progress,
) -> Result<Recorded, Failure> {
    let (table, untimed) = timed(table(path, progress)?, path, assembly);
    let files = Files {
        path,
        system,
        assembly,
        table: &table,
    };
    let train = files.windows(Portion::Train)?;
    let test = files.windows(Portion::Test)?;
    let doubts = files.doubts(&train, &test);
    let whole = if assembly.holds_out_of_one_run() && !test.is_empty() {
        files.windows(Portion::All)?.into_iter().next()
    } else {
        None
    };
    let test = test
        .into_iter()
        .map(|window| HeldOut::new(window, whole.as_ref(), &train))
        .collect();
    Ok(Recorded {
        unread: files.unread(),
        train,
        test,
        issues: (table.issues.iter().map(ToString::to_string))
            .chain(untimed)
            .chain(doubts)
            .collect(),
    })
}

/// A recording of any format, with what was wrong in it told.
fn table(path: &Path, progress: &Progress) -> Result<Table, Failure> {
    let (_, table) = load::read_table(path, progress)?;
    for issue in &table.issues {
        tracing::warn!("{}: {issue}", path.display());
    }
    Ok(table)
}

/// The rows that have a time, without which the others say nothing; and how many have none, in a sentence.
fn timed(mut table: Table, path: &Path, assembly: &Assembly) -> (Table, Option<String>) {
    let stamps = (assembly.system().record.time.as_deref()).and_then(|tag| table.column(tag));
    let Some(stamps) = stamps else {
        return (table, None);
    };
    let has: Vec<bool> = stamps.values.iter().map(|t| t.is_finite()).collect();
    let without = has.iter().filter(|has| !**has).count();
    if without == 0 {
        return (table, None);
    }
    let said = format!(
        "left out {} without a value of `{}`",
        counted(without, "row"),
        stamps.tag
    );
    tracing::warn!("{}: {said}", path.display());
    for column in &mut table.columns {
        let mut kept = has.iter();
        column.values.retain(|_| kept.next().is_none_or(|has| *has));
    }
    (table, Some(said))
}

/// A recording's columns of both parts.
pub(crate) struct Whole {
    /// Those that the system names, under the names it knows them by.
    pub(crate) columns: Vec<(String, Vec<f64>)>,
    /// What was wrong in the file and lived with.
    pub(crate) issues: Vec<String>,
}

/// Reads a recording of any format whole; one in which no instrument moves is refused.
pub(crate) fn whole(
    path: &Path,
    system: &Path,
    assembly: &Assembly,
    progress: &Progress,
) -> Result<Whole, Failure> {
    let (table, untimed) = timed(table(path, progress)?, path, assembly);
    let files = Files {
        path,
        system,
        assembly,
        table: &table,
    };
    let mut columns = files.named(Portion::Train)?;
    files.unread().map_or(Ok(()), Err)?;
    if assembly.system().record.test.is_some() {
        for (name, values) in files.named(Portion::Test)? {
            if !columns.iter().any(|c| c.0 == name) {
                columns.push((name, values));
            }
        }
    }
    let record = Record {
        columns: columns.iter().map(|(n, v)| (n.as_str(), &**v)).collect(),
    };
    // What cannot be cut into windows is refused where they are used.
    let cut = |portion| assembly.windows(&record, portion).unwrap_or_default();
    let (train, test) = (cut(Portion::Train), cut(Portion::Test));
    let doubts = files.doubts(&train, &test);
    if doubts::all_dead(&files, &train) {
        return Err(Failure::Input {
            path: path.to_owned(),
            reason: "no instrument changes in the fitted part, so no cause can be identified"
                .into(),
            help: Some(
                "check that the transmitters were live, and that the channels are the right ones"
                    .into(),
            ),
        });
    }
    let issues = table.issues.iter().map(ToString::to_string);
    Ok(Whole {
        issues: issues.chain(untimed).chain(doubts).collect(),
        columns,
    })
}

struct Files<'a> {
    path: &'a Path,
    system: &'a Path,
    assembly: &'a Assembly,
    table: &'a Table,
}

impl Files<'_> {
    fn windows(&self, portion: Portion) -> Result<Vec<Window>, Failure> {
        if portion == Portion::Test && self.assembly.system().record.test.is_none() {
            return Ok(Vec::new());
        }
        let columns = self.named(portion)?;
        let record = Record {
            columns: columns.iter().map(|(n, v)| (n.as_str(), &**v)).collect(),
        };
        self.assembly
            .windows(&record, portion)
            .map_err(|e| failed(self.system, self.path, &e))
    }

    /// What the samples leave in doubt, warned of.
    fn doubts(&self, train: &[Window], test: &[Window]) -> Vec<String> {
        let doubts = doubts::of(self, train, test);
        for doubt in &doubts {
            tracing::warn!("{}: {doubt}", self.path.display());
        }
        doubts
    }

    /// The column that stands for a channel in a part.
    fn stands_for<'a>(&'a self, portion: Portion, channel: &'a str) -> &'a str {
        let named = self.assembly.system().record.channels(portion);
        named.get(channel).map_or(channel, String::as_str)
    }

    /// The columns that a part of the recording is made of.
    fn named(&self, portion: Portion) -> Result<Vec<(String, Vec<f64>)>, Failure> {
        let layout = &self.assembly.system().record;
        let name = match portion {
            Portion::Test => "record.test",
            Portion::Train | Portion::All => "record.train",
        };
        // Both parts are told of what they lack, units once.
        let first = portion == Portion::Train;
        let mut columns: Vec<(String, Vec<f64>)> = Vec::new();
        let mut add = |name: &str, values: &[f64]| {
            if !columns.iter().any(|c| c.0 == name) {
                columns.push((name.to_owned(), values.to_vec()));
            }
        };
        if let Some(time) = &layout.time {
            let found = self.found(time, "the time", "`time` under [record]")?;
            // A clock is converted; along a depth, say, the file and the record must agree.
            if first && self.assembly.system().independent != "time" {
                self.check_unit(found, layout.unit.as_deref(), "[record]");
            }
            add(time, &self.on_the_clock(found));
        } else if layout.step.is_none() && self.assembly.system().independent == "time" {
            return Err(self.untimed());
        }
        for (path, input) in &self.assembly.system().inputs {
            let wanted = self.stands_for(portion, &input.channel);
            let mend =
                format!("`channel` of \"{path}\" under [inputs], or `channels` under [{name}]");
            let found = self.found(wanted, &format!("the input `{path}`"), &mend)?;
            if first {
                self.check_unit(found, input.unit.as_deref(), path);
            }
            add(wanted, &found.values);
        }
        for gauge in gauges(self.assembly) {
            let wanted = self.stands_for(portion, &gauge.channel);
            let Some(found) = self.table.column(wanted) else {
                if portion != Portion::All {
                    tracing::warn!(
                        "{}: no column `{wanted}`, so `{}` counts as not recorded in [{name}]; it has {}: set `channel` of `{}` under [components], \
                         or `channels` under [{name}], in {}",
                        self.path.display(),
                        gauge.name,
                        self.tags(),
                        gauge.name,
                        self.system.display()
                    );
                }
                continue;
            };
            if first {
                self.check_gauge(found, &gauge);
            }
            add(wanted, &found.values);
        }
        if columns.is_empty() {
            return Err(Failure::input(
                self.path,
                format!("has no column named in {}", self.system.display()),
            ));
        }
        Ok(columns)
    }

    /// The system does not tell when the samples were taken: a step of 1 s would only be a guess.
    fn untimed(&self) -> Failure {
        let clock = (self.table.clock)
            .or_else(|| dgd_recording::survey(self.table).time_column)
            .and_then(|index| self.table.columns.get(index));
        let step = "`step` there to the seconds between samples";
        let help = clock.map_or_else(
            || format!("set {step}, or `time` to the column of times"),
            |column| {
                let [tag, file] = [column.tag.clone(), file_name(self.path)];
                format!(
                    "set `time = \"{tag}\"` there, which looks like the times of {file}, or {step}"
                )
            },
        );
        Failure::Input {
            path: self.system.to_owned(),
            reason: "has neither `time` nor `step` under [record], so it does not tell when the samples were taken".into(),
            help: Some(help),
        }
    }

    fn found(&self, tag: &str, what: &str, mend: &str) -> Result<&Column, Failure> {
        self.table.column(tag).ok_or_else(|| Failure::Input {
            path: self.path.to_owned(),
            reason: format!("has no column `{tag}` for {what}; it has {}", self.tags()),
            help: Some(format!("set {mend} in {}", self.system.display())),
        })
    }

    /// The columns of the file, the first of many.
    fn tags(&self) -> String {
        const SHOWN: usize = 20;
        let tags = self.table.columns.iter().map(|c| c.tag.as_str());
        let mut known = tags.take(SHOWN).collect::<Vec<_>>().join(", ");
        if self.table.columns.len() > SHOWN {
            known.push_str(", ...");
        }
        known
    }

    /// Where there are instruments and none has a column in what is fitted: nothing is left to compare.
    fn unread(&self) -> Option<Failure> {
        let all = gauges(self.assembly);
        let wanted = |g: &Gauge| self.stands_for(Portion::Train, &g.channel).to_owned();
        if all.is_empty() || all.iter().any(|g| self.table.column(&wanted(g)).is_some()) {
            return None;
        }
        let each = all
            .iter()
            .map(|g| format!("`{}` for `{}`", wanted(g), g.name));
        let missing = each.collect::<Vec<_>>().join(", ");
        let system = self.system.display();
        Some(Failure::Input {
            path: self.path.to_owned(),
            reason: format!(
                "has no column of any instrument: {missing}; it has {}",
                self.tags()
            ),
            help: Some(format!(
                "set `channel` of the instruments under [components], or `channels` under [record.train], in {system}"
            )),
        })
    }

    /// Times of the file in the unit that the record counts in, where the file says another.
    fn on_the_clock<'c>(&self, column: &'c Column) -> Cow<'c, [f64]> {
        let unit = column.unit.as_deref().and_then(|u| Unit::parse(u).ok());
        let in_time = self.assembly.system().independent == "time";
        let time = unit.filter(|u| in_time && u.dimension == Dimension::Time);
        let Some(file) = time else {
            return Cow::Borrowed(&column.values);
        };
        let tick = self.assembly.tick_s();
        if file.factor == tick {
            return Cow::Borrowed(&column.values);
        }
        let values = column.values.iter();
        values.map(|v| file.to_si(*v) / tick).collect()
    }

    fn check_gauge(&self, column: &Column, gauge: &Gauge) {
        // A reading with a gain of its own is in no unit.
        if !gauge.symbol.is_empty() {
            self.check_unit(column, Some(&gauge.symbol), &gauge.name);
        }
    }

    /// Warns where the file says another unit than the system.
    fn check_unit(&self, column: &Column, said: Option<&str>, of: &str) {
        let (Some(written), Some(said)) = (column.unit.as_deref(), said) else {
            return;
        };
        let (Ok(file), Ok(system)) = (Unit::parse(written), Unit::parse(said)) else {
            return;
        };
        if file != system {
            tracing::warn!(
                "{}: column `{}` is written in {written}, `{of}` of {} reads it in {said}",
                self.path.display(),
                column.tag,
                self.system.display()
            );
        }
    }
}
