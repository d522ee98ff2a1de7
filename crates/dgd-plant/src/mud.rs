//! The mud: Herschel-Bulkley rheology and what it costs to push it through a pipe.

use std::f64::consts::PI;

/// Rheology of the drilling mud, τ = τ_y + K γ̇ⁿ.
#[derive(Debug, Clone, PartialEq)]
pub struct Rheology {
    /// Yield stress τ_y, Pa.
    pub yield_pa: f64,
    /// Consistency K, Pa·sⁿ.
    pub consistency_pa_sn: f64,
    /// Flow index n.
    pub index: f64,
}

impl Rheology {
    /// Wall stress of laminar pipe flow, Pa: Rabinowitsch-Mooney shear rate, with the
    /// Buckingham-Reiner factor 4/3 on the yield stress. The yield stress fades in over
    /// the first millimetres per second, because standing mud pushes neither way.
    fn laminar_wall_stress_pa(&self, velocity_m_s: f64, diameter_m: f64) -> f64 {
        let n = self.index;
        let shear = (3.0 * n + 1.0) / (4.0 * n) * 8.0 * velocity_m_s / diameter_m;
        let awake = velocity_m_s / (velocity_m_s + 2e-3);
        4.0 / 3.0 * self.yield_pa * awake + self.consistency_pa_sn * shear.powf(n)
    }

    /// Pressure lost to wall friction, Pa/m, at mean velocity `velocity_m_s` >= 0.
    ///
    /// Laminar below a generalised Reynolds number (Metzner and Reed) of about 2,700, Haaland's formula
    /// on the same number above, blended by a logistic weight; Darcy-Weisbach turns the factor into a gradient.
    pub fn friction_gradient_pa_m(
        &self,
        velocity_m_s: f64,
        diameter_m: f64,
        roughness_m: f64,
        density_kg_m3: f64,
    ) -> f64 {
        if velocity_m_s <= 0.0 {
            return 0.0;
        }
        let stress = self.laminar_wall_stress_pa(velocity_m_s, diameter_m);
        let laminar = 4.0 * stress / diameter_m;
        let reynolds = 8.0 * density_kg_m3 * velocity_m_s.powi(2) / stress;
        let inverse_root = -1.8
            * (6.9 / reynolds.max(500.0) + (roughness_m / (3.7 * diameter_m)).powf(1.11)).log10();
        let turbulent =
            inverse_root.powi(-2) * density_kg_m3 * velocity_m_s.powi(2) / (2.0 * diameter_m);
        let weight = 1.0 / (1.0 + (-(reynolds - 2700.0) / 250.0).exp());
        (1.0 - weight) * laminar + weight * turbulent
    }
}

/// Friction gradient against flow, tabulated once: the line asks sixteen times a step.
#[derive(Debug, Clone)]
pub(crate) struct FrictionTable {
    gradient_pa_m: Vec<f64>,
    step_m3_s: f64,
}

impl FrictionTable {
    const POINTS: usize = 1024;

    pub(crate) fn new(
        rheology: &Rheology,
        diameter_m: f64,
        roughness_m: f64,
        density_kg_m3: f64,
    ) -> Self {
        let area = PI / 4.0 * diameter_m.powi(2);
        let step_m3_s = 12.0 * area / Self::POINTS as f64;
        let gradient_pa_m = (0..=Self::POINTS)
            .map(|i| {
                let v = step_m3_s * i as f64 / area;
                rheology.friction_gradient_pa_m(v, diameter_m, roughness_m, density_kg_m3)
            })
            .collect();
        Self {
            gradient_pa_m,
            step_m3_s,
        }
    }

    /// Multiplies every gradient by `factor`.
    pub(crate) fn scale(&mut self, factor: f64) {
        self.gradient_pa_m.iter_mut().for_each(|g| *g *= factor);
    }

    /// Gradient at `flow_m3_s` (odd in flow) with its slope, Pa/m and Pa/m per m³/s.
    pub(crate) fn at(&self, flow_m3_s: f64) -> (f64, f64) {
        let x = flow_m3_s.abs() / self.step_m3_s;
        let i = crate::constants::index(x, Self::POINTS - 1);
        let (low, high) = (self.gradient_pa_m[i], self.gradient_pa_m[i + 1]);
        let value = low + (high - low) * (x - i as f64);
        (value.copysign(flow_m3_s), (high - low) / self.step_m3_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn newtonian_laminar_flow_gives_hagen_poiseuille() {
        let water = Rheology {
            yield_pa: 0.0,
            consistency_pa_sn: 0.1,
            index: 1.0,
        };
        let (v, d) = (0.5, 0.1524);
        let expected = 32.0 * 0.1 * v / (d * d);
        let found = water.friction_gradient_pa_m(v, d, 1e-5, 1080.0);
        assert!((found / expected - 1.0).abs() < 1e-3, "{found} {expected}");
    }

    #[test]
    fn friction_grows_with_flow_and_is_odd() {
        let mud = Rheology {
            yield_pa: 0.5,
            consistency_pa_sn: 0.06,
            index: 0.85,
        };
        let table = FrictionTable::new(&mud, 0.1524, 5e-5, 1080.0);
        let mut last = 0.0;
        for i in 1..60 {
            let q = f64::from(i) * 1e-3;
            let (value, _) = table.at(q);
            assert!(value > last);
            assert_eq!(table.at(-q).0, -value);
            last = value;
        }
    }
}
