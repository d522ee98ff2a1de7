//! The mud return line: an elastic column of cells with a free surface.
//!
//! Faces carry flow, cells carry pressure and composition. Momentum and compressibility are
//! advanced together by backward Euler, which stays stable at a wave speed of 1,000 m/s and a quarter of a
//! second; it damps water hammer quicker than nature does. The column need not fill the line:
//! when it does not, its cells share the wet length and the surface moves; when it does, the surplus runs out.

use crate::constants::{ATMOSPHERE_PA, GRAVITY_M_S2};
use crate::mud::FrictionTable;

/// What the return line is built of.
#[derive(Debug, Clone, PartialEq)]
pub struct LineParameters {
    /// Cells along the column, 2 to 1,000.
    pub cells: usize,
    /// Speed of pressure waves in mud and wall together, m/s.
    pub wave_speed_m_s: f64,
    /// Wall roughness, m.
    pub roughness_m: f64,
    /// Loss coefficient of bends, hoses and valves, on the line's velocity head.
    pub minor_loss: f64,
    /// Time constant of the non-return valve's closing, s.
    pub valve_close_s: f64,
    /// What of its opening the closed valve still leaks.
    pub valve_leak: f64,
}

/// The return line's state.
#[derive(Debug, Clone)]
pub(crate) struct ReturnLine {
    length_m: f64,
    area_m2: f64,
    density_kg_m3: f64,
    stiffness_pa: f64,
    minor_pa_s2_m6: f64,
    /// Resistance of flowing mud that hardly hangs on the flow, Pa/m.
    stubborn_pa_m: f64,
    /// Share of `stubborn_pa_m` that full flow leaves.
    stubborn_share: f64,
    inlet_inertance: f64,
    friction: FrictionTable,
    pressure_pa: Vec<f64>,
    flow_m3_s: Vec<f64>,
    /// Density above the base mud, cell by cell, kg/m³.
    excess_kg_m3: Vec<f64>,
    /// Stored mud, m³ at the reference pressure; conserved to rounding.
    volume_m3: f64,
    wet_m: f64,
    constant: Vec<f64>,
    gain: Vec<f64>,
}

/// What went through in one step.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Passed {
    pub(crate) inflow_m3_s: f64,
    pub(crate) outflow_m3_s: f64,
    /// Density above base at the top, which goes with the outflow, kg/m³.
    pub(crate) top_excess_kg_m3: f64,
    /// Density above base at the bottom, which the riser gets when the flow reverses.
    pub(crate) bottom_excess_kg_m3: f64,
}

impl ReturnLine {
    pub(crate) fn new(
        p: &LineParameters,
        length_m: f64,
        area_m2: f64,
        density_kg_m3: f64,
        friction: FrictionTable,
    ) -> Self {
        let n = p.cells.clamp(2, 1000);
        let dx = length_m / n as f64;
        let stiffness_pa = density_kg_m3 * p.wave_speed_m_s.powi(2);
        let pressure_pa: Vec<f64> = (0..n)
            .map(|i| {
                let above = length_m - (i as f64 + 0.5) * dx;
                ATMOSPHERE_PA + density_kg_m3 * GRAVITY_M_S2 * above
            })
            .collect();
        let mean = pressure_pa.iter().sum::<f64>() / n as f64;
        Self {
            length_m,
            area_m2,
            density_kg_m3,
            stiffness_pa,
            minor_pa_s2_m6: p.minor_loss * density_kg_m3 / (2.0 * area_m2.powi(2)),
            stubborn_pa_m: 0.0,
            stubborn_share: 1.0,
            // Six metres of suction and pump passages at the line's bore.
            inlet_inertance: density_kg_m3 * 6.0 / area_m2,
            friction,
            pressure_pa,
            flow_m3_s: vec![0.0; n + 1],
            excess_kg_m3: vec![0.0; n],
            volume_m3: area_m2 * length_m * (1.0 + mean / stiffness_pa),
            wet_m: length_m,
            constant: vec![0.0; n + 1],
            gain: vec![0.0; n + 1],
        }
    }

    pub(crate) fn inflow_m3_s(&self) -> f64 {
        self.flow_m3_s[0]
    }

    pub(crate) fn volume_m3(&self) -> f64 {
        self.volume_m3
    }

    pub(crate) fn wet_m(&self) -> f64 {
        self.wet_m
    }

    pub(crate) fn set_friction(&mut self, friction: FrictionTable) {
        self.friction = friction;
    }

    /// Sets the loss coefficient of bends, hoses, valves and restrictions, on the line's velocity head.
    pub(crate) fn set_minor_loss(&mut self, k: f64) {
        self.minor_pa_s2_m6 = k * self.density_kg_m3 / (2.0 * self.area_m2.powi(2));
    }

    /// Sets a resistance, Pa/m, that wakes within a litre a second, of which `share` is left at 1.5 m/s and more.
    pub(crate) fn set_stubborn(&mut self, pa_m: f64, share: f64) {
        self.stubborn_pa_m = pa_m;
        self.stubborn_share = share;
    }

