//! Every figure once, from synthetic data.

use dgd_report::{
    Axis, Compared, CostGrid, Curve, Figure, Interval, Residuals, Role, Scatter, SearchPath,
    Series, SpeedFamily, TimePanel, all_samples, complete_dynamics, delay_sweep,
    delayed_friction_fit, dynamic_and_static, exponent_search, final_friction_fit,
    final_pump_curves, first_pump_curves, friction_fit, kept_samples, residual_histogram,
    return_flow, riser_level, time_series,
};

use super::synthetic::{self, Noise};

pub(crate) fn percent(label: &str) -> Axis {
    Axis::new(format!("{label} [%]"))
}

pub(crate) fn all(samples: usize) -> Vec<(&'static str, Figure)> {
    let (all, kept) = synthetic::friction(samples);
    let (all, kept) = (scatter(&all), scatter(&kept));
    let (flow, friction) = (percent("Return flow"), percent("Frictional pressure loss"));
    let x = synthetic::ramp(110, 105.0);
    let quadratic: Vec<f64> = x.iter().map(|q| -0.1 * q + 0.0092 * q * q).collect();
    let cubic: Vec<f64> = x
        .iter()
        .map(|q| 1.0 + 0.004 * q * q + 0.000_04 * q.powi(3))
        .collect();
    let delay: Vec<f64> = synthetic::ramp(30, 30.0);
    let mse: Vec<f64> = delay
        .iter()
        .map(|d| 14.79 + 0.042 * (d - 13.0).powi(2))
        .collect();
    let curve = |y| Curve { x: &x, y };
    let mut out = vec![
        ("3-2", all_samples(all, &flow, &friction).unwrap()),
        ("3-3", kept_samples(all, kept, &flow, &friction).unwrap()),
        (
            "3-4",
            friction_fit(kept, curve(&quadratic), &flow, &friction).unwrap(),
        ),
        (
            "3-5",
            delay_sweep(&delay, &mse, &Axis::new("Mean squared error [%²]")).unwrap(),
        ),
        (
            "3-6",
            delayed_friction_fit(13.0, kept, curve(&quadratic), &flow, &friction).unwrap(),
        ),
        (
            "3-7",
            final_friction_fit(13.0, kept, curve(&cubic), &flow, &friction).unwrap(),
        ),
    ];
    pumps(&mut out);
    search(&mut out);
    simulations(&mut out);
    diagnosis(&mut out);
    out
}

fn scatter(pair: &[Vec<f64>; 2]) -> Scatter<'_> {
    Scatter {
        x: &pair[0],
        y: &pair[1],
    }
}

