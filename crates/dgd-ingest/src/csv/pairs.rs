//! Texts in which each value has its own time beside it, as spreadsheets get them from historians: time, value, time, value.

use super::layout::Head;
use super::readings::Readings;
use super::rows::Rows;
use super::stamp::StampKind;
use crate::IngestError;
use crate::tags::tell_columns_apart;
use dgd_recording::{Column, Issue, Table, rfc3339};

/// Where each pair has its time; the value is behind it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Pairs {
    times: Vec<usize>,
}

impl Pairs {
    /// The pairs of a text of nothing else, if it has two or more.
    ///
    /// - `kinds`: what the times of each column are.
    pub(super) fn of(
        heads: &[Head],
        kinds: &[Option<StampKind>],
        numeric: &[bool],
    ) -> Option<Self> {
        let used = heads
            .iter()
            .zip(numeric)
            .rposition(|(head, numeric)| head.named || *numeric)?
            + 1;
        let is_time = |index: usize| {
            let dated = matches!(kinds[index], Some(StampKind::DateTime { .. }));
            heads[index].stamps && dated
        };
        let is_value = |index: usize| numeric[index] && !heads[index].stamps;
        let times: Vec<usize> = (0..used).step_by(2).collect();
        let are_pairs = used % 2 == 0 && times.iter().all(|at| is_time(*at) && is_value(at + 1));
        (are_pairs && times.len() > 1).then_some(Self { times })
    }

    /// The table of rows that were read, with a column a pair, on one clock.
    ///
    /// # Errors
    /// [`IngestError`] if most readings have the time of another, or for too many stamps of so many pairs in so many `bytes`.
    pub(super) fn beside_each_other(
        &self,
        rows: &Rows,
        mut issues: Vec<Issue>,
        bytes: usize,
    ) -> Result<Table, IngestError> {
        let columns = &rows.columns;
        issues.extend(rows.issues());
        let told = columns.iter().flat_map(|column| column.issues(rows.points));
        issues.extend(told);
        let origins = self
            .times
            .iter()
            .filter_map(|at| columns[*at].clock.origin());
        let origin = origins.min();
        let began_ns = origin.map_or(0, |(ns, _)| ns);
        // Each column of times counts from its own first.
        let after_s = |at: usize| {
            let first = columns[at].clock.origin();
            first.map_or(0.0, |(ns, _)| ns.saturating_sub(began_ns) as f64 / 1e9)
        };
        let times = |at: usize| columns[at].values.iter().map(move |t| t + after_s(at));
        let first = self
            .times
            .iter()
            .flat_map(|at| times(*at))
            .fold(f64::INFINITY, f64::min);
        let mut readings = Readings::new(self.times.len(), &[first]);
        let mut names = Vec::new();
        for (pair, at) in self.times.iter().enumerate() {
            let (time, value) = (&columns[*at].head, &columns[at + 1].head);
            // Where only one is named, it is the time.
            names.push(if value.named {
                value.written.clone()
            } else {
                time.written.clone()
            });
            for (t, v) in times(*at).zip(&columns[at + 1].values) {
                // Pairs are as long as they have readings.
                if t.is_finite() || v.is_finite() {
                    readings.add(Some(pair), t, *v);
                }
            }
        }
        let told = readings.onto_one_clock(&names, "s");
        issues.extend(told.ok_or_else(|| IngestError::NotTabular {
            place: format!("column `{}`", columns[self.times[0]].head.tag),
            reason: "most readings have the time of another of the same column".into(),
            mend: "export each reading once".into(),
        })?);
        readings.check(bytes)?;
        // Its name is that of the first times, unless that is the name of their values.
        let mut values = self.times.iter().map(|at| &columns[at + 1].head);
        let clock = match values.all(|head| head.named) {
            true => columns[self.times[0]].head.tag.clone(),
            false => "time".to_owned(),
        };
        let mut table = Table {
            columns: vec![Column {
                tag: clock,
                unit: Some("s".into()),
                values: readings.stamps(),
            }],
            origin: origin.map(|(ns, zoned)| rfc3339(ns, zoned)),
            clock: Some(0),
            issues,
        };
        let units = self
            .times
            .iter()
            .map(|at| columns[at + 1].head.unit.clone());
        let named = names.into_iter().zip(units).zip(readings.columns());
        table
            .columns
            .extend(named.map(|((tag, unit), values)| Column { tag, unit, values }));
        table.issues.extend(tell_columns_apart(&mut table.columns));
        Ok(table)
    }
}
