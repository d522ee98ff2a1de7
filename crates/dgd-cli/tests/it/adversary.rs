//! Somebody who has everything that `dgd mask` emits looks for the rig in it.
//!
//! What the numbers of the recording give away is tried in `dgd-mask`; here it is what is written, drawn, said and named.

use crate::bench::{Bench, DENSITY_KG_M3, DEPTH_M, Ran, TAGS, WELL, recording, riser_area_m2};
use std::time::SystemTime;

const MASK: &str =
    "mask secretname.csv --well secretwell.toml --out masked --references private/refs.toml";
/// The first sample's time of day.
const STAMP: &str = "2019-03-07T05:12:00Z";
const EPOCH_S: i64 = 1_551_935_520;

/// The recording with times of day, as CSV; the well's depths, bores and density are nowhere round.
fn stamped() -> Bench {
    let bench = Bench::bare();
    let table = recording(4000);
    let mut csv = String::from("when");
    for column in &table.columns[1..] {
        csv.push_str(&format!(
            ",{} [{}]",
            column.tag,
            column.unit.as_deref().unwrap_or("")
        ));
    }
    csv.push('\n');
    for row in 0..table.rows() {
        // 05:12:00 and 4000 s end before seven o'clock.
        let second = 5 * 3600 + 12 * 60 + row;
        let (hour, minute) = (second / 3600, second / 60 % 60);
        csv.push_str(&format!(
            "2019-03-07T{hour:02}:{minute:02}:{:02}Z",
            second % 60
        ));
        for column in &table.columns[1..] {
            csv.push_str(&format!(",{}", column.values[row]));
        }
        csv.push('\n');
    }
    assert!(csv.contains(STAMP));
    bench.write("secretname.csv", csv);
    let well = WELL.replace(
        "{ tag = \"t\", unit = \"s\" }",
        "{ tag = \"when\", unit = \"s\" }",
    );
    bench.write("secretwell.toml", well);
    bench
}

/// Every number in a text as it is spelled: digits without sign and exponent, and its value.
fn spelled(text: &str) -> Vec<(usize, f64)> {
    let number = |c: char| c.is_ascii_digit() || c == '.';
    let mut found = Vec::new();
    let mut rest = text;
    while let Some(start) = rest.find(number) {
        rest = &rest[start..];
        let end = rest.find(|c| !number(c)).unwrap_or(rest.len());
        let (digits, after) = rest.split_at(end);
        rest = after;
        let mut whole = digits.to_owned();
        if let Some(after) = rest.strip_prefix(['e', 'E']) {
            let sign = usize::from(after.starts_with(['-', '+']));
            let power = after[sign..].find(|c: char| !c.is_ascii_digit());
            let power = sign + power.unwrap_or(after.len() - sign);
            if power > sign {
                whole.push('e');
                whole.push_str(&after[..power]);
                rest = &after[power..];
            }
        }
        let significant = digits.replace('.', "");
        if let Ok(value) = whole.parse() {
            found.push((significant.trim_start_matches('0').len(), value));
        }
    }
    found
}

/// Whether a number of so many digits is the secret, rounded to as many; under four digits chance does that.
fn is(secret: f64, (digits, value): (usize, f64)) -> bool {
    (4..=17).contains(&digits) && {
        let rounded: f64 = format!("{:.*e}", digits - 1, secret).parse().unwrap();
        (rounded - value).abs() <= 1e-14 * secret
    }
}

/// What must not be found, in the units that people use.
struct Secrets {
    named: Vec<(String, f64)>,
}

impl Secrets {
    fn of(bench: &Bench) -> Self {
        let text = bench.text("private/refs.toml");
        let value = |name: &str| -> f64 {
            let line = text.lines().find(|l| l.starts_with(name)).unwrap();
            let quoted = line.split('"').nth(1).unwrap();
            quoted.split(' ').next().unwrap().parse().unwrap()
        };
        const FLOW: [f64; 6] = [1.0, 1e3, 6e4, 3600.0, 1.0 / 6.3090e-5, 377.388_6];
        const PRESSURE: [f64; 5] = [1.0, 1e-3, 1e-5, 1e-6, 1.0 / 6_894.757_29];
        const LENGTH: [f64; 5] = [1.0, 1e2, 1e3, 1.0 / 0.3048, 1.0 / 0.0254];
        const AREA: [f64; 3] = [1.0, 1.0 / 0.092_903_04, 1.0 / 6.4516e-4];
        const DENSITY: [f64; 3] = [1.0, 1e-3, 8.345_404e-3];
        let weight_pa_m = DENSITY_KG_M3 * 9.806_65;
        let bore_area_m2 = |d: f64| std::f64::consts::PI / 4.0 * d * d;
        let all: [(&str, f64, &[f64]); 14] = [
            ("flow reference", value("flow"), &FLOW),
            ("friction reference", value("friction"), &PRESSURE),
            ("head reference", value("head"), &LENGTH),
            ("level reference", value("level"), &LENGTH),
            ("depth", DEPTH_M, &LENGTH),
            ("riser bore", 0.495_37, &LENGTH),
            ("drill pipe", 0.168_33, &LENGTH),
            ("line bore", 0.152_41, &LENGTH),
            ("riser area", riser_area_m2(), &AREA),
            ("line area", bore_area_m2(0.152_41), &AREA),
            ("density", DENSITY_KG_M3, &DENSITY),
            ("weight", weight_pa_m, &PRESSURE),
            ("weight of the depth", weight_pa_m * DEPTH_M, &PRESSURE),
            ("air pressure", 101_325.0, &PRESSURE),
        ];
        let in_units = all.iter().flat_map(|(name, value, units)| {
            units
                .iter()
                .map(move |unit| ((*name).to_owned(), value * unit))
        });
        Self {
            named: in_units.collect(),
        }
    }

