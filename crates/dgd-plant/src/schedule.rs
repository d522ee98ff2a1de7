//! What the crew does: a list of segments, each with its flow orders and the way the pump is run.

use crate::noise::Noise;

/// How the subsea pump is run during a segment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Control {
    /// The level controller holds this riser level, m below the rotary table.
    Level(f64),
    /// The operator keeps the speed where the controller left it.
    Hold,
    /// The operator sets this speed, %.
    Speed(f64),
    /// The pump stands.
    Stop,
}

/// A stretch of constant orders.
#[derive(Debug, Clone, PartialEq)]
pub struct Segment {
    /// Length, s.
    pub duration_s: f64,
    /// Mud pump order, US gallons a minute.
    pub mud_pump_gpm: f64,
    /// Booster pump order, US gallons a minute.
    pub booster_gpm: f64,
    /// Topfill order, US gallons a minute.
    pub topfill_gpm: f64,
    /// Whether the bit makes hole, and cuttings with it.
    pub drilling: bool,
    /// How the subsea pump is run.
    pub control: Control,
    /// Whether the historian files every second; otherwise it files by exception.
    pub every_second: bool,
}

/// Writes segments down one after the other.
struct Crew {
    noise: Noise,
    log: Vec<Segment>,
    booster_gpm: f64,
    topfill_gpm: f64,
    every_second: bool,
}

impl Crew {
    fn add(&mut self, minutes: f64, mud_pump_gpm: f64, control: Control) {
        self.log.push(Segment {
            duration_s: (minutes * 60.0).round(),
            mud_pump_gpm,
            booster_gpm: self.booster_gpm,
            topfill_gpm: self.topfill_gpm,
            drilling: false,
            control,
            every_second: self.every_second,
        });
    }

    fn drill(&mut self, minutes: f64, mud_pump_gpm: f64, control: Control) {
        self.add(minutes, mud_pump_gpm, control);
        if let Some(last) = self.log.last_mut() {
            last.drilling = true;
        }
    }

    /// Stands of drilling with connections between them. At a connection the level is raised to make up
    /// for the friction the well loses with its flow. With `manual`, the operator takes the pump off the
    /// controller once the stand runs quietly.
    fn stands(&mut self, hours: f64, gpm: f64, level_m: f64, manual: f64) {
        let mut left = hours * 60.0;
        while left > 0.0 {
            let stand = self.noise.between(32.0, 62.0).min(left.max(12.0));
            let flow = (gpm + self.noise.between(-25.0, 25.0)).round();
            let level = level_m + self.noise.between(-4.0, 4.0).round();
            if self.noise.unit() < manual {
                self.drill(9.0, flow, Control::Level(level));
                self.drill((stand - 9.0).max(1.0), flow, Control::Hold);
            } else {
                let first = stand * self.noise.between(0.3, 0.7);
                self.drill(first, flow, Control::Level(level));
                let trim = (flow + self.noise.between(-40.0, 30.0)).round();
                self.drill(stand - first, trim, Control::Level(level));
            }
            let raise = self.noise.between(8.0, 22.0).round();
            let connection = self.noise.between(6.0, 13.0);
            self.add(connection, 0.0, Control::Level((level - raise).max(15.0)));
            left -= stand + connection;
        }
    }

    /// A staircase of mud-pump flows at one level.
    fn staircase(&mut self, flows_gpm: &[f64], minutes: f64, level_m: f64) {
        for &flow in flows_gpm {
            let spread = self.noise.between(0.7, 1.3);
            self.add(minutes * spread, flow, Control::Level(level_m));
        }
    }

    /// Level moves at small flow, where the pump turns slowly.
    fn level_moves(&mut self, levels_m: &[f64], minutes: f64, gpm: f64) {
        for &level in levels_m {
            let spread = self.noise.between(0.7, 1.3);
            let flow = (gpm * self.noise.between(0.4, 1.6)).round();
            self.add(minutes * spread, flow, Control::Level(level));
        }
    }

