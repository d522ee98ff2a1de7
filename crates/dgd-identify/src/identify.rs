//! The ladder from the textbook model to one that replicates the recording.

use crate::clocks::{warn_of_clocks, warn_of_inflow, warn_of_speed};
use crate::friction::{final_friction, scan, warn_of_sweep};
use crate::prepare::Prepared;
use crate::pump::{PumpRungs, fit_pump};
use crate::series::read_ahead;
use crate::{DataUsed, FrictionModel, Model, PumpModel, Series};
use dgd_friction::{DelaySweep, FrictionError, Loss, PolynomialFit, Terms};
use dgd_pump::{PumpError, SearchOptions};
use dgd_recording::{Well, WellError};
use dgd_screen::ScreenError;
use std::ops::RangeInclusive;

/// What to try.
#[derive(Debug, Clone, PartialEq)]
pub struct IdentifyOptions {
    /// Delays of the flow meter to try, whole samples; 0 to 30 as in the thesis by default.
    pub delays: RangeInclusive<i64>,
    /// What residuals of the friction fits cost; squared by default.
    pub loss: Loss,
    /// Search for the pump's exponents (Eq. 3.39); else 2 and 2 (Eq. 3.31), constrained.
    pub free_exponents: bool,
    /// Settings of that search.
    pub search: SearchOptions,
}

impl Default for IdentifyOptions {
    fn default() -> Self {
        Self {
            delays: 0..=30,
            loss: Loss::Squared,
            free_exponents: true,
            search: SearchOptions::default(),
        }
    }
}

/// Fewest samples from which anything is identified: a few a parameter.
const FEWEST: usize = 20;

/// The model and every rung that led to it.
#[derive(Debug, Clone, PartialEq)]
pub struct Identification {
    /// The final model.
    pub model: Model,
    /// `C q + D q²`, no delay (Eq. 3.14).
    pub undelayed: Result<PolynomialFit, FrictionError>,
    /// The same at every delay (Eq. 3.23); its fit is the one at the best delay.
    pub sweep: DelaySweep,
    /// `B + D q² + E q³` at that delay (Eq. 3.26).
    pub cubic: Result<PolynomialFit, FrictionError>,
    /// The head curve's rungs.
    pub pump: PumpRungs,
    /// Level, friction and head of the screened recording.
    pub series: Series,
    /// Flow through the pump, m³/s: the meter's, read ahead by the delay (Eq. 3.30).
    pub pump_flow_m3_s: Vec<f64>,
    /// Samples that the pump's fits used.
    pub pump_keep: Vec<bool>,
    /// What a person should know before using the model.
    pub warnings: Vec<String>,
    /// Those of the warnings that doubt that the channels share one clock: they concern whatever is made of the recording.
    pub clocks: Vec<String>,
}

