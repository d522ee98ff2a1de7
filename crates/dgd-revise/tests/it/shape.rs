//! What holds whatever the bench.

use crate::benches::{Draws, WELL, noisy, run, steps, told};
use dgd_assembly::{Assembly, Record};
use dgd_revise::{Options, ReviseError, Revision, Verdict, revise};

const TEXT: &str = r#"
connections = ["pump -> tank -> valve -> atmosphere"]
[components]
pump = { kind = "boundary" }
tank = { kind = "tank", area = 0.5 }
valve = { kind = "valve" }
gauge = { kind = "instrument", measures = "level", of = "tank", channel = "h" }
[inputs]
"pump.flow" = { channel = "q", between = "held" }
[initial]
"tank.level" = { start = 0.5, low = 0.0, high = 3.0 }
[free]
"valve.flow_coefficient" = { start = 3e-5, low = 1e-6, high = 1e-3 }
[record]
train.windows = [[0.0, 199.0]]
test.windows = [[200.0, 299.0]]
"#;

/// A tank whose outlet lies 0.3 m below its zero.
fn columns() -> (Vec<f64>, Vec<f64>) {
    tank(300, 0.3)
}

/// A tank whose outlet lies some metres below its zero.
fn tank(n: usize, below: f64) -> (Vec<f64>, Vec<f64>) {
    let (q, all) = tank_without_noise(n, below);
    (q, noisy(all.into_iter(), 1e-3, 3))
}

fn tank_without_noise(n: usize, below: f64) -> (Vec<f64>, Vec<f64>) {
    let q = steps(n, 10, 0.002, 0.012, 2);
    let mut level = 0.4_f64;
    let mut all = Vec::new();
    for q in &q {
        all.push(level);
        for _ in 0..100 {
            level += 0.01 * (q - 1e-4 * (9806.65 * (level + below).max(0.0)).sqrt()) / 0.5;
        }
    }
    (q, all)
}

fn with(text: &str, q: &[f64], h: &[f64], options: &Options) -> Result<Revision, ReviseError> {
    let assembly = Assembly::parse(text).unwrap();
    let record = Record {
        columns: vec![("q", q), ("h", h)],
    };
    revise(&assembly, &record, options, &mut |_| {})
}

#[test]
fn the_answer_does_not_depend_on_the_threads() {
    let (q, h) = columns();
    let [one, three] = [1, 3].map(|threads| {
        let options = Options {
            threads,
            ..Options::default()
        };
        format!("{:?}", with(TEXT, &q, &h, &options).unwrap())
    });
    assert_eq!(one, three);
}

#[test]
fn a_record_in_twice_the_unit_gives_the_same_names_and_numbers() {
    let (q, h) = columns();
    let first = with(TEXT, &q, &h, &Options::default()).unwrap();
    assert_eq!(first.findings.len(), 1, "{:?}", first.findings);
    let twice: Vec<f64> = h.iter().map(|h| 2.0 * h).collect();
    let text = TEXT.replace("channel = \"h\"", "channel = \"h\", gain = 2.0");
    let second = with(&text, &q, &twice, &Options::default()).unwrap();
    // The outlet lies 0.3 m below the zero; the reading's offset does the same to every number, in its own unit.
    assert_eq!(first.findings[0].effect, "reading_offset");
    assert_eq!(second.findings[0].effect, "reading_offset");
    for (a, b) in first.findings[0]
        .parameters
        .iter()
        .zip(&second.findings[0].parameters)
    {
        assert!((2.0 * a.value - b.value).abs() < 1e-3, "{a:?} {b:?}");
    }
    assert!((2.0 * first.outputs[0].test.1 - second.outputs[0].test.1).abs() < 1e-5);
}

#[test]
fn the_rows_of_a_relation_may_stand_in_any_order() {
    const N: usize = 300;
    for seed in 1..=2 {
        let mut draws = Draws::new(seed);
        let mut wander = 0.0;
        let rows: Vec<[f64; 4]> = (0..N)
            .map(|i| {
                let depth = 100.0 + 2000.0 * i as f64 / N as f64;
                let q = 0.01 + 0.03 * draws.unit();
                // An error that changes slowly along the depth.
                wander = 0.97 * wander + 3e3 * draws.normal();
                let bit = 500.0 * q * q / (0.95_f64 * 4e-4).powi(2);
                let pressure = 101_325.0 + 2e6 * depth * q * q + bit + wander;
                [depth, q, 2e6 * depth, pressure + 1e3 * draws.normal()]
            })
            .collect();
        let told_of = |rows: &[[f64; 4]]| {
            let [depth, q, resistance, p] = [0, 1, 2, 3].map(|k| {
                let column: Vec<f64> = rows.iter().map(|row| row[k]).collect();
                column
            });
            let columns = [
                ("depth", &*depth),
                ("q", &*q),
                ("resistance", &*resistance),
                ("p", &*p),
            ];
            told(&run(WELL, &columns))
        };
        let ascending = told_of(&rows);
        // Steps that have no factor in common with the number of rows.
        let shuffled: Vec<[f64; 4]> = (0..N).map(|i| rows[(i * 119 + 7) % N]).collect();
        assert_eq!(told_of(&shuffled), ascending, "{seed}");
    }
}

