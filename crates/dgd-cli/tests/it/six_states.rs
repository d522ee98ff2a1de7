//! The complete dual-gradient system (Eq. 2.47) from the command line.

use crate::bench::Bench;

const SIX: &str = include_str!("../../../dgd-assembly/examples/dual_gradient.toml");

/// 600 s at constant inputs, with a booster flow of `booster_m3_s`.
fn rig(booster_m3_s: f64) -> Bench {
    let bench = Bench::bare();
    bench.write("six.toml", SIX);
    let mut table = String::from("t,q_p,q_bp,q_tf,w\n");
    for t in 0..600 {
        table += &format!("{t},0.03,{booster_m3_s},0.001,62\n");
    }
    bench.write("rig.csv", table);
    bench
}

#[test]
fn the_complete_system_runs_is_linearised_and_tells_which_parameters_its_transmitters_see() {
    let bench = rig(0.025);
    let ran = bench.dgd("simulate rig.csv --system six.toml --out run.csv");
    assert!(!ran.err.contains("vacuum"), "{}", ran.err);
    ran.done();
    let told = bench.json(
        "sensitivities rig.csv --system six.toml --out s",
        "dgd.sensitivities/1",
    );
    assert_eq!(told["identifiability"]["of"], 7);
    bench
        .dgd("linearise --system six.toml --at mud_pump.flow=0.03 booster_pump.flow=0.025 topfill.flow=0.001 subsea_pump.speed=62 --step 1 --out l")
        .done();
    let linear = bench.text("l/linear.json");
    assert!(linear.contains("return_line.flow"), "{linear}");
}

#[test]
fn a_volume_that_falls_below_vacuum_is_warned_of_with_its_time() {
    // The mud of the booster line falls faster than so little flow fills it.
    let bench = rig(0.005);
    let ran = bench.dgd("simulate rig.csv --system six.toml --out run.csv");
    assert!(
        ran.err
            .contains("booster_head.pressure falls below vacuum at"),
        "{}",
        ran.err
    );
    ran.done();
}
