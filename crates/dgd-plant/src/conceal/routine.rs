//! What the crew does in a case: stands with connections, level moves, booster changes, pump stops.

use crate::conceal::rig::{Level, Rig};
use crate::constants::GPM_M3_S;
use crate::noise::Noise;
use crate::schedule::{Control, Segment};

/// Share of the recordings of level two in which the rig runs steadily: long stands, one flow, one level.
const STEADY: f64 = 0.4;

/// Writes a schedule that fills the rig's recording; with `stops` at least every second connection stops the pump.
pub(crate) fn draw(rig: &Rig, stops: bool, noise: &mut Noise) -> Vec<Segment> {
    let lively = rig.level == Level::One || noise.unit() >= STEADY;
    let usual_gpm = rig.usual_flow_m3_s() / GPM_M3_S;
    let boost_gpm = (usual_gpm * noise.between(0.22, 0.32)).round();
    let mut crew = Crew {
        log: Vec::new(),
        booster_gpm: if noise.unit() < 0.8 { boost_gpm } else { 0.0 },
        left_s: rig.length_s,
    };
    let mut level_m = rig.level_m;
    let mut connections = 0;
    let mut mud_gpm = (usual_gpm * noise.between(0.65, 0.8)).round();
    while crew.left_s > 0.0 {
        let stand_s = if lively {
            noise.between(1200.0, 2500.0)
        } else {
            noise.between(2400.0, 5400.0)
        };
        let pieces = if lively { 3 } else { 1 };
        // The bit is off bottom while the pumps come up, and before the connection.
        crew.run(noise.between(120.0, 300.0), mud_gpm, level_m, false);
        for _ in 0..pieces {
            crew.run(stand_s / f64::from(pieces), mud_gpm, level_m, true);
            if lively || noise.unit() < 0.3 {
                mud_gpm = (usual_gpm * noise.between(0.45, 0.85)).round();
            }
            if lively && noise.unit() < 0.25 || noise.unit() < 0.05 {
                let swing = noise.between(0.04, 0.09) * rig.well.pump_inlet_depth_m;
                let up = if noise.unit() < 0.5 { -swing } else { swing };
                level_m = (rig.level_m + up).round();
            }
            if noise.unit() < if lively { 0.15 } else { 0.05 } {
                crew.booster_gpm = if crew.booster_gpm > 0.0 {
                    0.0
                } else {
                    boost_gpm
                };
            }
        }
        crew.run(noise.between(60.0, 300.0), mud_gpm, level_m, false);
        let standing_s = noise.between(180.0, 420.0);
        connections += 1;
        // At level two the booster keeps the mud in the riser moving at whatever the crew thinks enough.
        let [less, often, more] = match rig.level {
            Level::One => [1.0; 3],
            Level::Two => {
                [(0.45, 1.0), (0.0, 1.0), (1.1, 1.4)].map(|(low, high)| noise.between(low, high))
            }
        };
        if noise.unit() < 0.4 || stops && connections % 2 == 1 {
            // Mud pump off first, then the subsea pump with the booster.
            crew.stop(standing_s, level_m, noise.between(20.0, 80.0));
        } else {
            let kept = crew.booster_gpm;
            if kept == 0.0 {
                crew.booster_gpm = (boost_gpm * less).round();
            } else if often < 0.3 {
                crew.booster_gpm = (boost_gpm * more).round();
            }
            crew.run(standing_s, 0.0, level_m, false);
            crew.booster_gpm = kept;
        }
    }
    crew.log
}

struct Crew {
    log: Vec<Segment>,
    booster_gpm: f64,
    left_s: f64,
}

impl Crew {
    fn add(&mut self, duration_s: f64, mud_gpm: f64, control: Control, drilling: bool) {
        let duration_s = duration_s.round();
        self.left_s -= duration_s;
        self.log.push(Segment {
            duration_s,
            mud_pump_gpm: mud_gpm,
            booster_gpm: self.booster_gpm,
            topfill_gpm: 30.0,
            drilling,
            control,
            every_second: true,
        });
    }

    fn run(&mut self, duration_s: f64, mud_gpm: f64, level_m: f64, drilling: bool) {
        self.add(duration_s, mud_gpm, Control::Level(level_m), drilling);
    }

    fn stop(&mut self, duration_s: f64, level_m: f64, before_s: f64) {
        self.run(before_s, 0.0, level_m, false);
        let booster = std::mem::replace(&mut self.booster_gpm, 0.0);
        self.add(duration_s, 0.0, Control::Stop, false);
        self.booster_gpm = booster;
    }
}
