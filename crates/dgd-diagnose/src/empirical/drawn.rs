//! A curve through knots, drawn for what the relations leave over.

use super::smooth::{of_straight, smoothed, weighed};
use super::{Correction, Course, owed, size};
use crate::layout::Section;
use crate::numbers::tails;
use crate::record::Record;
use crate::relations::{Applied, FINE_KNOTS, joined};
use crate::tangent::Tangent;
use crate::twins::Twins;
use dgd_effects::{Curve, KNOTS, Place, Quantity, Relation};
use dgd_lsq::dot;
use nalgebra::{DMatrix, DVector};

/// The correction of one place along one quantity; `None` if the recording does not move the quantity, or if the riser's transmitter
/// (`beside_riser`) shows no such drift of the inlets.
pub(super) fn drawn(
    record: &Record,
    tangent: &Tangent,
    state: &[Applied],
    beside_riser: Option<&Twins>,
    course: Course,
) -> Option<Correction> {
    let place = course.place;
    let drawing = Drawing::of(record, tangent, state, course)?;
    let riser = beside_riser.and_then(|twins| drawing.beside_riser(twins));
    if let Some((gram, right)) = &riser
        && weighed(&smoothed(gram, right, false, false)) <= 0.0
    {
        // What the riser's transmitter does not see is no drift of the inlets: the relations need not be asked.
        return None;
    }
    let changes = drawing.knot_changes();
    let fit = drawing.fit(&changes, riser)?;
    let curve = drawing.through(fit.values.iter().map(|c| c * place.width()).collect());
    let signature = drawing.signature(&curve, &fit.values, &changes);
    // Of what is not owed already, as large a part as of the whole.
    let rest = if fit.owed > 0.0 {
        (1.0 - fit.owed / fit.borne).clamp(0.0, 1.0)
    } else {
        1.0
    };
    let busiest = owed(record, tangent, &signature);
    let off = fit.owed + rest * busiest;
    Some(Correction {
        size: size(place, &curve.knots),
        curve,
        signature,
        evidence: fit.evidence - off,
        borne: fit.borne - off,
        choice: 0.0,
        owed: off - busiest,
        freedom: fit.freedom,
        least: least(course),
        seen: None,
        times: record.times_usual(record.setting.span_s),
    })
}

/// Normal equations of the values at the knots, in widths of their place.
type Equations = (DMatrix<f64>, DVector<f64>);

/// A curve that is to be drawn: its knots, and the residuals that tell their values.
struct Drawing<'a> {
    record: &'a Record,
    tangent: &'a Tangent,
    state: &'a [Applied],
    course: Course,
    /// The quantity at the first and at the last knot.
    range: (f64, f64),
    knots: usize,
}

/// The curve that fits best.
struct Fit {
    /// At the knots, in widths of their place.
    values: DVector<f64>,
    /// How many straight parameters the curve is worth.
    freedom: f64,
    /// Of curves of every smoothness, with what the riser's transmitter tells and without it.
    evidence: f64,
    borne: f64,
    /// The part of both that errors of the flow and the relation's own curve bring.
    owed: f64,
}

impl<'a> Drawing<'a> {
    fn of(
        record: &'a Record,
        tangent: &'a Tangent,
        state: &'a [Applied],
        course: Course,
    ) -> Option<Self> {
        /// Range of a quantity that rests, over its size, and the least size, in the quantity's unit: rounding, not movement.
        const RESTS: f64 = 1e-9;
        const LEAST: f64 = 1e-3;
        let (from, to) = (course.timed_s).or_else(|| range(record, course.quantity))?;
        if to - from <= RESTS * to.abs().max(LEAST) {
            return None;
        }
        let fine = course.timed_s.is_some() || course.quantity == Quantity::InletPressure;
        Some(Self {
            record,
            tangent,
            state,
            course,
            range: (from, to),
            knots: if fine { FINE_KNOTS } else { KNOTS },
        })
    }

    /// What the riser's transmitter tells of a drift of the inlets; `None` for any other curve.
    fn beside_riser(&self, twins: &Twins) -> Option<Equations> {
        let drift =
            (self.course.place, self.course.quantity) == (Place::InletReading, Quantity::Time);
        drift
            .then(|| twins.normal_equations(self.range, self.course.place.width()))
            .flatten()
    }

