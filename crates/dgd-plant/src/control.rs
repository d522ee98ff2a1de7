//! Who runs the subsea pump: the level controller or the operator.

use crate::config::Controller;
use crate::schedule::Control;

/// Orders the pump speed once a second.
#[derive(Debug, Clone)]
pub(crate) struct PumpDesk {
    kind: Controller,
    order_pct: f64,
    integral_pct: f64,
    setpoint_m: f64,
    seen_m: f64,
    before_stop_pct: f64,
    standing: bool,
    held_s: f64,
}

impl PumpDesk {
    pub(crate) fn new(kind: &Controller, level_m: f64) -> Self {
        Self {
            kind: kind.clone(),
            order_pct: 0.0,
            integral_pct: 50.0,
            setpoint_m: level_m,
            seen_m: level_m,
            before_stop_pct: 50.0,
            standing: true,
            held_s: 0.0,
        }
    }

    /// The speed ordered for the coming second, %.
    pub(crate) fn order(&mut self, control: Control, measured_level_m: f64) -> f64 {
        let k = &self.kind;
        if measured_level_m.is_finite() {
            self.seen_m += (measured_level_m - self.seen_m) * (1.0 - (-1.0 / k.filter_s).exp());
        }
        match control {
            Control::Stop => {
                if !self.standing {
                    self.before_stop_pct = self.order_pct;
                }
                self.standing = true;
                self.order_pct = 0.0;
            }
            Control::Level(target_m) => {
                self.start();
                let k = &self.kind;
                let most = k.setpoint_rate_m_s;
                self.setpoint_m += (target_m - self.setpoint_m).clamp(-most, most);
                let error = self.setpoint_m - self.seen_m;
                let (low, high) = k.limits_pct;
                self.integral_pct =
                    (self.integral_pct + k.gain_pct_m * error / k.integral_s).clamp(low, high);
                let wish = (self.integral_pct + k.gain_pct_m * error).clamp(low, high);
                self.order_pct += (wish - self.order_pct).clamp(-k.rate_pct_s, k.rate_pct_s);
                self.held_s = 0.0;
            }
            Control::Hold => {
                self.start();
                if self.held_s == 0.0 {
                    // The operator takes over at the mean, to the next half percent.
                    self.order_pct = (2.0 * self.integral_pct).round() / 2.0;
                }
                self.held_s += 1.0;
                // Every quarter of an hour the operator looks at the level.
                let error = self.setpoint_m - self.seen_m;
                if self.held_s % 900.0 == 0.0 && error.abs() > 6.0 {
                    self.order_pct += 0.5_f64.copysign(error);
                }
                self.integral_pct = self.order_pct;
            }
            Control::Speed(pct) => {
                self.start();
                let most = self.kind.rate_pct_s;
                self.order_pct += (pct - self.order_pct).clamp(-most, most);
                self.integral_pct = self.order_pct;
                self.held_s = 0.0;
            }
        }
        self.order_pct
    }

    /// A start from standstill resumes a little below where the pump last ran.
    fn start(&mut self) {
        if self.standing {
            self.standing = false;
            self.integral_pct = 0.9 * self.before_stop_pct;
            self.setpoint_m = self.seen_m;
            self.held_s = 1.0;
        }
    }
}
