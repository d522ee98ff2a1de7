//! What every step works on: the assembly, its samples in rows, its hypotheses; and the fit of a set of effects.

use crate::parallel::Threads;
use crate::stack::{Data, Runner};
use dgd_assembly::{Assembly, EffectParameter, Hypothesis, SimulationOptions};
use dgd_lsq::lm::{self, Bounds, Effort, Minimum};
use nalgebra::DMatrix;
use std::collections::BTreeMap;

/// Values by path; what is not named starts where the assembly says.
pub(crate) type Values = BTreeMap<String, f64>;

pub(crate) struct Context<'a> {
    /// As it is fitted, its starts loose around the readings that they are taken from.
    pub assembly: &'a Assembly,
    /// As it was asked about, and is answered: its starts are those readings.
    pub asked: &'a Assembly,
    pub data: &'a Data,
    /// Size by which residuals are divided, by output.
    pub scale: Vec<f64>,
    pub simulation: SimulationOptions,
    pub threads: &'a Threads,
    pub hypotheses: Vec<Hypothesis>,
}

/// A set of effects, fitted.
#[derive(Debug, Clone)]
pub(crate) struct Trial {
    /// Numbers of hypotheses, ascending.
    pub members: Vec<usize>,
    pub paths: Vec<String>,
    pub bounds: Bounds,
    pub minimum: Minimum,
}

impl Trial {
    pub(crate) fn cost(&self) -> f64 {
        self.minimum.cost
    }

    /// The members but one.
    pub(crate) fn others(&self, member: usize) -> Vec<usize> {
        let mut rest = self.members.clone();
        rest.retain(|m| *m != member);
        rest
    }

    pub(crate) fn values(&self) -> Values {
        self.paths
            .iter()
            .cloned()
            .zip(self.minimum.theta.iter().copied())
            .collect()
    }
}

pub(crate) fn path(h: &Hypothesis, p: &EffectParameter) -> String {
    format!("{}.{}.{}", h.component, h.effect, p.name)
}

/// Values with those of an effect beside them.
pub(crate) fn with(values: &Values, h: &Hypothesis, own: &[f64]) -> Values {
    let mut all = values.clone();
    let named = h.parameters.iter().zip(own);
    all.extend(named.map(|(p, v)| (path(h, p), *v)));
    all
}

impl<'a> Context<'a> {
    /// The same with the assembly as it was asked about.
    pub(crate) fn as_asked(&self) -> Context<'a> {
        Context {
            assembly: self.asked,
            scale: self.scale.clone(),
            hypotheses: self.hypotheses.clone(),
            ..*self
        }
    }

    /// The assembly with a set of effects, all their parameters free; `None` if they contradict each other.
    pub(crate) fn build(&self, members: &[usize]) -> Option<Assembly> {
        let mut built = self.assembly.clone();
        for &m in members {
            let h = &self.hypotheses[m];
            let names: Vec<&str> = h.parameters.iter().map(|p| p.name).collect();
            built = built.with_effect(&h.component, h.effect, &names).ok()?;
        }
        Some(built)
    }

    /// `(simulated − measured)/scale` from simulated readings.
    pub(crate) fn residual(&self, mut simulated: Vec<f64>) -> Vec<f64> {
        for ((s, row), measured) in simulated
            .iter_mut()
            .zip(&self.data.rows)
            .zip(&self.data.measured)
        {
            *s = (*s - measured) / self.scale[row.output];
        }
        simulated
    }

    /// Start and bounds of an assembly's parameters. `None` if the bounds cannot be, which no assembly has.
    pub(crate) fn start(
        assembly: &Assembly,
        values: &Values,
    ) -> Option<(Vec<String>, Vec<f64>, Bounds)> {
        let (mut low, mut high) = (Vec::new(), Vec::new());
        let (mut paths, mut theta) = (Vec::new(), Vec::new());
        for p in assembly.parameters() {
            theta.push(values.get(&p.path).copied().unwrap_or(p.start));
            low.push(p.low);
            high.push(p.high);
            paths.push(p.path);
        }
        let bounds = Bounds::new(low, high).ok()?;
        bounds.clamp(&mut theta);
        Some((paths, theta, bounds))
    }

    /// Fits a set from a start. `None` if it cannot be built or run.
    pub(crate) fn fit(&self, members: &[usize], values: &Values, effort: Effort) -> Option<Trial> {
        let built = self.build(members)?;
        let (paths, theta, bounds) = Self::start(&built, values)?;
        let mut runner = Runner::new(&built, self.data, &self.simulation).ok()?;
        let minimum = lm::minimise(
            &mut |t: &[f64]| runner.run(t).map(|s| self.residual(s)),
            &theta,
            &bounds,
            None,
            None,
            effort,
        );
        minimum.cost.is_finite().then(|| Trial {
            members: members.to_vec(),
            paths,
            bounds,
            minimum: light(minimum),
        })
    }

    /// Goes on with a trial.
    pub(crate) fn refine(&self, trial: &Trial, effort: Effort) -> Option<Trial> {
        let built = self.build(&trial.members)?;
        let mut runner = Runner::new(&built, self.data, &self.simulation).ok()?;
        let mut run = |t: &[f64]| runner.run(t).map(|s| self.residual(s));
        // The residuals there are known, the Jacobian is an old one.
        let known = &trial.minimum;
        let (theta, residuals) = (&known.theta, &known.residuals);
        let jacobian = lm::differences(&mut run, theta, residuals, &trial.bounds);
        let minimum = lm::minimise(
            &mut run,
            theta,
            &trial.bounds,
            None,
            Some((residuals, &jacobian)),
            Effort {
                fresh: effort.fresh.saturating_sub(1),
                ..effort
            },
        );
        (minimum.cost <= trial.cost()).then(|| Trial {
            minimum: light(minimum),
            ..trial.clone()
        })
    }
}

/// Without the Jacobian, as large as the record times the parameters: whoever needs one makes it afresh, and hundreds of trials are kept.
fn light(minimum: Minimum) -> Minimum {
    Minimum {
        jacobian: DMatrix::zeros(0, 0),
        ..minimum
    }
}
