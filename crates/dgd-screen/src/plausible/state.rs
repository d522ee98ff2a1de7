//! A way to read a recording: the description's own, or one of its alternatives.

use super::facts::{Facts, feeds, is_flow, median, quantile};
use crate::channel::is_pressure;
use dgd_recording::{Channel, Geometry, Well};
use dgd_units::{STANDARD_ATMOSPHERE_PA, STANDARD_GRAVITY_M_S2, Unit};

/// Share of the largest flows above which mud counts as flowing, whatever its unit.
const FLOWING_SHARE: f64 = 0.5;

/// Where a channel's values are taken from: `factor * blocks[from] + offset`.
#[derive(Clone, Copy)]
pub(super) struct Map {
    pub(super) from: usize,
    pub(super) factor: f64,
    pub(super) offset: f64,
}

/// One way to read.
#[derive(Clone)]
pub(super) struct State<'a> {
    pub(super) facts: &'a Facts,
    pub(super) maps: Vec<Map>,
    pub(super) units: Vec<Unit>,
    pub(super) density_kg_m3: f64,
    pub(super) geometry: Geometry,
    /// Multiple of the clock's step.
    pub(super) time: f64,
}

impl<'a> State<'a> {
    pub(super) fn described(facts: &'a Facts, well: &Well) -> Self {
        let maps = (0..facts.told.len()).map(|from| Map {
            from,
            factor: 1.0,
            offset: 0.0,
        });
        Self {
            facts,
            maps: maps.collect(),
            units: facts.told.iter().map(|t| t.unit).collect(),
            density_kg_m3: well.mud_density_kg_m3,
            geometry: well.geometry.clone(),
            time: 1.0,
        }
    }

    pub(super) fn value(&self, told: usize, block: usize) -> f64 {
        let map = self.maps[told];
        let blocks = &self.facts.told[map.from].blocks;
        map.factor * blocks.get(block).copied().unwrap_or(f64::NAN) + map.offset
    }

    pub(super) fn values(&self, told: usize) -> impl Iterator<Item = f64> {
        (0..self.blocks()).map(move |k| self.value(told, k))
    }

    pub(super) fn blocks(&self) -> usize {
        self.facts.told.first().map_or(0, |t| t.blocks.len())
    }

    pub(super) fn block_s(&self) -> f64 {
        self.facts.block_s * self.time
    }

    pub(super) fn step_s(&self) -> f64 {
        self.facts.step_s * self.time
    }

    /// ρg, Pa/m.
    pub(super) fn weight_pa_m(&self) -> f64 {
        self.density_kg_m3 * STANDARD_GRAVITY_M_S2
    }

    /// Pressure of a full column down to a depth, Pa absolute.
    pub(super) fn column_pa(&self, depth_m: f64) -> f64 {
        STANDARD_ATMOSPHERE_PA + self.weight_pa_m() * depth_m
    }

    pub(super) fn side(&self, ours: fn(Channel) -> bool) -> Vec<usize> {
        let told = self.facts.told.iter().enumerate();
        told.filter(|(_, t)| ours(t.channel))
            .map(|(i, _)| i)
            .collect()
    }

    pub(super) fn inlets(&self) -> Vec<usize> {
        self.side(|c| matches!(c, Channel::PumpInletPressure(_)))
    }

    pub(super) fn outlets(&self) -> Vec<usize> {
        self.side(|c| matches!(c, Channel::PumpOutletPressure(_)))
    }

    pub(super) fn pressures(&self) -> Vec<usize> {
        self.side(is_pressure)
    }

    pub(super) fn flows(&self) -> Vec<usize> {
        self.side(is_flow)
    }

    pub(super) fn inflows(&self) -> Vec<usize> {
        self.side(feeds)
    }

    /// Mean of the channels that have a value in a block.
    pub(super) fn mean_of(&self, told: &[usize], block: usize) -> f64 {
        let values = told.iter().map(|i| self.value(*i, block));
        let (sum, count) = values
            .filter(|v| v.is_finite())
            .fold((0.0, 0.0), |(sum, count), v| (sum + v, count + 1.0));
        sum / count
    }

    /// Sum of the inflows; NaN where one has no value.
    pub(super) fn inflow(&self, block: usize) -> f64 {
        // Asked for at every block: a list of them would take longer than the sum.
        let told = self.facts.told.iter().enumerate();
        let inflows = told.filter(|(_, t)| feeds(t.channel));
        inflows.map(|(i, _)| self.value(i, block)).sum()
    }

    pub(super) fn return_flow(&self, block: usize) -> f64 {
        let told = self.facts.find(Channel::ReturnFlow);
        told.map_or(f64::NAN, |i| self.value(i, block))
    }

    /// Blocks in which mud flows; all of them where no flow says so.
    pub(super) fn flowing(&self) -> Vec<usize> {
        let flow = |k: &usize| self.return_flow(*k);
        let high = quantile((0..self.blocks()).map(|k| self.return_flow(k)), 0.9);
        let found: Vec<usize> = (0..self.blocks())
            .filter(|k| flow(k) > FLOWING_SHARE * high)
            .collect();
        if found.is_empty() {
            return (0..self.blocks()).collect();
        }
        found
    }

    /// Median of a channel over blocks.
    pub(super) fn median(&self, told: usize, blocks: &[usize]) -> f64 {
        median(blocks.iter().map(|k| self.value(told, *k)))
    }
}
