//! What was concealed, in the terms of the catalogue's strength: so that it can be held against its standard error.

use super::truth::Concealed;

/// What of a well description turns a truth into a strength.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Well {
    pub(crate) density_kg_m3: f64,
    pub(crate) riser_id_m: f64,
    pub(crate) drillpipe_od_m: f64,
    pub(crate) return_line_id_m: f64,
    pub(crate) pump_outlet_depth_m: f64,
}

/// Ten bar, at which the catalogue gives leaks, Pa.
const TEN_BAR_PA: f64 = 1e6;

impl Well {
    /// Of a `well.toml` as the plant writes it; `None` where something is missing or in another unit.
    pub(crate) fn read(text: &str) -> Option<Well> {
        let value = |key: &str, unit: &str, si: f64| -> Option<f64> {
            let lines = text.lines().filter_map(|l| l.split_once('='));
            let found = lines.filter(|(k, _)| k.trim() == key).map(|(_, v)| v);
            let quoted = found.map(|v| v.trim().trim_matches('"')).next()?;
            let (number, found) = quoted.split_once(' ')?;
            let number: f64 = number.parse().ok()?;
            (found == unit).then_some(si * number)
        };
        Some(Well {
            density_kg_m3: value("density", "sg", 1000.0)?,
            riser_id_m: value("riser_id", "in", 0.0254)?,
            drillpipe_od_m: value("drillpipe_od", "in", 0.0254)?,
            return_line_id_m: value("return_line_id", "in", 0.0254)?,
            pump_outlet_depth_m: value("pump_outlet_depth", "m", 1.0)?,
        })
    }

    fn annulus_m2(self) -> f64 {
        std::f64::consts::FRAC_PI_4 * (self.riser_id_m.powi(2) - self.drillpipe_od_m.powi(2))
    }
}

/// Size of what was concealed, SI, in the unit of the strength that `dgd diagnose` tells; `None` where the truth does not say.
///
/// - a gain counts from one, an area from what the well description says;
/// - a yield stress as the drop it makes in the limit of slow flow, 16 tau L / (3 d);
/// - a line leak at 10 bar above the air;
/// - a worn pump's leakage at the end, at 10 bar; the plant gives its growth at 100 m of head;
/// - heave as its amplitude.
pub(crate) fn strength(effect: &Concealed, well: Well, hours: f64) -> Option<f64> {
    let of = |name: &str| {
        let mut all = effect.parameters.iter().chain(&effect.extra);
        all.find(|(n, _)| n == name).map(|(_, v)| *v)
    };
    let size = match effect.effect.as_str() {
        "return_flow_gain" | "inflow_gain" => of("gain")? - 1.0,
        "annulus_area" => of("area_m2")? - well.annulus_m2(),
        "yield_stress" => {
            16.0 * of("tau_y_pa")? * well.pump_outlet_depth_m / (3.0 * well.return_line_id_m)
        }
        "line_leak" => of("C")? * TEN_BAR_PA.sqrt(),
        "pump_wear" => {
            let head_m = TEN_BAR_PA / (well.density_kg_m3 * 9.80665);
            of("leak_growth")? * hours * 3600.0 * (head_m / 100.0).sqrt()
        }
        "heave" => of("amplitude_m")?,
        "u_tube" => of("tau_s")?,
        _ => {
            let scored = effect.parameters.iter().find(|(n, _)| n != "sensor");
            scored.map(|(_, v)| *v)?
        }
    };
    (size.is_finite() && size != 0.0).then(|| size.abs())
}

/// Name of the parameter that the strength is, where `tested` does not tell.
pub(crate) fn parameter_of(effect: &str) -> Option<&'static str> {
    match effect {
        "heave" => Some("amplitude_m"),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may")]
    use super::*;

    const WELL: &str = "[mud]\ndensity = \"1.250 sg\"\n[geometry]\nriser_id = \"19 in\"\ndrillpipe_od = \"6.625 in\"\n\
                        return_line_id = \"5.500 in\"\npump_outlet_depth = \"300.00 m\"\n";

    fn of(effect: &str, name: &str, value: f64) -> Option<f64> {
        let concealed = Concealed {
            effect: effect.into(),
            extra: vec![(name.into(), value)],
            ..Concealed::default()
        };
        strength(&concealed, Well::read(WELL).unwrap(), 5.0)
    }

    #[test]
    fn a_well_is_read_and_another_unit_is_not_taken_for_the_usual_one() {
        let well = Well::read(WELL).unwrap();
        assert!((well.annulus_m2() - 0.160_68).abs() < 1e-5);
        assert_eq!(well.density_kg_m3, 1250.0);
        assert_eq!(Well::read(&WELL.replace("300.00 m", "984 ft")), None);
        assert_eq!(Well::read(""), None);
    }

    #[test]
    fn gains_count_from_one_and_areas_from_the_file() {
        let close = |a: Option<f64>, b: f64| assert!((a.unwrap() - b).abs() < 1e-9 * b, "{a:?}");
        close(of("inflow_gain", "gain", 0.96), 0.04);
        let nominal = Well::read(WELL).unwrap().annulus_m2();
        close(of("annulus_area", "area_m2", nominal - 0.02), 0.02);
        // 16 * 1.5 Pa * 300 m / (3 * 0.1397 m)
        close(of("yield_stress", "tau_y_pa", 1.5), 17_179.670_722_977_8);
        close(of("line_leak", "C", 2e-6), 2e-3);
        // 81.577 m of head at 10 bar
        close(
            of("pump_wear", "leak_growth", 1e-7),
            1.8e-3 * 0.815_772_970_f64.sqrt(),
        );
    }

    #[test]
    fn what_the_truth_does_not_say_has_no_strength() {
        assert_eq!(of("pump_wear", "other", 1.0), None);
        assert_eq!(of("inflow_gain", "gain", 1.0), None, "no effect at all");
    }
}
