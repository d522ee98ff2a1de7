//! What holds whatever the bench.

use crate::benches::{noisy, steps};
use dgd_assembly::{Assembly, Record};
use dgd_revise::{Options, ReviseError, Revision, TestStart, revise};

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
    let q = steps(300, 10, 0.002, 0.012, 2);
    let mut level = 0.4_f64;
    let mut all = Vec::new();
    for q in &q {
        all.push(level);
        for _ in 0..100 {
            level += 0.01 * (q - 1e-4 * (9806.65 * (level + 0.3)).sqrt()) / 0.5;
        }
    }
    (q, noisy(all.into_iter(), 1e-3, 3))
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
fn missing_readings_are_left_out() {
    let (q, mut h) = columns();
    h[50..80].fill(f64::NAN);
    let found = with(TEXT, &q, &h, &Options::default()).unwrap();
    assert_eq!(found.findings.len(), 1);
    assert!(found.outputs[0].test.1 < 1.3e-3, "{:?}", found.outputs);
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
    assert_eq!(
        name(refused(Options {
            gate: 0.0,
            ..Options::default()
        })),
        "gate"
    );
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
    let start = Options {
        test_start: TestStart::FirstSamples(0.0),
        ..Options::default()
    };
    assert_eq!(name(refused(start)), "test_start");
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