#[test]
fn missing_readings_are_left_out() {
    let (q, mut h) = columns();
    h[50..80].fill(f64::NAN);
    let found = with(TEXT, &q, &h, &Options::default()).unwrap();
    assert_eq!(found.findings.len(), 1);
    assert!(found.outputs[0].test.1 < 1.3e-3, "{:?}", found.outputs);
}

#[test]
fn a_reading_that_the_log_holds_between_updates_leaves_a_sound_model_consistent() {
    let text = TEXT
        .replace("[[0.0, 199.0]]", "[[0.0, 799.0]]")
        .replace("[[200.0, 299.0]]", "[[800.0, 999.0]]");
    let (q, fresh) = tank(1000, 0.0);
    // Every sample is logged, of an instrument that reads every fifth.
    let h: Vec<f64> = (0..1000).map(|i| fresh[i / 5 * 5]).collect();
    let found = with(&text, &q, &h, &Options::default()).unwrap();
    assert_eq!(found.verdict, Verdict::Consistent, "{:?}", found.checks);
    let told = |(name, value): &(String, String)| name.contains("the log repeats") && value == "5";
    assert!(found.settings.iter().any(told), "{:?}", found.settings);
}

#[test]
fn an_instrument_read_every_third_sample_shows_what_it_showed_in_every_one() {
    let (q, mut h) = columns();
    for (i, h) in h.iter_mut().enumerate() {
        if i % 3 != 0 {
            *h = f64::NAN;
        }
    }
    let found = with(TEXT, &q, &h, &Options::default()).unwrap();
    let effects: Vec<&str> = found.findings.iter().map(|f| f.effect.as_str()).collect();
    assert_eq!(effects, ["reading_offset"], "{:?}", found.checks);
}

#[test]
fn an_experiment_done_twice_shows_what_it_shows_once() {
    let text = TEXT
        .replace("[[0.0, 199.0]]", "[[0.0, 199.0], [200.0, 399.0]]")
        .replace("[[200.0, 299.0]]", "[[400.0, 499.0]]");
    let (once, clean) = tank_without_noise(300, 0.3);
    let twice = |x: &[f64]| [&x[..200], &x[..200], &x[200..]].concat();
    // With these the noise lets the second run explain more of the first than its own.
    for seed in [1, 3] {
        let h = noisy(twice(&clean).into_iter(), 1e-3, seed);
        let found = with(&text, &twice(&once), &h, &Options::default()).unwrap();
        let effects: Vec<&str> = found.findings.iter().map(|f| f.effect.as_str()).collect();
        assert_eq!(effects, ["reading_offset"], "{:?}", found.checks);
    }
}

#[test]
fn a_test_part_of_few_readings_withdraws_nothing() {
    let (q, h) = columns();
    let text = TEXT.replace("[[200.0, 299.0]]", "[[200.0, 209.0]]");
    let found = with(&text, &q, &h, &Options::default()).unwrap();
    assert_eq!(found.findings.len(), 1, "{:?}", found.checks);
    assert_eq!(found.findings[0].effect, "reading_offset");
    let mut checks = found.checks.iter();
    let stands = checks.find(|c| c.name == "stands on the test part");
    let stands = stands.unwrap();
    assert!(
        stands.passed && stands.detail.contains("fewer than 12 readings"),
        "{stands:?}"
    );
    assert!(!stands.detail.contains("NaN"), "{stands:?}");
}

#[test]
fn the_model_after_reads_back_and_finds_nothing_more() {
    let (q, h) = columns();
    let found = with(TEXT, &q, &h, &Options::default()).unwrap();
    let again = with(&found.after.assembly.to_toml(), &q, &h, &Options::default()).unwrap();
    assert!(again.findings.is_empty(), "{:?}", again.findings);
    assert!((again.outputs[0].test.0 - found.outputs[0].test.1).abs() < 1e-5);
}

#[test]
fn wrong_calls_are_refused() {
    let (q, h) = columns();
    let refused = |options: Options| with(TEXT, &q, &h, &options).unwrap_err();
    let name = |error: ReviseError| match error {
        ReviseError::Option { name, .. } => name,
        other => panic!("{other}"),
    };
    // Five tests of 999 draws cannot tell less than 0.005.
    for gate in [0.0, 0.0049, 1.0] {
        assert_eq!(
            name(refused(Options {
                gate,
                ..Options::default()
            })),
            "gate"
        );
    }
    assert_eq!(
        name(refused(Options {
            least_gain: 1.0,
            ..Options::default()
        })),
        "least_gain"
    );
    assert_eq!(
        name(refused(Options {
            most_effects: 0,
            ..Options::default()
        })),
        "most_effects"
    );
    assert_eq!(
        name(refused(Options {
            scored: 0,
            ..Options::default()
        })),
        "scored"
    );
    assert_eq!(
        name(refused(Options {
            pool: 1,
            ..Options::default()
        })),
        "pool"
    );
    assert!(matches!(
        with(TEXT, &q[..1], &h[..1], &Options::default()),
        Err(ReviseError::Assembly(_))
    ));
    let mostly = [vec![f64::NAN; 180], h[180..].to_vec()].concat();
    assert_eq!(
        with(TEXT, &q, &mostly, &Options::default()).unwrap_err(),
        ReviseError::TooShort {
            expected: 40,
            found: 20
        }
    );
    // An input that nothing can be run with.
    let mut wild = q.clone();
    wild[3] = 1e300;
    assert!(with(TEXT, &wild, &h, &Options::default()).is_err());
}

