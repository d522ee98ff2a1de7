//! Steady flow: the root of Eq. 4.2.

use super::ReturnLine;
use super::model::Momentum;
use crate::DynamicsError;

/// How the steady flow of one sample was found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum SteadyStatus {
    /// The balance is met to round-off.
    Solved,
    /// The pump cannot lift the columns and the non-return valve is shut: the flow is 0.
    Shut,
    /// No resistance stops the flow below [`FLOW_LIMIT_M3_S`], or only over less than a fiftieth of some flow; the flow is
    /// that bound.
    Unbounded,
    /// Iterations ran out, or the balance overflowed; the flow is the best found.
    IterationLimit,
}

/// Largest flow looked at, m³/s: far above any return line.
pub const FLOW_LIMIT_M3_S: f64 = 1e3;
const ITERATIONS: usize = 200;
/// Where to start without a sample before: the size of a usual flow.
const FIRST_M3_S: f64 = 0.01;

/// Least flow looked at for a balance that was passed over, and by what factor the next is greater.
const FINEST_M3_S: f64 = 1e-4;
const CLOSE: f64 = 1.02;

/// Steady flows of a series.
#[derive(Debug, Clone, PartialEq)]
pub struct SteadyFlow {
    /// Flow, m³/s, shape `(n,)`.
    pub flow_m3_s: Vec<f64>,
    /// How each was found, shape `(n,)`.
    pub status: Vec<SteadyStatus>,
}

/// Solves Eq. 4.2 for the flow at every sample.
///
/// - `level_m`: riser level h_r, m, shape `(n,)`, finite.
/// - `speed_pct`: pump speed, %, shape `(n,)`, finite, at least 0.
///
/// Newton's method within a bracket, started from the sample before. Where parameters allow
/// several roots, it returns one at which more flow meets more resistance, hence a stable one.
///
/// # Errors
/// [`DynamicsError::Parameter`], [`DynamicsError::Length`], [`DynamicsError::Sample`].
pub fn steady_state(
    line: &ReturnLine,
    level_m: &[f64],
    speed_pct: &[f64],
) -> Result<SteadyFlow, DynamicsError> {
    SteadyParts::new(line)?.add(level_m, speed_pct)
}

/// [`steady_state`] of a series that comes in parts: each sample starts from the one before, whatever its part.
#[derive(Debug)]
pub struct SteadyParts {
    momentum: Momentum,
    valve: bool,
    guess: f64,
}

impl SteadyParts {
    /// For a line.
    ///
    /// # Errors
    /// [`DynamicsError::Parameter`].
    pub fn new(line: &ReturnLine) -> Result<Self, DynamicsError> {
        line.check()?;
        Ok(Self {
            momentum: Momentum::new(line),
            valve: line.non_return_valve,
            guess: 0.0,
        })
    }

    /// Solves for the next samples; level, m, and speed, %, as in [`steady_state`].
    ///
    /// # Errors
    /// [`DynamicsError::Length`], [`DynamicsError::Sample`].
    pub fn add(&mut self, level_m: &[f64], speed_pct: &[f64]) -> Result<SteadyFlow, DynamicsError> {
        if speed_pct.len() != level_m.len() {
            return Err(DynamicsError::Length {
                name: "speed_pct",
                expected: level_m.len(),
                found: speed_pct.len(),
            });
        }
        super::simulate::check_speed("speed_pct", speed_pct)?;
        if let Some(index) = level_m.iter().position(|h| !h.is_finite()) {
            return Err(DynamicsError::Sample {
                name: "level_m".to_owned(),
                index,
                found: level_m[index],
                expected: "a finite number",
            });
        }
        let (mut flow_m3_s, mut status) = (
            Vec::with_capacity(level_m.len()),
            Vec::with_capacity(level_m.len()),
        );
        for (&h, &w) in level_m.iter().zip(speed_pct) {
            let (q, how) = solve(&mut self.momentum, self.valve, h, w, self.guess);
            self.guess = q;
            flow_m3_s.push(q);
            status.push(how);
        }
        Ok(SteadyFlow { flow_m3_s, status })
    }
}

/// Solves Eq. 4.2 for the flow at one level (m) and speed (%).
///
/// # Errors
/// As [`steady_state`].
pub fn steady_flow(
    line: &ReturnLine,
    level_m: f64,
    speed_pct: f64,
) -> Result<(f64, SteadyStatus), DynamicsError> {
    let all = steady_state(line, &[level_m], &[speed_pct])?;
    Ok((all.flow_m3_s[0], all.status[0]))
}

fn solve(momentum: &mut Momentum, valve: bool, h: f64, w: f64, guess: f64) -> (f64, SteadyStatus) {
    momentum.refer(w, guess);
    let still = momentum.drive(h, w, 0.0).0;
    if still == 0.0 {
        return (0.0, SteadyStatus::Solved);
    }
    if still < 0.0 && valve {
        return (0.0, SteadyStatus::Shut);
    }
    // The root lies on the side to which the standing columns are pushed. `near` still has
    // their sign, `far` the opposite one, once found.
    let side = still.signum();
    let (mut near, mut far) = (0.0_f64, None);
    let mut q = if guess * side > 0.0 {
        guess
    } else {
        side * FIRST_M3_S
    };
    for _ in 0..ITERATIONS {
        let (drive, _, swept) = momentum.drive(h, w, q);
        if !drive.is_finite() {
            break; // parameters so large that the balance overflows
        }
        let step = -drive / momentum.drive_by_flow(w, q, swept);
        if drive == 0.0 || step.abs() <= 2.0 * f64::EPSILON * q.abs() {
            return (
                q + if step.is_finite() { step } else { 0.0 },
                SteadyStatus::Solved,
            );
        }
        if side * drive > 0.0 {
            near = q
        } else {
            far = Some(q)
        }
        let newton = q + step;
        q = match far {
            // Newton's step may lead far astray where the curve is flat.
            None if q.abs() >= FLOW_LIMIT_M3_S => match passed_over(momentum, h, w, side) {
                Some((before, after)) => {
                    (near, far) = (before, Some(after));
                    0.5 * (before + after)
                }
                None => return (side * FLOW_LIMIT_M3_S, SteadyStatus::Unbounded),
            },
            None if newton * side > near * side && newton.abs() < 4.0 * q.abs() => newton,
            None => side * (4.0 * q.abs()).min(FLOW_LIMIT_M3_S),
            Some(far) if newton > near.min(far) && newton < near.max(far) => newton,
            Some(far) => {
                let middle = 0.5 * (near + far);
                if middle == near || middle == far {
                    return (middle, SteadyStatus::Solved);
                }
                middle
            }
        };
    }
    (q, SteadyStatus::IterationLimit)
}

/// The first flows between which the balance is met, from a standstill on: where resistance falls again beyond a peak,
/// Newton's step may have led over both.
fn passed_over(momentum: &Momentum, h: f64, w: f64, side: f64) -> Option<(f64, f64)> {
    let mut before = 0.0;
    let mut size = FINEST_M3_S;
    while size < FLOW_LIMIT_M3_S {
        let q = side * size;
        if side * momentum.drive(h, w, q).0 <= 0.0 {
            return Some((before, q));
        }
        before = q;
        size *= CLOSE;
    }
    None
}
