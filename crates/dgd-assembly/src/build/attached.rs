//! The effects that a description puts on its components.

use super::{Slots, listed};
use crate::effects;
use crate::network::Attached;
use crate::spec::{EffectSetting, System};

/// Slots of the effects' parameters; those of a part stand together.
pub(super) fn effect_slots(slots: &mut Slots, system: &System) {
    let mut asked: Vec<(usize, &EffectSetting)> = Vec::new();
    for setting in &system.effects {
        let path = format!("{}.{}", setting.component, setting.effect);
        match slots.part(&setting.component) {
            None => slots.problem(
                path,
                format!("there is no component `{}`", setting.component),
                "",
            ),
            Some(part) => asked.push((part, setting)),
        }
    }
    // In the order of the catalogue: what a system is does not hang on the order in which its effects are written.
    let rank = |id: &str| effects::all().iter().position(|e| e.about().id == id);
    asked.sort_by_key(|(part, setting)| (*part, rank(&setting.effect)));
    for (part, setting) in asked {
        let kind = slots.parts[part].kind;
        let path = format!("{}.{}", setting.component, setting.effect);
        let Some(effect) =
            effects::find(&setting.effect).filter(|e| e.about().kinds.contains(&kind))
        else {
            let known = listed(
                effects::all()
                    .iter()
                    .map(|e| e.about())
                    .filter(|a| a.kinds.contains(&kind))
                    .map(|a| a.id),
            );
            slots.problem(
                path,
                format!("is not an effect of a {}", kind.name()),
                format!("expected one of: {known}"),
            );
            continue;
        };
        if slots
            .paths
            .contains_key(&format!("{path}.{}", effect.about().parameters[0].name))
        {
            slots.problem(
                path,
                "is given twice",
                "an effect can act only once on a component",
            );
            continue;
        }
        let about = effect.about();
        for key in setting.parameters.keys() {
            if !about.parameters.iter().any(|p| p.name == key) {
                let known = listed(about.parameters.iter().map(|p| p.name));
                slots.problem(
                    format!("{path}.{key}"),
                    "is not a parameter of the effect",
                    format!("expected one of: {known}"),
                );
            }
        }
        let base = slots.values.len();
        for parameter in about.parameters {
            let value = setting.parameters.get(parameter.name).copied();
            slots
                .paths
                .insert(format!("{path}.{}", parameter.name), slots.values.len());
            // NaN: filled in once the sizes are known.
            slots.values.push(value.unwrap_or(f64::NAN));
        }
        let index = slots.effects.len();
        slots.effects.push(Attached {
            effect,
            part,
            base,
            count: about.parameters.len(),
            states: 0..0,
        });
        let range = &mut slots.parts[part].effects;
        let first = if range.start == range.end {
            index
        } else {
            range.start
        };
        *range = first..index + 1;
    }
}
