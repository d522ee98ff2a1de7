//! Messages to columns, topic by topic.

use super::json;
use crate::IngestError;
use crate::nulls::Nulls;
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
    /// What its channel calls the clock.
    pub(super) named_clock: Option<String>,
    /// Whether its log times are of UTC.
    pub(super) zoned: bool,
    pub(super) log_ns: Vec<u64>,
    /// What [`Stream::settle`] let go of.
    settled: Settled,
    pub(super) members: Vec<Member>,
    index: HashMap<Vec<u8>, usize>,
    /// Members of the message being read.
    row: Vec<(usize, f64)>,
    pub(super) refused: u64,
    /// Sequence number and byte of the first message that is no JSON.
    pub(super) first_refused: Option<(u64, usize)>,
    pub(super) cut_arrays: u64,
}

/// Messages whose values are no longer held.
#[derive(Debug, Default)]
struct Settled {
    messages: usize,
    /// Log times of the first and the last one.
    ends_ns: Option<(u64, u64)>,
    /// Messages that came too early.
    backward: usize,
}

/// One numeric member.
#[derive(Debug)]
pub(super) struct Member {
    pub(super) path: Vec<u8>,
    pub(super) values: Vec<f64>,
    /// Whether a message that was not refused had it, among those that are settled.
    met: bool,
    pub(super) nulls: Nulls,
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
            zoned: true,
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
                    met: false,
                    nulls: Nulls::default(),
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
                let count = self.messages() as u64 + self.refused;
                self.first_refused.get_or_insert((count + 1, byte));
                self.refused += 1;
                return Ok(());
            }
        }
        let rows = self.log_ns.len();
        let number = self.messages() as u64 + 1;
        for (at, value) in &self.row {
            let Member { values, nulls, .. } = &mut self.members[*at];
            budget.spend(rows + 1 - values.len().min(rows + 1))?;
            values.resize(rows, f64::NAN);
            values.push(nulls.blank(*value, number));
        }
        self.log_ns.push(log_ns);
        Ok(())
    }

    /// Messages that were not refused.
    pub(super) fn messages(&self) -> usize {
        self.settled.messages + self.log_ns.len()
    }

    /// Log time of the first message.
    pub(super) fn first_ns(&self) -> Option<u64> {
        let settled = self.settled.ends_ns.map(|(first, _)| first);
        settled.or(self.log_ns.first().copied())
    }

    /// Tag of the column of log times: as its channel calls it, unless a member has that name.
    pub(super) fn clock_tag(&self) -> String {
        let named = self.named_clock.as_deref();
        let free = named.filter(|tag| self.met().all(|m| m.path != tag.as_bytes()));
        free.unwrap_or("t").to_owned()
    }

    /// Members that a message had that was not refused.
    pub(super) fn met(&self) -> impl Iterator<Item = &Member> {
        self.members
            .iter()
            .filter(|m| m.met || !m.values.is_empty())
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

    /// Lets the values go, and remembers that they were there.
    pub(super) fn settle(&mut self) {
        let (Some(first), Some(last)) = (self.log_ns.first(), self.log_ns.last()) else {
            return;
        };
        let settled = &mut self.settled;
        let (begin, before) = settled.ends_ns.unwrap_or((*first, *first));
        settled.backward += usize::from(*first < before) + backward(&self.log_ns);
        settled.ends_ns = Some((begin, *last));
        settled.messages += self.log_ns.len();
        self.log_ns.clear();
        for member in &mut self.members {
            member.met |= !member.values.is_empty();
            member.values.clear();
        }
    }

    /// Puts the messages in the order of their log times, unless that would mix two stretches of a clock that was set back.
    pub(super) fn sort(&mut self) -> Order {
        let backward = backward(&self.log_ns);
        let places = self.settled.backward + backward;
        if backward == 0 {
            return if places == 0 {
                Order::AsLogged
            } else {
                Order::Sorted(places)
            };
        }
        let mut order: Vec<usize> = (0..self.log_ns.len()).collect();
        order.sort_by_key(|i| self.log_ns[*i]);
        let shared = order.windows(2).filter(|pair| {
            self.log_ns[pair[0]] == self.log_ns[pair[1]] && pair[1].abs_diff(pair[0]) > STRETCH
        });
        if shared.count() > STRETCH {
            return Order::SetBack(places);
        }
        self.log_ns = order.iter().map(|i| self.log_ns[*i]).collect();
        for member in &mut self.members {
            member.values = order.iter().map(|i| member.values[*i]).collect();
        }
        Order::Sorted(places)
    }
}

/// How the messages of a stream came, and in how many places backwards.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Order {
    AsLogged,
    Sorted(usize),
    /// Two stretches share one time: they are left as they came, so that whoever reads the clock can tell.
    SetBack(usize),
}

/// Messages that share their times with others farther away than this, and more than so many, are a stretch.
const STRETCH: usize = 10;

fn backward(log_ns: &[u64]) -> usize {
    log_ns.windows(2).filter(|w| w[1] < w[0]).count()
}

impl Budget {
    /// Whether so many rows of so many members are within what the messages may say.
    pub(super) fn check(&self, rows: usize, members: usize) -> Result<(), IngestError> {
        let cells = (rows as u64).saturating_mul(members as u64);
        Self { cells, ..*self }.spend(0)
    }

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