/// Why no model was identified.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum IdentifyError {
    /// What was screened does not belong together.
    #[error(transparent)]
    Prepared(#[from] ScreenError),
    /// The well cannot be.
    #[error(transparent)]
    Well(#[from] WellError),
    /// Nothing passed the screening.
    #[error("none of {samples} samples passed the screening; most were rejected for: {most}")]
    NothingKept {
        /// Samples on the clock.
        samples: usize,
        /// The commonest reason.
        most: String,
    },
    /// Too little passed the screening.
    #[error(
        "only {kept} of {samples} samples passed the screening, expected at least {fewest}; \
         most were rejected for: {most}"
    )]
    TooFewKept {
        /// Samples that passed.
        kept: usize,
        /// Samples on the clock.
        samples: usize,
        /// Samples needed.
        fewest: usize,
        /// The commonest reason.
        most: String,
    },
    /// No friction law could be fitted.
    #[error("return line friction: {0}")]
    Friction(#[from] FrictionError),
    /// No head curve could be fitted.
    #[error("pump head: {0}")]
    Pump(#[from] PumpError),
}

/// Identifies friction, delay and head curve of a screened recording.
///
/// Where the recording excites too little for a law, a poorer one takes its place and
/// a warning says so: the offset and cube of Eq. 3.26 give way to `B + D q²`, and that to
/// `D q²`, where a law with an offset explains less than half of the friction's variance
/// or its terms are not told apart; free exponents that fit no better than 2 and 2 give
/// way to the constrained fit at those, and that to `c0 w²`.
///
/// # Errors
/// [`IdentifyError`] if no sample is usable or even the poorest law is not excited, the well cannot be, or the series of
/// `prepared` are not of one length.
///
/// # Source
/// Sections 3.3 and 3.4 of the thesis.
pub fn identify(
    prepared: &Prepared,
    well: &Well,
    options: &IdentifyOptions,
) -> Result<Identification, IdentifyError> {
    well.check()?;
    prepared.check()?;
    let Prepared {
        recording, step_s, ..
    } = prepared;
    let kept = prepared.kept();
    if kept == 0 {
        return Err(nothing_kept(prepared));
    }
    if kept < FEWEST {
        return Err(IdentifyError::TooFewKept {
            kept,
            samples: prepared.keep.len(),
            fewest: FEWEST,
            most: commonest(prepared),
        });
    }
    let series = Series::of(
        well,
        &prepared.inlet_pressure_pa,
        &prepared.outlet_pressure_pa,
    );
    let job = Job {
        prepared,
        series: &series,
        options,
    };
    let mut warnings = Vec::new();
    let rungs = match job.rungs(&Terms::Quadratic) {
        Err(FrictionError::Fit(_)) => {
            warnings.push(
                "the flow varies too little to separate C from D: the delay was found with D alone"
                    .into(),
            );
            job.rungs(&Terms::Powers(vec![2.0]))
        }
        rungs => rungs,
    };
    let Rungs {
        undelayed,
        sweep,
        cubic,
        friction,
        pump_flow_m3_s,
        pump_keep,
        pump,
        warnings: of_rungs,
        clocks,
    } = rungs?;
    warn_of_sweep(&sweep, &mut warnings);
    warnings.extend(of_rungs);
    let friction = friction?;
    let (pump_model, pump) = pump?;
    let model = Model {
        density_kg_m3: well.mud_density_kg_m3,
        geometry: well.geometry.clone(),
        friction,
        pump: pump_model,
        delay_s: sweep.delays_s[sweep.best],
        data: DataUsed {
            recordings: Vec::new(),
            samples: recording.len(),
            kept,
            step_s: *step_s,
            rejected: prepared
                .tally
                .iter()
                .filter(|t| t.total > 0)
                .map(|t| (t.name.to_owned(), t.total))
                .collect(),
        },
    };
    Ok(Identification {
        model,
        undelayed,
        sweep,
        cubic,
        pump,
        series,
        pump_flow_m3_s,
        pump_keep,
        warnings,
        clocks,
    })
}

/// What the rungs are fitted to.
struct Job<'a> {
    prepared: &'a Prepared,
    series: &'a Series,
    options: &'a IdentifyOptions,
}

/// Every rung, at the best delay of one law.
struct Rungs {
    undelayed: Result<PolynomialFit, FrictionError>,
    sweep: DelaySweep,
    cubic: Result<PolynomialFit, FrictionError>,
    friction: Result<FrictionModel, FrictionError>,
    pump_flow_m3_s: Vec<f64>,
    pump_keep: Vec<bool>,
    pump: Result<(PumpModel, PumpRungs), PumpError>,
    /// But for those of the sweep.
    warnings: Vec<String>,
    clocks: Vec<String>,
}

