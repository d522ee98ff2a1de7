use dgd_units::{FullScale, MaskReferences};
use proptest::prelude::*;

#[test]
fn masking_is_a_percentage_of_the_reference() {
    let references = MaskReferences::new(FullScale {
        flow_m3_s: 0.06,
        friction_pa: 5e5,
        head_m: 300.0,
        level_m: 200.0,
    })
    .unwrap();
    assert_eq!(references.mask_friction(2.5e5), 50.0);
    assert_eq!(references.mask_flow(0.06), 100.0);
    assert_eq!(references.mask_head(30.0), 10.0);
    assert_eq!(references.mask_level(50.0), 25.0);
}

#[test]
fn a_reference_that_is_not_positive_is_named_but_not_shown() {
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-320] {
        let error = MaskReferences::new(FullScale {
            flow_m3_s: 0.06,
            friction_pa: 5e5,
            head_m: bad,
            level_m: 200.0,
        })
        .unwrap_err();
        assert_eq!(
            error.to_string(),
            "the head reference must be a positive finite number"
        );
    }
}

#[test]
fn debug_output_does_not_disclose_the_references() {
    let references = MaskReferences::new(FullScale {
        flow_m3_s: 0.0613,
        friction_pa: 5e5,
        head_m: 300.0,
        level_m: 200.0,
    })
    .unwrap();
    assert_eq!(format!("{references:?}"), "MaskReferences(undisclosed)");
}

proptest! {
    #[test]
    fn mask_and_unmask_are_inverse(value in -1e6f64..1e6, reference in 1e-3f64..1e6, power in 0f64..3.0) {
        let r = MaskReferences::new(FullScale { flow_m3_s: reference, friction_pa: reference * 2.0, head_m: reference * 3.0, level_m: reference * 5.0 }).unwrap();
        let close = |a: f64, b: f64| (a - b).abs() <= 1e-12 * b.abs();
        prop_assert!(close(r.unmask_flow(r.mask_flow(value)), value));
        prop_assert!(close(r.unmask_friction(r.mask_friction(value)), value));
        prop_assert!(close(r.unmask_head(r.mask_head(value)), value));
        prop_assert!(close(r.unmask_level(r.mask_level(value)), value));
        prop_assert!(close(r.unmask_friction_coefficient(r.mask_friction_coefficient(value, power), power), value));
        prop_assert!(close(r.unmask_head_coefficient(r.mask_head_coefficient(value, power), power), value));
    }

    #[test]
    fn a_masked_law_gives_the_masked_value(coefficient in -1e3f64..1e3, flow in 0.001f64..0.1, power in 0f64..3.0) {
        let r = MaskReferences::new(FullScale { flow_m3_s: 0.06, friction_pa: 5e5, head_m: 300.0, level_m: 200.0 }).unwrap();
        let masked = r.mask_head_coefficient(coefficient, power) * r.mask_flow(flow).powf(power);
        let expected = r.mask_head(coefficient * flow.powf(power));
        prop_assert!((masked - expected).abs() <= 1e-11 * expected.abs().max(1e-12));
    }
}
