//! The plant at work: supply, riser, pump and line, advanced together.

use crate::config::Physics;
use crate::constants::{ATMOSPHERE_PA, GPM_M3_S, GRAVITY_M_S2};
use crate::line::ReturnLine;
use crate::mud::FrictionTable;
use crate::noise::{Noise, Wander};
use crate::pump::{Drive, NonReturnValve};
use crate::riser::Riser;
use crate::schedule::Segment;
use crate::well::Well;

/// Steps a second. A quarter of a second resolves every lag the plant has.
pub(crate) const STEPS: usize = 4;

/// What is true at the end of a second, whatever the instruments say. SI units.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct TrueState {
    /// Depth of the riser's surface below the rotary table, m.
    pub riser_level_m: f64,
    /// Flow through the subsea pump, m³/s.
    pub pump_flow_m3_s: f64,
    /// Flow out of the return line's top, m³/s.
    pub line_outflow_m3_s: f64,
    /// Flow at the flow meter, m³/s.
    pub metered_flow_m3_s: f64,
    /// Flow out of the bit, m³/s.
    pub bit_flow_m3_s: f64,
    /// Flow out of the booster line, m³/s.
    pub booster_flow_m3_s: f64,
    /// Topfill, m³/s.
    pub topfill_m3_s: f64,
    /// Pressure at the subsea pump's inlet, Pa.
    pub pump_inlet_pa: f64,
    /// Pressure behind the subsea pump's non-return valve, Pa.
    pub pump_outlet_pa: f64,
    /// Pressure at the riser sensor, Pa.
    pub riser_sensor_pa: f64,
    /// Speed of the subsea pump on the set-point's scale, %.
    pub pump_speed_pct: f64,
    /// Length of the mud column in the return line, m.
    pub line_filled_m: f64,
    /// Mud stored in the return line, m³.
    pub line_volume_m3: f64,
    /// Density of the mud the pump draws, kg/m³.
    pub suction_density_kg_m3: f64,
    /// Density of the mud at the top of the return line's column, kg/m³.
    pub line_top_density_kg_m3: f64,
    /// All that has come into the riser since the start, m³.
    pub came_in_m3: f64,
    /// All that has left the line's top or run over the riser since the start, m³.
    pub went_out_m3: f64,
}

/// The moving parts.
pub(crate) struct Plant {
    well: Well,
    physics: Physics,
    line: ReturnLine,
    riser: Riser,
    drive: Drive,
    valve: NonReturnValve,
    mud_pump_gpm: f64,
    booster_gpm: f64,
    topfill_gpm: f64,
    flow_line: [f64; 2],
    on_the_way: Vec<f64>,
    next_out: usize,
    noise: Noise,
    pit: Wander,
    stroke: Wander,
    pit_kg_m3: f64,
    stroke_factor: f64,
    drilling: f64,
    state: TrueState,
}

impl Plant {
    pub(crate) fn new(well: &Well, physics: &Physics, seed: u64, level_m: f64) -> Self {
        let area = well.return_line_area_m2();
        let density = well.mud_density_kg_m3;
        let friction = FrictionTable::new(
            &physics.rheology,
            well.return_line_id_m,
            physics.line.roughness_m,
            density,
        );
        let line = ReturnLine::new(
            &physics.line,
            well.pump_outlet_depth_m,
            area,
            density,
            friction,
        );
        let mut noise = Noise::new(seed, 2);
        let pit = Wander::new(physics.pit_density_sd_kg_m3, 9000.0, &mut noise);
        let stroke = Wander::new(0.0015, 600.0, &mut noise);
        let slots = crate::constants::index(
            (physics.flow_meter_delay_s * STEPS as f64).round(),
            600 * STEPS,
        );
        let state = TrueState {
            riser_level_m: level_m,
            line_filled_m: line.wet_m(),
            line_volume_m3: line.volume_m3(),
            ..TrueState::default()
        };
        Self {
            well: well.clone(),
            physics: physics.clone(),
            riser: Riser::new(
                well.annulus_area_m2(),
                well.pump_inlet_depth_m,
                well.wellhead_depth_m,
                level_m,
            ),
            drive: Drive::default(),
            valve: NonReturnValve::new(
                physics.line.valve_leak,
                physics.line.valve_close_s,
                3.0 * density / (2.0 * area * area),
            ),
            line,
            mud_pump_gpm: 0.0,
            booster_gpm: 0.0,
            topfill_gpm: 0.0,
            flow_line: [0.0; 2],
            on_the_way: vec![0.0; slots.max(1)],
            next_out: 0,
            noise,
            pit,
            stroke,
            pit_kg_m3: 0.0,
            stroke_factor: 1.0,
            drilling: 0.0,
            state,
        }
    }

    /// Flows the rig pumps make now, m³/s: mud pump, booster, topfill.
    pub(crate) fn rig_pumps_m3_s(&self) -> [f64; 3] {
        [
            self.mud_pump_gpm * GPM_M3_S * self.stroke_factor,
            self.booster_gpm * GPM_M3_S,
            self.topfill_gpm * GPM_M3_S,
        ]
    }

