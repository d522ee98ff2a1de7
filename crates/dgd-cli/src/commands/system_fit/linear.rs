//! `--linear`: the same values estimated on the linear model, beside those of the equations themselves.

use super::{HUBER, errors, parameters};
use crate::failure::Failure;
use crate::say::TextTable;
use crate::system::columns::Recorded;
use crate::system::measure::Measure;
use crate::system::runs::{self, Run};
use crate::system::{bounds, ending, failed, page};
use dgd_assembly::{Assembly, Fit, FitOptions, Loss, SimulationOptions, fit};
use dgd_documents::FittedParameter;
use dgd_report::{Page, Table};
use serde_json::{Value, json};
use std::path::Path;

const OPTIONS: SimulationOptions = SimulationOptions {
    method: dgd_assembly::Method::Rodasp,
    relative: 1e-6,
    max_steps: 10_000_000,
    linear: true,
};

/// A fit of the linear model and its runs.
pub(super) struct Linear {
    status: &'static str,
    fitted: Vec<FittedParameter>,
    runs: Vec<Run>,
}

/// From where the fit of the equations ended.
pub(super) fn of(
    assembly: &Assembly,
    found: &Fit,
    recorded: &Recorded,
    robust: bool,
    (system, recording): (&Path, &Path),
) -> Result<Linear, Failure> {
    let options = FitOptions {
        start: Some(found.theta.clone()),
        loss: if robust {
            Loss::Huber(HUBER)
        } else {
            Loss::Square
        },
        simulation: OPTIONS,
        ..FitOptions::default()
    };
    let linear =
        fit(assembly, &recorded.train, &options).map_err(|e| failed(system, recording, &e))?;
    let runs = runs::simulate(
        assembly,
        &linear.theta,
        recorded,
        &OPTIONS,
        (system, recording),
    )?;
    Ok(Linear {
        status: ending(linear.status),
        fitted: parameters(assembly, &linear),
        runs,
    })
}

impl Linear {
    /// Path, unit, and value with interval by the equations and by the linear model.
    fn rows(&self, assembly: &Assembly, fitted: &[FittedParameter]) -> Vec<[String; 4]> {
        let told = |p: &FittedParameter| {
            let told = page::Told::of_fitted(assembly, p);
            match told.ends {
                Some([from, to]) => format!("{} ({from} to {to})", told.value),
                None => format!("{} ({})", told.value, told.note),
            }
        };
        let pairs = fitted.iter().zip(&self.fitted);
        pairs
            .map(|(p, l)| {
                let unit = Measure::of(assembly.system(), &p.path).symbol;
                [p.path.clone(), unit, told(p), told(l)]
            })
            .collect()
    }

    pub(super) fn tell(&self, assembly: &Assembly, fitted: &[FittedParameter]) -> String {
        let mut table = TextTable::new(["parameter", "unit", "by the equations", "linear model"]);
        for row in self.rows(assembly, fitted) {
            table.row(row);
        }
        format!(
            "\nthe fit of the linear model, around the steady state at the mean of the inputs, {}\n\n{}\n{}",
            self.status,
            errors(assembly, &self.runs).render(),
            table.render()
        )
    }

    pub(super) fn draw(&self, page: &mut Page, assembly: &Assembly, fitted: &[FittedParameter]) {
        page.section("Estimated on the linear model").paragraph(&format!(
            "The same parameters, with the equations replaced by the linear model around the steady state at the mean of the inputs; that fit {}. \
             If the two differ by more than their intervals, a linear model is not adequate for this recording.",
            self.status
        ));
        page.table(&page::errors(assembly, &self.runs));
        let rows = self.rows(assembly, fitted).into_iter();
        page.table(&Table {
            caption: "Estimates with 95 % intervals".into(),
            head: ["Parameter", "Unit", "By the equations", "Linear model"]
                .map(Into::into)
                .to_vec(),
            rows: rows
                .map(|row| row.map(|cell| page::typeset(&cell)).to_vec())
                .collect(),
        });
    }

    pub(super) fn as_json(&self, assembly: &Assembly) -> Value {
        let each = self.fitted.iter().map(|p| {
            let measure = Measure::of(assembly.system(), &p.path);
            let (low, high) = measure.ends(page::interval(p, bounds(assembly, &p.path)));
            json!({ "path": p.path, "value": measure.shown(p.value), "standard_error": measure.shown(p.standard_error),
                    "ci95": [low, high], "at_bound": p.at_bound, "unit": measure.symbol })
        });
        json!({
            "status": self.status,
            "parameters": each.collect::<Vec<_>>(),
            "outputs": runs::errors_as_json(assembly, &self.runs),
        })
    }
}