    /// What a knot of one width changes in the rows, knot by knot.
    fn knot_changes(&self) -> Vec<Vec<f64>> {
        let width = self.course.place.width();
        if self.course.place == Place::InletReading {
            // The mass balance holds the rate of this reading: it does not answer a constant.
            return (0..self.knots)
                .map(|k| self.change(|j| if j == k { width } else { 0.0 }))
                .collect();
        }
        // The quantity hardly moves within a row: each knot's share of it follows from how the row answers a constant, and from where
        // it lies between the knots.
        let constant = self.change(|_| width);
        let positions = self.positions(&constant);
        (0..self.knots)
            .map(|k| {
                let hat = |(position, whole): (&f64, &f64)| {
                    let share = (1.0 - (position - k as f64).abs()).max(0.0);
                    if *whole == 0.0 { 0.0 } else { share * whole }
                };
                positions.iter().zip(&constant).map(hat).collect()
            })
            .collect()
    }

    /// Where each row lies, in knots from the first, by how it answers a straight line and a `constant`.
    fn positions(&self, constant: &[f64]) -> Vec<f64> {
        let last = (self.knots - 1) as f64;
        if self.course.timed_s.is_some() {
            // A row in which a period ends answers the mean of both ends, and lies at neither: periods go by the clock.
            let (from, to) = self.range;
            let begin = self.record.setting.span_s.0;
            let within = |t: f64| (begin + t - from).rem_euclid(to - from);
            let times = self.tangent.layout.times_s(self.record.block_s());
            return (times.into_iter())
                .map(|t| last * within(t) / (to - from))
                .collect();
        }
        // The line is no larger than the constant, as friction is not linear in an error of the flow.
        let width = self.course.place.width();
        let line = self.change(|k| width * k as f64 / last);
        (line.iter().zip(constant))
            .map(|(line, whole)| last * line / whole)
            .collect()
    }

    /// What the curve of these values at the knots changes in the rows.
    fn change(&self, value: impl Fn(usize) -> f64) -> Vec<f64> {
        let curve = self.through((0..self.knots).map(value).collect());
        let beside = joined(self.state, &Applied::from(&curve));
        self.tangent.change(self.record, &beside)
    }

    fn through(&self, values: Vec<f64>) -> Curve {
        Curve::new(self.course.place, self.course.quantity, self.range, values)
    }

    /// Fits the values at the knots to the residuals, and to what the riser's transmitter tells.
    fn fit(&self, changes: &[Vec<f64>], riser: Option<Equations>) -> Option<Fit> {
        let course = self.course;
        let tangent = self.tangent;
        let errors = answering_the_flow(course)
            .and_then(|section| tangent.flow_errors(self.record, section, course.quantity))
            .map(|errors| as_they_show(tangent.project(&errors), &tangent.off));
        let of = [Some(&tangent.off), errors.as_ref()].into_iter().flatten();
        let of: Vec<&[f64]> = of.map(Vec::as_slice).collect();
        let (mut gram, products) = tangent.inner_products(self.record, changes, &of);
        let mut products = products.into_iter();
        let mut right = products.next()?;
        // The mass balance has no term of its own for a constant.
        let constant = (course.place, course.quantity) == (Place::Balance, Quantity::Time);
        let round = course.timed_s.is_some();
        let mut curves = smoothed(&gram, &right, constant, round);
        let borne = weighed(&curves);
        let owed = products.next().map_or(0.0, |of_errors| {
            let slopes = own_curve_slopes(course);
            let by_curve = |right| of_straight(&gram, right, slopes).max(0.0);
            let by_errors = weighed(&smoothed(&gram, &of_errors, constant, round));
            by_curve(&right) + (by_errors - by_curve(&of_errors)).max(0.0)
        });
        if let Some((more, pull)) = riser {
            gram += more;
            right += pull;
            curves = smoothed(&gram, &right, constant, round);
        }
        let evidence = weighed(&curves);
        let best = (curves.into_iter()).max_by(|a, b| a.evidence.total_cmp(&b.evidence))?;
        Some(Fit {
            values: best.coefficients,
            freedom: best.freedom,
            evidence,
            borne,
            owed,
        })
    }

