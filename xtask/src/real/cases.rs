//! The recordings, what is asked of them, and what others have reached.

/// A file as its publisher gives it.
pub(crate) struct File {
    pub(crate) name: &'static str,
    pub(crate) sha256: &'static str,
}

/// How a recording becomes one table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Source {
    /// Read by `dgd` as it is; the held-out part is a column of its own.
    AsItIs { held_out: &'static str },
    /// One row per foot drilled; the held-out part lies between these depths, ft.
    Drilling { held_out: (f64, f64) },
    /// Files of steady operation in ten-second medians; these stretches of them, ends included, are held out.
    Bench { held_out: &'static [(f64, f64)] },
}

/// What must come out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Aim {
    /// Held-out root mean square at most this, from about that, with causes named.
    AtMost { after: f64, from: f64 },
    /// Nothing is to be found.
    Consistent,
    /// Where the cause differs is located; nothing that hurts the held-out part is claimed.
    Located,
}

/// A recording with its description.
pub(crate) struct Case {
    pub(crate) id: &'static str,
    pub(crate) title: &'static str,
    /// Folder below the one given and below `fixtures/real`.
    pub(crate) folder: &'static str,
    pub(crate) files: &'static [File],
    pub(crate) source: Source,
    /// Description below `fixtures/real/<folder>`.
    pub(crate) system: &'static str,
    /// Instrument that is scored.
    pub(crate) output: &'static str,
    pub(crate) unit: &'static str,
    /// What its samples lie along.
    pub(crate) axis: &'static str,
    pub(crate) aim: Aim,
    /// What it is, in a sentence.
    pub(crate) about: &'static str,
    /// Figures of others on the same held-out part, in the unit above.
    pub(crate) published: &'static [(&'static str, f64)],
    /// What the first run said, before anything was mended or described better, and what was changed since.
    pub(crate) history: &'static [&'static str],
    /// Most seconds of the diagnosis on an idle machine of two cores, if there is a target.
    pub(crate) seconds: Option<f64>,
}

const LOG: &[File] = &[File {
    name: "MU-ESW1_data_to_7536_TD.csv",
    sha256: "f5bad96f3e6547c224415322374c28ff015d2f1a2acf9331d381f6d4db8ee334",
}];

