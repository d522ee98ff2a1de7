//! Which effects can sit on which components of an assembly.

use crate::assembly::Assembly;
use crate::effect::{Effect, Place};
use crate::effects;
use crate::kinds;
use crate::network::{Flow, NodeKind};
use crate::spec::Kind;

/// An effect on a component of an assembly, with its parameters in SI bounds.
#[derive(Clone)]
pub struct Hypothesis {
    /// Component.
    pub component: String,
    /// Id of the effect.
    pub effect: &'static str,
    /// The effect.
    pub law: &'static dyn Effect,
    /// Its parameters.
    pub parameters: Vec<EffectParameter>,
}

impl std::fmt::Debug for Hypothesis {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} on {}", self.effect, self.component)
    }
}

/// A parameter of an effect at a place.
#[derive(Debug, Clone, PartialEq)]
pub struct EffectParameter {
    /// Name.
    pub name: &'static str,
    /// Least value.
    pub low: f64,
    /// Greatest value.
    pub high: f64,
    /// Value that changes nothing (strength), or the usual one (shape).
    pub neutral: f64,
    /// Where a search starts.
    pub usual: f64,
}

/// Every effect on every component that it can sit on and does not sit on yet, in the order of components and catalogue.
#[must_use]
pub fn effects_for(assembly: &Assembly) -> Vec<Hypothesis> {
    let net = &assembly.net;
    let mut found = Vec::new();
    for (i, part) in net.parts.iter().enumerate() {
        let place = place(assembly, i);
        for &law in effects::all() {
            let about = law.about();
            let there = net
                .effects_of(i)
                .iter()
                .any(|a| a.effect.about().id == about.id);
            if there || !about.kinds.contains(&part.kind) || !law.fits(&place) {
                continue;
            }
            let parameters = about
                .parameters
                .iter()
                .map(|p| {
                    let size = part.scale.of(p.size);
                    EffectParameter {
                        name: p.name,
                        low: p.low * size,
                        high: p.high * size,
                        neutral: p.neutral * size,
                        usual: p.usual * size,
                    }
                })
                .collect();
            found.push(Hypothesis {
                component: part.name.clone(),
                effect: about.id,
                law,
                parameters,
            });
        }
    }
    found
}

fn place(assembly: &Assembly, i: usize) -> Place {
    let net = &assembly.net;
    let part = &net.parts[i];
    let tank = net.tanks.iter().position(|&t| t == i);
    let mut place = Place {
        has_brim: false,
        has_tank_below: tank.is_some_and(|k| net.below[k].is_some()),
        outlet_stores: false,
        has_inertia: false,
        may_have_inertia: false,
        in_time: net.in_time,
        gives_flow: part.gives_flow,
        driven: net
            .driven
            .iter()
            .any(|d| d.slot >= part.base && d.slot < part.base + part.count),
    };
    if part.kind == Kind::Tank {
        let slot = part.base + kinds::tank::BRIM;
        place.has_brim = net.values[slot].is_finite();
    }
    if let Some((c, member)) = net.seat[i] {
        let chain = &net.chains[c];
        let last = member + 1 == chain.members.len() && chain.members[member].sign > 0.0;
        place.outlet_stores = last && net.nodes[chain.to].kind != NodeKind::Free;
        place.has_inertia = matches!(chain.flow, Flow::State(_));
        let pumped = chain
            .members
            .iter()
            .any(|m| net.parts[m.part].kind == Kind::DisplacementPump);
        place.may_have_inertia = net.in_time && !pumped && chain.flow == Flow::Algebraic;
    }
    place
}
