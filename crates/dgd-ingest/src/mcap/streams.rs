//! Messages to columns, topic by topic.

use super::json;
use crate::IngestError;
use std::collections::HashMap;

/// Members that the messages of a file may have, all topics together.
const MAX_MEMBERS: usize = 4096;
/// Cells a file may have beyond one for every two bytes of its messages: a member costs
/// at least that much where it stands, and NaN elsewhere must stay cheap.
const SPARE_CELLS: u64 = 1 << 20;

/// The numbers of one topic.
#[derive(Debug, Default)]
pub(super) struct Stream {
    pub(super) topic: String,
    pub(super) log_ns: Vec<u64>,
    pub(super) members: Vec<Member>,
    index: HashMap<Vec<u8>, usize>,
    /// Members of the message being read.
    row: Vec<(usize, f64)>,
    pub(super) refused: u64,
    /// Sequence number and byte of the first message that is no JSON.
    pub(super) first_refused: Option<(u64, usize)>,
    pub(super) cut_arrays: u64,
}

/// One numeric member.
#[derive(Debug)]
pub(super) struct Member {
    pub(super) path: Vec<u8>,
    pub(super) values: Vec<f64>,
}

/// What all streams together may take.
#[derive(Debug, Default)]
pub(super) struct Budget {
    members: usize,
    cells: u64,
    bytes: u64,
}

impl Stream {
    pub(super) fn new(topic: String) -> Self {
        Self {
            topic,
            ..Self::default()
        }
    }

    /// Adds a message, unless it is no JSON.
    ///
    /// # Errors
    /// [`IngestError::TooLarge`] if the budget is spent.
    pub(super) fn add(
        &mut self,
        log_ns: u64,
        message: &[u8],
        budget: &mut Budget,
    ) -> Result<(), IngestError> {
        budget.bytes += message.len() as u64 + 31;
        let Self {
            members,
            index,
            row,
            ..
        } = self;
        row.clear();
        let mut next = 0;
        let mut refused = false;
        let scanned = json::numbers(message, &mut |path, value| {
            // Messages of a topic name their members in one order.
            let at = match members.get(next) {
                Some(member) if member.path == path => Some(next),
                _ => index.get(path).copied(),
            };
            let at = at.or_else(|| {
                if budget.members == MAX_MEMBERS {
                    refused = true;
                    return None;
                }
                budget.members += 1;
                let at = members.len();
                index.insert(path.to_vec(), at);
                members.push(Member {
                    path: path.to_vec(),
                    values: Vec::new(),
                });
                Some(at)
            });
            if let Some(at) = at {
                next = at + 1;
                row.push((at, value));
            }
        });
        if refused {
            return Err(IngestError::TooLarge {
                what: format!("topic `{}`: the members of its messages", self.topic),
                claimed: MAX_MEMBERS as u64 + 1,
                limit: MAX_MEMBERS as u64,
            });
        }
        match scanned {
            Ok(cut) => self.cut_arrays += u64::from(cut),
            Err(byte) => {
                let count = self.log_ns.len() as u64 + self.refused;
                self.first_refused.get_or_insert((count + 1, byte));
                self.refused += 1;
                return Ok(());
            }
        }
        let rows = self.log_ns.len();
        for (at, value) in &self.row {
            let values = &mut self.members[*at].values;
            budget.spend(rows + 1 - values.len().min(rows + 1))?;
            values.resize(rows, f64::NAN);
            values.push(*value);
        }
        self.log_ns.push(log_ns);
        Ok(())
    }

    /// Fills short columns with NaN and drops the members of refused messages.
    pub(super) fn close(&mut self, budget: &mut Budget) -> Result<(), IngestError> {
        let rows = self.log_ns.len();
        self.members.retain(|m| !m.values.is_empty());
        for member in &mut self.members {
            budget.spend(rows - member.values.len())?;
            member.values.resize(rows, f64::NAN);
        }
        Ok(())
    }

    /// Puts the messages in the order of their log times; returns how many came too early.
    pub(super) fn sort(&mut self) -> usize {
        let backward = self.log_ns.windows(2).filter(|w| w[1] < w[0]).count();
        if backward > 0 {
            let mut order: Vec<usize> = (0..self.log_ns.len()).collect();
            order.sort_by_key(|i| self.log_ns[*i]);
            self.log_ns = order.iter().map(|i| self.log_ns[*i]).collect();
            for member in &mut self.members {
                member.values = order.iter().map(|i| member.values[*i]).collect();
            }
        }
        backward
    }
}

impl Budget {
    fn spend(&mut self, cells: usize) -> Result<(), IngestError> {
        self.cells += cells as u64;
        let limit = self.bytes / 2 + SPARE_CELLS;
        if self.cells <= limit {
            return Ok(());
        }
        Err(IngestError::TooLarge {
            what: "the table of all members at all messages".into(),
            claimed: self.cells,
            limit,
        })
    }
}