    /// Wall friction at `flow_m3_s` with its slope, Pa/m and Pa/m per m³/s.
    fn resistance(&self, flow_m3_s: f64) -> (f64, f64) {
        const AWAKE_M3_S: f64 = 5e-4;
        let (loss, slope) = self.friction.at(flow_m3_s);
        if self.stubborn_pa_m == 0.0 {
            return (loss, slope);
        }
        let size = flow_m3_s.abs();
        let awake = size / (size + AWAKE_M3_S);
        let fast = (size / self.area_m2 / 1.5).powi(2);
        let kept = self.stubborn_share + (1.0 - self.stubborn_share) / (1.0 + fast);
        let extra = self.stubborn_pa_m * kept * awake;
        let steep = self.stubborn_pa_m * AWAKE_M3_S / (size + AWAKE_M3_S).powi(2);
        (loss + extra.copysign(flow_m3_s), slope + steep)
    }

    /// Pressure that standing mud puts on the line's foot, Pa.
    pub(crate) fn static_foot_pa(&self) -> f64 {
        let mean = self.excess_kg_m3.iter().sum::<f64>() / self.excess_kg_m3.len() as f64;
        ATMOSPHERE_PA + (self.density_kg_m3 + mean) * GRAVITY_M_S2 * self.wet_m
    }

    /// One step of `dt_s`, in which `bled_m3_s` leaves at the foot besides. `drive(q)` is the pressure at the line's foot when `q` passes pump and valve.
    pub(crate) fn step(
        &mut self,
        dt_s: f64,
        inlet_excess_kg_m3: f64,
        bled_m3_s: f64,
        drive: impl Fn(f64) -> f64,
    ) -> Passed {
        let n = self.pressure_pa.len();
        let dx = self.wet_m / n as f64;
        let full = self.wet_m >= self.length_m;
        let kappa = self.stiffness_pa * dt_s / (self.area_m2 * dx);
        let inertance = self.density_kg_m3 * dx / self.area_m2 / dt_s;

        // Eliminate from the surface down: q[j] = constant[j] + gain[j] q[j-1].
        for j in (1..=n).rev() {
            let last = j == n;
            let share = if last { 0.5 } else { 1.0 };
            let old = self.flow_m3_s[j];
            let (loss, slope) = self.resistance(old);
            let (mut loss, mut slope) = (loss * dx * share, slope * dx * share);
            if last && full {
                loss += self.minor_pa_s2_m6 * old * old.abs();
                slope += 2.0 * self.minor_pa_s2_m6 * old.abs();
            }
            let (above_pa, above_excess) = if last {
                (ATMOSPHERE_PA, self.excess_kg_m3[n - 1])
            } else {
                (self.pressure_pa[j], self.excess_kg_m3[j])
            };
            let density = self.density_kg_m3 + 0.5 * (self.excess_kg_m3[j - 1] + above_excess);
            let weight = density * GRAVITY_M_S2 * dx * share;
            let carry = inertance * share + slope;
            let mut diagonal = carry + kappa;
            let mut right = self.pressure_pa[j - 1] - above_pa - weight - loss + carry * old;
            if !last {
                diagonal += kappa * (1.0 - self.gain[j + 1]);
                right += kappa * self.constant[j + 1];
            }
            self.constant[j] = right / diagonal;
            self.gain[j] = kappa / diagonal;
        }
        let old = self.flow_m3_s[0];
        let (loss, slope) = self.resistance(old);
        let carry = 0.5 * inertance + self.inlet_inertance / dt_s + 0.5 * dx * slope;
        let weight = (self.density_kg_m3 + self.excess_kg_m3[0]) * GRAVITY_M_S2 * 0.5 * dx;
        let right =
            carry * old + kappa * self.constant[1] - self.pressure_pa[0] - weight - 0.5 * dx * loss;
        let left = carry + kappa * (1.0 - self.gain[1]);
        self.flow_m3_s[0] = solve_inlet(left, right, old, drive);
        for j in 1..=n {
            self.flow_m3_s[j] = self.constant[j] + self.gain[j] * self.flow_m3_s[j - 1];
        }
        for i in 0..n {
            self.pressure_pa[i] += kappa * (self.flow_m3_s[i] - self.flow_m3_s[i + 1]);
        }
        self.settle(dt_s, inlet_excess_kg_m3, bled_m3_s)
    }

