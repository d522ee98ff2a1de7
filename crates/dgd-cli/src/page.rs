//! The report of a fit and its simulations, as one page.

use crate::commands::fit::Fitted;
use crate::figures::{self, Units};
use crate::say::{self, brief, count, number};
use dgd_identify::Estimate;
use dgd_replay::{Deviation, Pair, Replay};
use dgd_report::{Page, ReportError, Table};

/// The two equations of the model (3.45, 3.46).
const EQUATIONS: [&str; 2] = [
    "<math display=\"block\"><mover><mi>h</mi><mo>˙</mo></mover><mo>=</mo><mfrac><mrow><mi>q</mi><mo>−</mo>\
     <msub><mi>q</mi><mi>in</mi></msub></mrow><msub><mi>A</mi><mi>a</mi></msub></mfrac></math>",
    "<math display=\"block\"><mi>M</mi><mo>(</mo><mi>h</mi><mo>)</mo><mover><mi>q</mi><mo>˙</mo></mover><mo>=</mo>\
     <mi>ρ</mi><mi>g</mi><mo>(</mo><msub><mi>c</mi><mn>0</mn></msub><msup><mi>ω</mi><msub><mi>n</mi><mn>0</mn></msub></msup>\
     <mo>−</mo><msub><mi>c</mi><mn>1</mn></msub><mi>ω</mi><mi>q</mi><mo>−</mo><msub><mi>c</mi><mn>2</mn></msub>\
     <msup><mi>q</mi><msub><mi>n</mi><mn>2</mn></msub></msup><mo>)</mo><mo>−</mo><mo>(</mo><mi>B</mi><mo>+</mo>\
     <mi>D</mi><msup><mi>q</mi><mn>2</mn></msup><mo>+</mo><mi>E</mi><msup><mi>q</mi><mn>3</mn></msup><mo>)</mo>\
     <mo>−</mo><mi>ρ</mi><mi>g</mi><mi>h</mi></math>",
];

/// The page of `dgd demo`: recording, screening, friction, pump, dynamics.
pub(crate) fn identified(
    title: &str,
    provenance: &str,
    fitted: &Fitted,
    runs: &[Replay; 4],
) -> Result<String, ReportError> {
    let units = Units::plain();
    let mut page = Page::new(title, lead(fitted, &runs[3]));
    let drawn = figures::identification(fitted, &units)?;
    let figure = |number: &str| drawn.iter().find(|f| f.number() == number);
    page.section("The recording")
        .paragraph(provenance)
        .paragraph(&screening_sentence(fitted))
        .table(&rejected(fitted));
    figure("3.3").map(|f| page.figure(f));
    page.section("Friction of the return line and delay of its meter")
        .paragraph(&friction_sentence(fitted));
    ["3.4", "3.5", "3.6", "3.7"]
        .iter()
        .filter_map(|n| figure(n))
        .for_each(|f| {
            page.figure(f);
        });
    page.section("Head of the subsea pump")
        .paragraph(&pump_sentence(fitted));
    ["3.9", "3.10", "3.11"]
        .iter()
        .filter_map(|n| figure(n))
        .for_each(|f| {
            page.figure(f);
        });
    page.section("The model");
    for equation in EQUATIONS {
        page.formula(equation)?;
    }
    page.table(&parameters(fitted));
    if !fitted.identification.warnings.is_empty() {
        page.paragraph("Before using it, note:")
            .list(&fitted.identification.warnings);
    }
    page.section("The model runs beside the recording")
        .table(&deviations(runs));
    for figure in figures::simulations(runs, &units)? {
        page.figure(&figure);
    }
    Ok(page.html())
}

/// The page of `dgd mask`: the friction and pump figures in percent, nothing else.
pub(crate) fn masked(
    fitted: &Fitted,
    references: &dgd_units::MaskReferences,
) -> Result<String, ReportError> {
    let mut page = Page::new(
        "Return line in percent",
        "Flow, friction, pump head and riser level are percentages of undisclosed references.",
    );
    page.section("Figures");
    for figure in figures::identification(fitted, &Units::percent(references))? {
        page.figure(&figure);
    }
    Ok(page.html())
}

fn lead(fitted: &Fitted, coupled: &Replay) -> String {
    let model = &fitted.identification.model;
    let kept = 100.0 * model.data.kept as f64 / model.data.samples.max(1) as f64;
    let level = coupled.level_m.deviation().map_or(String::new(), |d| {
        format!(" In a free run over {} h the riser level is off by {} m (root mean square; {} m at most).",
            brief((coupled.time_s.len() as f64 * model.data.step_s) / 3600.0), brief(d.rmse), brief(d.largest))
    });
    format!(
        "The return flow meter is {} s late; the error of friction is {} bar and of pump head {} m (root mean square) over {} samples, {kept:.0} % \
         of the recording.{level}",
        brief(model.delay_s),
        brief(model.friction.mse_pa2.sqrt() * 1e-5),
        brief(model.pump.mse_m2.sqrt()),
        count(model.data.kept),
    )
}

