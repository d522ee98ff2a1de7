//! Whether a density or a depth in the description may be what findings are taken for.

use crate::selection::Named;
use dgd_effects::Setting;
use dgd_units::STANDARD_GRAVITY_M_S2;

/// Offset of the outlet, Pa, that is more than a transmitter's as a rule. Set by hand.
const BEYOND_PA: f64 = 2e5;
/// Densities that differ by less than this share of them are one; that of the description, from which they differ by more, is not. Set by hand.
const ALIKE: f64 = 0.02;

/// What is to be looked at in the description before anything else is believed; `None` where nothing speaks against it.
pub(super) fn warning(setting: &Setting, named: &[Named]) -> Option<String> {
    let likely = |id: &str| {
        let mut named = named.iter();
        named.find(|n| n.applied.id() == id && n.probability >= 0.5)
    };
    let same_as = |id: &str| {
        let one = &likely(id)?.applied;
        one.effect.same_as(&one.parameters, setting)
    };
    let rho = setting.density_kg_m3;
    let strength = |n: &Named| n.applied.parameters.first().copied();
    let offset_pa = likely("outlet_pressure_bias").and_then(strength);
    let in_line = offset_pa.map(|pa| rho + pa / (STANDARD_GRAVITY_M_S2 * setting.line_length_m));
    // A pressure stands for a height by the density, and for a volume by the area.
    let in_riser = likely("annulus_area")
        .and_then(strength)
        .map(|change| rho / (1.0 + change));
    let apart = |a: f64, b: f64| (a / b - 1.0).abs();
    let both = in_line.zip(in_riser).filter(|(line, riser)| {
        apart(*line, *riser) < ALIKE && apart(*line, rho) > ALIKE && apart(*riser, rho) > ALIKE
    });
    if let Some((line, riser)) = both {
        return Some(format!(
            "is the mud's density right? Outlet pressure and riser level imply mud of {line:.0} and {riser:.0} kg/m3, the description says {rho:.0}. Correct \
             `density` first: all other findings and sizes depend on it"
        ));
    }
    if let Some(same) = same_as("cuttings_loading") {
        return Some(format!(
            "is the mud's density right? The cuttings are as {same}. Correct `density` first: all other findings and sizes depend on it"
        ));
    }
    let offset_pa = offset_pa.filter(|pa| pa.abs() > BEYOND_PA)?;
    let side = if offset_pa < 0.0 { "little" } else { "much" };
    Some(format!(
        "is the description right? The outlet reads {:.1} bar too {side} throughout, beyond the usual error of a transmitter: as much as {}. Correct \
         `density` or `pump_outlet_depth` first, or the transmitter: all other findings and sizes depend on them",
        offset_pa.abs() / 1e5,
        same_as("outlet_pressure_bias")?,
    ))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

    use super::warning;
    use crate::selection::Named;
    use crate::test_rig::{named, steady};

    #[test]
    fn a_density_that_two_findings_tell_and_an_offset_beyond_any_transmitter_are_asked_about() {
        let setting = steady(10).setting;
        let (rho, length) = (setting.density_kg_m3, setting.line_length_m);
        let offset = |heavier: f64| named("outlet_pressure_bias", &[9.806_65 * length * heavier]);
        let area = |rho_there: f64| named("annulus_area", &[rho / rho_there - 1.0]);
        let told = |named: &[Named]| warning(&setting, named).unwrap_or_default();
        let both = told(&[offset(0.1 * rho), area(1.105 * rho)]);
        assert!(both.contains("is the mud's density right?"), "{both}");
        assert!(
            both.contains(&format!("{:.0} kg/m3", 1.105 * rho)),
            "{both}"
        );
        // One of them alone, or another density: an offset of so many bar is told, a smaller one is not.
        for (findings, words) in [
            (vec![offset(0.3 * rho)], "too much throughout"),
            (vec![offset(-0.3 * rho), area(rho)], "too little throughout"),
            (
                vec![offset(-2.0 * rho)],
                "as much as 3000.0 m less of the mud",
            ),
        ] {
            let told = told(&findings);
            assert!(
                told.contains(words) && told.contains("`pump_outlet_depth`"),
                "{told}"
            );
        }
        assert_eq!(told(&[offset(0.01 * rho)]), "");
        assert_eq!(told(&[area(1.1 * rho)]), "");
        let unlikely = Named {
            probability: 0.4,
            ..offset(0.3 * rho)
        };
        assert_eq!(told(&[unlikely]), "");
        // Cuttings that wash out are some.
        let cuttings =
            |drilled: f64| named("cuttings_loading", &[90.0, drilled, 0.3, 0.0, 1.0, 0.5]);
        let stays = told(&[cuttings(1.0)]);
        assert!(
            stays.contains("mud of 1290 kg/m3, described as 1200"),
            "{stays}"
        );
        assert_eq!(told(&[cuttings(0.8)]), "");
    }
}