    /// The pump stands; mud pump and booster are off.
    fn stop(&mut self, minutes: f64) {
        let booster = std::mem::replace(&mut self.booster_gpm, 0.0);
        let topfill = std::mem::replace(&mut self.topfill_gpm, 0.0);
        self.add(minutes, 0.0, Control::Stop);
        self.booster_gpm = booster;
        self.topfill_gpm = topfill;
    }
}

/// Eighty-five hours: drilling at several levels, circulation, two trips, pump trials.
pub(crate) fn gom(seed: u64) -> Vec<Segment> {
    let mut c = Crew {
        noise: Noise::new(seed, 1),
        log: Vec::new(),
        booster_gpm: 220.0,
        topfill_gpm: 30.0,
        every_second: true,
    };
    // The first hours are filed in full.
    c.stands(6.6, 590.0, 110.0, 0.0);
    c.staircase(&[560.0, 420.0, 300.0, 480.0, 600.0], 16.0, 105.0);
    c.every_second = false;
    c.stands(6.5, 600.0, 125.0, 0.9);
    c.stop(230.0);
    c.booster_gpm = 120.0;
    c.every_second = true;
    c.level_moves(&[60.0, 35.0, 80.0, 45.0, 25.0, 60.0, 100.0], 14.0, 170.0);
    c.booster_gpm = 220.0;
    c.every_second = false;
    c.stands(5.0, 610.0, 150.0, 0.8);
    c.stop(12.0);
    c.stands(3.0, 600.0, 160.0, 0.6);
    c.stands(1.0, 600.0, 160.0, 0.0);
    c.every_second = true;
    c.staircase(&[300.0, 450.0, 600.0, 350.0, 200.0], 12.0, 140.0);
    c.every_second = false;
    c.stands(6.0, 560.0, 60.0, 0.75);
    c.every_second = true;
    c.stands(1.5, 560.0, 60.0, 0.0);
    c.stop(25.0);
    c.every_second = false;
    c.stands(4.5, 520.0, 45.0, 0.5);
    c.stop(400.0);
    c.booster_gpm = 100.0;
    c.level_moves(&[30.0, 70.0, 40.0], 16.0, 180.0);
    c.every_second = true;
    c.level_moves(&[70.0, 25.0, 40.0], 14.0, 220.0);
    c.booster_gpm = 230.0;
    c.every_second = false;
    c.stands(8.0, 600.0, 175.0, 0.75);
    c.stop(9.0);
    c.every_second = true;
    c.stands(0.8, 600.0, 180.0, 0.0);
    c.every_second = false;
    c.stands(5.0, 615.0, 185.0, 0.75);
    for trial in 0..5 {
        c.every_second = trial % 2 == 0;
        let minutes = c.noise.between(4.0, 12.0);
        c.stop(minutes);
        let level = c.noise.between(60.0, 150.0).round();
        let flow = c.noise.between(100.0, 450.0).round();
        c.add(22.0, flow, Control::Level(level));
    }
    c.every_second = false;
    c.stands(11.5, 580.0, 130.0, 0.7);
    c.log
}

/// Two hours: a stand, a connection, a pump stop, level moves and a staircase.
pub(crate) fn short(seed: u64) -> Vec<Segment> {
    let mut c = Crew {
        noise: Noise::new(seed, 1),
        log: Vec::new(),
        booster_gpm: 220.0,
        topfill_gpm: 30.0,
        every_second: true,
    };
    c.drill(17.0, 590.0, Control::Level(110.0));
    c.add(7.0, 0.0, Control::Level(95.0));
    c.drill(12.0, 600.0, Control::Level(110.0));
    c.every_second = false;
    c.drill(7.0, 600.0, Control::Hold);
    c.every_second = true;
    c.staircase(&[420.0, 250.0], 7.0, 150.0);
    c.add(7.0, 60.0, Control::Level(120.0));
    c.stop(7.0);
    c.booster_gpm = 100.0;
    c.level_moves(&[60.0, 35.0, 50.0], 8.0, 150.0);
    c.booster_gpm = 220.0;
    c.drill(60.0, 560.0, Control::Level(75.0));
    c.log
}
