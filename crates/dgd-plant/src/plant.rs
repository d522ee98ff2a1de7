//! The plant at work: supply, riser, pump and line, advanced together.

mod flow_line;
mod resistance;

use crate::cause::{Active, Foreign};
use crate::config::Physics;
use crate::constants::{ATMOSPHERE_PA, GPM_M3_S, GRAVITY_M_S2};
use crate::line::ReturnLine;
use crate::mud::FrictionTable;
use crate::noise::{Noise, Wander};
use crate::pump::{Drive, NonReturnValve, PumpParameters};
use crate::riser::Riser;
use crate::schedule::Segment;
use crate::well::Well;
use flow_line::FlowLine;
use resistance::{Resistance, Settings};

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
    flow_line: FlowLine,
    noise: Noise,
    pit: Wander,
    stroke: Wander,
    pit_kg_m3: f64,
    stroke_factor: f64,
    drilling: f64,
    causes: Active,
    resistance: Resistance,
    /// Seconds the mud pump has stood.
    connection_s: f64,
    /// Until the mud pump starts again, s.
    restart_s: f64,
    heave_rad: f64,
    seconds: f64,
    shiver: Noise,
    trembling: Wander,
    tremble_pa: f64,
    state: TrueState,
}

/// What comes up to the pump's inlet from well and booster line.
struct Inflow {
    pumped_m3_s: f64,
    gained_m3_s: f64,
    lost_m3_s: f64,
    /// Density that cuttings and new mud add.
    cuttings_kg_m3: f64,
}

impl Inflow {
    fn net_m3_s(&self) -> f64 {
        self.pumped_m3_s + self.gained_m3_s - self.lost_m3_s
    }
}

/// The way of the mud from the riser through the pump, for one step.
struct Lift {
    static_pa: f64,
    suction_pa_s2_m6: f64,
    /// From the pump's inlet up to its outlet.
    rise_pa: f64,
    weight_pa_m: f64,
    shaft: f64,
    head_factor: f64,
    leak_m3_s: f64,
}

impl Lift {
    fn inlet_pa(&self, q: f64) -> f64 {
        self.static_pa - self.suction_pa_s2_m6 * q * q.abs()
    }

    fn before_valve_pa(&self, pump: &PumpParameters, q: f64) -> f64 {
        let leak = self.leak_m3_s;
        let through = if q > -leak && leak > 0.0 { q + leak } else { q };
        let head_m = pump.head_m(self.shaft, through);
        self.inlet_pa(q) + self.rise_pa + self.weight_pa_m * head_m * self.head_factor
    }
}

