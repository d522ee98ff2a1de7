//! The survey of a clock, in passes over stamps that are not held.

use super::{ClockError, ClockSurvey, Gap, ON_CLOCK};
use crate::survey::Selection;

/// An even clock longer than this many times the samples is a broken clock, not a gap.
const MOST_STEPS_A_SAMPLE: f64 = 20.0;
/// Short recordings may have proportionally longer gaps.
const STEPS_ALWAYS_ALLOWED: f64 = 100_000.0;

/// The longest even clock that so many samples may lie on.
pub(crate) fn most_steps(samples: usize) -> f64 {
    STEPS_ALWAYS_ALLOWED.max(MOST_STEPS_A_SAMPLE * samples as f64)
}

/// One odd step in so many is no jitter.
const ODD_STEPS: usize = 1000;
/// Where more than one sample in so many shares its step with another, the step is wrong.
const MOST_CROWDED: usize = 20;
/// Steps that are held at a time to find their median.
const HELD: usize = 1 << 17;

/// The survey of stamps, s, that come in the order of the file, again on every pass.
#[derive(Debug)]
pub(crate) struct ClockPasses {
    samples: usize,
    even: Even,
    order: Order,
    /// Stamps held to be put in order; nothing else is held.
    held: Vec<f64>,
    stage: Stage,
    /// The stamp before, where it is of the same pass.
    last: Option<f64>,
    median: Selection,
    near: Near,
    fit: Fit,
    found: Option<Result<ClockSurvey, ClockError>>,
}

/// What is looked for in a pass.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Stage {
    /// Whether the stamps are in order, and what they are.
    Order,
    /// All stamps, for they are not.
    Hold,
    /// The median of their steps.
    Median,
    /// The steps near it.
    Near,
    /// How the stamps sit on the even clock.
    Fit,
}

/// Stamps that are whole seconds and all one step apart, as most are: nothing is left to look for.
#[derive(Debug, Default)]
pub(super) struct Even {
    ends_s: Option<(f64, f64)>,
    step_s: Option<f64>,
    broken: bool,
}

/// What stamps are there, and in which order.
#[derive(Debug, Default)]
struct Order {
    missing: usize,
    backward: usize,
    /// The stamp behind which the clock goes back furthest, and how far.
    back: Option<(f64, f64)>,
    duplicates: usize,
    first: Option<f64>,
    last: f64,
    /// Steps that are longer than none, and their sum, s.
    steps: usize,
    forward_s: f64,
    /// The longest step, of equals the last, and the stamp before it.
    jump: Option<(f64, f64)>,
    /// Samples of this stamp so far.
    shared: usize,
    /// How many samples share a stamp as a rule: what is told by most, and by how many more than by others (Boyer and Moore's vote).
    usual: (usize, usize),
}

/// The steps around the median.
#[derive(Debug, Default)]
struct Near {
    median_s: f64,
    odd: usize,
    sum: f64,
    count: f64,
    /// Of a half, a third and so on of the median: steps that are no multiples of it, and steps of just it.
    parts: [(usize, usize); PARTS.len()],
}

/// Parts of the median step that rows which come irregularly may be multiples of.
const PARTS: [f64; 4] = [2.0, 3.0, 4.0, 5.0];

/// Stamps on an even clock.
#[derive(Debug, Default)]
struct Fit {
    step_s: f64,
    jitter_s: f64,
    /// Stamps that are so little after the one before that the two are one.
    repeats: usize,
    /// Stamps on the step of the one before that are none of these.
    crowded: usize,
    gaps: Vec<Gap>,
}

impl ClockPasses {
    /// For so many samples.
    pub(crate) fn new(samples: usize) -> Self {
        Self {
            samples,
            even: Even::default(),
            order: Order::default(),
            held: Vec::new(),
            stage: Stage::Order,
            last: None,
            median: Selection::new(HELD),
            near: Near::default(),
            fit: Fit::default(),
            found: None,
        }
    }

