//! How a diagnosis looks for an effect, and what the effect must show before it is believed.

use crate::Setting;

/// What a diagnosis must know of an effect beside its physics.
///
/// An effect states what differs from [`Search::BASE`]: `Search { least: Some(1.5), ..Search::BASE }`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Search {
    /// Where its traces are sought.
    pub method: Method,
    /// How much evidence it takes to believe it.
    pub belief: Belief,
    /// Accuracy of instruments in terms of the strength: what does not exceed it is never named.
    pub least: Option<f64>,
    /// Error of the effect's form, as a share of its strength.
    pub form_error: f64,
    /// By how much of its [size](Shown::size) it is told wrongly beyond the noise, as simulated recordings show, or where they do not the error
    /// of its form; it widens the interval of the strength, but for what is found in the spectrum.
    pub size_error: f64,
    /// Share by which its strength differs from stand to stand, if each stand has its own.
    pub stand_error: Option<f64>,
    /// What a recording must hold, or the effect cannot be tested on it.
    pub needs: &'static [Excitation],
    /// Strengths at which a sound rig shows it: one of them may be allowed for before anything is accused. Times may be below 0: channels that
    /// do not share one clock.
    pub allowance: &'static [f64],
    /// Whether it comes upon flowing mud and does nothing at rest: then it must show without the stops as well.
    pub flowing: bool,
    /// What it makes late, if it does.
    pub timing: Option<Timing>,
}

impl Search {
    /// What holds of most effects.
    pub const BASE: Self = Self {
        method: Method::Relations,
        belief: Belief {
            hurdle: 9.0,
            scale: 3.0,
        },
        least: None,
        form_error: 0.06,
        size_error: 0.03,
        stand_error: None,
        needs: &[],
        allowance: &[],
        flowing: false,
        timing: None,
    };
}

/// Where the traces of an effect are sought.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// In the residuals of the relations.
    Relations,
    /// As a peak of the inlet pressure's spectrum; the parameters are its period and amplitude, in this order.
    Spectrum,
    /// It is the empirical correction, which stands against all others.
    Correction,
}

/// What an effect must show before it is believed.
///
/// Set by hand on simulated recordings, clean ones and others; what they are worth, `cargo xtask prove` tells on seeds
/// that were not looked at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Belief {
    /// Evidence, as the natural logarithm of a Bayes factor, that sound recordings do not reach.
    pub hurdle: f64,
    /// Evidence beyond it over which belief grows by a factor e in the odds.
    pub scale: f64,
}

/// What a recording must hold to show an effect at all.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Excitation {
    /// A stop or a start of the subsea pump.
    PumpStops,
    /// Stretches in which the mud pump stands.
    Connections,
    /// Booster flow that changes.
    BoosterSteps,
    /// Sampling fast enough for the period of the swell.
    FastSampling,
}

/// What an effect makes late.
///
/// Curves fitted without it bend towards it: they are fitted again for each of its strengths, and the allowances of
/// other effects are chosen again beside it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Timing {
    /// The return flow's meter. What one effect of this kind leaves over looks like another: one of them is named at the most.
    Meter,
    /// The subsea pump.
    Pump,
}

/// How a parameter is reported.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shown {
    /// As it is carried.
    AsCarried,
    /// Whole, as a gain: it is carried as the excess over 1.
    Gain,
    /// Whole, in m²: it is carried as the excess over the riser's area, relative to it.
    RiserArea,
}

impl Shown {
    /// Offset and factor that turn a carried value into the one reported; a difference takes the factor alone.
    pub fn scale(self, setting: &Setting) -> (f64, f64) {
        let whole = match self {
            Self::AsCarried => return (0.0, 1.0),
            Self::Gain => 1.0,
            Self::RiserArea => setting.riser_area_m2,
        };
        (whole, whole)
    }

    /// The reported value that relative sizes count from: 1 of a gain, 0 otherwise.
    pub fn neutral(self) -> f64 {
        match self {
            Self::Gain => 1.0,
            Self::AsCarried | Self::RiserArea => 0.0,
        }
    }

    /// What shares of a reported value are shares of: the value itself, of a gain its distance from 1.
    pub fn size(self, shown: f64) -> f64 {
        (shown - self.neutral()).abs()
    }
}
