//! Cuttings that raise the density in riser and line while the well is drilled.

use crate::moment::{MIXING_LEAST, Stirred};
use crate::{
    About, Action, Component, Effect, Excitation, Parameter, Relation, Role, Search, Setting,
};

/// The drilled part of each stand between connections.
fn drilled_spans(setting: &Setting, lag: f64, share: f64) -> Vec<(f64, f64)> {
    let mut spans = Vec::new();
    let mut start = setting.span_s.0;
    let ends = setting.connections.iter().map(|c| (c.from_s, c.to_s));
    for (end, next) in ends.chain([(setting.span_s.1, f64::INFINITY)]) {
        let stand = end - start;
        if stand > 0.0 {
            spans.push((start + lag * stand, start + share * stand));
        }
        start = next;
    }
    spans
}

/// See the module.
pub(super) struct CuttingsLoading;

static ABOUT: About = About {
    id: "cuttings_loading",
    title: "cuttings raise the density while the well is drilled",
    component: Component::Tank,
    relation: Relation::ReturnLineFriction,
    equation_without: Some("rho = rho_0"),
    equation: "V d(rho)/dt = q (rho_c s(t) - rho), s = 1 while drilling; p_in gains (rho - rho_0) g V_column/A; p_out gains (rho - rho_0) g L",
    source: "cuttings concentration: Bourgoyne et al. 1986; stirred-tank mixing: Levenspiel 1999",
    excited_by: "connections: between them the load builds up and washes out",
    confusable: &[
        (
            "mud_density_change",
            "observe a connection: new mud stays, cuttings wash out",
        ),
        (
            "outlet_pressure_bias",
            "circulate without drilling: cuttings wash out, a bias stays",
        ),
    ],
    parameters: &[
        Parameter {
            name: "delta_rho_kg_m3",
            meaning: "added density while drilling",
            role: Role::Amplitude,
            low: 0.0,
            high: 200.0,
            usual: 15.0,
            ..Parameter::BASE
        },
        Parameter {
            name: "drilled",
            meaning: "share of a stand that is drilled; the rest is circulated clean",
            role: Role::Shape(&[0.76, 0.9, 0.97]),
            low: 0.4,
            high: 1.0,
            usual: 0.82,
            ..Parameter::BASE
        },
        Parameter {
            name: "mixing",
            meaning: "mixed volume / mud volume in the riser",
            role: Role::Shape(&[0.15, 0.3, 0.6, 1.0]),
            low: 0.03,
            high: 2.0,
            usual: 0.3,
            ..Parameter::BASE
        },
        Parameter {
            name: "lag",
            meaning: "wait before drilling after a connection, share of a stand",
            role: Role::Shape(&[0.0, 0.08, 0.2]),
            low: 0.0,
            high: 0.4,
            usual: 0.05,
            ..Parameter::BASE
        },
        Parameter {
            name: "begun",
            meaning: "load of the mud at the start of the recording, over that while drilling",
            role: Role::Shape(&[0.0, 1.0]),
            low: 0.0,
            high: 1.0,
            usual: 1.0,
            ..Parameter::BASE
        },
        Parameter {
            name: "column_share",
            meaning: "share of the mud above the pump inlet that changes density",
            role: Role::Shape(&[0.0, 1.0]),
            low: 0.0,
            high: 1.5,
            usual: 0.5,
            ..Parameter::BASE
        },
    ],
    search: Search {
        least: Some(1.5),
        stand_error: Some(0.3),
        needs: &[Excitation::Connections],
        form_error: 0.2,
        size_error: 0.05,
        ..Search::BASE
    },
};

impl Effect for CuttingsLoading {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn begin(&self, p: &[f64], setting: &Setting) -> Action {
        let load = p[0];
        let spans = drilled_spans(setting, p[3], p[1]);
        let mut riser = Stirred::new(p[2] * setting.riser_volume_m3);
        let turned = p[5] / p[2].max(MIXING_LEAST);
        let mut line = Stirred::new(0.5 * setting.line_volume_m3());
        let mut next = 0;
        // A recording may begin amid a stand, or on clean mud.
        riser.value = load * p[4];
        line.value = load * p[4];
        Box::new(move |at, changes| {
            while spans.get(next).is_some_and(|s| at.t_s >= s.1) {
                next += 1;
            }
            let drilling = spans.get(next).is_some_and(|s| at.t_s >= s.0);
            let entering = if drilling { load } else { 0.0 };
            // The mass balance has the load enter with all that flows in: what does not leave by the pump loads the riser.
            let inflow = at.mud_pump_m3_s + at.booster_m3_s + at.topfill_m3_s;
            let leaving = riser.step(entering, inflow, at.dt_s);
            changes.riser_kg_m3 += leaving;
            changes.entering_kg_m3 += leaving + turned * (entering - leaving);
            changes.line_kg_m3 += line.step(leaving, at.flow_m3_s, at.dt_s);
        })
    }

    fn same_as(&self, p: &[f64], setting: &Setting) -> Option<String> {
        /// Share of a stand without cuttings, and of the load that is missing at the start, that washes nothing out to speak of.
        const HARDLY: f64 = 0.05;
        let stays = p[1] - p[3] > 1.0 - HARDLY && p[4] > 1.0 - HARDLY;
        let rho = setting.density_kg_m3;
        stays.then(|| {
            format!(
                "mud of {:.0} kg/m3, described as {rho:.0}: this load is there from the start and does not wash out",
                rho + p[0]
            )
        })
    }
}
