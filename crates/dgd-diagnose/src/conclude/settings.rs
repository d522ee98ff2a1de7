//! How a diagnosis came about, for whoever repeats it.

use crate::cost::Work;
use crate::record::Record;
use crate::selection::Selection;
use crate::suction::ALLOWED_HEADS;

/// Names and values of what the recording and the search set.
pub(super) fn settings(
    record: &Record,
    windows: &[(f64, f64)],
    selection: &Selection,
    work: Work,
) -> Vec<(String, String)> {
    let seconds = record.block_s();
    let listed = |each: Vec<String>, none: &str| match each.as_slice() {
        [] => none.to_owned(),
        each => each.join(", "),
    };
    let allowed = selection.allowances.iter().filter(|a| a.allowance);
    let allowed = allowed.map(|a| format!("{} {} s", a.id(), a.parameters[0]));
    let seldom = (record.seldom.iter())
        .map(|(channel, every_s)| format!("{channel} every {} s", (10.0 * every_s).round() / 10.0));
    [
        ("working clock", format!("{} s", record.dt_s)),
        ("block of relation residuals", format!("{seconds} s")),
        ("row of the mass balance", format!("{} s", record.row_s())),
        (
            "held out",
            format!("{} windows of {:.0} s", windows.len(), windows.first().map_or(0.0, |w| w.1 - w.0)),
        ),
        ("timing allowed for", listed(allowed.collect(), "nothing")),
        (
            "on straight lines between readings",
            listed(seldom.collect(), "no channel"),
        ),
        (
            "friction curve",
            match record.laminar {
                Some(laminar) => format!(
                    "laminar below {:.0} L/min, with the flow to the power of {}",
                    6e4 * laminar.below_m3_s, laminar.index
                ),
                None => "turbulent".to_owned(),
            },
        ),
        (
            "suction loss",
            match record.suction_heads {
                Some(heads) => format!("{heads:.2} velocity heads of the return line"),
                None => format!(
                    "unknown (no riser transmitter, or too little change in flow): not corrected for; every hurdle is raised by the evidence a \
                     loss of {ALLOWED_HEADS} velocity heads would produce"
                ),
            },
        ),
        ("work", told(work, record.t_s.len())),
    ]
    .map(|(name, value)| (name.to_owned(), value))
    .into()
}

/// What a diagnosis cost, in words.
fn told(work: Work, samples: usize) -> String {
    format!(
        "{} hypotheses tested, relations run over {:.0} recording lengths, base curves fitted {} times",
        work.hypotheses,
        work.samples_run as f64 / samples as f64,
        work.fits
    )
}