impl Job<'_> {
    /// # Errors
    /// Where the law of the sweep is refused.
    fn rungs(&self, terms: &Terms) -> Result<Rungs, FrictionError> {
        let (options, step_s) = (self.options, self.prepared.step_s);
        let samples = dgd_friction::Samples {
            flow_m3_s: &self.prepared.recording.return_flow_m3_s,
            friction_pa: &self.series.friction_pa,
            keep: &self.prepared.keep,
            keep_delayed: false,
        };
        let scan = scan(&samples, terms, step_s, options)?;
        let delay = scan.best_delay_samples;
        // The delay is all that the rest waits for. What does not wait for one another goes side by side, the longest
        // first; each warns on its own, so that the order stays.
        let pump = || self.pump(delay);
        let clocks = || {
            let mut warnings = Vec::new();
            let best_s = delay as f64 * step_s;
            warn_of_clocks(&samples, step_s, best_s, options, &mut warnings);
            warn_of_inflow(self.prepared, delay, &mut warnings);
            warnings
        };
        let laws = || {
            let mut warnings = Vec::new();
            let cubic = dgd_friction::fit(&samples, delay, &Terms::OffsetCubic, options.loss);
            let friction = final_friction(&samples, delay, &cubic, options.loss, &mut warnings);
            (cubic, friction, warnings)
        };
        let swept = || scan.fit(&samples);
        let undelayed = || dgd_friction::fit(&samples, 0, &Terms::Quadratic, options.loss);
        let (pumped, ((of_clocks, (cubic, friction, of_friction)), (sweep, undelayed))) =
            rayon::join(pump, || {
                rayon::join(
                    || rayon::join(clocks, laws),
                    || rayon::join(swept, undelayed),
                )
            });
        let (pump_flow_m3_s, pump_keep, pump, of_speed, of_pump) = pumped;
        let clocks: Vec<String> = of_clocks.iter().chain(&of_speed).cloned().collect();
        let of_clocks = of_clocks.into_iter().chain(of_friction);
        let warnings = of_clocks.chain(of_speed).chain(of_pump);
        Ok(Rungs {
            undelayed,
            sweep: sweep?,
            cubic,
            friction,
            pump_flow_m3_s,
            pump_keep,
            pump,
            warnings: warnings.collect(),
            clocks,
        })
    }

    /// The flow through the pump, which of its samples are used, the fits, and what is to be said of the clock of the speed, and of the fits.
    #[expect(clippy::type_complexity, reason = "taken apart where it is called")]
    fn pump(
        &self,
        delay: i64,
    ) -> (
        Vec<f64>,
        Vec<bool>,
        Result<(PumpModel, PumpRungs), PumpError>,
        Vec<String>,
        Vec<String>,
    ) {
        let recording = &self.prepared.recording;
        let flow_m3_s = read_ahead(&recording.return_flow_m3_s, delay);
        // The meter may read a little below zero around standstill; no power of that is defined.
        let keep: Vec<bool> = (self.prepared.keep.iter().zip(&flow_m3_s))
            .map(|(keep, q)| *keep && *q >= 0.0)
            .collect();
        let samples = dgd_pump::Samples {
            speed_pct: &recording.pump_speed_pct,
            flow_m3_s: &flow_m3_s,
            head_m: &self.series.head_m,
            keep: &keep,
        };
        let (mut of_speed, mut warnings) = (Vec::new(), Vec::new());
        warn_of_speed(&samples, self.prepared.step_s, &mut of_speed);
        let fitted = fit_pump(&samples, self.options, &mut warnings);
        (flow_m3_s, keep, fitted, of_speed, warnings)
    }
}

fn nothing_kept(prepared: &Prepared) -> IdentifyError {
    IdentifyError::NothingKept {
        samples: prepared.keep.len(),
        most: commonest(prepared),
    }
}

/// The reason for which most samples were rejected.
fn commonest(prepared: &Prepared) -> String {
    let most = prepared
        .tally
        .iter()
        .max_by_key(|t| t.total)
        .filter(|t| t.total > 0);
    most.map_or("no samples at all".to_owned(), |t| {
        format!("{} ({} samples)", t.name, t.total)
    })
}
