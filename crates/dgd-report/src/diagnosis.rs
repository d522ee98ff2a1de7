//! The report of a diagnosis: the answer, where, what, the equation, the fit, the checks.

mod answer;
mod cause;
mod checks;
mod correction;
mod draw;
mod equation;
mod fit;
mod glossary;
mod html;
mod place;
mod plain;
mod quantity;
mod symbol;
mod token;
mod words;

use dgd_diagnose::Diagnosis;

use crate::page::Page;
use html::Html;

const STYLE: &str = include_str!("diagnosis/report.css");

/// Writes one section.
type Write = fn(&Diagnosis, &mut Html);

/// The report of a diagnosis as one self-contained HTML page: no network, no script, readable on paper.
///
/// - `recording`: name of the recording, for people.
/// - `command`: the command line that repeats the diagnosis.
///
/// Six sections whatever the verdict: the answer in a sentence, where (a timeline by relation), what (candidates and
/// what would separate them), the equation before and after, the fit on the held-out windows, and the checks with
/// every effect that was tested. The series are thinned to what paper can show, so the page stays below 0.5 MB
/// whatever the length of the recording. Values that are not finite are shown as a dash or left out; text is escaped.
///
/// ```
/// # use dgd_diagnose::{Diagnosis, Simulation, Verdict};
/// # use dgd_effects::{AugmentedModel, Curves, FRICTION_TERMS, HEAD_TERMS, Noise, Scale, Setting};
/// # let model = AugmentedModel {
/// #     curves: Curves {
/// #         scale: Scale { flow_m3_s: 0.05, speed_pct: 50.0, laminar: None },
/// #         friction: [0.0; FRICTION_TERMS],
/// #         head: [0.0; HEAD_TERMS],
/// #     },
/// #     speed_range_pct: (0.0, 100.0),
/// #     ratio_range: (0.0, 1.0),
/// #     span_s: None,
/// #     inlet_range_pa: None,
/// #     effects: Vec::new(),
/// # };
/// # let setting = Setting {
/// #     density_kg_m3: 1200.0, riser_area_m2: 0.15, line_area_m2: 0.02, line_diameter_m: 0.15,
/// #     line_length_m: 1400.0, riser_volume_m3: 200.0, span_s: (0.0, 3600.0),
/// #     inlet_range_pa: (1e6, 2e6), connections: Vec::new(), outlets: 2, noise: Noise::default(),
/// # };
/// # let simulation =
/// #     Simulation { t_s: Vec::new(), held_out: Vec::new(), valid: Vec::new(), signals: Vec::new() };
/// # let diagnosis = Diagnosis {
/// #     verdict: Verdict::Consistent, findings: Vec::new(), started_from: Vec::new(), suspected: Vec::new(), tested: Vec::new(), warnings: Vec::new(),
/// #     checks: Vec::new(),
/// #     before: model.clone(), after: model, setting, simulation, traces: Vec::new(),
/// #     held_out_s: Vec::new(), began: None, settings: Vec::new(), work: Default::default(),
/// # };
/// let html = dgd_report::diagnosis_page(&diagnosis, "rig.csv", "dgd diagnose rig.csv --well well.toml");
/// assert!(html.contains("The model leaves out nothing that this recording could show"));
/// ```
#[must_use]
pub fn diagnosis_page(diagnosis: &Diagnosis, recording: &str, command: &str) -> String {
    let mut page = Page::new(
        format!("Diagnosis of {recording}"),
        answer::headline(diagnosis),
    )
    .styled(STYLE);
    let sections: [(&str, Write); 6] = [
        ("The answer", answer::write),
        ("Where", place::write),
        ("What", cause::write),
        ("The equation, before and after", equation::write),
        ("The fit, before and after", fit::write),
        ("Checks, limits and settings", checks::write),
    ];
    if !diagnosis.warnings.is_empty() {
        page.section("Before you read on")
            .paragraph(
                "The recording or its well description may be at fault. If a line below is right, the rest of this report is not: mend that and \
                 diagnose again.",
            )
            .list(&diagnosis.warnings);
    }
    for (heading, write) in sections {
        let mut html = Html::default();
        write(diagnosis, &mut html);
        page.section(heading).raw(html.text());
    }
    let mut foot = Html::default();
    foot.open("div", "foot")
        .paragraph("To repeat this diagnosis:")
        .code_block(command)
        .close("div");
    page.raw(foot.text());
    page.html()
}

/// Letter of a finding on the page: A, B, C.
fn letter(index: usize) -> char {
    u8::try_from(index)
        .ok()
        .filter(|&i| i < 26)
        .map_or('+', |i| char::from(b'A' + i))
}
