//! Held-out windows, and what leads up to them.

use crate::assembly::Assembly;
use crate::error::AssemblyError;
use crate::network::Start;
use crate::record::{Portion, Record, Window};

/// A held-out window.
#[derive(Debug, Clone, Default)]
pub struct HeldOut {
    /// Its samples.
    pub window: Window,
    /// The number of the last training window before it in the same recording, from 0, and all samples from that one's start to the end
    /// of this one: a run through these, with the initial states of that training window, says where this one starts without a look
    /// at its readings.
    pub through: Option<(usize, Window)>,
}

impl HeldOut {
    /// `window`, with what leads up to it from the windows in `train` if it lies in the same recording, of which `whole` holds all samples.
    #[must_use]
    pub fn new(window: Window, whole: Option<&Window>, train: &[Window]) -> Self {
        Self {
            through: whole.and_then(|whole| through(whole, train, &window)),
            window,
        }
    }

    /// What `assembly` is run over to know this window: the number of the training window whose initial states it starts from, and the
    /// samples, of which the last are the window's.
    #[must_use]
    pub fn run(&self, assembly: &Assembly) -> (usize, &Window) {
        match &self.through {
            Some((number, whole)) if !assembly.starts_measured() => (*number, whole),
            // Another run, or one whose start is known: of free initial states it takes those of the first training window.
            _ => (0, &self.window),
        }
    }
}

impl Assembly {
    /// The held-out windows of a record, each with what leads up to it.
    ///
    /// # Errors
    /// As [`Self::windows`].
    pub fn held_out(&self, record: &Record<'_>) -> Result<Vec<HeldOut>, AssemblyError> {
        let test = self.windows(record, Portion::Test)?;
        if test.is_empty() {
            return Ok(Vec::new());
        }
        let train = self.windows(record, Portion::Train)?;
        let whole = if self.holds_out_of_one_run() {
            self.windows(record, Portion::All)?.into_iter().next()
        } else {
            None
        };
        Ok(test
            .into_iter()
            .map(|window| HeldOut::new(window, whole.as_ref(), &train))
            .collect())
    }

    /// Whether the held-out part is a stretch, along time, of the recording that is trained on.
    #[must_use]
    pub fn holds_out_of_one_run(&self) -> bool {
        let record = &self.system().record;
        let same = record.channels(Portion::Test) == record.channels(Portion::Train);
        self.system().independent == "time" && record.test.is_some() && same
    }

    /// Whether every state starts from a reading; one that is given or fitted, or that an effect owns, does not.
    #[must_use]
    pub fn starts_measured(&self) -> bool {
        let mut states = self.net.states.iter();
        states.all(|state| matches!(state.start, Start::Measured(_)))
    }
}

/// All samples from the start of the last training window before `window` to its end.
fn through(whole: &Window, train: &[Window], window: &Window) -> Option<(usize, Window)> {
    let (&from, &to) = (window.time.first()?, window.time.last()?);
    let starts = train.iter().map(|w| w.time.first().copied());
    let (number, start) = starts
        .enumerate()
        .filter_map(|(k, start)| Some((k, start?)))
        .filter(|(_, start)| *start < from)
        .max_by(|a, b| a.1.total_cmp(&b.1))?;
    let first = whole.time.partition_point(|t| *t < start);
    let last = whole.time.partition_point(|t| *t <= to);
    let cut = |values: &Vec<f64>| values.get(first..last).unwrap_or_default().to_vec();
    let run = Window {
        time: cut(&whole.time),
        inputs: whole.inputs.iter().map(cut).collect(),
        readings: whole.readings.iter().map(cut).collect(),
        origin: whole.origin,
    };
    (run.time.len() >= window.time.len()).then_some((number, run))
}
