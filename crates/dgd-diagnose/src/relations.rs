//! The four relations in block form, under a hypothesis.
//!
//! Rows: line friction (Eq. 3.13 with the inertia of Eq. 3.46), pump head (Eq. 2.27), the redundant outlet
//! transmitters, and the riser's mass balance (Eq. 3.45) in integral form over half a minute.

mod blocks;
mod line_flow;
mod parts;
mod rows;
#[cfg(test)]
mod tests;

pub(crate) use blocks::Blocks;
pub(crate) use line_flow::LineFlow;
pub(crate) use parts::Parts;
pub(crate) use rows::{Rows, repeats};

use crate::record::{MASS_BLOCKS, Record};
use dgd_effects::{Changes, Effect, Moment};
use dgd_units::STANDARD_GRAVITY_M_S2;
use parts::Native;
use std::ops::Range;

/// An effect with its parameters.
#[derive(Clone)]
pub(crate) struct Applied {
    pub effect: &'static dyn Effect,
    pub parameters: Vec<f64>,
    /// Whether it only allows for timing: no finding.
    pub allowance: bool,
}

impl Applied {
    /// An effect that counts as a finding.
    pub(crate) fn new(effect: &'static dyn Effect, parameters: Vec<f64>) -> Self {
        Self {
            effect,
            parameters,
            allowance: false,
        }
    }
}

/// Runs effects over samples of a recording; `changes` tells what they change at each, which is called in order.
pub(crate) fn run(
    record: &Record,
    line: &LineFlow,
    samples: Range<usize>,
    mut changes: impl FnMut(&Moment) -> Changes,
) -> Parts {
    let setting = &record.setting;
    let (flow, filled_flow) = line.of(record);
    let rho = setting.density_kg_m3;
    let g = STANDARD_GRAVITY_M_S2;
    let column = record.column_pa();
    let single = record.outlets.len() < 2;
    // Row by row of the mass balance: samples need not be held once their means are taken.
    let per_row = record.per_block * MASS_BLOCKS;
    let mut parts = Parts::room_for(samples.len() / record.per_block);
    let mut native = Native::default();
    let mut first = samples.start;
    for i in samples {
        let moment = Moment {
            index: i,
            t_s: record.t_s[i],
            dt_s: record.dt_s,
            mud_pump_m3_s: record.filled.mud_pump[i],
            booster_m3_s: record.filled.booster[i],
            topfill_m3_s: record.filled.topfill[i],
            flow_m3_s: filled_flow[i],
            outflow_m3_s: filled_flow[i],
            speed_pct: record.filled.speed[i],
            inlet_pa: record.filled.inlet[i],
            outlet_pa: record.filled.outlet[i],
            pumping: record.filled.pumping[i],
        };
        let c = changes(&moment);
        let bias = if single {
            c.outlet_bias_pa[0]
        } else {
            0.5 * (c.outlet_bias_pa[0] + c.outlet_bias_pa[1])
        };
        let inlet_bias = 0.5 * (c.inlet_bias_pa[0] + c.inlet_bias_pa[1]);
        let q = flow[i] / c.meter_gain;
        let through = q + c.leak_m3_s;
        native.flow.push(through);
        native.through.push(through + c.recirculation_m3_s);
        native.speed.push(record.speed[i] + c.speed_pct);
        let outlet = record.outlet[i] - bias;
        native.drop.push(
            outlet - column - c.line_kg_m3 * g * setting.line_length_m + rho * g * c.line_fall_m
                - c.line_drop_pa,
        );
        native
            .friction_factor
            .push(c.friction_factor * (1.0 + c.line_kg_m3 / rho));
        native
            .lift
            .push(outlet - record.inlet[i] + inlet_bias - c.head_pa);
        native.inlet_bias.push(inlet_bias);
        native
            .head_factor
            .push(c.head_factor * (1.0 + c.riser_kg_m3 / rho));
        let inflow =
            record.filled.mud_pump[i] + record.filled.booster[i] + record.filled.topfill[i];
        native.net.push(
            inflow * (1.0 + c.entering_kg_m3 / rho) + c.inflow_m3_s
                - through * (1.0 + c.riser_kg_m3 / rho),
        );
        native
            .area
            .push(c.area_factor * setting.riser_area_m2 / (rho * g));
        native.bias.push(c.outlet_bias_pa[0] - c.outlet_bias_pa[1]);
        if i + 1 - first == per_row {
            native.move_into(&mut parts, record, first);
            first = i + 1;
        }
    }
    native.move_into(&mut parts, record, first);
    parts
}