    fn in_text(&self, text: &str) -> Vec<String> {
        let numbers = spelled(text);
        let of = |(name, secret): &(String, f64)| {
            let hit = numbers.iter().find(|number| is(*secret, **number));
            hit.map(|(_, value)| format!("{name} as {value}"))
        };
        self.named.iter().filter_map(of).collect()
    }
}

/// Words of the owner's that no artefact may hold, and units that only the owner's numbers have.
fn words(text: &str) -> Vec<String> {
    let epoch = EPOCH_S.to_string();
    let mut words: Vec<&str> = TAGS.to_vec();
    words.extend([
        "secretname",
        "secretwell",
        "refs.toml",
        "private",
        "2019",
        "05:12",
        "Mar",
        &epoch,
    ]);
    words.extend([
        "gpm", "psi", "m3/s", "m³/s", "kg/m", " Pa", "[m]", "[bar]", "when",
    ]);
    let held = words.iter().filter(|word| text.contains(**word));
    held.map(|word| (*word).to_owned()).collect()
}

/// What a page says: the text between its tags, its titles, descriptions and attributes but for those that place things.
fn said_by(html: &str) -> String {
    let mut said = String::new();
    for part in html.split('<').skip(1) {
        let (tag, text) = part.split_once('>').unwrap_or((part, ""));
        if !tag.starts_with("style") {
            said.push_str(text);
            said.push('\n');
        }
        for attribute in [
            "id=",
            "class=",
            "aria-label=",
            "alt=",
            "title=",
            "href=",
            "content=",
        ] {
            if let Some(at) = tag.find(attribute) {
                said.push_str(&tag[at..]);
                said.push('\n');
            }
        }
        assert!(!tag.starts_with("metadata"), "{tag}");
        assert!(!tag.starts_with("!--"), "a comment: {tag}");
    }
    said
}

/// A table without its first column, which counts seconds through all numbers of four digits.
fn without_time(csv: &str) -> String {
    let rest = csv.lines().filter_map(|l| l.split_once(','));
    rest.map(|(_, rest)| format!("{rest}\n")).collect()
}

fn masked() -> (Bench, Ran, Secrets) {
    let bench = stamped();
    let ran = bench.dgd(&format!("{MASK} -vvv"));
    assert_eq!(ran.status, 0, "{}", ran.err);
    let secrets = Secrets::of(&bench);
    (bench, ran, secrets)
}

#[test]
fn what_is_looked_for_is_found_where_it_is() {
    let (bench, _, secrets) = masked();
    let well = secrets.in_text(&bench.text("secretwell.toml"));
    for name in [
        "depth as 351.37",
        "density as 1083.7",
        "riser bore as 0.49537",
    ] {
        assert!(well.contains(&name.to_owned()), "{well:?}");
    }
    assert!(secrets.in_text(&bench.text("private/refs.toml")).len() >= 4);
    // Rounded to four digits and in another unit, as a page would say it.
    let flow_gpm = secrets.named[4].1;
    for page in [
        format!("q100 = {flow_gpm:.1} gpm"),
        format!("<text>{flow_gpm:.3e}</text>"),
    ] {
        assert_eq!(secrets.in_text(&page).len(), 1, "{page}");
    }
    assert!(words("QXRET17 at 05:12 in gpm").len() == 3);
    assert_eq!(
        spelled("a-1.50e3,x=.5 7e 0.0120"),
        [(3, 1500.0), (1, 0.5), (1, 7.0), (3, 0.012)]
    );
}

