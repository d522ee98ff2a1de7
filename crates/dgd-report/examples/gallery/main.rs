//! Writes every figure as SVG and PNG, a page of all of them, and a report of each kind of diagnosis, into the folder
//! named first:
//! `cargo run -p dgd-report --example gallery -- FOLDER`.
#![allow(clippy::unwrap_used, reason = "an example that fails should say where")]

mod diagnoses;
mod figures;
mod synthetic;

use std::error::Error;
use std::path::PathBuf;

use dgd_report::{Page, Table, diagnosis_page};

fn main() -> Result<(), Box<dyn Error>> {
    let folder = PathBuf::from(
        std::env::args()
            .nth(1)
            .ok_or("expected a folder to write to")?,
    );
    std::fs::create_dir_all(&folder)?;
    let mut page = Page::new(
        "Gallery",
        "Every figure of this crate, drawn from synthetic data.",
    );
    page.section("Model");
    page.paragraph(
        "The friction in the return line, with the flow read after its delay, is modelled as",
    );
    page.formula(
        "<math display=\"block\"><msub><mi>F</mi><mi>MRL</mi></msub><mo>=</mo><mi>B</mi><mo>+</mo><mi>D</mi>\
         <msup><mover><mi>q</mi><mo>^</mo></mover><mn>2</mn></msup><mo>+</mo><mi>E</mi>\
         <msup><mover><mi>q</mi><mo>^</mo></mover><mn>3</mn></msup></math>",
    )?;
    page.table(&Table {
        caption: "Coefficients of the synthetic data.".to_owned(),
        head: ["Coefficient", "Value", "Meaning"]
            .map(str::to_owned)
            .to_vec(),
        rows: [
            ["B", "1.0", "Offset of the pressure transmitters, %"],
            ["D", "0.004", "Quadratic term, %/%²"],
            ["E", "0.00004", "Cubic term, %/%³"],
        ]
        .map(|row| row.map(str::to_owned).to_vec())
        .to_vec(),
    });
    page.note("Nothing on this page was measured on a rig.");
    page.section("Figures");
    for (name, figure) in figures::all(305_820) {
        let alone = figure.captioned();
        std::fs::write(folder.join(format!("{name}.svg")), alone.svg())?;
        std::fs::write(folder.join(format!("{name}.png")), alone.png(2.0)?)?;
        page.figure(&figure);
    }
    page.section("Limits").list(&[
        "Letters beyond Latin and Greek show as boxes in a PNG.",
        "A page has one column.",
    ]);
    std::fs::write(folder.join("gallery.html"), page.html())?;
    for (name, diagnosis) in diagnoses::all(8) {
        let html = diagnosis_page(
            &diagnosis,
            "synthetic-8h.mat",
            "dgd diagnose synthetic-8h.mat --well well.toml --out report",
        );
        std::fs::write(folder.join(format!("diagnosis-{name}.html")), html)?;
    }
    Ok(())
}
