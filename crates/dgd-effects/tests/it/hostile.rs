//! Nothing panics, whatever the numbers.

use crate::{model, moments, setting};
use dgd_effects::{Changes, Effect, Inputs, KNOTS, Noise, catalogue, unknown};
use proptest::prelude::*;

/// Numbers that break arithmetic, and any other.
fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        Just(0.0),
        Just(-0.0),
        Just(1.0),
        Just(-1.0),
        Just(f64::NAN),
        Just(f64::INFINITY),
        Just(f64::NEG_INFINITY),
        Just(f64::MAX),
        Just(f64::MIN_POSITIVE),
        -1e3..1e3,
        any::<f64>(),
    ]
}

fn effects() -> Vec<&'static dyn Effect> {
    catalogue().iter().copied().chain([unknown()]).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn effects_take_any_parameters_in_any_setting(
        p in prop::collection::vec(number(), 4 + KNOTS),
        s in prop::collection::vec(number(), 4 + KNOTS),
        m in prop::collection::vec(number(), 9),
    ) {
        let mut setting = setting();
        setting.density_kg_m3 = s[0];
        setting.line_area_m2 = s[1];
        setting.line_diameter_m = s[2];
        setting.line_length_m = s[3];
        setting.riser_volume_m3 = s[4];
        setting.span_s = (s[5], s[6]);
        setting.inlet_range_pa = (s[7], s[8]);
        setting.noise = Noise { booster_m3_s: s[9], ..Noise::default() };
        let mut moments: Vec<_> = moments().into_iter().skip(3090).take(20).collect();
        let odd = &mut moments[7];
        (odd.t_s, odd.dt_s, odd.mud_pump_m3_s, odd.booster_m3_s) = (m[0], m[1], m[2], m[3]);
        (odd.topfill_m3_s, odd.flow_m3_s, odd.speed_pct) = (m[4], m[5], m[6]);
        (odd.inlet_pa, odd.outlet_pa) = (m[7], m[8]);
        for effect in effects() {
            let about = effect.about();
            let p = &p[..about.parameters.len()];
            let mut action = effect.begin(p, &setting);
            for moment in &moments {
                action(moment, &mut Changes::default());
            }
            let _ = (effect.meter_path(p), about.interval_s(p, setting.span_s));
        }
    }

    #[test]
    fn a_free_run_takes_any_effect_and_gives_every_sample(
        p in prop::collection::vec(number(), 4 + KNOTS),
        which in 0..25_usize,
        step_s in number(),
        start in (number(), number()),
        odd in (number(), number()),
    ) {
        let about = effects()[which].about();
        let model = model(&[(about.id, &p[..about.parameters.len()])]);
        let time: Vec<f64> = (0..30).map(f64::from).collect();
        let mut flow = vec![0.04; 30];
        let mut speed = vec![80.0; 30];
        (flow[10], speed[11]) = odd;
        speed[20..25].fill(0.0);
        let inputs = Inputs {
            time_s: &time,
            step_s,
            mud_pump_m3_s: &flow,
            booster_m3_s: &flow,
            topfill_m3_s: &flow,
            speed_pct: &speed,
        };
        let run = model.free_run(&setting(), inputs, 5..30, start).unwrap();
        prop_assert_eq!(run.return_flow_m3_s.len(), 25);
        prop_assert_eq!(run.inlet_pa.len(), 25);
        prop_assert_eq!(run.outlet_pa.len(), 25);
    }

    #[test]
    fn the_head_takes_any_ranges(n in prop::collection::vec(number(), 8)) {
        let mut model = model(&[]);
        model.speed_range_pct = (n[0], n[1]);
        model.ratio_range = (n[2], n[3]);
        model.curves.scale.flow_m3_s = n[4];
        model.curves.scale.speed_pct = n[5];
        let _ = model.head_pa(n[6], n[7]);
        let _ = model.friction_pa(n[7]);
    }
}
