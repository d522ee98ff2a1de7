//! Which cases are made: what is concealed, how strong, in which bench and under which operator.

use super::circuit::Circuit;
use super::hidden::Hidden;
use super::run::{Record, simulate};
use super::schedule::Programme;
use super::surge::Surge;
use super::{Bench, SAMPLES, SAMPLING_S};
use crate::noise::Noise;

/// What cases conceal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// One of [`Bench::things`].
    Single,
    /// Nothing.
    Clean,
    /// One of [`Bench::foreign`].
    Foreign,
    /// Of five cases three single, one clean, one foreign; of forty, every thing in every severity once.
    Mix,
}

/// How much of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Severity {
    /// Half of the moderate size.
    Subtle,
    /// The size that [`draw`] documents.
    Moderate,
    /// Twice that.
    Strong,
}

impl Severity {
    /// All, the strongest first.
    pub const ALL: [Severity; 3] = [Severity::Strong, Severity::Moderate, Severity::Subtle];

    /// `strong`, `moderate` or `subtle`.
    pub fn name(self) -> &'static str {
        match self {
            Severity::Subtle => "subtle",
            Severity::Moderate => "moderate",
            Severity::Strong => "strong",
        }
    }

    /// The severity of that name.
    pub fn named(name: &str) -> Option<Severity> {
        Severity::ALL.into_iter().find(|s| s.name() == name)
    }

    fn factor(self) -> f64 {
        match self {
            Severity::Subtle => 0.5,
            Severity::Moderate => 1.0,
            Severity::Strong => 2.0,
        }
    }
}

/// A series of cases to be made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Order {
    /// Which bench.
    pub bench: Bench,
    /// Seed of everything.
    pub seed: u64,
    /// What is concealed.
    pub kind: Kind,
    /// Only this severity; by default all in turn.
    pub severity: Option<Severity>,
    /// Only this one of [`Bench::things`] or [`Bench::foreign`].
    pub thing: Option<&'static str>,
}

/// The physics of a case.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Bed {
    Surge(Surge),
    Circuit(Circuit),
}

/// A case: a bench, its operator, and what it conceals.
#[derive(Debug, Clone, PartialEq)]
pub struct Case {
    /// `c000`, `c001`, ...
    pub id: String,
    /// Which bench.
    pub bench: Bench,
    /// How strong what is concealed is; in a clean case it means nothing.
    pub severity: Severity,
    /// What drives each of [`Bench::inputs`], in SI.
    pub programmes: Vec<Programme>,
    /// Free values of the system description, as they truly are, by path.
    pub values: Vec<(&'static str, f64)>,
    pub(crate) bed: Bed,
    pub(crate) noise_seed: u64,
}

impl Case {
    /// What it conceals.
    pub fn hidden(&self) -> Option<Hidden> {
        match &self.bed {
            Bed::Surge(bench) => bench.hidden,
            Bed::Circuit(bench) => bench.hidden,
        }
    }

