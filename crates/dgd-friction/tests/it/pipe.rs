use std::f64::consts::PI;

use dgd_friction::{
    Pipe, RE_CRIT, bit_loss, darcy_weisbach, friction_factor, observed_friction, reynolds,
};

const WATER: Pipe = Pipe {
    length_m: 100.0,
    diameter_m: 0.1,
    roughness_m: 0.0,
    density_kg_m3: 1000.0,
    viscosity_pa_s: 1e-3,
};

#[test]
fn a_pipe_that_cannot_be_is_refused_by_the_number_and_at_rest_nothing_rubs() {
    let pipe = Pipe {
        length_m: 350.0,
        diameter_m: 0.1524,
        roughness_m: 0.0,
        density_kg_m3: 1080.0,
        viscosity_pa_s: 0.02,
    };
    pipe.check().unwrap();
    let refused = |name: &str, set: &dyn Fn(&mut Pipe, f64)| {
        for value in [0.0, -0.1524, f64::NAN, f64::INFINITY] {
            let mut odd = pipe;
            set(&mut odd, value);
            let said = odd.check().unwrap_err().to_string();
            assert!(said.contains(name) && said.contains("above 0"), "{said}");
            assert_eq!(darcy_weisbach(&odd, 0.0), 0.0);
        }
    };
    refused("length_m", &|p, v| p.length_m = v);
    refused("diameter_m", &|p, v| p.diameter_m = v);
    refused("density_kg_m3", &|p, v| p.density_kg_m3 = v);
    refused("viscosity_pa_s", &|p, v| p.viscosity_pa_s = v);
    let rough = Pipe {
        roughness_m: -1e-4,
        ..pipe
    };
    let said = rough.check().unwrap_err().to_string();
    assert!(
        said.contains("roughness_m") && said.contains("at least 0"),
        "{said}"
    );
}

#[test]
fn reynolds_is_velocity_times_diameter_over_kinematic_viscosity() {
    let velocity = 0.01 / (std::f64::consts::FRAC_PI_4 * 0.01);
    assert!((reynolds(1000.0, 0.1, 1e-3, 0.01) / (velocity * 0.1 / 1e-6) - 1.0).abs() < 1e-12);
}

#[test]
fn laminar_drop_is_hagen_poiseuille() {
    let q = 1e-5;
    assert!(reynolds(1000.0, 0.1, 1e-3, q) < RE_CRIT);
    let expected = 8.0 * 1e-3 * 100.0 * q / (std::f64::consts::PI * 0.05_f64.powi(4));
    assert!((darcy_weisbach(&WATER, q) / expected - 1.0).abs() < 1e-12);
}

#[test]
fn haaland_stays_within_two_percent_of_colebrook() {
    for re in [1e4, 1e5, 1e6, 1e7] {
        for roughness in [1e-5, 1e-3, 1e-2] {
            let f = friction_factor(re, roughness);
            // One fixed-point step of Colebrook from Haaland is Colebrook to 0.1 %.
            let mut c = f;
            for _ in 0..20 {
                let inner = roughness / 3.7 + 2.51 / (re * c.sqrt());
                c = (-2.0 * inner.log10()).powi(-2);
            }
            assert!(
                (f / c - 1.0).abs() < 0.02,
                "Re {re}, ε/d {roughness}: {f} against {c}"
            );
        }
    }
}

#[test]
fn turbulent_drop_is_f_l_over_d_dynamic_pressure() {
    let q = 0.02;
    let v = q / (std::f64::consts::FRAC_PI_4 * 0.01);
    let f = friction_factor(reynolds(1000.0, 0.1, 1e-3, q), 0.0);
    let expected = f * 100.0 / 0.1 * 0.5 * 1000.0 * v * v;
    assert!((darcy_weisbach(&WATER, q) / expected - 1.0).abs() < 1e-12);
}

#[test]
fn reversing_flow_reverses_drop_and_rest_has_none() {
    for q in [1e-6, 1e-5, 0.02, 0.1] {
        assert_eq!(darcy_weisbach(&WATER, -q), -darcy_weisbach(&WATER, q));
        assert_eq!(
            bit_loss(1200.0, 0.95, 1e-3, -q),
            -bit_loss(1200.0, 0.95, 1e-3, q)
        );
    }
    assert_eq!(darcy_weisbach(&WATER, 0.0), 0.0);
}

#[test]
fn bit_loss_is_the_orifice_equation() {
    let loss = bit_loss(1200.0, 0.95, 1e-3, 0.03);
    let jet: f64 = 0.03 / (0.95 * 1e-3);
    assert!((loss / (0.5 * 1200.0 * jet * jet) - 1.0).abs() < 1e-12);
}

#[test]
fn a_still_column_has_no_friction_and_nan_stays_nan() {
    let still = 1080.0 * 9.80665 * 350.0 + 101_325.0;
    let found = observed_friction(&[still, still + 5e4, f64::NAN], 1080.0, 350.0, 101_325.0);
    assert_eq!(found[0], 0.0);
    assert!((found[1] - 5e4).abs() < 1e-6);
    assert!(found[2].is_nan());
}

#[test]
fn at_the_critical_reynolds_number_flow_is_turbulent() {
    // A flow whose Reynolds number is the critical one to the last bit.
    let q = (0..64)
        .map(|k| f64::from_bits((RE_CRIT * PI * 0.1 * 1e-3 / 4000.0).to_bits() - 32 + k))
        .find(|q| reynolds(1000.0, 0.1, 1e-3, *q).to_bits() == RE_CRIT.to_bits())
        .unwrap();
    let turbulent = (-1.8 * (6.9 / RE_CRIT).log10()).powi(-2);
    assert!((friction_factor(RE_CRIT, 0.0) / turbulent - 1.0).abs() < 1e-12);
    let v = q / (PI / 4.0 * 0.01);
    let drop = turbulent * 100.0 / 0.1 * 0.5 * 1000.0 * v * v;
    assert!((darcy_weisbach(&WATER, q) / drop - 1.0).abs() < 1e-12);
}

#[test]
fn the_laminar_factor_is_64_over_reynolds_number() {
    for re in [1.0, 640.0, 2299.0] {
        assert!((friction_factor(re, 0.01) * re / 64.0 - 1.0).abs() < 1e-15);
    }
}

#[test]
fn a_rough_wall_raises_the_drop_as_the_formula_says() {
    let rough = Pipe {
        roughness_m: 2e-4,
        ..WATER
    };
    let re = reynolds(1000.0, 0.1, 1e-3, 0.02);
    let ratio = friction_factor(re, 2e-3) / friction_factor(re, 0.0);
    assert!(ratio > 1.3, "{ratio}");
    let drops = darcy_weisbach(&rough, 0.02) / darcy_weisbach(&WATER, 0.02);
    assert!((drops / ratio - 1.0).abs() < 1e-12);
}
