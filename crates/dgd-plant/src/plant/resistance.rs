//! What changes slowly in the return line's resistance: gel, viscosity, restrictions and their like.

use crate::cause::{Active, Foreign};
use crate::config::Physics;
use crate::line::ReturnLine;
use crate::mud::FrictionTable;
use crate::noise::Noise;
use crate::well::Well;

/// What the resistance depends on and does not change.
pub(super) struct Settings<'a> {
    pub(super) well: &'a Well,
    pub(super) physics: &'a Physics,
    pub(super) causes: &'a Active,
}

/// What the line remembers of the flow.
pub(super) struct Resistance {
    /// Gel in the line, share of its full strength.
    gel: f64,
    /// Swell since the restart, share of its full size.
    swell: f64,
    /// Direction of the flow's last clear movement, -1 to 1.
    sense: f64,
    /// Flow that hysteresis saw last, or at which the choke last jumped, m³/s.
    held_m3_s: f64,
    /// Loss coefficient of the seat the choke sticks in.
    seat: f64,
    friction: FrictionAt,
}

/// Which friction table is in use.
#[derive(Debug, Clone, Copy)]
struct FrictionAt {
    viscosity: f64,
    swelled: f64,
}

/// What an effect outside the catalogue adds.
struct Extra {
    /// Factor on the friction.
    swelled: f64,
    stubborn_pa_m: f64,
    minor_loss: f64,
}

impl Resistance {
    pub(super) fn new() -> Self {
        Self {
            gel: 0.0,
            swell: 0.0,
            sense: 0.0,
            held_m3_s: 0.0,
            seat: 0.0,
            friction: FrictionAt {
                viscosity: 1.0,
                swelled: 1.0,
            },
        }
    }

    /// Once a second: gives the line what resists in it at `t_s`.
    pub(super) fn age(
        &mut self,
        t_s: f64,
        settings: &Settings<'_>,
        line: &mut ReturnLine,
        noise: &mut Noise,
    ) {
        let q = line.inflow_m3_s();
        let (stubborn, share) = self.stubborn(q, settings);
        let foreign = self.foreign(q, settings, noise);
        let minor_loss = settings.physics.line.minor_loss + settings.causes.restriction_k(t_s);
        line.set_minor_loss(minor_loss + foreign.minor_loss);
        line.set_stubborn(stubborn + foreign.stubborn_pa_m, share);
        let friction = FrictionAt {
            viscosity: settings.causes.viscosity_factor(t_s),
            swelled: foreign.swelled,
        };
        if friction.is_far_from(self.friction) {
            self.friction = friction;
            line.set_friction(friction.table(settings));
        }
    }

    /// Resistance of yield stress and gel, Pa/m, and the share of it that full flow leaves.
    fn stubborn(&mut self, q: f64, settings: &Settings<'_>) -> (f64, f64) {
        let diameter = settings.well.return_line_id_m;
        let mut stubborn = 0.0;
        let mut share = 1.0;
        if let Some((tau, turbulent)) = settings.causes.yield_stress {
            stubborn = 16.0 / 3.0 * tau / diameter;
            share = turbulent;
        }
        if let Some((tau, build_s, break_m3)) = settings.causes.gel {
            if flows(q) {
                self.gel *= (-q / break_m3).exp();
            } else {
                self.gel += (1.0 - self.gel) / build_s;
            }
            let gel = 4.0 * tau * self.gel / diameter;
            share = (share * stubborn + gel) / (stubborn + gel).max(1e-9);
            stubborn += gel;
        }
        (stubborn, share)
    }

    fn foreign(&mut self, q: f64, settings: &Settings<'_>, noise: &mut Noise) -> Extra {
        let mut more = Extra {
            swelled: 1.0,
            stubborn_pa_m: 0.0,
            minor_loss: 0.0,
        };
        match settings.causes.foreign {
            Some(Foreign::FrictionSwell(size, tau_s)) => {
                self.swell = if flows(q) {
                    self.swell + (1.0 - self.swell) / tau_s
                } else {
                    0.0
                };
                more.swelled = 1.0 + size * self.swell;
            }
            Some(Foreign::FrictionHysteresis(size_pa)) => {
                let slope = q - self.held_m3_s;
                self.held_m3_s = q;
                let push = (slope / 2e-4).clamp(-1.0, 1.0);
                // It remembers the last clear movement and forgets it over half an hour.
                self.sense += (push - self.sense) * 0.1 * push.abs() - self.sense / 1800.0;
                if flows(q) {
                    more.stubborn_pa_m =
                        (1.0 + self.sense) * 0.5 * size_pa / settings.well.pump_outlet_depth_m;
                }
            }
            Some(Foreign::ChokeStick(low, high)) => {
                // Stuck where it is until the flow has moved by a tenth; then it jumps to the other seat.
                if (q - self.held_m3_s).abs() > 0.1 * self.held_m3_s.abs().max(0.01) {
                    self.held_m3_s = q;
                    self.seat = if noise.unit() < 0.5 { low } else { high };
                }
                more.minor_loss = self.seat;
            }
            _ => {}
        }
        more
    }
}

impl FrictionAt {
    fn is_far_from(self, other: Self) -> bool {
        (self.viscosity - other.viscosity).abs() > 0.002
            || (self.swelled - other.swelled).abs() > 0.002
    }

    fn table(self, settings: &Settings<'_>) -> FrictionTable {
        let mut mud = settings.physics.rheology.clone();
        mud.consistency_pa_sn *= self.viscosity;
        let mut table = FrictionTable::new(
            &mud,
            settings.well.return_line_id_m,
            settings.physics.line.roughness_m,
            settings.well.mud_density_kg_m3,
        );
        table.scale(self.swelled);
        table
    }
}

fn flows(q_m3_s: f64) -> bool {
    q_m3_s > 1e-3
}
