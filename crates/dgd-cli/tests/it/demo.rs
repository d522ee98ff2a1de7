//! The demo: the embedded recording through the whole job.

use crate::bench::Bench;

#[test]
fn the_demo_writes_its_input_its_results_and_a_report() {
    let bench = Bench::bare();
    let said = bench.json("demo --out demo", "dgd.demo/1");
    assert!(said["level_rmse_m"].as_f64().unwrap().is_finite());
    for name in [
        "recording.mat",
        "well.toml",
        "model.toml",
        "simulation.csv",
        "simulation.mcap",
        "report.html",
    ] {
        assert!(!bench.bytes(&format!("demo/{name}")).is_empty(), "{name}");
    }
    // Every step of it can be repeated by hand, and gives the same.
    bench
        .dgd("fit demo/recording.mat --well demo/well.toml")
        .done();
    assert_eq!(bench.text("model.toml"), bench.text("demo/model.toml"));
    bench
        .dgd("simulate demo/recording.mat --well demo/well.toml")
        .done();
    assert_eq!(
        bench.text("simulation.csv"),
        bench.text("demo/simulation.csv")
    );
}