#[test]
fn no_artefact_spells_a_secret_in_any_unit() {
    let (bench, _, secrets) = masked();
    for (name, text) in [
        ("model.toml", bench.text("masked/model.toml")),
        ("report.html", said_by(&bench.text("masked/report.html"))),
        (
            "recording.csv",
            without_time(&bench.text("masked/recording.csv")),
        ),
    ] {
        assert!(text.len() > 200, "{name}");
        assert_eq!(secrets.in_text(&text), [""; 0], "{name}");
    }
    // Where a picture puts things, numbers run from 1 to some hundreds and meet secrets of that size by chance.
    let large = Secrets {
        named: secrets
            .named
            .into_iter()
            .filter(|(_, v)| !(0.1..4000.0).contains(v))
            .collect(),
    };
    assert!(large.named.len() > 10);
    assert_eq!(large.in_text(&bench.text("masked/report.html")), [""; 0]);
}

#[test]
fn no_artefact_holds_a_word_of_the_owner() {
    let (bench, _, _) = masked();
    let mut names: Vec<String> = Vec::new();
    for entry in std::fs::read_dir(bench.path("masked")).unwrap() {
        let entry = entry.unwrap();
        let name = entry.file_name().into_string().unwrap();
        let mut text = bench.text(&format!("masked/{name}"));
        if name == "recording.csv" {
            let (head, body) = text.split_at(text.find("\n0,").unwrap());
            let number = |c: char| c.is_ascii_digit() || ".,-e\n".contains(c);
            assert!(body.chars().all(number), "words among the numbers");
            text = head.to_owned();
        }
        assert_eq!(words(&text), [""; 0], "{name}");
        // Dated by the masking, not by the recording.
        let age = SystemTime::now().duration_since(entry.metadata().unwrap().modified().unwrap());
        assert!(age.unwrap_or_default().as_secs() < 600, "{name}");
        names.push(name);
    }
    names.sort();
    assert_eq!(names, ["model.toml", "recording.csv", "report.html"]);
    let csv = bench.text("masked/recording.csv");
    let mut lines = csv.lines();
    assert_eq!(
        lines.next(),
        Some("t,inflow,return_flow,friction,pump_head,riser_level,pump_speed,usable")
    );
    assert_eq!(lines.next(), Some("s,%,%,%,%,%,%,1"));
    assert!(
        lines.next().is_some_and(|l| l.starts_with("0,")),
        "time counts from 0"
    );
}

#[test]
fn no_column_is_a_channel_in_a_unit_of_the_owner() {
    let (bench, _, _) = masked();
    let text = bench.text("masked/recording.csv");
    let columns = |text: &str, skip: usize| -> Vec<Vec<f64>> {
        let rows = text.lines().skip(skip).map(|l| {
            l.split(',')
                .map(|v| v.parse().unwrap_or(f64::NAN))
                .collect::<Vec<f64>>()
        });
        let rows: Vec<_> = rows.collect();
        (0..rows[0].len())
            .map(|c| rows.iter().map(|r| r[c]).collect())
            .collect()
    };
    let (shown, own) = (columns(&text, 2), columns(&bench.text("secretname.csv"), 1));
    // Factors of units, and of none.
    let units = [
        1.0,
        6.3090e-5,
        6.3090e-2,
        3.7854,
        6_894.757_29,
        6.894_757_29,
        0.068_947_57,
    ];
    for column in &shown[1..6] {
        for channel in &own[1..9] {
            let ratios: Vec<f64> = column
                .iter()
                .zip(channel)
                .map(|(a, b)| a / b)
                .filter(|r| r.is_finite())
                .collect();
            let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
            let spread = (ratios.iter().map(|r| (r - mean).powi(2)).sum::<f64>()
                / ratios.len() as f64)
                .sqrt();
            let proportional = spread < 1e-2 * mean.abs();
            let plain = units.iter().any(|u| (mean / u - 1.0).abs() < 1e-3);
            assert!(
                !(proportional && plain),
                "a channel stands in the open at factor {mean}"
            );
        }
    }
}

#[test]
fn the_terminal_and_its_log_say_no_secret() {
    let (bench, ran, secrets) = masked();
    let again = bench.dgd(&format!("{MASK} --json -vvv"));
    assert_eq!(again.status, 0, "{}", again.err);
    for said in [&ran.out, &ran.err, &again.out, &again.err] {
        assert_eq!(secrets.in_text(said), [""; 0], "{said}");
        // The files that the command line names may be named; nothing else of the owner's.
        let mut held = words(said);
        held.retain(|w| {
            !["secretname", "secretwell", "refs.toml", "private"].contains(&w.as_str())
        });
        assert_eq!(held, [""; 0], "{said}");
    }
}