    /// The same case with something else, or nothing, concealed.
    pub fn with(&self, hidden: Option<Hidden>) -> Case {
        let mut other = self.clone();
        match &mut other.bed {
            Bed::Surge(bench) => bench.hidden = hidden,
            Bed::Circuit(bench) => bench.hidden = hidden,
        }
        other
    }
}

const MIX: [Kind; 5] = [
    Kind::Single,
    Kind::Single,
    Kind::Clean,
    Kind::Single,
    Kind::Foreign,
];

/// The case number `index` of an order. The same order gives the same case, whatever comes before it.
///
/// A single case takes the moderate size within 20 %, times the severity's factor of 2, 1 or 0.5. Cases of one number of other
/// kinds differ in what is concealed and in nothing else. Thresholds (crest, chamber, cracking pressure) are laid where the same run
/// without anything concealed goes: a crest that no wave reaches conceals nothing.
pub fn draw(order: &Order, index: usize) -> Case {
    let kind = match order.kind {
        Kind::Mix => MIX[index % MIX.len()],
        kind => kind,
    };
    // Of those before it, how many were of its kind.
    let turn = match order.kind {
        Kind::Mix => {
            let before = MIX[..index % MIX.len()]
                .iter()
                .filter(|k| **k == kind)
                .count();
            index / MIX.len() * MIX.iter().filter(|k| **k == kind).count() + before
        }
        _ => index,
    };
    let names: &[&'static str] = match kind {
        Kind::Foreign => &order.bench.foreign(),
        _ => &order.bench.things(),
    };
    let thing = order.thing.unwrap_or(names[turn % names.len()]);
    // A round through the things goes through the severities too, and the next one begins with another.
    let round = match order.thing {
        Some(_) => turn,
        None => turn % names.len() + turn / names.len(),
    };
    let severity = order.severity.unwrap_or(Severity::ALL[round % 3]);
    let clean = base(order, index);
    if kind == Kind::Clean {
        return clean;
    }
    let mut noise = Noise::new(clean.noise_seed, 3);
    let amount = severity.factor() * noise.between(0.8, 1.2);
    let hidden = size(thing, amount, &clean, &mut noise);
    Case {
        severity,
        ..clean.with(hidden)
    }
}

/// A seed for the case alone.
fn own_seed(order: &Order, index: usize) -> u64 {
    let bench = u64::from(order.bench == Bench::GlycolLoop);
    Noise::new(order.seed, 1_000_000 + 2 * index as u64 + bench).whole()
}

/// The case with nothing concealed.
fn base(order: &Order, index: usize) -> Case {
    let noise_seed = own_seed(order, index);
    let mut noise = Noise::new(noise_seed, 1);
    let mut operator = Noise::new(noise_seed, 2);
    let length_s = SAMPLES as f64 * SAMPLING_S;
    let (bed, programmes, values) = match order.bench {
        Bench::SurgeShaft => {
            let bench = Surge {
                roughness_m: 1e-4 * noise.between(0.6, 2.5),
                flow_coefficient: 7.2e-5 * noise.between(0.85, 1.15),
                hidden: None,
            };
            let values = vec![
                ("tunnel.roughness", bench.roughness_m),
                ("valve.flow_coefficient", bench.flow_coefficient),
            ];
            let head = Programme::wander(length_s, 136_000.0, 800.0, &mut operator);
            let valve = Programme::moves(
                length_s,
                (0.25, 0.85),
                (30.0, 130.0),
                (2.0, 8.0),
                &mut operator,
            );
            (Bed::Surge(bench), vec![head, valve], values)
        }
        Bench::GlycolLoop => {
            let bench = Circuit {
                displacement_m3_s_rpm: 1.75e-7 * noise.between(0.93, 1.07),
                flow_coefficient: 1e-6 * noise.between(0.9, 1.1),
                discharge_coefficient: noise.between(0.58, 0.66),
                viscosity_pa_s: 0.012 * noise.between(0.9, 1.1),
                hidden: None,
            };
            let values = vec![
                ("pump.coefficient", bench.displacement_m3_s_rpm),
                ("needle.flow_coefficient", bench.flow_coefficient),
                ("drain.discharge_coefficient", bench.discharge_coefficient),
                ("hose.linear", bench.hose_pa(1e-4, 0.0) / 1e-4),
                ("accumulator.bulk_modulus", 2.5e5),
            ];
            let speed = Programme::moves(
                length_s,
                (800.0, 1800.0),
                (40.0, 160.0),
                (2.0, 6.0),
                &mut operator,
            );
            let needle = Programme::moves(
                length_s,
                (0.4, 0.9),
                (50.0, 180.0),
                (2.0, 6.0),
                &mut operator,
            );
            (Bed::Circuit(bench), vec![speed, needle], values)
        }
    };
    Case {
        id: format!("c{index:03}"),
        bench: order.bench,
        severity: Severity::Moderate,
        programmes,
        values,
        bed,
        noise_seed,
    }
}

/// The value below which a share of an output lies in a run, SI.
fn quantile(record: &Record, output: usize, share: f64) -> f64 {
    let mut values = record.quiet_si[output].clone();
    values.sort_by(f64::total_cmp);
    let last = values.len().saturating_sub(1);
    values
        .get(crate::constants::index(share * last as f64, last))
        .copied()
        .unwrap_or(0.0)
}

/// What is concealed, of `amount` times the moderate size.
fn size(thing: &str, amount: f64, clean: &Case, noise: &mut Noise) -> Option<Hidden> {
    let length_s = SAMPLES as f64 * SAMPLING_S;
    Some(match thing {
        "crest_overflow" => Hidden::CrestOverflow {
            crest_m: quantile(&simulate(clean), 0, noise.between(0.7, 0.85)),
            width_m: 0.012 * amount,
        },
        "shaft_widening" => Hidden::ShaftWidening {
            from_m: quantile(&simulate(clean), 0, noise.between(0.4, 0.6)),
            share: 0.35 * amount,
        },
        // At 2.5 m 2 % of 6.5 l/s.
        "shaft_leak" => Hidden::ShaftLeak {
            area_m2: 1.9e-5 * amount,
        },
        "rack_clogging" => Hidden::RackClogging {
            from_s: length_s * noise.between(0.1, 0.4),
            heads_per_hour: 4.5 * amount,
        },
        "valve_backlash" => Hidden::ValveBacklash {
            half_band: 0.01 * amount,
        },
        // Half a millimetre of crest is no crest: twice the height for the strong one.
        "tailwater_rise" => Hidden::TailwaterRise {
            width_m: 0.06 / amount.powf(1.5),
        },
        // The loss goes with the square of the area.
        "foot_throttle" => Hidden::FootThrottle {
            area_m2: 2.2e-3 / amount.sqrt(),
        },
        "level_drift" => Hidden::LevelDrift {
            per_hour_m: 0.06 * amount * noise.sign(),
        },
        // 3 % of 0.23 l/s at 3 bar.
        "pump_slip" => Hidden::PumpSlip {
            per_pa: 2.3e-11 * amount,
        },
        "relief_cracking" => Hidden::ReliefCracking {
            crack_pa: quantile(&simulate(clean), 0, noise.between(0.6, 0.75))
                - crate::constants::ATMOSPHERE_PA,
            per_pa: 6e-11 * amount,
        },
        "warming_fluid" => Hidden::WarmingFluid {
            log_share: 0.3 * amount,
            time_constant_s: noise.between(500.0, 1300.0),
        },
        "early_transition" => Hidden::EarlyTransition {
            reynolds: 2100.0 - 400.0 * amount,
        },
        "sump_evaporation" => Hidden::SumpEvaporation {
            per_hour_m: 0.006 * amount,
        },
        "needle_stiction" => Hidden::NeedleStiction {
            band: 0.03 * amount,
        },
        "trapped_gas" => Hidden::TrappedGas {
            volume_m3: 1.2e-3 * amount,
        },
        "meter_lag" => Hidden::MeterLag {
            time_constant_s: 5.0 * amount,
        },
        "humming_shaft" => Hidden::HummingShaft {
            share: 0.04 * amount,
            wave_m: noise.between(0.35, 0.5),
        },
        "echo_of_the_valve" => Hidden::EchoOfTheValve {
            level_m: 0.04 * amount * noise.sign(),
            delay_s: noise.between(20.0, 40.0).round(),
        },
        "travelling_rag" => Hidden::TravellingRag {
            share: 0.1 * amount,
            round_m3: noise.between(0.045, 0.065),
        },
        "float_switch" => Hidden::FloatSwitch {
            share: 0.03 * amount,
            wave_m: noise.between(0.09, 0.13),
        },
        _ => return None,
    })
}
