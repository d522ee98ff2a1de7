//! From the return line's top to the flow meter, over the shaker trough.

use super::{STEPS, lag};

/// Gas cushions, two tanks, then a stretch of pipe.
pub(super) struct FlowLine {
    /// Time constant of each cushion, s.
    cushions_s: [f64; 2],
    /// Time constant of each tank, s.
    lag_s: f64,
    cushions_m3_s: [f64; 2],
    tanks_m3_s: [f64; 2],
    /// What is in the pipe, a slot a step.
    on_the_way: Vec<f64>,
    next_out: usize,
}

impl FlowLine {
    pub(super) fn new(cushions_s: [f64; 2], lag_s: f64, delay_s: f64) -> Self {
        let slots = crate::constants::index((delay_s * STEPS as f64).round(), 600 * STEPS);
        Self {
            cushions_s,
            lag_s,
            cushions_m3_s: [0.0; 2],
            tanks_m3_s: [0.0; 2],
            on_the_way: vec![0.0; slots.max(1)],
            next_out: 0,
        }
    }

    /// One step; returns the flow at the meter, m³/s.
    pub(super) fn pass(&mut self, dt_s: f64, outflow_m3_s: f64) -> f64 {
        let mut behind = outflow_m3_s;
        for (flow, tau_s) in self.cushions_m3_s.iter_mut().zip(self.cushions_s) {
            *flow += (behind - *flow) * lag(dt_s, tau_s);
            behind = *flow;
        }
        let k = lag(dt_s, self.lag_s);
        self.tanks_m3_s[0] += (behind - self.tanks_m3_s[0]) * k;
        self.tanks_m3_s[1] += (self.tanks_m3_s[0] - self.tanks_m3_s[1]) * k;
        let slot = &mut self.on_the_way[self.next_out];
        let metered = std::mem::replace(slot, self.tanks_m3_s[1]);
        self.next_out = (self.next_out + 1) % self.on_the_way.len();
        metered
    }
}