    /// Moves the surface, spills what does not fit, and carries the composition along.
    fn settle(&mut self, dt_s: f64, inlet_excess_kg_m3: f64, bled_m3_s: f64) -> Passed {
        let n = self.pressure_pa.len();
        let inflow = self.flow_m3_s[0];
        let mean = self.pressure_pa.iter().sum::<f64>() / n as f64;
        let squeeze = 1.0 + mean / self.stiffness_pa;
        let capacity = self.area_m2 * self.length_m * squeeze;
        let before = self.volume_m3;
        let entered = inflow - bled_m3_s;
        let mut after = before + dt_s * entered;
        let mut outflow = 0.0;
        if after >= capacity {
            outflow = (after - capacity) / dt_s;
            after = capacity;
            self.wet_m = self.length_m;
        } else {
            // A foot of mud always remains above the valve.
            self.wet_m = (after / (self.area_m2 * squeeze)).max(0.02 * self.length_m);
        }
        let bottom_excess_kg_m3 = self.excess_kg_m3[0];
        let top_excess_kg_m3 = self.excess_kg_m3[n - 1];
        // Cells of equal, moving size: through[j] is what passes face j relative to the grid.
        let (cell_before, cell_after) = (before / n as f64, after / n as f64);
        let mut through = dt_s * entered;
        let mut carried = through
            * if through >= 0.0 {
                inlet_excess_kg_m3
            } else {
                bottom_excess_kg_m3
            };
        for i in 0..n {
            through -= cell_after - cell_before;
            let upstream = if through >= 0.0 || i + 1 == n {
                self.excess_kg_m3[i]
            } else {
                self.excess_kg_m3[i + 1]
            };
            let leaves = through * upstream;
            let mass = self.excess_kg_m3[i] * cell_before + carried - leaves;
            carried = leaves;
            self.excess_kg_m3[i] = mass / cell_after;
        }
        self.volume_m3 = after;
        Passed {
            inflow_m3_s: inflow,
            outflow_m3_s: outflow,
            top_excess_kg_m3,
            bottom_excess_kg_m3,
        }
    }
}

/// Root of `left q = drive(q) + right`: Newton from the old flow inside a shrinking bracket.
fn solve_inlet(left: f64, right: f64, start: f64, drive: impl Fn(f64) -> f64) -> f64 {
    let residual = |q: f64| left * q - drive(q) - right;
    let (mut low, mut high) = (-0.3, 0.3);
    let mut q = start;
    for _ in 0..60 {
        let r = residual(q);
        if r > 0.0 {
            high = q;
        } else {
            low = q;
        }
        let h = 1e-7;
        let slope = (residual(q + h) - r) / h;
        let mut next = q - r / slope;
        if !(next > low && next < high) {
            next = 0.5 * (low + high);
        }
        if (next - q).abs() < 1e-10 {
            return next;
        }
        q = next;
    }
    q
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mud::Rheology;

    fn line() -> ReturnLine {
        let p = LineParameters {
            cells: 16,
            wave_speed_m_s: 1000.0,
            roughness_m: 5e-5,
            minor_loss: 10.0,
            valve_close_s: 3.0,
            valve_leak: 1e-3,
        };
        let mud = Rheology {
            yield_pa: 0.2,
            consistency_pa_sn: 0.05,
            index: 0.9,
        };
        let friction = FrictionTable::new(&mud, 0.1524, 5e-5, 1080.0);
        ReturnLine::new(&p, 350.0, 0.018_241, 1080.0, friction)
    }

    #[test]
    fn steady_flow_costs_the_tabulated_friction() {
        let mut line = line();
        let foot = line.static_foot_pa();
        for _ in 0..4000 {
            line.step(0.25, 0.0, 0.0, |_| foot + 2.0e5);
        }
        let q = line.inflow_m3_s();
        let expected = 350.0 * line.friction.at(q).0 + line.minor_pa_s2_m6 * q * q;
        assert!((expected / 2.0e5 - 1.0).abs() < 1e-6, "{expected}");
        assert!((line.flow_m3_s[16] - q).abs() < 1e-9);
    }

    #[test]
    fn draining_and_refilling_conserve_mud_and_solids() {
        let mut line = line();
        let foot = line.static_foot_pa();
        let solids = |l: &ReturnLine| {
            l.excess_kg_m3.iter().sum::<f64>() * l.volume_m3 / l.excess_kg_m3.len() as f64
        };
        let (mut volume, mut mass) = (line.volume_m3(), solids(&line));
        for i in 0..8000 {
            let push = if (2000..4000).contains(&i) {
                -1.0e6
            } else {
                2.0e5
            };
            let passed = line.step(0.25, 7.0, 0.0, |q| foot + push - 3e7 * q);
            volume += 0.25 * (passed.inflow_m3_s - passed.outflow_m3_s);
            let inlet = if passed.inflow_m3_s >= 0.0 {
                7.0
            } else {
                passed.bottom_excess_kg_m3
            };
            mass +=
                0.25 * (passed.inflow_m3_s * inlet - passed.outflow_m3_s * passed.top_excess_kg_m3);
            if i == 3999 {
                assert!(line.wet_m() < 300.0);
            }
        }
        assert!((volume - line.volume_m3()).abs() < 1e-8);
        assert!(
            (mass - solids(&line)).abs() < 1e-6,
            "{mass} {}",
            solids(&line)
        );
        assert!((line.wet_m() - 350.0).abs() < 1e-9);
    }
}
