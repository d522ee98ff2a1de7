//! A progress line for work that takes over a second.

use crate::args::Global;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde_json::{Map, Value};
use std::cell::RefCell;
use std::time::{Duration, Instant};

/// Shows the present stage once the work has taken a second; silent when
/// standard error is no terminal.
pub(crate) struct Progress {
    bar: ProgressBar,
    started: Instant,
    /// Name and start of each kind of stage, in order.
    stages: RefCell<Vec<(&'static str, f64)>>,
}

impl Progress {
    /// Shows nothing under `--json` and `--quiet`, nor under `--verbose`, which tells of each stage in a line of its own.
    pub(crate) fn new(global: &Global) -> Self {
        let bar = ProgressBar::new_spinner();
        bar.set_draw_target(ProgressDrawTarget::hidden());
        let style = ProgressStyle::with_template("{spinner} {elapsed:>4} {wide_msg}");
        bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_spinner()));
        if !(global.json || global.quiet || global.verbose > 0) {
            // Drawn from a thread of its own, so that a stage needs no ticking.
            let later = bar.clone();
            std::thread::spawn(move || {
                std::thread::sleep(Duration::from_secs(1));
                if !later.is_finished() {
                    later.set_draw_target(ProgressDrawTarget::stderr());
                    later.enable_steady_tick(Duration::from_millis(120));
                }
            });
        }
        Self {
            bar,
            started: Instant::now(),
            stages: RefCell::default(),
        }
    }

    /// Says what is being done; `kind` is what its time is booked under.
    pub(crate) fn stage(&self, kind: &'static str, what: &str) {
        let now = self.seconds();
        tracing::info!("{now:.1} s: {kind} {what}");
        self.stages.borrow_mut().push((kind, now));
        self.bar.set_message(format!("{kind} {what}"));
    }

    /// Seconds spent in each kind of stage so far.
    pub(crate) fn seconds_by_stage(&self) -> Value {
        let stages = self.stages.borrow();
        let ends = stages
            .iter()
            .skip(1)
            .map(|(_, start)| *start)
            .chain([self.seconds()]);
        let mut spent: Map<String, Value> = Map::new();
        for ((kind, start), end) in stages.iter().zip(ends) {
            let before = spent.get(*kind).and_then(Value::as_f64).unwrap_or(0.0);
            spent.insert((*kind).to_owned(), Value::from(before + end - start));
        }
        Value::Object(spent)
    }

    /// Seconds since the start.
    pub(crate) fn seconds(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
