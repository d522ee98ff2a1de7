//! The pump's speed at rest: what the outlet pressure says when it ends.

use super::window::Window;
use crate::scan::Steps;
use crate::screening::Rules;
use crate::speed::{self, Release};
use crate::stuck::Held;
use dgd_recording::Run;

/// Frozen runs of the speed, and what is known on the way to them.
#[derive(Debug)]
pub(super) struct Resting {
    on_above_pct: f64,
    floor: usize,
    /// So many missing samples in a row do not end a run.
    gap: usize,
    /// Samples in a window.
    window: usize,
    /// Smallest jump out of a frozen run, %.
    least: f64,
    /// Means of the last two windows.
    before: Vec<(f64, f64)>,
    /// The next window.
    next_window: usize,
    changes: Vec<(f64, f64)>,
    /// The next sample.
    next: usize,
    open: Option<Ended>,
    waiting: Vec<Ended>,
    releases: Vec<(Run, Release)>,
    frozen: Vec<Run>,
}

/// A run, with the mean outlet pressure at its start once that is known.
#[derive(Debug, Clone, Copy)]
struct Ended {
    held: Held,
    at_start: Option<Option<f64>>,
}

impl Resting {
    pub(super) fn new(rules: Rules<'_>) -> Self {
        Self {
            on_above_pct: rules.options.pump_on_above_pct,
            floor: rules.frozen_floor(),
            gap: rules.gap(),
            window: speed::window(rules.step_s),
            least: 0.0,
            before: Vec::new(),
            next_window: 0,
            changes: Vec::new(),
            next: 0,
            open: None,
            waiting: Vec::new(),
            releases: Vec::new(),
            frozen: Vec::new(),
        }
    }

    pub(super) fn begin(&mut self, steps: Steps) {
        self.least = speed::least(steps);
    }

    /// Takes the samples that are settled by now.
    pub(super) fn add(&mut self, at_hand: &Window, samples: usize, at_end: bool) {
        let Some((start, readings, outlet_pa)) = at_hand.speed() else {
            return;
        };
        let speed_pct = readings.speed_pct;
        let to = start + speed_pct.len();
        let window = self.window;
        while self.next_window < samples / window && (self.next_window + 1) * window <= to {
            let from = self.next_window * window - start;
            let means = speed::means(readings, outlet_pa, from..from + window);
            if let [two_ago, _] = self.before[..] {
                self.changes
                    .extend(speed::change(two_ago, means, self.least));
                self.before.remove(0);
            }
            self.before.push(means);
            self.next_window += 1;
        }
        for i in self.next..to {
            let value = speed_pct[i - start];
            let gap = self.gap;
            let open = self.open.as_mut();
            if let Some(open) = open.and_then(|open| open.held.goes_on(value, gap).then_some(open))
            {
                let run = open.held.run;
                if open.at_start.is_none() && run.length >= 2 * window {
                    let from = run.start - start;
                    open.at_start = Some(speed::at_start(outlet_pa, from, 2 * window, window));
                }
                continue;
            }
            let new = Ended {
                held: Held::at(i, value),
                at_start: None,
            };
            let ended = self.open.replace(new);
            if let Some(mut ended) = ended.filter(|ended| self.counts(&ended.held)) {
                let run = ended.held.run;
                if run.length < 2 * window {
                    let from = run.start - start;
                    let at_start = speed::at_start(outlet_pa, from, run.length, window);
                    ended.at_start = Some(at_start);
                }
                self.waiting.push(ended);
            }
        }
        self.next = self.next.max(to);
        let (least, releases) = (self.least, &mut self.releases);
        self.waiting.retain(|Ended { held, at_start }| {
            let run = &held.run;
            let end = run.start + run.length;
            if !at_end && end + 2 * window > to {
                return true;
            }
            // The samples at hand begin later than the run.
            let here = Run {
                start: 0,
                length: end - start,
                ..*run
            };
            let release = Release::of(readings, outlet_pa, &here, window, least, || {
                at_start.flatten()
            });
            releases.extend(release.map(|release| (*run, release)));
            false
        });
    }

    fn counts(&self, held: &Held) -> bool {
        let value = held.run.value;
        held.told >= self.floor && value.is_finite() && value > self.on_above_pct
    }

    /// The first sample that is still to be looked at.
    pub(super) fn needed(&self, to: usize) -> usize {
        let waiting = self
            .waiting
            .iter()
            .map(|w| w.held.run.start + w.held.run.length);
        let first = waiting.fold(to, usize::min);
        first
            .saturating_sub(2 * self.window + self.gap)
            .min(self.next_window * self.window)
    }

    /// Ends the pass.
    pub(super) fn know_frozen(&mut self) {
        let changes = std::mem::take(&mut self.changes);
        let Some(answer) = speed::answer(&changes) else {
            return;
        };
        let releases = std::mem::take(&mut self.releases).into_iter();
        let frozen = releases.filter(|(_, release)| release.tells(answer).is_some());
        self.frozen = frozen.map(|(run, _)| run).collect();
    }

    pub(super) fn frozen(&self) -> &[Run] {
        &self.frozen
    }
}