    /// What the curve takes out of the residuals, off the tangent.
    fn signature(&self, curve: &Curve, values: &DVector<f64>, changes: &[Vec<f64>]) -> Vec<f64> {
        if self.course.place == Place::MeterFactor {
            // Rows are not linear in an error of the flow: the changes of its knots do not add up.
            let beside = joined(self.state, &Applied::from(curve));
            return self.tangent.signature(self.record, &beside);
        }
        let change: Vec<f64> = (0..changes[0].len())
            .map(|i| changes.iter().zip(values).map(|(c, w)| w * c[i]).sum())
            .collect();
        self.tangent.beyond(self.record, &change)
    }
}

/// The rows that answer the flow, where what they are corrected along stands for it without its meter's noise.
fn answering_the_flow(course: Course) -> Option<Section> {
    match (course.place, course.quantity) {
        (Place::Head, Quantity::InletPressure | Quantity::PumpSpeed) => Some(Section::Head),
        (Place::Friction, Quantity::PumpSpeed) => Some(Section::Friction),
        _ => None,
    }
}

/// Whether a straight line along the quantity, and not only a level, may be the relation's own curve: fitted curves follow that no further than pumps and
/// lines do as a rule.
fn own_curve_slopes(course: Course) -> bool {
    (course.place, course.quantity) == (Place::Head, Quantity::PumpSpeed)
}

/// Errors of the flow, off the tangent, at least as large as they show in what is left over: noise in the flow makes the fitted curves flatter than the
/// true ones.
fn as_they_show(errors: Vec<f64>, left: &[f64]) -> Vec<f64> {
    let share = dot(&errors, left) / dot(&errors, &errors);
    if share > 1.0 {
        errors.into_iter().map(|v| share * v).collect()
    } else {
        errors
    }
}

/// Size up to which a curve may be the accuracy of instruments, in the unit of its place.
pub(super) fn least(course: Course) -> f64 {
    /// By what it is multiplied for the booster's flow in an outlet's reading. Set by hand.
    const BOOSTER: f64 = 0.5;
    // The booster's flow enters an outlet's reading alone: as little as in the friction, where it shows. The mud pump's comes and goes
    // with the return flow, as what mud leaves of its strength at rest does.
    let booster =
        course.place.relation() == Relation::Instrument && course.quantity == Quantity::BoosterFlow;
    course.place.least() * if booster { BOOSTER } else { 1.0 }
}

/// The range of a quantity in the recording; a period has its own.
pub(super) fn range(record: &Record, quantity: Quantity) -> Option<(f64, f64)> {
    /// One value in so many lies beyond either end.
    const TAIL: usize = 50;
    /// Flow, m³/s, and speed, %, above which mud flows and the pump turns. Set by hand.
    const FLOWING_M3_S: f64 = 2e-3;
    const TURNING_PCT: f64 = 10.0;
    /// Longest time since the pump started, as `ln(1 + minutes)`: an hour and a half. Set by hand.
    const LN_MINUTES: f64 = 4.5;
    /// Rate of the flow, m³/s², either way. Set by hand.
    const RATE_M3_S2: f64 = 2e-4;
    let f = &record.filled;
    let quantiles = |values: &[f64]| tails(values, TAIL).unwrap_or((0.0, 0.0));
    let above = |values: &[f64], least: f64| {
        let moving: Vec<f64> = values.iter().copied().filter(|v| *v > least).collect();
        quantiles(&moving)
    };
    Some(match quantity {
        Quantity::Time => record.setting.span_s,
        Quantity::InletPressure => quantiles(&f.inlet),
        Quantity::MudPumpFlow => quantiles(&f.mud_pump),
        Quantity::BoosterFlow => quantiles(&f.booster),
        Quantity::ReturnFlow => above(&f.flow, FLOWING_M3_S),
        Quantity::PumpSpeed => above(&f.speed, TURNING_PCT),
        Quantity::SinceStart => (0.0, LN_MINUTES),
        Quantity::FlowRate => (-RATE_M3_S2, RATE_M3_S2),
        Quantity::Period | Quantity::Episode => return None,
    })
}
