//! The two-state model that goes into model.toml, and what its identification found by itself.

use crate::commands::fit::delays_in_samples;
use crate::failure::Failure;
use crate::say::brief;
use dgd_documents::Base;
use dgd_identify::{Identification, IdentifyOptions, Prepared, identify};
use dgd_recording::Well;

/// The model, and its departures from the textbook's: name and words, as settings are told.
pub(super) struct TwoState {
    pub(super) base: Base,
    pub(super) departures: Vec<(String, String)>,
    /// What doubts that the channels share one clock.
    pub(super) clocks: Vec<String>,
}

/// The two-state model; a recording that gives none can still be diagnosed.
pub(super) fn two_state(
    prepared: &Prepared,
    well: &Well,
    samples: usize,
    recordings: &[String],
) -> Result<TwoState, Failure> {
    // The default is thirty samples, which are thirty seconds at 1 Hz alone.
    let options = IdentifyOptions {
        delays: delays_in_samples((0.0, LATEST_S), prepared.step_s)?,
        ..IdentifyOptions::default()
    };
    Ok(match identify(prepared, well, &options) {
        Ok(identification) => {
            let clocks = identification.clocks.clone();
            for warning in &identification.warnings {
                if !clocks.contains(warning) {
                    tracing::info!("two-state model: {warning}");
                }
            }
            let departures = departures(&identification);
            let mut model = identification.model;
            model.data.samples = samples;
            model.data.recordings = recordings.to_vec();
            TwoState {
                base: Base::Identified(Box::new(model)),
                departures,
                clocks,
            }
        }
        Err(error) => {
            tracing::warn!("model.toml will contain no two-state model: {error}");
            TwoState {
                base: Base::WellOnly {
                    density_kg_m3: well.mud_density_kg_m3,
                    geometry: well.geometry.clone(),
                },
                departures: Vec::new(),
                clocks: Vec::new(),
            }
        }
    })
}

/// The latest that a flow meter is tried, s.
const LATEST_S: f64 = 30.0;

/// Share of the textbook's mean square that another law must stay below to be told.
const TELLING: f64 = 0.9;

/// Where the identified laws leave the textbook's: a late meter (Eq. 3.21), another law of the pump (Eq. 3.39).
fn departures(identification: &Identification) -> Vec<(String, String)> {
    let model = &identification.model;
    let mut out = Vec::new();
    let mut tell = |name: &str, what: String| out.push((name.to_owned(), what));
    if let Ok(undelayed) = &identification.undelayed
        && model.delay_s > 0.0
        && identification.sweep.fit.mse_pa2 < TELLING * undelayed.mse_pa2
    {
        let bar = |mse_pa2: f64| brief(mse_pa2.sqrt() * 1e-5);
        tell(
            "two-state model: return flow",
            format!(
                "delay {} s{}: friction error {} bar, without delay {} bar",
                brief(model.delay_s),
                // Half a step from it no later one was tried.
                if model.delay_s > LATEST_S - 0.5 * model.data.step_s {
                    " or more"
                } else {
                    ""
                },
                bar(identification.sweep.fit.mse_pa2),
                bar(undelayed.mse_pa2)
            ),
        );
    }
    let pump = &model.pump;
    if let Ok(squares) = &identification.pump.constrained
        && pump.mse_m2 < TELLING * squares.fit.mse_m2
    {
        tell(
            "two-state model: pump",
            format!(
                "head c0 w^{:.2} - c1 w q - c2 q^{:.2}: error {} m, with squares {} m",
                pump.n0,
                pump.n2,
                brief(pump.mse_m2.sqrt()),
                brief(squares.fit.mse_m2.sqrt())
            ),
        );
    }
    out
}
