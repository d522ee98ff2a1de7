//! A recording of a well that is longer than memory, put on its clock and screened.

use super::blocks::{self, Blocks};
use super::{Described, When};
use crate::failure::Failure;
use crate::progress::Progress;
use dgd_ingest::BlockOptions;
use dgd_recording::{BlockGrid, ReadingSurvey, Recording, RecordingError, Settle};
use dgd_screen::{BlockScreen, BlockSuspect, ScreenOptions};
use std::path::{Path, PathBuf};
use tracing::warn;

/// A recording on disk, screened block by block.
pub(crate) struct Screened<'w> {
    path: PathBuf,
    well: &'w Described,
    blocks: Blocks,
    grid: BlockGrid<'w>,
    screen: BlockScreen,
    /// What has been warned of, and whoever reads the answer must know as well.
    told: Vec<String>,
}

/// Values of a block, 1 MiB: screened and simulated each becomes five to ten, and shorter ones gain nothing.
const CELLS: usize = 1 << 17;

/// Opens a recording and finds its clock; `None` if it is to be read whole.
pub(crate) fn open<'w>(
    path: &Path,
    well: &'w Described,
    options: &ScreenOptions,
    when: When,
    progress: &Progress,
) -> Result<Option<Screened<'w>>, Failure> {
    let limits = BlockOptions {
        cells: CELLS,
        ..BlockOptions::default()
    };
    let Some(mut blocks) =
        blocks::open_with(path, when, Some(blocks::CONVERTED), limits, progress)?
    else {
        return Ok(None);
    };
    if let Some(channel) = well.channels.off_clock() {
        let path = path.display();
        let why = format!("{path} is read in full: `{channel}` has its own clock (`late`)");
        when.say(blocks.bytes(), &why);
        return Ok(None);
    }
    let grid = BlockGrid::new(blocks.head(), blocks.rows(), well);
    let mut grid = grid.map_err(|e| well.unmapped(path, &e, &blocks.head().issues))?;
    let mut readings = ReadingSurvey::default();
    for pass in 1.. {
        progress.stage("surveying", &format!("the clock, pass {pass}"));
        blocks.each::<Failure>(|block| {
            grid.add(block);
            if pass == 1 {
                readings.add(block, well);
            }
            Ok(())
        })?;
        if !grid.next_pass().map_err(|e| Failure::input(path, e))? {
            break;
        }
    }
    if !grid.is_in_order() {
        let why = format!(
            "{} is read in full: its samples must be put in order; sort its rows by time",
            path.display()
        );
        when.say(blocks.bytes(), &why);
        return Ok(None);
    }
    if readings.may_be_joined() {
        let why = format!(
            "{} is read in full: some of its channels have a reading in fewer than half of the rows, and what lies between may be drawn",
            path.display()
        );
        when.say(blocks.bytes(), &why);
        return Ok(None);
    }
    let of_grid = grid.issues();
    let issues = blocks.head().issues.iter().chain(&of_grid);
    let told = super::warn_of(well, issues.map(|issue| (path, issue)));
    let screen = BlockScreen::new(grid.samples(), grid.step_s(), options);
    Ok(Some(Screened {
        path: path.to_owned(),
        well,
        screen: screen.map_err(|e| Failure::input(path, e))?,
        blocks,
        grid,
        told,
    }))
}

/// What ends a pass.
enum Stop<E> {
    Recording(RecordingError),
    Taken(E),
}

impl<E> From<RecordingError> for Stop<E> {
    fn from(error: RecordingError) -> Self {
        Self::Recording(error)
    }
}

impl Screened<'_> {
    /// Samples on the even clock.
    pub(crate) fn samples(&self) -> usize {
        self.grid.samples()
    }

    /// First and last second.
    pub(crate) fn span_s(&self) -> (f64, f64) {
        self.grid.span_s()
    }

    /// Gathers what the screening must know before it can begin; gives what the answer must carry: what was warned of, and what the recording
    /// makes unlikely in the well description.
    pub(crate) fn look_through(&mut self, progress: &Progress) -> Result<Vec<String>, Failure> {
        let suspect = BlockSuspect::new(self.grid.step_s());
        let mut suspect = Some(suspect.map_err(|e| Failure::input(&self.path, e))?);
        let mut warnings = self.told.clone();
        for pass in 1.. {
            if self.screen.is_last_pass() {
                break;
            }
            progress.stage("screening", &format!("pass {pass}"));
            self.pass(|screen, part| {
                if let Some(suspect) = &mut suspect {
                    suspect.add(&part)?;
                }
                screen.add(&part).map(drop)
            })?;
            if let Some(suspect) = suspect.take() {
                let mut found = Vec::new();
                super::once(&mut found, suspect.finish(self.well));
                for suspicion in &found {
                    let suspicion = self.well.pointing(suspicion);
                    warn!("{suspicion}");
                    warnings.push(suspicion);
                }
            }
            let next = self.screen.next_pass();
            next.map_err(|e| Failure::input(&self.path, e))?;
        }
        Ok(warnings)
    }

    fn pass(
        &mut self,
        mut take: impl FnMut(&mut BlockScreen, Recording) -> Result<(), dgd_screen::ScreenError>,
    ) -> Result<(), Failure> {
        let path = self.path.clone();
        self.parts(|screen, part| take(screen, part).map_err(|e| Failure::input(&path, e)))
    }

    /// Goes through the screened recording: NaN for what is not to be trusted, one series a pump side.
    pub(crate) fn each<E: From<Failure>>(
        &mut self,
        mut take: impl FnMut(Recording) -> Result<(), E>,
    ) -> Result<(), E> {
        let path = self.path.clone();
        self.parts(|screen, part| {
            let screened = screen.add(&part);
            let screened = screened.map_err(|e| E::from(Failure::input(&path, e)))?;
            take(screened.trusted())
        })
    }

    fn parts<E: From<Failure>>(
        &mut self,
        mut take: impl FnMut(&mut BlockScreen, Recording) -> Result<(), E>,
    ) -> Result<(), E> {
        let (grid, screen, path) = (&mut self.grid, &mut self.screen, &self.path);
        grid.rewind();
        let mut settle = Settle::default();
        self.blocks.each(|block| {
            let given = grid.each(block, |mut part| {
                settle.add(&mut part);
                take(screen, part).map_err(Stop::Taken)
            });
            given.map_err(|stop| match stop {
                Stop::Recording(error) => E::from(Failure::input(path, error)),
                Stop::Taken(error) => error,
            })
        })
    }
}