#[test]
fn a_held_out_stretch_of_the_recording_is_run_up_to_from_a_start_that_is_given() {
    // The level is at 0.4 m where the recording begins, and elsewhere where the held-out part does.
    let text = TEXT.replace("{ start = 0.5, low = 0.0, high = 3.0 }", "0.4");
    let q = steps(300, 10, 0.008, 0.014, 2);
    let mut level = 0.4_f64;
    let mut all = Vec::new();
    for q in &q {
        all.push(level);
        for _ in 0..100 {
            level += 0.01 * (q - 1e-4 * (9806.65 * level).sqrt()) / 0.5;
        }
    }
    assert!(
        (all[200] - 0.4).abs() > 0.05,
        "it says nothing: {}",
        all[200]
    );
    let h = noisy(all.into_iter(), 1e-3, 3);
    let found = with(&text, &q, &h, &Options::default()).unwrap();
    let gauge = &found.outputs[0];
    assert!(
        gauge.test.0 < 1.3 * gauge.training.0,
        "held out {:?}, trained {:?}",
        gauge.test,
        gauge.training
    );
}

/// A pump into a line between two transmitters; nothing in it has a level.
const STANDPIPE: &str = r#"
connections = ["pump -> string -> bit -> atmosphere"]
[components]
pump = { kind = "boundary" }
string = { kind = "line", friction = "polynomial" }
bit = { kind = "orifice", discharge_coefficient = 0.95, area = 4e-4 }
spp = { kind = "instrument", measures = "pressure", of = "string.inlet", channel = "p", unit = "bar" }
below = { kind = "instrument", measures = "pressure", of = "bit.inlet", channel = "b", unit = "bar" }
[inputs]
"pump.flow" = { channel = "q", unit = "m3/s" }
[free]
"string.quadratic" = { start = 5e9, low = 1e8, high = 1e11 }
[record]
time = "t"
train.windows = [[0.0, 1799.0]]
test.windows = [[1800.0, 2397.0]]
"#;

#[test]
fn without_a_tank_the_record_says_what_is_usual_and_the_model_keeps_it() {
    let t: Vec<f64> = (0..800).map(|i| 3.0 * f64::from(i)).collect();
    let q = steps(800, 20, 0.02, 0.04, 5);
    let bit = |q: f64| 1e-5 * (101_325.0 + 500.0 * (q / (0.95 * 4e-4)).powi(2));
    let pipe = |q: f64| 1e-5 * 7e9 * q * q;
    let below = noisy(q.iter().map(|q| bit(*q)), 0.1, 7);
    // A standpipe transmitter that follows with 60 s, thirty times an estimate without the record.
    let mut lagged = bit(q[0]) + pipe(q[0]);
    let spp = noisy(
        q.iter().map(|q| {
            lagged += (bit(*q) + pipe(*q) - lagged) * (1.0 - (-3.0_f64 / 60.0).exp());
            lagged
        }),
        0.1,
        8,
    );
    let assembly = Assembly::parse(STANDPIPE).unwrap();
    let record = Record {
        columns: vec![("t", &t), ("q", &q), ("p", &spp), ("b", &below)],
    };
    let found = revise(&assembly, &record, &Options::default(), &mut |_| {}).unwrap();
    let lag = &found.findings[0];
    assert_eq!(
        (lag.effect.as_str(), lag.component.as_str()),
        ("reading_lag", "spp")
    );
    let tau = &lag.parameters[0];
    assert!(!tau.at_bound && (tau.value - 60.0).abs() < 6.0, "{tau:?}");
    // What is written down runs as what was told.
    let after = Assembly::parse(&found.after.assembly.to_toml()).unwrap();
    let runs = after.held_out(&record).unwrap();
    let (number, run) = runs[0].run(&after);
    let simulated = after
        .simulate(
            &found.after.theta,
            run,
            number,
            &Options::default().simulation,
        )
        .unwrap();
    let told = &found
        .traces
        .iter()
        .find(|trace| trace.test)
        .unwrap()
        .outputs[0]
        .after;
    let from = simulated.outputs[0].len() - told.len();
    let apart = (simulated.outputs[0][from..].iter().zip(told))
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max);
    assert!(apart < 1e-2 * told[0].abs(), "{apart} of {}", told[0]);
}