#[test]
fn no_error_message_says_a_secret() {
    let (bench, _, secrets) = masked();
    let whole = bench.text("private/refs.toml");
    let first = whole.lines().position(|l| l.starts_with("flow")).unwrap();
    let line = whole.lines().nth(first).unwrap();
    let broken = [
        whole.replace(" m\"", " furlong\""),
        whole.replace(line, &line.replace("\"", "")),
        whole.replace(line, &line.replace("= \"", "= \"-")),
        whole.replace(line, ""),
        whole.replace(line, &format!("{line}\n{line}")),
        whole.replace("m3/s", "m3/s m3/s"),
        whole[..whole.len() - 20].to_owned(),
        format!("{whole}\n[extra]\nflow = 3"),
        whole.replace("head = ", "head "),
    ];
    for text in broken {
        bench.write("private/refs.toml", &text);
        let ran = bench.dgd(&format!("{MASK} -vvv"));
        assert!(ran.status == 2 || ran.status == 0, "{ran:?}");
        assert_eq!(secrets.in_text(&ran.err), [""; 0], "{text}\n{}", ran.err);
        assert_eq!(secrets.in_text(&ran.out), [""; 0], "{text}");
    }
}

/// Least squares by the normal equations; columns of like size.
fn least_squares(rows: &[([f64; 5], f64)]) -> [f64; 5] {
    let mut a = [[0.0; 6]; 5];
    for (x, y) in rows {
        for i in 0..5 {
            for j in 0..5 {
                a[i][j] += x[i] * x[j];
            }
            a[i][5] += x[i] * y;
        }
    }
    for i in 0..5 {
        let pivot = (i..5)
            .max_by(|p, q| a[*p][i].abs().total_cmp(&a[*q][i].abs()))
            .unwrap();
        a.swap(i, pivot);
        for k in 0..5 {
            if k != i {
                let factor = a[k][i] / a[i][i];
                for j in i..6 {
                    a[k][j] -= factor * a[i][j];
                }
            }
        }
    }
    std::array::from_fn(|i| a[i][5] / a[i][i])
}

#[test]
fn gravity_gives_no_length_of_the_line_that_stands_still() {
    // Friction holds M q' (Eq. 3.46), time is in seconds and gravity is known: with both bores guessed rightly,
    // L = mu phi g/(kappa lambda) A_l/A_a, where mu is found by regression and the others stand in the masked model.
    let bench = Bench::bare();
    bench.write(
        "rig.mat",
        include_bytes!("../../../../fixtures/demo/recording.mat"),
    );
    bench.write(
        "well.toml",
        include_str!("../../../../fixtures/demo/well.toml"),
    );
    bench
        .dgd("mask rig.mat --well well.toml --out masked --references r.toml")
        .done();
    let model = bench.text("masked/model.toml");
    let told = |name: &str| -> f64 {
        let line = model.lines().find(|l| l.starts_with(name)).unwrap();
        line.split(" = ").nth(1).unwrap().parse().unwrap()
    };
    let delay = told("delay_s");
    let bores = 6.0f64.powi(2) / (19.5f64.powi(2) - 6.625f64.powi(2));
    let metres = told("friction_in_head") * 9.806_65
        / (told("level_rate_per_s") * told("level_in_head"))
        * bores;
    let text = bench.text("masked/recording.csv");
    let rows: Vec<Vec<f64>> = text
        .lines()
        .skip(2)
        .map(|l| {
            l.split(',')
                .map(|v| v.parse().unwrap_or(f64::NAN))
                .collect()
        })
        .collect();
    let late = (0..60).find(|i| f64::from(*i) >= delay).unwrap();
    let late = usize::try_from(late).unwrap();
    let length_m = |averaged: usize| {
        let mean = |at: usize, column: usize, shift: usize| {
            let part = &rows[at + shift..at + shift + averaged];
            part.iter().map(|r| r[column]).sum::<f64>() / averaged as f64
        };
        let mut samples = Vec::new();
        for at in 1..rows.len() - late - averaged - 1 {
            let (flow, friction) = (mean(at, 2, late) / 100.0, mean(at, 3, 0));
            let rate = 0.5 * (mean(at + 1, 2, late) - mean(at - 1, 2, late));
            let usable = rows[at..at + averaged].iter().all(|r| r[7] > 0.5);
            if usable && (flow + friction + rate).is_finite() {
                samples.push(([1.0, flow, flow.powi(2), flow.powi(3), rate], friction));
            }
        }
        assert!(samples.len() > 3000);
        least_squares(&samples)[4] * metres
    };
    // 350.3 m it is.
    let found = [1, 3, 10].map(length_m);
    println!("length of the line by gravity, averaged over 1, 3 and 10 s: {found:.0?} m");
    let (least, most) = found
        .iter()
        .fold((f64::MAX, f64::MIN), |(l, m), v| (l.min(*v), m.max(*v)));
    assert!(most > 3.0 * least.max(0.0), "{found:?}");
}