    /// One second under the crew's orders and the pump's set-point.
    pub(crate) fn second(&mut self, orders: &Segment, speed_pct: f64) -> TrueState {
        self.pit_kg_m3 = self.pit.step(1.0, &mut self.noise);
        self.stroke_factor = 1.0 + self.stroke.step(1.0, &mut self.noise);
        // Rig pumps are brought up and down by hand, stroke by stroke.
        approach(&mut self.mud_pump_gpm, orders.mud_pump_gpm, 4.0, 6.0);
        approach(&mut self.booster_gpm, orders.booster_gpm, 5.0, 8.0);
        approach(&mut self.topfill_gpm, orders.topfill_gpm, 2.0, 2.0);
        // The bit reaches bottom and leaves it over some minutes.
        let bottom = if orders.drilling { 1.0 } else { 0.0 };
        self.drilling += (bottom - self.drilling) / 180.0;
        for _ in 0..STEPS {
            self.step(speed_pct);
        }
        self.state
    }

    fn step(&mut self, speed_pct: f64) {
        let dt = 1.0 / STEPS as f64;
        let p = &self.physics;
        let [mud, boost, topfill] = self.rig_pumps_m3_s();
        let s = &mut self.state;
        s.bit_flow_m3_s += (mud - s.bit_flow_m3_s) * lag(dt, p.string_lag_s);
        s.booster_flow_m3_s += (boost - s.booster_flow_m3_s) * lag(dt, p.booster_lag_s);
        s.topfill_m3_s = topfill;
        let below = s.bit_flow_m3_s + s.booster_flow_m3_s;
        let cuttings = p.cuttings_kg_m3 * self.drilling * s.bit_flow_m3_s / below.max(1e-6);

        self.drive.step(dt, speed_pct, p.pump.slew_pct_s);
        let shaft = p.pump.shaft(self.drive.speed_pct);
        let density = self.well.mud_density_kg_m3;
        let column = density + self.riser.upper_kg_m3();
        let inlet_depth = self.well.pump_inlet_depth_m;
        let level = self.riser.level_m();
        let static_pa = ATMOSPHERE_PA + column * GRAVITY_M_S2 * (inlet_depth - level).max(0.0);
        let drawn = self.line.inflow_m3_s();
        let suction_kg_m3 = self.riser.suction_kg_m3(below, drawn);
        let weight = (density + suction_kg_m3) * GRAVITY_M_S2;
        let area = self.well.return_line_area_m2();
        let suction_pa = p.suction_loss * density / (2.0 * area * area);
        let lift_pa = weight * (inlet_depth - self.well.pump_outlet_depth_m);
        let inlet_pa = |q: f64| static_pa - suction_pa * q * q.abs();
        let before_valve = |q: f64| inlet_pa(q) + lift_pa + weight * p.pump.head_m(shaft, q);

        let forward = drawn > 1e-5 || before_valve(0.0) > self.line.static_foot_pa();
        self.valve.step(dt, forward);
        let valve = &self.valve;
        let drive = |q: f64| before_valve(q) - valve.loss_pa(q);
        let passed = self.line.step(dt, suction_kg_m3, drive);

        let q = passed.inflow_m3_s;
        let spilled = self.riser.step(
            dt,
            (below, self.pit_kg_m3 + cuttings),
            (topfill, self.pit_kg_m3),
            q,
            passed.bottom_excess_kg_m3,
        );
        // Over the shaker trough to the meter: two tanks, then a stretch of pipe.
        let k = lag(dt, p.flow_line_lag_s);
        self.flow_line[0] += (passed.outflow_m3_s - self.flow_line[0]) * k;
        self.flow_line[1] += (self.flow_line[0] - self.flow_line[1]) * k;
        let slot = &mut self.on_the_way[self.next_out];
        s.metered_flow_m3_s = std::mem::replace(slot, self.flow_line[1]);
        self.next_out = (self.next_out + 1) % self.on_the_way.len();

        s.riser_level_m = self.riser.level_m();
        s.pump_flow_m3_s = q;
        s.line_outflow_m3_s = passed.outflow_m3_s;
        s.pump_inlet_pa = inlet_pa(q);
        s.pump_outlet_pa = drive(q);
        s.riser_sensor_pa = ATMOSPHERE_PA
            + column * GRAVITY_M_S2 * (self.well.riser_sensor_depth_m - level).max(0.0);
        s.pump_speed_pct = self.drive.speed_pct;
        s.line_filled_m = self.line.wet_m();
        s.line_volume_m3 = self.line.volume_m3();
        s.suction_density_kg_m3 = density + suction_kg_m3;
        s.line_top_density_kg_m3 = density + passed.top_excess_kg_m3;
        s.came_in_m3 += dt * (below + topfill);
        s.went_out_m3 += dt * (passed.outflow_m3_s + spilled);
    }
}

/// Share of the way a first-order lag goes in `dt_s`.
fn lag(dt_s: f64, time_constant_s: f64) -> f64 {
    if time_constant_s > 0.0 {
        1.0 - (-dt_s / time_constant_s).exp()
    } else {
        1.0
    }
}

fn approach(value: &mut f64, target: f64, up: f64, down: f64) {
    *value += (target - *value).clamp(-down, up);
}