    /// Takes the next stamps.
    pub(crate) fn add(&mut self, stamps: &[f64]) {
        match self.stage {
            Stage::Order => self.even.add(stamps),
            Stage::Hold => {
                self.held
                    .extend(stamps.iter().filter(|stamp| stamp.is_finite()));
                return;
            }
            _ => {}
        }
        stamps.iter().for_each(|stamp| self.add_one(*stamp));
    }

    fn add_one(&mut self, stamp: f64) {
        if !stamp.is_finite() {
            self.order.missing += usize::from(self.stage == Stage::Order);
            return;
        }
        let from = self.last.replace(stamp);
        match self.stage {
            Stage::Order => self.order.add(from, stamp),
            Stage::Fit => self.fit.add(from, stamp, self.order.first.unwrap_or(stamp)),
            _ => {}
        }
        let Some(step) = from.map(|from| stamp - from).filter(|step| *step > 0.0) else {
            return;
        };
        match self.stage {
            Stage::Order | Stage::Median => self.median.add(step),
            Stage::Near => self.near.add(step),
            _ => {}
        }
    }

    /// Ends a pass; says whether the stamps must come again.
    pub(crate) fn next_pass(&mut self) -> bool {
        self.last = None;
        match self.stage {
            Stage::Order => {
                if let Some(sound) = self.even.sound() {
                    return self.end(Ok(sound));
                }
                if self.order.backward > 0 && self.order.coarse().is_none() {
                    self.stage = Stage::Hold;
                    return true;
                }
                if let Some(error) = self.order.coarse() {
                    return self.end(Err(error));
                }
                if self.order.steps == 0 {
                    return self.end(Err(ClockError::TooFew {
                        found: usize::from(self.order.first.is_some()),
                        samples: self.samples,
                    }));
                }
                self.stage = Stage::Median;
                self.next_median()
            }
            Stage::Hold => {
                let found = self.in_order();
                self.end(found)
            }
            Stage::Median => self.next_median(),
            Stage::Near => {
                self.fit.step_s = self.near.step_s(&self.order);
                match self.jump(self.fit.step_s) {
                    Some(error) => self.end(Err(error)),
                    None => {
                        self.stage = Stage::Fit;
                        true
                    }
                }
            }
            Stage::Fit => {
                // Rows that come every one to three seconds have no mean step.
                if self.fit.crowded > self.samples / MOST_CROWDED
                    && let Some(step_s) = self.near.part_s(&self.order)
                    && step_s < self.fit.step_s
                    && self.jump(step_s).is_none()
                {
                    self.fit = Fit {
                        step_s,
                        ..Fit::default()
                    };
                    return true;
                }
                let fitted = self.fitted();
                self.end(Ok(fitted))
            }
        }
    }

    /// What was found, once no other pass is needed.
    ///
    /// # Errors
    /// Those of [`super::survey_clock`].
    pub(crate) fn finish(self) -> Result<ClockSurvey, ClockError> {
        let samples = self.samples;
        // A caller that stopped early has no stamps that are known.
        self.found
            .unwrap_or(Err(ClockError::TooFew { found: 0, samples }))
    }

    fn end(&mut self, found: Result<ClockSurvey, ClockError>) -> bool {
        self.found = Some(found);
        false
    }

    fn next_median(&mut self) -> bool {
        if !self.median.next_pass() {
            self.near.median_s = self.median.found().unwrap_or(f64::NAN);
            self.stage = Stage::Near;
        }
        true
    }

    /// The survey of the stamps that are held, in order.
    fn in_order(&mut self) -> Result<ClockSurvey, ClockError> {
        let mut held = std::mem::take(&mut self.held);
        held.sort_by(f64::total_cmp);
        let mut sorted = Self::new(self.samples);
        loop {
            sorted.add(&held);
            if !sorted.next_pass() {
                break;
            }
        }
        let mut found = sorted.finish()?;
        found.missing = self.order.missing;
        found.backward = self.order.backward;
        found.furthest_back_s = self.order.back;
        found.even = false;
        Ok(found)
    }