pub(crate) const CASES: [Case; 4] = [
    Case {
        id: "cascaded-tanks",
        title: "Cascaded tanks",
        folder: "cascaded-tanks",
        files: &[File {
            name: "dataBenchmark.mat",
            sha256: "cb2f88d4388be4d3f2a24c6402fba804976aac5f2e1f26cda59ea0a38d016eab",
        }],
        source: Source::AsItIs { held_out: "yVal" },
        system: "system.toml",
        output: "level",
        unit: "V",
        axis: "its samples, 4 s apart",
        aim: Aim::AtMost {
            after: 0.25,
            from: 0.67,
        },
        about: "Two water tanks above each other and a pump. The level of the lower one is measured, that of the upper one is not. Parameters \
                and the state at the start come from the estimation record alone; the free run goes through all 1024 samples of the \
                validation record.",
        published: &[
            ("best linear approximation", 0.757),
            ("Volterra series", 0.54),
            ("PNLSS", 0.450),
            ("Gaussian-process state space", 0.45),
            ("NLSS2", 0.343),
            ("TSEM", 0.33),
            ("tensor B-splines", 0.30),
            ("SUBNET", 0.22),
            ("grey box with explicit physics", 0.18),
        ],
        history: &[
            "Not blind: the search for pairs, the hurdles for a further effect and the classes of dgd-revise were set with this recording at hand. The \
             catalogue was not: it was written before.",
            "Since: a set that does as well as the best of its size and is surely worth its further effect is taken where the best itself is \
             not surely worth it; explicit steps where nothing is stiff; weak candidates are given up earlier. The result is the same to four digits: \
             0.2491 V before and after. What is part of the model with too little weight for a finding is told as also possible: the model is \
             the same.",
        ],
        seconds: Some(30.0),
    },
    Case {
        id: "forge-shallow",
        title: "FORGE 58-32, 85 to 2160 ft",
        folder: "utah-forge-58-32-drilling",
        files: LOG,
        source: Source::Drilling {
            held_out: (1537.55, 2160.0),
        },
        system: "shallow.toml",
        output: "standpipe",
        unit: "psi",
        axis: "the depth in feet",
        aim: Aim::AtMost {
            after: 30.0,
            from: 145.0,
        },
        about: "A geothermal well being drilled, a row per foot: standpipe pressure against flow, p = B + D q². Rows with a flow of 0 or above 1200 gpm, \
                which the source calls instrument errors, are left out. The deepest 30 % is held out, so that the model has to extrapolate.",
        published: &[("B + D q², least squares without bounds", 145.0)],
        history: &[
            "First run, blind (first/shallow.toml): standpipe.reading_drift, not told apart from drill_string.column_drift, and an unknown beside it; 158.5 to \
             41.8 psi. The cause was wrong: a drift with depth that does not depend on the flow.",
            "Not blind from the second run on. Described since: the drill string is as long as the hole is deep (shallow.toml), which the first \
             description had left out. Mended in the engine since: (1) where the re-fit drives a base parameter onto its bound (here D = 0), effects that \
             act through it were called not testable; they are now screened from inside the bounds too (first/shallow.toml stays at \
             41.8 psi). (2) A set with a member that takes no more of the squares at its place than shifted along the record was told as failed and \
             claimed all the same; it is no longer claimed (with (1) alone shallow.toml came to 37.8 psi with a reading that moves in steps). \
             (3) Sections weighed their cuts by all readings, not by those that count as independent, and were told of column_drift beside \
             the tool_joints claimed. No effect was added or changed.",
        ],
        seconds: None,
    },
    Case {
        id: "forge-whole",
        title: "FORGE 58-32, the whole well",
        folder: "utah-forge-58-32-drilling",
        files: LOG,
        source: Source::Drilling {
            held_out: (5300.75, 7536.0),
        },
        system: "whole.toml",
        output: "standpipe",
        unit: "psi",
        axis: "the depth in feet",
        aim: Aim::Located,
        about: "The same over 7,451 ft, through all bits, hole sections and muds. One relation cannot hold; what is asked is where it changes, and that \
                nothing is claimed that helps in training and hurts below.",
        published: &[],
        history: &[
            "First run, blind (first/whole.toml): drill_string.column_drift halved the error in training and made it worse where it was held out: withdrawn, \
             nothing claimed; five sections located. The same today.",
        ],
        seconds: None,
    },
    Case {
        id: "whut",
        title: "WHUT pipeline bench",
        folder: "whut-pipeline-pumps",
        files: &[
            File {
                name: "1bengzc.csv",
                sha256: "5cb211a2d726be394a8f1fc9799feb6d23f5ab681ac993a11f98938371bf1d73",
            },
            File {
                name: "2bengzc.csv",
                sha256: "066c0d8974b03a970123719dd36f72ff4344269639ec35b4936fc6f575a29fc1",
            },
            File {
                name: "3bengzc.csv",
                sha256: "94c1b5434dc5d77e67ebb749e9ec9df4e48d42ba083b56d7b1834ef63ee4176a",
            },
            File {
                name: "4bengzc.csv",
                sha256: "6d850ae308d33aeb2c44f4f5af8ec928beb0dc28654c7b3bd5e1fe2eaf7f9a3a",
            },
            File {
                name: "5bengzc.csv",
                sha256: "439dd8233854c882b99e18eff84ae8122ab91e48200803220c6d2201eda5eb9f",
            },
        ],
        source: Source::Bench {
            held_out: &[
                (45.0, 64.0),
                (107.0, 125.0),
                (170.0, 188.0),
                (242.0, 265.0),
                (315.0, 336.0),
            ],
        },
        system: "system.toml",
        output: "behind_pumps",
        unit: "MPa",
        axis: "its ten-second medians",
        aim: Aim::Consistent,
        about: "One to five pumps on a 144 m water line of DN 40, each number at steady operation. The pressure behind the pumps goes with the square of \
                the flow; ten-second medians, of each file the last 30 % held out.",
        published: &[],
        history: &[
            "Before the first run the first two rows of each file were seen, to tell the columns apart: both gauges differ by 0.006 MPa, so the line is \
             described from the gauge to its open end. The description written before that, with a gauge at either end (first/between_gauges.toml), \
             came out unexplained, with nothing claimed.",
            "First run, blind (first/system.toml): explained, wrongly: pumps.inflow_offset and behind_pumps.reading_quantisation, both with a failed placebo; \
             0.0110 to 0.0080 MPa. What is left of the square law is 0.0065 MPa in training, under 1 % of the greatest reading: \
             systematic, with five points of operation, but less than the instruments can tell.",
            "Not blind from the second run on. Described since: an accuracy of 1 % of 1 MPa, assumed, for none is published. Mended in the engine since: a base \
             that is off by no more than the accuracy stated is consistent (the accuracy of an instrument had no say); failed placebos as above \
             (with that alone it came out as pumps.inflow_drift, 0.0110 to 0.0047 MPa). Without a stated accuracy it still does.",
        ],
        seconds: None,
    },
];
