//! What does not fit together is told with its mend.

use super::benches;

#[test]
fn exactly_one_of_well_and_system_is_taken() {
    let bench = benches();
    for command in ["fit two_tanks.csv", "simulate two_tanks.csv"] {
        let none = bench.dgd(command);
        none.refused(&["--well", "--system"]);
        bench
            .dgd(&format!(
                "{command} --well well.toml --system two_tanks.toml"
            ))
            .refused(&["cannot be used with"]);
    }
    for wrong in [
        "--delays 0:3",
        "--figures d",
        "--fixed-exponents",
        "--thesis-screening",
    ] {
        bench
            .dgd(&format!(
                "fit two_tanks.csv --system two_tanks.toml {wrong}"
            ))
            .refused(&["cannot be used with"]);
    }
    bench
        .dgd("fit two_tanks.csv two_tanks.csv --system two_tanks.toml")
        .refused(&["one recording"]);
}

#[test]
fn a_recording_that_does_not_fit_the_system_is_told_with_the_mend() {
    let bench = benches();
    let system = bench.text("two_tanks.toml");
    bench.write(
        "bad.toml",
        system.replace("channel = \"u\"", "channel = \"volts\""),
    );
    bench.dgd("fit two_tanks.csv --system bad.toml").refused(&[
        "two_tanks.csv",
        "no column `volts`",
        "pump.input",
        "t, u, h2",
        "[inputs]",
        "bad.toml",
    ]);
    bench.write(
        "bad.toml",
        system.replace("[[0.0, 1600.0]]", "[[9000.0, 9100.0]]"),
    );
    bench.dgd("fit two_tanks.csv --system bad.toml").refused(&[
        "two_tanks.csv",
        "record.train",
        "9000",
    ]);
    let untimed = |record: &str| system.split("[record]").next().unwrap().to_owned() + record;
    bench.write("untimed.toml", untimed(""));
    bench
        .dgd("fit two_tanks.csv --system untimed.toml")
        .refused(&["untimed.toml", "neither `time` nor `step`", "time = \"t\""]);
    bench.write("untimed.toml", untimed("[record]\nstep = 4.0\n"));
    bench
        .dgd("simulate two_tanks.csv --system untimed.toml")
        .done();
    bench.write(
        "still.toml",
        system
            .split("[free]")
            .next()
            .unwrap()
            .replace("{ start = 0.1, low = 0.0, high = 0.4 }", "0.1")
            .replace("area = 1e-4", "area = 1e-4, discharge_coefficient = 0.6")
            .replace(
                "area = 1.2e-4",
                "area = 1.2e-4, discharge_coefficient = 0.6",
            )
            + "[record]\ntime = \"t\"\n",
    );
    bench
        .dgd("fit two_tanks.csv --system still.toml")
        .refused(&["still.toml", "no free parameters", "[free]"]);
    bench
        .dgd("simulate two_tanks.csv --system still.toml")
        .done();
    bench
        .dgd("sensitivities two_tanks.csv --system still.toml --out s")
        .refused(&["no free parameters"]);
}

#[test]
fn a_column_in_another_unit_than_the_instrument_reads_is_told() {
    let bench = benches();
    let recording = bench.text("two_tanks.csv").replacen("s,V,cm", "s,V,m", 1);
    bench.write("metres.csv", recording);
    let ran = bench.dgd("simulate metres.csv --system two_tanks.toml");
    assert!(
        ran.err.contains("written in m") && ran.err.contains("cm"),
        "{}",
        ran.err
    );
}

#[test]
fn results_never_replace_the_description_and_a_failed_fit_leaves_nothing() {
    let bench = benches();
    let before = bench.names();
    bench
        .dgd("fit two_tanks.csv --system two_tanks.toml --out two_tanks.toml")
        .refused(&["input of this run"]);
    // The simulation would stand where the recording stands.
    bench
        .dgd("fit two_tanks.csv --system return_line.toml --out fitted.toml")
        .refused(&["two_tanks.csv"]);
    bench
        .dgd("fit two_tanks.csv --system two_tanks.toml --out model.html")
        .refused(&["model.html"]);
    assert_eq!(bench.names(), before);
}