    /// The jump that makes an even clock of this step implausibly long, if there is one.
    fn jump(&self, step_s: f64) -> Option<ClockError> {
        let first = self.order.first?;
        let span_s = self.order.last - first;
        let steps = span_s / step_s;
        let most = most_steps(self.samples);
        // Stamps near the ends of f64 overflow the span: then there is no count at all.
        (steps.is_nan() || steps > most).then(|| ClockError::Jump {
            span_s,
            step_s,
            steps,
            samples: self.samples,
            jump_s: self.order.jump.map_or(first, |(from, _)| from),
        })
    }

    fn fitted(&mut self) -> ClockSurvey {
        let Fit {
            step_s,
            jitter_s,
            repeats,
            crowded,
            gaps,
        } = std::mem::take(&mut self.fit);
        let order = &self.order;
        let duplicates = order.duplicates + repeats;
        let sound = order.missing + duplicates + order.backward == 0 && gaps.is_empty();
        ClockSurvey {
            step_s,
            span_s: (order.first.unwrap_or(order.last), order.last),
            missing: order.missing,
            duplicates,
            crowded,
            backward: order.backward,
            furthest_back_s: order.back,
            jitter_s,
            even: sound && jitter_s <= ON_CLOCK * step_s,
            gaps,
        }
    }
}

impl Even {
    pub(super) fn add(&mut self, stamps: &[f64]) {
        let (Some(first), Some(last)) = (stamps.first(), stamps.last()) else {
            return;
        };
        let before = self.ends_s.map(|(_, last)| last);
        let step = match (before, stamps) {
            (Some(before), _) => Some(first - before),
            (None, [first, second, ..]) => Some(second - first),
            _ => None,
        };
        let step_s = self.step_s.or(step).unwrap_or(f64::NAN);
        let joins = before.is_none_or(|before| first - before == step_s);
        let even = stamps.windows(2).all(|w| w[1] - w[0] == step_s);
        self.broken |= !(joins && even);
        self.step_s = self.step_s.or(step);
        self.ends_s = Some((self.ends_s.map_or(*first, |(first, _)| first), *last));
    }

    pub(super) fn sound(&self) -> Option<ClockSurvey> {
        /// Beyond 2^53 not every whole number is a float.
        const MOST: f64 = 9e15;
        let whole = |t: f64| t.fract() == 0.0 && t.abs() < MOST;
        let ((first, last), step_s) = (self.ends_s?, self.step_s?);
        let sound = !self.broken && whole(first) && whole(last) && whole(step_s) && step_s > 0.0;
        sound.then(|| ClockSurvey {
            step_s,
            span_s: (first, last),
            missing: 0,
            duplicates: 0,
            crowded: 0,
            backward: 0,
            furthest_back_s: None,
            jitter_s: 0.0,
            gaps: Vec::new(),
            even: true,
        })
    }
}

impl Order {
    fn add(&mut self, from: Option<f64>, stamp: f64) {
        self.first.get_or_insert(stamp);
        self.last = stamp;
        let Some(from) = from else {
            return;
        };
        let step = stamp - from;
        self.backward += usize::from(step < 0.0);
        self.duplicates += usize::from(step == 0.0);
        self.steps += usize::from(step > 0.0);
        self.forward_s += step.max(0.0);
        self.shared += 1;
        if step != 0.0 {
            let shared = std::mem::take(&mut self.shared);
            self.usual = match self.usual {
                (_, 0) => (shared, 1),
                (usual, votes) if usual == shared => (usual, votes + 1),
                (usual, votes) => (usual, votes - 1),
            };
        }
        if step < 0.0 && self.back.is_none_or(|(_, by)| -step > by) {
            self.back = Some((from, -step));
        }
        if self
            .jump
            .is_none_or(|(_, longest)| step.total_cmp(&longest).is_ge())
        {
            self.jump = Some((from, step));
        }
    }
}