fn pumps(out: &mut Vec<(&'static str, Figure)>) {
    let speeds = synthetic::speeds();
    let families: Vec<SpeedFamily<'_>> = speeds
        .iter()
        .map(|s| SpeedFamily {
            speed_pct: s.speed_pct,
            samples: Scatter {
                x: &s.flow,
                y: &s.head,
            },
            model: Curve {
                x: &s.model[0],
                y: &s.model[1],
            },
        })
        .collect();
    let (flow, head) = (percent("Return flow"), percent("Pump head"));
    out.push((
        "3-9",
        first_pump_curves(&families, 0.1, &flow, &head).unwrap(),
    ));
    out.push((
        "3-11",
        final_pump_curves(&families, 0.1, &flow, &head).unwrap(),
    ));
}

fn search(out: &mut Vec<(&'static str, Figure)>) {
    let cost = |a: f64, b: f64| {
        if b <= 1.0 {
            f64::INFINITY
        } else {
            0.071 + 1.8 * (a - 1.93).powi(2) + 0.05 * (b - 2.6 - 2.0 * (a - 1.93)).powi(2)
        }
    };
    let mut noise = Noise::new(5);
    let (mut n0, mut n2) = (vec![1.45], vec![1.2]);
    for i in 0..60 {
        let pull = 0.12;
        let (a, b) = (n0[n0.len() - 1], n2[n2.len() - 1]);
        let wobble = 0.25 * (-f64::from(i) / 12.0).exp();
        n0.push(a + pull * (1.93 - a) + wobble * 0.4 * noise.normal());
        n2.push(b + pull * (2.6 - b) + wobble * noise.normal());
    }
    let costs: Vec<f64> = n0.iter().zip(&n2).map(|(a, b)| cost(*a, *b)).collect();
    let (g0, g2): (Vec<f64>, Vec<f64>) = (synthetic::ramp(60, 1.6), synthetic::ramp(60, 3.2));
    let (g0, g2): (Vec<f64>, Vec<f64>) = (
        g0.iter().map(|v| v + 1.0).collect(),
        g2.iter().map(|v| v + 0.5).collect(),
    );
    let grid: Vec<f64> = g2
        .iter()
        .flat_map(|b| g0.iter().map(move |a| cost(*a, *b)))
        .collect();
    let path = SearchPath {
        n0: &n0,
        n2: &n2,
        cost: &costs,
    };
    let grid = CostGrid {
        n0: &g0,
        n2: &g2,
        cost: &grid,
    };
    let axis = Axis::new("Mean squared error [%²]");
    out.push(("3-10", exponent_search(&path, Some(&grid), &axis).unwrap()));
    out.push((
        "3-10-plain",
        exponent_search(&SearchPath { cost: &[], ..path }, None, &axis).unwrap(),
    ));
}

fn simulations(out: &mut Vec<(&'static str, Figure)>) {
    let run = synthetic::run(6000);
    let of = |y| Curve { x: &run.time_s, y };
    let level = Compared {
        measured: of(&run.level[0]),
        simulated: of(&run.level[1]),
    };
    let flow = Compared {
        measured: of(&run.flow[0]),
        simulated: of(&run.flow[1]),
    };
    let input = |label, n, value| Series {
        label,
        role: Role::Input(n),
        time_s: &run.time_s,
        value,
    };
    let inputs = [
        input("Rig pumps", 0, run.inflow.as_slice()),
        input("Return flow", 1, run.flow[0].as_slice()),
    ];
    let level_axis = Axis::new("Riser level [m]");
    let flow_axis = percent("Flow");
    out.push((
        "4-1",
        riser_level(&level, &inputs, &level_axis, &flow_axis).unwrap(),
    ));
    out.push((
        "4-2",
        return_flow(&flow, of(&run.speed), &flow_axis, &percent("Speed")).unwrap(),
    ));
    out.push((
        "4-3",
        dynamic_and_static(
            of(&run.flow[0]),
            of(&run.flow[1]),
            of(&run.flow[2]),
            &flow_axis,
        )
        .unwrap(),
    ));
    out.push((
        "4-4",
        complete_dynamics(&level, &flow, &level_axis, &flow_axis).unwrap(),
    ));
    let si: Vec<f64> = run.flow[0].iter().map(|v| v * 6.3e-4).collect();
    let pressure: Vec<f64> = run.level[0]
        .iter()
        .map(|v| 2.4e7 + 1.3e4 * (v - 1250.0))
        .collect();
    let si = [Series {
        label: "Measured",
        role: Role::Measured,
        time_s: &run.time_s,
        value: &si,
    }];
    let pressure = [Series {
        label: "Measured",
        role: Role::Measured,
        time_s: &run.time_s,
        value: &pressure,
    }];
    let panels = [
        TimePanel {
            axis: Axis::new("Flow [m³/s]"),
            title: "",
            series: &si,
        },
        TimePanel {
            axis: Axis::new("Pump inlet pressure [Pa]"),
            title: "",
            series: &pressure,
        },
    ];
    out.push(("si", time_series(&panels, &[]).unwrap()));
}

fn diagnosis(out: &mut Vec<(&'static str, Figure)>) {
    let mut noise = Noise::new(9);
    let time: Vec<f64> = (0..306_000).map(f64::from).collect();
    let base: Vec<f64> = time
        .iter()
        .map(|t| 50.0 + 20.0 * (t / 9000.0).sin())
        .collect();
    let measured: Vec<f64> = base.iter().map(|v| v + 1.5 * noise.normal()).collect();
    let residual: Vec<f64> = time
        .iter()
        .map(|t| if (90_000.0..130_000.0).contains(t) { 4.0 } else { 0.0 } + 1.5 * noise.normal())
        .collect();
    let after: Vec<f64> = residual.iter().map(|_| 1.5 * noise.normal()).collect();
    let series = |label, role, value| Series {
        label,
        role,
        time_s: &time,
        value,
    };
    let flow = [
        series("Measured", Role::Measured, measured.as_slice()),
        series("Model", Role::Model, base.as_slice()),
    ];
    let difference = [
        series("Before", Role::Before, residual.as_slice()),
        series("After", Role::Model, after.as_slice()),
    ];
    let panels = [
        TimePanel {
            axis: percent("Flow"),
            title: "",
            series: &flow,
        },
        TimePanel {
            axis: percent("Residual"),
            title: "Relation: return-line friction",
            series: &difference,
        },
    ];
    let intervals = [
        Interval {
            start_s: 90_000.0,
            end_s: 130_000.0,
            label: "Mismatch",
        },
        Interval {
            start_s: 220_000.0,
            end_s: 228_000.0,
            label: "Stuck meter",
        },
    ];
    out.push(("time-series", time_series(&panels, &intervals).unwrap()));
    let set = |label, role, value| Residuals { label, role, value };
    let axis = percent("Residual of the friction");
    let one = [set("Model", Role::Model, after.as_slice())];
    out.push(("histogram", residual_histogram(&one, &axis).unwrap()));
    let two = [
        set("Before", Role::Before, residual.as_slice()),
        set("After", Role::Model, after.as_slice()),
    ];
    out.push(("histogram-two", residual_histogram(&two, &axis).unwrap()));
    out.push((
        "empty",
        all_samples(
            Scatter { x: &[], y: &[] },
            &percent("Return flow"),
            &percent("Friction"),
        )
        .unwrap(),
    ));
}