impl Plant {
    pub(crate) fn new(
        well: &Well,
        physics: &Physics,
        causes: &Active,
        seed: u64,
        level_m: f64,
    ) -> Self {
        let mut physics = physics.clone();
        physics.booster_lag_s = causes.booster_lag_s.unwrap_or(physics.booster_lag_s);
        physics.flow_meter_delay_s += causes.delay_s;
        let physics = &physics;
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
        // A stream of its own: what trembles must not move what is drawn after it.
        let mut shiver = Noise::new(seed, 4);
        let trembling = Wander::new(physics.tremble_pa, 2.0, &mut shiver);
        let state = TrueState {
            riser_level_m: level_m,
            line_filled_m: line.wet_m(),
            line_volume_m3: line.volume_m3(),
            ..TrueState::default()
        };
        let mut riser = Riser::new(
            causes.area_m2.unwrap_or(well.annulus_area_m2()),
            well.pump_inlet_depth_m,
            well.wellhead_depth_m,
            level_m,
        );
        if causes.turns_over() {
            riser.turn_over(physics.turnover_m3);
        }
        Self {
            well: well.clone(),
            physics: physics.clone(),
            riser,
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
            flow_line: FlowLine::new(
                causes.cushions_s,
                physics.flow_line_lag_s,
                physics.flow_meter_delay_s,
            ),
            noise,
            pit,
            stroke,
            pit_kg_m3: 0.0,
            stroke_factor: 1.0,
            drilling: 0.0,
            causes: causes.clone(),
            resistance: Resistance::new(),
            connection_s: 0.0,
            restart_s: 0.0,
            heave_rad: 0.0,
            seconds: 0.0,
            shiver,
            trembling,
            tremble_pa: 0.0,
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

    /// One second under the crew's orders and the pump's set-point; `clock_s` counts from the recording's start, and the crew wants the mud
    /// pump in `restart_s`.
    pub(crate) fn second(
        &mut self,
        orders: &Segment,
        speed_pct: f64,
        clock_s: f64,
        restart_s: f64,
    ) -> TrueState {
        self.restart_s = restart_s;
        self.pit_kg_m3 = self.pit.step(1.0, &mut self.noise);
        self.stroke_factor = 1.0 + self.stroke.step(1.0, &mut self.noise);
        // Rig pumps are brought up and down by hand, stroke by stroke.
        let (up, down) = self.physics.mud_pump_ramp_gpm_s;
        approach(&mut self.mud_pump_gpm, orders.mud_pump_gpm, up, down);
        approach(&mut self.booster_gpm, orders.booster_gpm, 5.0, 8.0);
        approach(&mut self.topfill_gpm, orders.topfill_gpm, 2.0, 2.0);
        // The bit reaches bottom and leaves it over some minutes.
        let bottom = if orders.drilling { 1.0 } else { 0.0 };
        self.drilling += (bottom - self.drilling) / 180.0;
        self.connection_s = if self.mud_pump_gpm > 0.0 {
            0.0
        } else {
            self.connection_s + 1.0
        };
        self.seconds = clock_s;
        let settings = Settings {
            well: &self.well,
            physics: &self.physics,
            causes: &self.causes,
        };
        self.resistance
            .age(clock_s, &settings, &mut self.line, &mut self.noise);
        let usual = 2.5 * self.well.return_line_area_m2();
        self.tremble_pa = self.trembling.step(1.0, &mut self.shiver)
            * (self.line.inflow_m3_s() / usual).clamp(0.0, 1.5);
        for _ in 0..STEPS {
            self.step(speed_pct);
        }
        self.state
    }

    /// Height of the rig above its mean, m.
    fn heave_m(&mut self, dt_s: f64) -> f64 {
        let Some((period, amplitude)) = self.causes.heave else {
            return 0.0;
        };
        self.heave_rad += std::f64::consts::TAU / period * dt_s;
        // Waves come in groups: two neighbouring periods beat.
        let group = 0.75 + 0.25 * (self.heave_rad / 11.3).sin();
        amplitude * group * self.heave_rad.sin()
    }

    /// Speed the shaft is asked for, %, when the set-point says `speed_pct`.
    fn asked_pct(&self, speed_pct: f64) -> f64 {
        match self.causes.foreign {
            Some(Foreign::SpeedBand(size, centre)) if speed_pct > 0.0 => {
                let deep = self.riser.level_m() / self.well.pump_inlet_depth_m;
                speed_pct + size * deep * (-((speed_pct - centre) / 4.0).powi(2)).exp()
            }
            _ => speed_pct,
        }
    }

    fn step(&mut self, speed_pct: f64) {
        let dt = 1.0 / STEPS as f64;
        let heave_m = self.heave_m(dt);
        let density = self.well.mud_density_kg_m3;
        let inlet_depth = self.well.pump_inlet_depth_m;
        let level = self.riser.level_m() - heave_m / 3.0;
        let column = density + self.riser.upper_kg_m3();
        let riser_pa =
            |depth_m: f64| ATMOSPHERE_PA + column * GRAVITY_M_S2 * (depth_m - level).max(0.0);
        let static_pa = riser_pa(inlet_depth);

        self.supply(dt);
        let below = self.inflow(static_pa);
        self.turn(dt, speed_pct);
        let drawn = self.line.inflow_m3_s();
        let suction_kg_m3 = self.riser.suction_kg_m3(below.net_m3_s().max(0.0), drawn);
        let lift = self.lift(static_pa, suction_kg_m3, level);
        let pump = &self.physics.pump;
        // The line's upper end moves with the rig, the foot does not.
        let swing_pa = density * GRAVITY_M_S2 * heave_m;

        let standing_pa = self.line.static_foot_pa() + swing_pa;
        let forward = drawn > 1e-5 || lift.before_valve_pa(pump, 0.0) > standing_pa;
        self.valve.step(dt, forward);
        let valve = &self.valve;
        let drive = |q: f64| lift.before_valve_pa(pump, q) - valve.loss_pa(q);
        let drains = speed_pct <= 0.0 && drawn < 1e-4 && self.line.wet_m() > 0.1 * inlet_depth;
        let bled = if drains {
            self.causes.drain_m_s * self.well.return_line_area_m2()
        } else {
            0.0
        };
        let passed = self
            .line
            .step(dt, suction_kg_m3, bled, |q| drive(q) - swing_pa);

        let q = passed.inflow_m3_s;
        let outlet_pa = drive(q);
        let topfill = self.state.topfill_m3_s;
        let spilled = self.riser.step(
            dt,
            (below.net_m3_s(), self.pit_kg_m3 + below.cuttings_kg_m3),
            (topfill, self.pit_kg_m3),
            q - bled,
            passed.bottom_excess_kg_m3,
        );
        let leaked = self
            .causes
            .leak_m3_s(self.seconds, outlet_pa - ATMOSPHERE_PA)
            .min(passed.outflow_m3_s.max(0.0));
        let metered = self.flow_line.pass(dt, passed.outflow_m3_s - leaked);

        let s = &mut self.state;
        s.metered_flow_m3_s = metered;
        s.riser_level_m = self.riser.level_m();
        s.pump_flow_m3_s = q;
        s.line_outflow_m3_s = passed.outflow_m3_s;
        s.pump_inlet_pa = lift.inlet_pa(q);
        s.pump_outlet_pa = outlet_pa;
        s.riser_sensor_pa = riser_pa(self.well.riser_sensor_depth_m);
        s.pump_speed_pct = self.drive.speed_pct;
        s.line_filled_m = self.line.wet_m();
        s.line_volume_m3 = self.line.volume_m3();
        s.suction_density_kg_m3 = density + suction_kg_m3;
        s.line_top_density_kg_m3 = density + passed.top_excess_kg_m3;
        s.came_in_m3 += dt * (below.pumped_m3_s + below.gained_m3_s + topfill);
        s.went_out_m3 += dt * (passed.outflow_m3_s + spilled + below.lost_m3_s);
    }

    /// The rig pumps' flows, as they leave string, booster line and topfill line.
    fn supply(&mut self, dt_s: f64) {
        let [mud, boost, mut topfill] = self.rig_pumps_m3_s();
        if let Some(Foreign::TopfillOffset(more)) = self.causes.foreign {
            topfill += more;
        }
        let p = &self.physics;
        let s = &mut self.state;
        let [fills_s, drains_s] = self.causes.string_lag_s.unwrap_or([p.string_lag_s; 2]);
        let string_lag_s = if mud < s.bit_flow_m3_s {
            drains_s
        } else {
            fills_s
        };
        s.bit_flow_m3_s += (mud - s.bit_flow_m3_s) * lag(dt_s, string_lag_s);
        s.booster_flow_m3_s += (boost - s.booster_flow_m3_s) * lag(dt_s, p.booster_lag_s);
        s.topfill_m3_s = topfill;
    }

    /// What comes up to the pump's inlet, where the riser stands at `static_pa`.
    fn inflow(&self, static_pa: f64) -> Inflow {
        let c = &self.causes;
        let s = &self.state;
        let t_s = self.seconds;
        let pumped_m3_s = s.bit_flow_m3_s + s.booster_flow_m3_s;
        let drilled =
            self.physics.cuttings_kg_m3 * self.drilling * s.bit_flow_m3_s / pumped_m3_s.max(1e-6);
        Inflow {
            pumped_m3_s,
            gained_m3_s: c.influx_m3_s(t_s) + self.pipe_m3_s(),
            lost_m3_s: c.loss_m3_s(t_s, static_pa),
            cuttings_kg_m3: drilled + c.cuttings_kg_m3 * self.drilling + c.new_mud_kg_m3(t_s),
        }
    }

    /// What pipe displaces that goes in at a connection, m³/s.
    fn pipe_m3_s(&self) -> f64 {
        let wait_s = if self.causes.pipe_before_start {
            self.restart_s
        } else {
            self.connection_s
        };
        if (30.0..70.0).contains(&wait_s) && self.connection_s > 0.0 {
            self.causes.pipe_m3 / 40.0
        } else {
            0.0
        }
    }

    /// Turns the shaft towards the set-point.
    fn turn(&mut self, dt_s: f64, speed_pct: f64) {
        let asked_pct = self.asked_pct(speed_pct);
        let lag_s = self.causes.speed_lag_s;
        if lag_s > 0.0 {
            self.drive.follow(dt_s, asked_pct, lag_s);
        } else {
            self.drive
                .step(dt_s, asked_pct, self.physics.pump.slew_pct_s);
        }
    }

    /// What lifts mud into the line now, drawn from a riser that stands at `static_pa`, its surface at `level_m`.
    fn lift(&self, static_pa: f64, suction_kg_m3: f64, level_m: f64) -> Lift {
        let p = &self.physics;
        let c = &self.causes;
        let t_s = self.seconds;
        let density = self.well.mud_density_kg_m3;
        let area = self.well.return_line_area_m2();
        let weight_pa_m = (density + suction_kg_m3) * GRAVITY_M_S2;
        let mut suction_pa_s2_m6 = p.suction_loss * density / (2.0 * area * area);
        let mut head_factor = 1.0 - c.gas_share(t_s);
        match c.foreign {
            Some(Foreign::InletFilterClog(most, period_s)) => {
                suction_pa_s2_m6 += most * (t_s / period_s).rem_euclid(1.0).powi(2);
            }
            Some(Foreign::HeadRippleLevel(size, wave_m)) => {
                head_factor += size * (std::f64::consts::TAU * level_m / wave_m).sin();
            }
            _ => {}
        }
        let shaft = p.pump.shaft(self.drive.speed_pct);
        let shut_in_m = p.pump.head_m(shaft, 0.0).max(0.0);
        Lift {
            static_pa,
            suction_pa_s2_m6,
            rise_pa: weight_pa_m * (self.well.pump_inlet_depth_m - self.well.pump_outlet_depth_m),
            weight_pa_m,
            shaft,
            head_factor,
            leak_m3_s: c.leak_growth_m3_s2 * t_s.max(0.0) * (shut_in_m / 100.0).sqrt(),
        }
    }

    /// What the instruments add of their own, in the order of the channels: flows m³/s, pressures Pa.
    pub(crate) fn instrument_errors(&self) -> [f64; 10] {
        let c = &self.causes;
        let t_s = self.seconds;
        let s = &self.state;
        let [mud, _, _] = self.rig_pumps_m3_s();
        let [first, second] = c.outlet_error_pa(t_s);
        let mut e = [0.0; 10];
        e[0] = c.inflow_gain.map_or(0.0, |g| (g - 1.0) * mud);
        e[3] = c
            .return_gain
            .map_or(0.0, |g| (g - 1.0) * s.metered_flow_m3_s);
        e[6] = first + self.tremble_pa;
        e[7] = second + self.tremble_pa;
        match c.foreign {
            Some(Foreign::BoosterCrosstalk(size)) => {
                e[6] += size * s.booster_flow_m3_s;
                e[7] += size * s.booster_flow_m3_s;
            }
            Some(Foreign::MeterFouling(size, centre, length_s)) => {
                let q = s.metered_flow_m3_s;
                let near = (-((q - centre) / 0.012).powi(2)).exp();
                e[3] += size * (0.3 + 0.7 * (t_s / length_s).clamp(0.0, 1.0)) * near * q;
            }
            Some(Foreign::InletTemperature(size, period_s)) => {
                let swing = size * (std::f64::consts::TAU * t_s / period_s).sin();
                e[4] += swing;
                e[5] += swing;
            }
            _ => {}
        }
        e
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