impl Order {
    /// Whether stamps have lost their seconds: many samples in a row share each, and those are far apart.
    fn coarse(&self) -> Option<ClockError> {
        const SHARED: usize = 5;
        const APART_S: f64 = 10.0;
        let stamps = self.steps + self.backward + 1;
        let step_s = if self.steps > 1 {
            // One gap, or a clock that was set back once, leaves the other steps as they are.
            let (_, longest_s) = self.jump?;
            (self.forward_s - longest_s) / (self.steps - 1) as f64
        } else {
            (self.last - self.first?).abs() / self.steps.max(self.backward) as f64
        };
        (self.duplicates >= (SHARED - 1) * stamps && step_s >= APART_S).then(|| {
            ClockError::Coarse {
                shared: self.shared_as_a_rule(stamps),
                step_s,
            }
        })
    }

    /// How many samples share a stamp: as many as at some three in four of them, or else the mean.
    fn shared_as_a_rule(&self, stamps: usize) -> usize {
        let (usual, votes) = self.usual;
        let mean = (stamps + self.duplicates + stamps / 2) / stamps;
        if 2 * votes > stamps { usual } else { mean }
    }
}

impl Near {
    fn add(&mut self, step: f64) {
        let steps = step / self.median_s;
        let off = |steps: f64| (steps - steps.round()).abs() > ON_CLOCK;
        self.odd += usize::from(off(steps));
        for ((odd, just), parts) in self.parts.iter_mut().zip(PARTS) {
            *odd += usize::from(off(steps * parts));
            *just += usize::from((steps * parts).round() == 1.0);
        }
        if (0.5 * self.median_s..1.5 * self.median_s).contains(&step) {
            self.sum += step;
            self.count += 1.0;
        }
    }

    /// The part of the median step of which nearly all steps are multiples, and many are no more than it.
    fn part_s(&self, order: &Order) -> Option<f64> {
        /// One step in so many, at least, is no more.
        const JUST: usize = 10;
        let parts = self.parts.iter().zip(PARTS);
        let mut fitting = parts.filter(|((odd, just), _)| {
            odd * ODD_STEPS <= order.steps && just * JUST >= order.steps
        });
        fitting.next().map(|(_, parts)| self.median_s / parts)
    }

    /// The median step, unless the stamps jitter: its error would then add up over the
    /// recording, so the mean of the steps around it is taken, in which jitter cancels.
    fn step_s(&self, order: &Order) -> f64 {
        // A clock that was set once or twice has an odd step there and runs evenly besides.
        let stamps = order.steps + order.duplicates + 1;
        if stamps < 3 || self.odd * ODD_STEPS <= order.steps {
            return self.median_s;
        }
        let mean = self.sum / self.count;
        if mean.is_normal() {
            mean
        } else {
            self.median_s
        }
    }
}

impl Fit {
    fn add(&mut self, from: Option<f64>, stamp: f64, first: f64) {
        let steps_to = |stamp: f64| (stamp - first) / self.step_s;
        let steps = steps_to(stamp);
        self.jitter_s = self
            .jitter_s
            .max((steps - steps.round()).abs() * self.step_s);
        // Stamps come in order, so that those of one step are neighbours.
        let dropped = |from: &f64| stamp > *from && steps_to(*from).round() == steps.round();
        if let Some(from) = from.filter(dropped) {
            // Else both would pass for being on the clock, each on the same step of it.
            let repeats = stamp - from <= 2.0 * ON_CLOCK * self.step_s;
            self.repeats += usize::from(repeats);
            self.crowded += usize::from(!repeats);
        }
        // A missing sample makes a step of two; half a step of slack leaves jitter alone.
        if let Some(from_s) = from.filter(|from| stamp - from > 1.5 * self.step_s) {
            self.gaps.push(Gap {
                from_s,
                to_s: stamp,
            });
        }
    }
}
