//! A channel map proposed from names, units and ranges.

use crate::{ColumnSurvey, TableSurvey};
use dgd_units::Dimension;

/// A proposed channel map; a person should read it before it is used.
#[derive(Debug, Clone, PartialEq)]
pub struct Proposal {
    /// Channels with a column proposed for them, in the order of Table 2.1.
    pub channels: Vec<ProposedChannel>,
    /// Names of needed channels for which nothing was found.
    pub missing: Vec<&'static str>,
    /// Things that look wrong or that only a person can decide.
    pub doubts: Vec<String>,
}

/// A column proposed for a channel.
#[derive(Debug, Clone, PartialEq)]
pub struct ProposedChannel {
    /// Channel name in `well.toml`.
    pub channel: &'static str,
    /// Column name.
    pub tag: String,
    /// Unit to write into `well.toml`; of a tachometer also what it reads at full speed is to be written.
    pub unit: String,
    /// Why the unit is assumed, if it is not the file's.
    pub unit_assumed: Option<String>,
    /// Why this column.
    pub reason: String,
}

struct Wanted {
    channel: &'static str,
    dimension: Dimension,
    /// The transmitter's name in Table 2.1, then words that name the quantity.
    names: &'static [&'static [&'static str]],
    most: usize,
    needed: bool,
    /// Unit assumed where the file says none.
    usual: &'static str,
}

const WANTED: &[Wanted] = &[
    Wanted {
        channel: "mud_pump_flow",
        dimension: Dimension::FlowRate,
        names: &[
            &["ft1"],
            &["mud", "pump"],
            &["qp"],
            &["pump", "flow"],
            &["flow", "in"],
            &["flowin"],
            &["standpipe", "flow"],
        ],
        most: 1,
        needed: true,
        usual: "gpm",
    },
    Wanted {
        channel: "booster_flow",
        dimension: Dimension::FlowRate,
        names: &[&["ft2"], &["boost"], &["qbp"]],
        most: 1,
        needed: true,
        usual: "gpm",
    },
    Wanted {
        channel: "topfill_flow",
        dimension: Dimension::FlowRate,
        names: &[&["ft3"], &["topfill"], &["top", "fill"], &["qtf"]],
        most: 1,
        needed: true,
        usual: "gpm",
    },
    Wanted {
        channel: "return_flow",
        dimension: Dimension::FlowRate,
        names: &[
            &["ft4"],
            &["return"],
            &["mrl"],
            &["flow", "out"],
            &["flowout"],
        ],
        most: 1,
        needed: true,
        usual: "gpm",
    },
    Wanted {
        channel: "pump_inlet_pressure",
        dimension: Dimension::Pressure,
        names: &[
            &["pt1"],
            &["pt2"],
            &["inlet"],
            &["suction"],
            &["spmin"],
            &["pin"],
        ],
        most: 2,
        needed: true,
        usual: "psia",
    },
    Wanted {
        channel: "pump_outlet_pressure",
        dimension: Dimension::Pressure,
        names: &[
            &["pt3"],
            &["pt4"],
            &["outlet"],
            &["disch"],
            &["spmout"],
            &["pout"],
        ],
        most: 2,
        needed: true,
        usual: "psia",
    },
    Wanted {
        channel: "riser_pressure",
        dimension: Dimension::Pressure,
        names: &[&["pt5"], &["riser"]],
        most: 1,
        needed: false,
        usual: "psia",
    },
    Wanted {
        channel: "pump_speed",
        dimension: Dimension::Percent,
        names: &[&["spm"], &["st1"], &["speed"], &["wssp"], &["omega"]],
        most: 1,
        needed: true,
        usual: "%",
    },
];

/// Names of the tachometer of the subsea pump: the pumps at the rig and the drill string turn too.
const TACHOMETER: &[&[&str]] = &[
    &["st1"],
    &["ssp", "rpm"],
    &["ssp", "speed"],
    &["subsea", "pump"],
    &["subsea", "speed"],
    &["pump", "speed"],
    &["wssp"],
    &["omega"],
];
const OTHER_TACHOMETERS: [&str; 4] = ["mud", "boost", "charge", "stroke"];

/// Words of columns in percent that are no speeds.
const OTHER_PERCENT: [&str; 9] = [
    "flow", "choke", "valve", "open", "level", "paddle", "torque", "gas", "position",
];

/// Proposes which column is which channel, by name and unit, and says what is doubtful.
pub fn propose_channels(survey: &TableSurvey) -> Proposal {
    let mut taken = vec![false; survey.columns.len()];
    let mut proposal = Proposal {
        channels: Vec::new(),
        missing: Vec::new(),
        doubts: Vec::new(),
    };
    match survey.time_column {
        Some(index) => {
            taken[index] = true;
            let column = &survey.columns[index];
            let written = column.unit.filter(|u| u.dimension == Dimension::Time);
            let (unit, reason) = if survey.counts_days() {
                ("d", "increases like time, in days as in spreadsheets")
            } else {
                (
                    written.map_or("s", |u| u.symbol),
                    "named like time, or increasing like it",
                )
            };
            proposal.channels.push(ProposedChannel {
                channel: "time",
                tag: column.tag.clone(),
                unit: unit.to_owned(),
                unit_assumed: written.is_none().then(|| why_assumed(column)),
                reason: reason.into(),
            });
        }
        None => proposal.missing.push("time"),
    }
    for wanted in WANTED {
        let before = proposal.channels.len();
        for words in wanted.names {
            for (index, column) in survey.columns.iter().enumerate() {
                let full = proposal.channels.len() - before >= wanted.most;
                // `Flow Out (%)` is no flow rate either.
                let percent = column.unit.is_none() && column.tag.contains('%');
                let other_dimension = column.unit.is_some_and(|u| u.dimension != wanted.dimension)
                    || (percent && wanted.dimension != Dimension::Percent);
                if full
                    || taken[index]
                    || other_dimension
                    || column.range.is_none()
                    || !matches(&column.tag, words)
                {
                    continue;
                }
                taken[index] = true;
                let unit = column.unit.map_or(wanted.usual, |u| u.symbol);
                // The thesis's psi are absolute (section 2.6); the file leaves it open.
                let unit = if unit == "psi" { "psia" } else { unit };
                let unit_assumed = column.unit.is_none().then(|| why_assumed(column));
                let unit_reason = match (&column.unit_written, &unit_assumed) {
                    (None, _) => format!("no unit in the file, `{unit}` assumed"),
                    (Some(_), Some(why)) => format!("{why}, `{unit}` assumed"),
                    (Some(written), None) if column.tag.ends_with(written.as_str()) => {
                        format!("unit `{written}` at its end")
                    }
                    (Some(written), None) => format!("unit `{written}`"),
                };
                proposal.channels.push(ProposedChannel {
                    channel: wanted.channel,
                    tag: column.tag.clone(),
                    unit: unit.to_owned(),
                    unit_assumed,
                    reason: format!("name has `{}`, {unit_reason}", words.join(" ")),
                });
            }
        }
        if proposal.channels.len() == before && wanted.dimension == Dimension::Percent {
            let found = tachometer(survey, &taken).or_else(|| only_percent(survey, &taken));
            proposal.channels.extend(found);
        }
        if proposal.channels.len() == before && wanted.needed {
            proposal.missing.push(wanted.channel);
        }
    }
    proposal.doubts = doubts(survey, &proposal);
    proposal
}

/// Why a column's unit must be assumed.
fn why_assumed(column: &ColumnSurvey) -> String {
    match &column.unit_written {
        None => "the file names none".into(),
        Some(written) => format!("the file's `{written}` is none that is known for it"),
    }
}

/// Pump speed from a column in revolutions.
fn tachometer(survey: &TableSurvey, taken: &[bool]) -> Option<ProposedChannel> {
    let free = || {
        survey
            .columns
            .iter()
            .zip(taken)
            .filter(|(_, taken)| !**taken)
    };
    let turns = |column: &ColumnSurvey| {
        let is_rate = (column.unit).is_some_and(|u| u.dimension == Dimension::RotationalSpeed);
        is_rate && column.range.is_some() && !has_word(column, &OTHER_TACHOMETERS)
    };
    TACHOMETER.iter().find_map(|words| {
        let (column, _) =
            free().find(|(column, _)| turns(column) && matches(&column.tag, words))?;
        Some(speed(
            column,
            format!(
                "name has `{}`, in revolutions: the full speed is to be written",
                words.join(" ")
            ),
        ))
    })
}

/// Pump speed from the one column in percent, unless its name says that it is another share.
fn only_percent(survey: &TableSurvey, taken: &[bool]) -> Option<ProposedChannel> {
    let percent = |column: &ColumnSurvey| {
        let unit = column
            .unit
            .is_some_and(|u| u.dimension == Dimension::Percent);
        unit && column.range.is_some()
    };
    let mut found = (survey.columns.iter().zip(taken)).filter(|(column, _)| percent(column));
    match (found.next(), found.next()) {
        (Some((column, false)), None) if !has_word(column, &OTHER_PERCENT) => Some(speed(
            column,
            "the only column in percent, whose name does not say what of".into(),
        )),
        _ => None,
    }
}

fn speed(column: &ColumnSurvey, reason: String) -> ProposedChannel {
    ProposedChannel {
        channel: "pump_speed",
        tag: column.tag.clone(),
        unit: column.unit.map_or("%", |u| u.symbol).to_owned(),
        unit_assumed: None,
        reason,
    }
}

/// Whether a column's name, or its unit as written, holds one of these.
fn has_word(column: &ColumnSurvey, words: &[&str]) -> bool {
    let written = column.unit_written.as_deref().unwrap_or_default();
    let text = format!("{} {written}", column.tag).to_lowercase();
    words.iter().any(|word| text.contains(word))
}

/// A short word alone must be the whole of the tag's last part, and beside others one of
/// its words (the `in` of `flow_in`, not of `flow_line`); longer ones may be part of it.
fn matches(tag: &str, words: &[&str]) -> bool {
    const SHORT: usize = 3;
    let last = tag.rsplit('.').next().unwrap_or(tag);
    let plain: String = last
        .chars()
        .filter(|c| c.is_alphanumeric())
        .flat_map(char::to_lowercase)
        .collect();
    match words {
        [only] if only.len() <= SHORT => plain == *only,
        [only] => plain.contains(only),
        many => {
            let tokens = tokens(last);
            many.iter().all(|word| {
                tokens.iter().any(|t| t == word) || word.len() > SHORT && plain.contains(word)
            })
        }
    }
}

/// `MudPump_flow` is `mud`, `pump` and `flow`.
fn tokens(name: &str) -> Vec<String> {
    let mut tokens = vec![String::new()];
    let mut lower_before = false;
    for c in name.chars() {
        if !c.is_alphanumeric() || (lower_before && c.is_uppercase()) {
            tokens.push(String::new());
        }
        lower_before = c.is_lowercase();
        if let Some(token) = tokens.last_mut().filter(|_| c.is_alphanumeric()) {
            token.extend(c.to_lowercase());
        }
    }
    tokens
}

fn doubts(survey: &TableSurvey, proposal: &Proposal) -> Vec<String> {
    let mut doubts = Vec::new();
    if let Some(time) = proposal.channels.iter().find(|c| c.channel == "time")
        && time.unit == "s"
        && survey.steps_like_days()
    {
        doubts.push(format!(
            "`{}` steps by less than a millisecond if read as s, as a clock in days would: is the unit right?",
            time.tag
        ));
    }
    let column = |channel: &str| {
        let proposed = proposal.channels.iter().find(|c| c.channel == channel)?;
        let column = survey.columns.iter().find(|c| c.tag == proposed.tag)?;
        let unit = dgd_units::Unit::parse(&proposed.unit).ok()?;
        column.range.map(|(_, median, _)| {
            (
                proposed.tag.clone(),
                proposed.unit.clone(),
                unit.to_si(median),
            )
        })
    };
    if let (Some((inlet, unit, p_in)), Some((outlet, _, p_out))) = (
        column("pump_inlet_pressure"),
        column("pump_outlet_pressure"),
    ) {
        if p_out < p_in {
            doubts.push(format!(
                "`{outlet}` is below `{inlet}` in the median: are inlet and outlet swapped?"
            ));
        }
        // A subsea inlet under less than 2 bar or more than 600 bar is no riser.
        if !(2e5..6e7).contains(&p_in) {
            doubts.push(format!(
                "`{inlet}` has a median of {:.3} bar if read as {unit}: is the unit right?",
                p_in / 1e5
            ));
        }
    }
    if let Some((tag, unit, flow)) = column("return_flow")
        && !(1e-3..0.3).contains(&flow)
    {
        doubts.push(format!(
            "`{tag}` has a median of {:.1} L/min if read as {unit}: is the unit right?",
            flow * 6e4
        ));
    }
    if let Some((tag, unit, speed)) = column("pump_speed")
        && unit == "%"
        && !(0.0..=100.0).contains(&speed)
    {
        doubts.push(format!(
            "`{tag}` has a median of {speed:.1} if read as {unit}, expected 0 to 100 %"
        ));
    }
    doubts
}
