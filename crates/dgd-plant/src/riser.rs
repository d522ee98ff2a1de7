//! The riser: how much mud it holds, of what density, and where its surface stands.

/// The riser's state. Composition is density above the base mud: a chain of cells from the wellhead to
/// the pump inlet, and one mixed pool above the inlet, where only topfill and level changes stir.
#[derive(Debug, Clone)]
pub(crate) struct Riser {
    area_m2: f64,
    inlet_depth_m: f64,
    /// Depth of the surface, m below the rotary table.
    level_m: f64,
    lower_kg_m3: Vec<f64>,
    lower_cell_m3: f64,
    upper_kg_m3: f64,
    /// With a turnover volume the whole riser takes on what comes in, as if mixed in it, m³.
    turnover_m3: Option<f64>,
}

impl Riser {
    pub(crate) fn new(
        area_m2: f64,
        inlet_depth_m: f64,
        wellhead_depth_m: f64,
        level_m: f64,
    ) -> Self {
        const CELLS: usize = 24;
        let lower = (wellhead_depth_m - inlet_depth_m).max(10.0) * area_m2;
        Self {
            area_m2,
            inlet_depth_m,
            level_m,
            lower_kg_m3: vec![0.0; CELLS],
            lower_cell_m3: lower / CELLS as f64,
            upper_kg_m3: 0.0,
            turnover_m3: None,
        }
    }

    /// Mixes what comes in within `volume_m3` instead of letting it travel up from the wellhead.
    pub(crate) fn turn_over(&mut self, volume_m3: f64) {
        const CELLS: usize = 2;
        self.lower_kg_m3 = vec![0.0; CELLS];
        self.lower_cell_m3 = volume_m3 / CELLS as f64;
        self.turnover_m3 = Some(volume_m3);
    }

    pub(crate) fn level_m(&self) -> f64 {
        self.level_m
    }

    pub(crate) fn upper_kg_m3(&self) -> f64 {
        self.upper_kg_m3
    }

    /// Density above base of what the pump would draw now, kg/m³.
    pub(crate) fn suction_kg_m3(&self, from_below_m3_s: f64, drawn_m3_s: f64) -> f64 {
        let below = self.lower_kg_m3[self.lower_kg_m3.len() - 1];
        if drawn_m3_s <= from_below_m3_s || drawn_m3_s <= 0.0 {
            return below;
        }
        let share = (from_below_m3_s / drawn_m3_s).max(0.0);
        share * below + (1.0 - share) * self.upper_kg_m3
    }

    /// One step: `below` and `topfill` come in (m³/s, with kg/m³ above base), `drawn` leaves to the pump
    /// (negative: comes back, at `returned_kg_m3`). Returns what ran over the riser's top, m³/s.
    pub(crate) fn step(
        &mut self,
        dt_s: f64,
        (below_m3_s, below_kg_m3): (f64, f64),
        (topfill_m3_s, topfill_kg_m3): (f64, f64),
        drawn_m3_s: f64,
        returned_kg_m3: f64,
    ) -> f64 {
        let share = (below_m3_s * dt_s / self.lower_cell_m3).clamp(0.0, 1.0);
        let mut inlet = below_kg_m3;
        for cell in &mut self.lower_kg_m3 {
            let old = *cell;
            *cell += share * (inlet - old);
            inlet = old;
        }
        // What the pump does not take of the flow from below rises into the pool above.
        let pool_m3 = ((self.inlet_depth_m - self.level_m) * self.area_m2).max(1.0);
        let surplus = below_m3_s - drawn_m3_s.max(0.0);
        let lifted = surplus.max(0.0);
        let back = (-drawn_m3_s).max(0.0);
        let gain = lifted * (inlet - self.upper_kg_m3)
            + topfill_m3_s * (topfill_kg_m3 - self.upper_kg_m3)
            + back * (returned_kg_m3 - self.upper_kg_m3);
        if self.turnover_m3.is_some() {
            self.upper_kg_m3 = self.lower_kg_m3[self.lower_kg_m3.len() - 1];
        } else {
            self.upper_kg_m3 += dt_s * gain / pool_m3;
        }

        self.level_m += dt_s * (drawn_m3_s - below_m3_s - topfill_m3_s) / self.area_m2;
        if self.level_m < 0.0 {
            let spilled = -self.level_m * self.area_m2 / dt_s;
            self.level_m = 0.0;
            return spilled;
        }
        0.0
    }
}
