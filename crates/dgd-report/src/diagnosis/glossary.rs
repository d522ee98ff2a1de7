//! What the letters of the equations stand for.

use super::html::Html;
use super::plain;
use super::token::{What, tokens};

/// A name in plain notation, what must stand in an equation for it to be meant, and its meaning.
const MEANINGS: [(&str, &str, &str); 42] = [
    ("p_out", "", "pressure at the pump outlet"),
    ("p_in", "", "pressure at its inlet"),
    ("p_0", "", "atmosphere"),
    ("p_meter", "", "reading of the pressure transmitter"),
    ("p_frac", "", "pressure above which mud is lost"),
    ("q", "", "flow through pump and return line"),
    ("q_in", "", "flow into the riser"),
    ("q_meter", "", "reading of the flow meter"),
    ("q_mud_pump", "", "flow of the mud pumps"),
    ("q_booster", "", "flow into the booster line"),
    ("q_out", "", "flow out of the booster line"),
    ("q_string", "", "flow out of the drill string"),
    ("q_0", "e q_0", "a usual flow of the mud pumps, 0.03 m³/s"),
    ("s", "s tau", "share of the string volume that drains"),
    ("e", "e q_0", "how evenly it drains"),
    ("t_d", "", "delay of the part spread along the line"),
    ("q_f", "", "flow at which turbulent friction takes over"),
    ("h", "", "height of the mud in the riser (not a depth)"),
    ("A", "A dh", "cross-section of the riser annulus"),
    ("A", "L/A", "cross-section of the return line"),
    ("A_line", "", "cross-section of the return line"),
    ("L", "", "length of the return line"),
    // Not that of dρ/dt.
    ("d", "L / d", "bore of the return line"),
    ("d", "(3 d)", "bore of the return line"),
    ("v", "", "velocity in the return line"),
    ("z", "", "height that has drained"),
    (
        "F",
        "F(",
        "friction as a function of flow, fitted to the recording",
    ),
    (
        "phi",
        "",
        "friction as a function of flow, fitted to the recording",
    ),
    (
        "H",
        "H(",
        "head of the pump as a function of speed and flow, fitted to the recording",
    ),
    ("w", "", "speed of the pump"),
    ("w_set", "", "set-point of the pump's speed"),
    ("rho", "", "density of the mud"),
    ("rho_0", "", "density according to the well file"),
    ("rho_in", "", "density of the mud pumped in"),
    ("rho_c", "", "density with cuttings"),
    ("V", "d(rho)", "volume in which muds mix"),
    ("tau", "tau d", "time constant"),
    ("tau", "4 tau", "strength of the gel at the wall"),
    ("mu", "", "viscosity"),
    ("Re", "", "Reynolds number"),
    ("g", "", "gravity"),
    ("s", "s(t)", "time profile, from 0 to 1"),
];

/// One line that explains the letters of these equations, each once.
pub(super) fn write<'a>(equations: impl IntoIterator<Item = &'a str>, html: &mut Html) {
    let told = meant(equations);
    if told.is_empty() {
        return;
    }
    html.open("p", "small symbols");
    html.element("b", "", "Symbols:");
    let last = told.len() - 1;
    for (index, (name, meaning)) in told.into_iter().enumerate() {
        let end = if index == last { "." } else { "; " };
        html.mathml(&plain::formula(name))
            .element("span", "", &format!(" {meaning}{end}"));
    }
    html.close("p");
}

fn meant<'a>(equations: impl IntoIterator<Item = &'a str>) -> Vec<(&'static str, &'static str)> {
    let mut found = [false; MEANINGS.len()];
    for equation in equations {
        let names: Vec<String> = (tokens(equation).into_iter().flatten())
            .filter_map(|token| match token.what {
                What::Name(name) => Some(name),
                _ => None,
            })
            .collect();
        let has = |wanted: &str| {
            names.iter().any(|name| {
                // `p_meter,i` is one of several; `dq_meter/dt` holds q_meter, `dp` is a pressure drop of its own.
                let name = name.split_once(',').map_or(name.as_str(), |(name, _)| name);
                name == wanted || name.strip_prefix('d') == Some(wanted)
            })
        };
        for (found, (name, when, _)) in found.iter_mut().zip(MEANINGS) {
            *found |= equation.contains(when) && has(name);
        }
    }
    let told = found.into_iter().zip(MEANINGS).filter(|(found, _)| *found);
    told.map(|(_, (name, _, meaning))| (name, meaning))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::meant;

    #[test]
    fn a_letter_is_explained_by_the_equation_that_it_stands_in() {
        let names = |equation| -> Vec<&str> {
            let told: Vec<_> = meant([equation]);
            told.into_iter().map(|(_, meaning)| meaning).collect()
        };
        assert_eq!(
            names("A dh/dt = q_in - q"),
            [
                "flow through pump and return line",
                "flow into the riser",
                "height of the mud in the riser (not a depth)",
                "cross-section of the riser annulus",
            ]
        );
        assert_eq!(
            names("tau dq_meter/dt = q - q_meter"),
            [
                "flow through pump and return line",
                "reading of the flow meter",
                "time constant",
            ]
        );
        assert!(names("not = known").is_empty());
    }

    #[test]
    fn every_equation_of_the_catalogue_is_explained_in_part() {
        for effect in dgd_effects::catalogue() {
            assert!(
                !meant([effect.about().equation]).is_empty(),
                "{}",
                effect.about().id
            );
        }
    }
}