fn screening_sentence(fitted: &Fitted) -> String {
    let data = &fitted.identification.model.data;
    format!(
        "{} samples, one every {} s. {} can be used: pump on, pressure rising across it, flow positive, no stuck or spiking transmitter.",
        count(data.samples),
        brief(data.step_s),
        count(data.kept)
    )
}

fn rejected(fitted: &Fitted) -> Table {
    let rows = fitted.prepared.tally.iter().filter(|t| t.total > 0);
    Table {
        caption: "Samples rejected; one may have several reasons".into(),
        head: vec![
            "Reason".into(),
            "Samples".into(),
            "Rejected for this reason first".into(),
        ],
        rows: rows
            .map(|t| vec![t.name.to_owned(), count(t.total), count(t.first)])
            .collect(),
    }
}

fn friction_sentence(fitted: &Fitted) -> String {
    let id = &fitted.identification;
    let root = |mse: f64| brief(mse.sqrt() * 1e-5);
    let first = id.undelayed.as_ref().map_or(String::new(), |f| {
        format!(
            "With the flow as metered, C q + D q² leaves {} bar. ",
            root(f.mse_pa2)
        )
    });
    let last = id.cubic.as_ref().map_or(String::new(), |f| {
        format!(
            " An offset and a cubic term instead of the linear one leave {} bar.",
            root(f.mse_pa2)
        )
    });
    format!(
        "{first}Read {} s later it leaves {} bar.{last}",
        brief(id.sweep.delays_s[id.sweep.best]),
        root(id.sweep.fit.mse_pa2)
    )
}

fn pump_sentence(fitted: &Fitted) -> String {
    let pump = &fitted.identification.pump;
    let plain = pump.plain.as_ref().map_or(String::new(), |f| {
        let shape = if f.curve.c2 < 0.0 {
            "but curves upwards (c2 < 0), which no pump does"
        } else {
            "and curves downwards"
        };
        format!(
            "With exponents 2 and 2 the fit leaves {} m {shape}. ",
            brief(f.mse_m2.sqrt())
        )
    });
    match &pump.search {
        Some(Ok(search)) => format!(
            "{plain}With exponents {} and {}, found under c1, c2 > 0 and n2 > 1, it leaves {} m.",
            brief(search.fit.curve.n0),
            brief(search.fit.curve.n2),
            brief(search.fit.mse_m2.sqrt())
        ),
        _ => plain,
    }
}

fn parameters(fitted: &Fitted) -> Table {
    let model = &fitted.identification.model;
    let row = |name: &str, estimate: &Estimate, unit: &str| {
        let [value, error] = estimate.standard_error.map_or_else(
            || [number(estimate.value), "held".to_owned()],
            |error| say::with_error(estimate.value, error),
        );
        vec![name.to_owned(), value, error, unit.to_owned()]
    };
    let letters = [
        ("B", "Pa"),
        ("C", "Pa/(m³/s)"),
        ("D", "Pa/(m³/s)²"),
        ("E", "Pa/(m³/s)³"),
    ];
    let mut rows: Vec<Vec<String>> = model
        .friction
        .terms
        .iter()
        .map(|t| {
            let (letter, unit) = letters[usize::from(t.power.min(3))];
            row(letter, &t.coefficient, unit)
        })
        .collect();
    rows.push(row("c0", &model.pump.c0, "m/%^n0"));
    rows.push(row("c1", &model.pump.c1, "m/(% m³/s)"));
    rows.push(row("c2", &model.pump.c2, "m/(m³/s)^n2"));
    for (name, value, unit) in [
        ("n0", model.pump.n0, ""),
        ("n2", model.pump.n2, ""),
        ("delay", model.delay_s, "s"),
    ] {
        rows.push(vec![name.into(), number(value), "—".into(), unit.into()]);
    }
    Table {
        caption: "Parameters; standard errors use the effective number of independent residuals"
            .into(),
        head: ["Parameter", "Value", "Standard error", "Unit"]
            .map(Into::into)
            .to_vec(),
        rows,
    }
}

fn deviations([riser, flow, steady, coupled]: &[Replay; 4]) -> Table {
    let cell = |pair: &Pair, scale: f64| match pair.deviation() {
        Some(Deviation { rmse, .. }) => number(rmse * scale),
        None => "—".into(),
    };
    let row = |name: &str, run: &Replay| {
        vec![
            name.to_owned(),
            cell(&run.level_m, 1.0),
            cell(&run.pump_flow_m3_s, 6e4),
            cell(&run.outlet_pressure_pa, 1e-5),
        ]
    };
    Table {
        caption: "Root mean square of simulated minus measured".into(),
        head: [
            "Simulation",
            "Level [m]",
            "Flow [L/min]",
            "Outlet pressure [bar]",
        ]
        .map(Into::into)
        .to_vec(),
        rows: vec![
            row("Level alone, driven by the measured flow", riser),
            row("Flow alone, driven by the measured level", flow),
            row("Steady flow at each sample", steady),
            row("Level and flow together", coupled),
        ],
    }
}
