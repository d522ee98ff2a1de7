//! Input that cannot be used: status 2, with the file and the place in it.

use crate::bench::{Bench, TAGS, WELL, mat5, recording};

#[test]
fn a_missing_file_is_named() {
    let bench = Bench::new();
    bench
        .dgd("fit no.mat --well well.toml")
        .refused(&["no.mat", "cannot be read"]);
    bench
        .dgd("fit rig.mat --well no.toml")
        .refused(&["no.toml", "cannot be read"]);
    bench.dgd("inspect no.mat").refused(&["no.mat"]);
    bench.dgd("convert no.mat out.csv").refused(&["no.mat"]);
    bench
        .dgd("simulate rig.mat --well well.toml --model no.toml")
        .refused(&["no.toml"]);
}

#[test]
fn a_folder_in_place_of_a_recording_is_named() {
    let bench = Bench::new();
    std::fs::create_dir(bench.path("recordings")).unwrap();
    bench
        .dgd("fit recordings --well well.toml")
        .refused(&["recordings", "folder"]);
    bench
        .dgd("inspect recordings")
        .refused(&["recordings", "folder"]);
    bench
        .dgd("fit rig.mat --well recordings")
        .refused(&["recordings"]);
}

#[test]
fn an_empty_file_is_named() {
    let bench = Bench::new();
    bench.write("empty.mat", "");
    bench.write("empty.csv", "");
    bench
        .dgd("fit empty.mat --well well.toml")
        .refused(&["empty.mat", "empty"]);
    bench
        .dgd("inspect empty.csv")
        .refused(&["empty.csv", "empty"]);
}

#[test]
fn a_file_cut_short_is_refused_wherever_it_was_cut() {
    let bench = Bench::new();
    let whole = bench.bytes("rig.mat");
    bench.dgd("convert rig.mat rig.mcap").done();
    bench.dgd("convert rig.mat rig73.mat --mat-v73").done();
    for share in [0.3, 0.9] {
        for name in ["rig.mat", "rig73.mat"] {
            let bytes = if name == "rig.mat" {
                whole.clone()
            } else {
                bench.bytes(name)
            };
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "a share of a length"
            )]
            let cut = (bytes.len() as f64 * share) as usize;
            bench.write("cut.mat", &bytes[..cut]);
            bench
                .dgd("fit cut.mat --well well.toml")
                .refused(&["cut.mat"]);
        }
    }
    bench.write("cut.mat", &whole[..100]);
    bench.dgd("inspect cut.mat").refused(&["cut.mat"]);
}

#[test]
fn prose_named_mat_is_refused() {
    let bench = Bench::new();
    bench.write(
        "letter.mat",
        "Dear all,\n\nplease find attached the recording of last week.\n",
    );
    bench
        .dgd("fit letter.mat --well well.toml")
        .refused(&["letter.mat"]);
}

#[test]
fn a_wrong_unit_is_shown_at_its_line() {
    let bench = Bench::new();
    bench.write(
        "well.toml",
        WELL.replace("\"QXRET17\", unit = \"gpm\"", "\"QXRET17\", unit = \"gmp\""),
    );
    let ran = bench.dgd("fit rig.mat --well well.toml");
    ran.refused(&["well.toml:16:", "gmp", "return_flow"]);
}

#[test]
fn every_wrong_line_is_shown_at_once() {
    let bench = Bench::new();
    bench.write(
        "well.toml",
        WELL.replace("1083.7 kg/m3", "1083.7 psi")
            .replace("0.49537 m", "-1 m"),
    );
    bench
        .dgd("fit rig.mat --well well.toml")
        .refused(&["well.toml:2:", "well.toml:5:"]);
}

#[test]
fn a_tag_that_the_recording_lacks_is_named_with_its_channel() {
    let bench = Bench::new();
    bench.write("well.toml", WELL.replace("QXRET17", "QXRET18"));
    bench.dgd("fit rig.mat --well well.toml").refused(&[
        "rig.mat",
        "return_flow",
        "QXRET18",
        "QXMUD17",
    ]);
}

#[test]
fn a_window_outside_the_recording_is_refused() {
    let bench = Bench::new();
    bench.dgd("fit rig.mat --well well.toml").done();
    bench
        .dgd("simulate rig.mat --well well.toml --window 90000:91000")
        .refused(&["rig.mat", "90000"]);
    bench
        .dgd("simulate rig.mat --well well.toml --window 200:100")
        .refused(&["200 is after 100"]);
    assert!(!bench.path("simulation.csv").exists());
}

#[test]
fn a_model_of_another_schema_is_shown_at_its_line() {
    let bench = Bench::new();
    bench.dgd("fit rig.mat --well well.toml").done();
    let model = bench.text("model.toml");
    let line = model.lines().position(|l| l.starts_with("schema")).unwrap();
    let schema = model.lines().nth(line).unwrap();
    bench.write(
        "other.toml",
        model.replace(schema, "schema = \"dgd.model/99\""),
    );
    let place = format!("other.toml:{}:", line + 1);
    bench
        .dgd("simulate rig.mat --well well.toml --model other.toml")
        .refused(&[&place, "dgd.model/99"]);
}

#[test]
fn a_recording_with_the_pump_off_throughout_says_why_nothing_is_left() {
    let bench = Bench::new();
    let mut table = recording(1000);
    table.columns[9].values.fill(0.0);
    assert_eq!(table.columns[9].tag, TAGS[8]);
    bench.write("off.mat", mat5(&table));
    bench.dgd("fit off.mat --well well.toml").refused(&[
        "off.mat",
        "none of 1000 samples passed the screening",
        "pump",
    ]);
}

#[test]
fn arguments_that_go_together_badly_are_refused() {
    let bench = Bench::new();
    bench
        .dgd("convert rig.mat rig.xlsx")
        .refused(&["rig.xlsx", ".csv, .mcap or .mat"]);
    bench
        .dgd("fit rig.mat --well well.toml --delays 5")
        .refused(&["--delays"]);
    bench
        .dgd("fit rig.mat --well well.toml --delays 0:9e9")
        .refused(&["--delays"]);
    bench
        .dgd("simulate rig.mat --well well.toml --level=3psi")
        .refused(&["--level", "psi"]);
    bench
        .dgd("simulate rig.mat --well well.toml --tolerance=-1")
        .refused(&["--tolerance"]);
    bench.dgd("fit").refused(&["Usage"]);
    bench.dgd("").refused(&["Usage"]);
}

#[test]
fn a_start_that_no_riser_has_is_refused() {
    let bench = Bench::new();
    bench.dgd("fit rig.mat --well well.toml").done();
    for (start, part) in [
        ("--level=-5m", "--level"),
        ("--level=99999m", "--level"),
        ("--flow=-800gpm", "--flow"),
    ] {
        bench
            .dgd(&format!("simulate rig.mat --well well.toml {start}"))
            .refused(&[part, "expected between"]);
    }
}
