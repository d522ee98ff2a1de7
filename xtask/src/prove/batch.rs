//! Runs many diagnoses, several at a time.

use super::exam::{self, Exam, Paper};
use std::io::{IsTerminal, Write};
use std::path::Path;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// Diagnoses all papers; results in their order, however many run at a time.
///
/// `what` says on standard error how they are diagnosed.
pub(crate) fn all(dgd: &Path, jobs: usize, papers: &[Paper], what: &str) -> Vec<Exam> {
    let time = exam::gnu_time();
    each(jobs, papers, what, |paper| {
        exam::sit(dgd, time.as_deref(), paper)
    })
}

/// `sit` of each item, `jobs` at a time; results in their order.
pub(crate) fn each<T: Sync, R: Send>(
    jobs: usize,
    items: &[T],
    what: &str,
    sit: impl Fn(&T) -> R + Sync,
) -> Vec<R> {
    let begun = Instant::now();
    let state = Mutex::new((0_usize, Vec::new()));
    let lock = || state.lock().unwrap_or_else(PoisonError::into_inner);
    let work = || {
        loop {
            let next = {
                let mut state = lock();
                state.0 += 1;
                state.0 - 1
            };
            let Some(item) = items.get(next) else {
                return;
            };
            let result = sit(item);
            let mut state = lock();
            state.1.push((next, result));
            progress(state.1.len(), items.len(), what, begun);
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..jobs.clamp(1, items.len().max(1)) {
            scope.spawn(work);
        }
    });
    let (_, mut results) = state.into_inner().unwrap_or_else(PoisonError::into_inner);
    results.sort_by_key(|(index, _)| *index);
    results.into_iter().map(|(_, result)| result).collect()
}

/// How far, and how long still, on standard error; one line that renews itself on a terminal.
fn progress(done: usize, of: usize, what: &str, begun: Instant) {
    let spent = begun.elapsed().as_secs_f64();
    let left = spent / done as f64 * (of - done) as f64;
    let mut to = std::io::stderr();
    let line = format!("{done} of {of} diagnosed{what}, {spent:.0} s, {left:.0} s to go");
    // Progress is a courtesy: nothing is lost if nobody listens.
    let _ = if to.is_terminal() {
        write!(to, "\r\x1b[2K{line}{}", if done == of { "\n" } else { "" })
    } else if done == of || done.is_multiple_of(10) {
        writeln!(to, "{line}")
    } else {
        Ok(())
    };
}
