//! When a recording tells anything: hours without a reading are no operation, and bear neither evidence nor a test.

use dgd_recording::Recording;

/// A shorter time without a reading is part of the operation, s. Set by hand.
const GAP_S: f64 = 600.0;

/// The times at which nothing was read for long.
#[derive(Debug, Clone, Default)]
pub(crate) struct Told {
    /// From and to, s, one after the other.
    gaps: Vec<(f64, f64)>,
}

impl Told {
    /// - `reads`: whether each sample of the recording has a reading, as of [`reads`].
    /// - `from_s`: of the first of them, and `step_s` to the next.
    pub(crate) fn of(reads: &[bool], from_s: f64, step_s: f64) -> Self {
        let mut start = 0;
        let mut gaps = Vec::new();
        for run in reads.chunk_by(|a, b| a == b) {
            let end = start + run.len();
            if !run[0] && run.len() as f64 * step_s >= GAP_S {
                gaps.push((from_s + start as f64 * step_s, from_s + end as f64 * step_s));
            }
            start = end;
        }
        Self { gaps }
    }

    /// For how long something was read between two times, s.
    pub(crate) fn between_s(&self, (from_s, to_s): (f64, f64)) -> f64 {
        let within = |gap: &(f64, f64)| (gap.1.min(to_s) - gap.0.max(from_s)).max(0.0);
        to_s - from_s - self.gaps.iter().map(within).sum::<f64>()
    }

    /// The gaps, s.
    pub(crate) fn gaps(&self) -> &[(f64, f64)] {
        &self.gaps
    }

    /// When something was read for so long since a time, s: where that is the edge of a gap, before it.
    pub(crate) fn until_s(&self, from_s: f64, told_s: f64) -> f64 {
        self.when_s(from_s, told_s, |gap_s, t_s| gap_s < t_s)
    }

    /// From when more than so much is read since a time, s: where that is the edge of a gap, behind it.
    pub(crate) fn beyond_s(&self, from_s: f64, told_s: f64) -> f64 {
        self.when_s(from_s, told_s, |gap_s, t_s| gap_s <= t_s)
    }

    fn when_s(&self, from_s: f64, told_s: f64, lies_before: impl Fn(f64, f64) -> bool) -> f64 {
        let later = self.gaps.iter().filter(|gap| gap.1 > from_s);
        later.fold(from_s + told_s, |t_s, gap| {
            let begins_s = gap.0.max(from_s);
            if lies_before(begins_s, t_s) {
                t_s + gap.1 - begins_s
            } else {
                t_s
            }
        })
    }
}

/// Whether anything was read, sample by sample: the return flow or a pressure at the pump. A constant of the description is no reading, and
/// without these there is no relation.
pub(crate) fn reads(recording: &Recording) -> Vec<bool> {
    let mut reads = vec![false; recording.len()];
    let (inlets, outlets) = (
        &recording.pump_inlet_pressure_pa,
        &recording.pump_outlet_pressure_pa,
    );
    for values in inlets
        .iter()
        .chain(outlets)
        .chain([&recording.return_flow_m3_s])
    {
        for (reads, value) in reads.iter_mut().zip(values) {
            *reads |= value.is_finite();
        }
    }
    reads
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Nothing is read from 700 to 1500 s, nor for a moment at 1700 s.
    fn told() -> Told {
        let missing = |i: &u32| (15..35).contains(i) || (40..45).contains(i);
        let flow = (0..50).map(|i| if missing(&i) { f64::NAN } else { 0.03 });
        let recording = Recording {
            time_s: (0..50).map(|i| 100.0 + 40.0 * f64::from(i)).collect(),
            return_flow_m3_s: flow.collect(),
            pump_inlet_pressure_pa: vec![vec![f64::NAN; 50]],
            booster_flow_m3_s: vec![0.01; 50],
            ..Recording::default()
        };
        Told::of(&reads(&recording), 100.0, 40.0)
    }

    #[test]
    fn hours_without_a_reading_do_not_count() {
        let told = told();
        assert_eq!(told.gaps(), [(700.0, 1500.0)]);
        for (from_s, to_s, seconds) in [
            (100.0, 650.0, 550.0),
            (100.0, 900.0, 600.0),
            (800.0, 900.0, 0.0),
            (600.0, 1600.0, 200.0),
            (100.0, 2100.0, 1200.0),
        ] {
            assert_eq!(told.between_s((from_s, to_s)), seconds, "{from_s} {to_s}");
        }
    }

    #[test]
    fn a_time_comes_back_from_what_was_told_until_then() {
        let told = told();
        for t_s in [100.0, 104.0, 650.0, 1510.0, 1990.0, 2100.0] {
            let seconds = told.between_s((100.0, t_s));
            assert_eq!(told.until_s(100.0, seconds), t_s);
            assert_eq!(told.beyond_s(100.0, seconds), t_s);
        }
        let edge = (told.until_s(100.0, 600.0), told.beyond_s(100.0, 600.0));
        assert_eq!(edge, (700.0, 1500.0));
        assert_eq!(told.until_s(1600.0, 50.0), 1650.0);
    }
}
