//! Which names of the catalogue count as right for what a bench conceals.
//!
//! Written from the ids and one-line titles that `dgd-assembly`'s README lists, before the first scored run, and not widened
//! since, but for what the catalogue has been given later: `opening_play` and `opening_stiction`, before any recording of seed 6007
//! was made. The plant knows none of these names; the catalogue was not looked into when the benches were made.

/// A concealed thing and the answers that name it.
pub(crate) struct Counterpart {
    pub(crate) thing: &'static str,
    /// Component and effect; none where the catalogue has no such effect, so that `unknown` is right.
    pub(crate) names: &'static [(&'static str, &'static str)],
}

/// The table.
pub(crate) const COUNTERPARTS: [Counterpart; 16] = [
    Counterpart {
        thing: "crest_overflow",
        names: &[("shaft", "unseen_brim")],
    },
    Counterpart {
        thing: "shaft_widening",
        names: &[("shaft", "taper")],
    },
    // Tunnel and penstock meet at the foot of the shaft, where the hole is.
    Counterpart {
        thing: "shaft_leak",
        names: &[
            ("shaft", "tank_leak"),
            ("tunnel", "line_leak"),
            ("penstock", "line_leak"),
        ],
    },
    Counterpart {
        thing: "rack_clogging",
        names: &[("tunnel", "friction_drift")],
    },
    // `reading_backlash` is an instrument's, `opening_lag` a valve that follows late, not one with play.
    Counterpart {
        thing: "valve_backlash",
        names: &[("valve", "opening_play")],
    },
    // "The outlet is drowned" says the same of the valve.
    Counterpart {
        thing: "tailwater_rise",
        names: &[("tailrace", "back_pressure"), ("valve", "tail_head")],
    },
    Counterpart {
        thing: "foot_throttle",
        names: &[],
    },
    Counterpart {
        thing: "level_drift",
        names: &[("level", "reading_drift")],
    },
    Counterpart {
        thing: "pump_slip",
        names: &[("pump", "pump_slip")],
    },
    Counterpart {
        thing: "relief_cracking",
        names: &[],
    },
    Counterpart {
        thing: "warming_fluid",
        names: &[("hose", "friction_drift")],
    },
    Counterpart {
        thing: "early_transition",
        names: &[("hose", "line_exponent")],
    },
    Counterpart {
        thing: "sump_evaporation",
        names: &[("sump", "evaporation")],
    },
    Counterpart {
        thing: "needle_stiction",
        names: &[("needle", "opening_stiction")],
    },
    // Storage between the pump and the hose.
    Counterpart {
        thing: "trapped_gas",
        names: &[("pump", "hose_storage"), ("hose", "gas_pocket")],
    },
    Counterpart {
        thing: "meter_lag",
        names: &[("flow", "reading_lag")],
    },
];

/// What names a concealed thing; nothing for what no catalogue could hold.
pub(crate) fn names(thing: &str) -> &'static [(&'static str, &'static str)] {
    let found = COUNTERPARTS.iter().find(|c| c.thing == thing);
    found.map_or(&[], |c| c.names)
}

/// A size of the plant, the catalogue's parameter that means the same, and how many of its units make one of the plant's. Only where
/// both write the same equation.
pub(crate) const SIZES: [(&str, &str, &str, f64); 5] = [
    ("crest_overflow", "crest_m", "shaft.unseen_brim.height", 1.0),
    (
        "valve_backlash",
        "half_band",
        "valve.opening_play.play",
        2.0,
    ),
    (
        "needle_stiction",
        "band",
        "needle.opening_stiction.band",
        1.0,
    ),
    ("meter_lag", "time_constant_s", "flow.reading_lag.tau", 1.0),
    // Of the sump's 0.12 m2.
    (
        "sump_evaporation",
        "per_hour_m",
        "sump.evaporation.rate",
        0.12 / 3600.0,
    ),
];

/// Components of the benches and their kinds, as the system descriptions have them.
const KINDS: [(&str, &str, &str); 21] = [
    ("surge-shaft", "reservoir", "boundary"),
    ("surge-shaft", "tunnel", "line"),
    ("surge-shaft", "shaft", "tank"),
    ("surge-shaft", "penstock", "line"),
    ("surge-shaft", "valve", "valve"),
    ("surge-shaft", "tailrace", "boundary"),
    ("surge-shaft", "level", "instrument"),
    ("surge-shaft", "tunnel_flow", "instrument"),
    ("surge-shaft", "penstock_flow", "instrument"),
    ("surge-shaft", "valve_pressure", "instrument"),
    ("glycol-loop", "sump", "tank"),
    ("glycol-loop", "pump", "pump"),
    ("glycol-loop", "accumulator", "volume"),
    ("glycol-loop", "hose", "line"),
    ("glycol-loop", "needle", "valve"),
    ("glycol-loop", "header", "tank"),
    // An orifice is a valve that stands still.
    ("glycol-loop", "drain", "valve"),
    ("glycol-loop", "pressure", "instrument"),
    ("glycol-loop", "flow", "instrument"),
    ("glycol-loop", "header_level", "instrument"),
    ("glycol-loop", "sump_level", "instrument"),
];

/// Kind of a component.
pub(crate) fn kind(bench: &str, component: &str) -> Option<&'static str> {
    let found = KINDS
        .iter()
        .find(|(b, c, _)| *b == bench && *c == component);
    found.map(|(_, _, kind)| *kind)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_sits_on_a_component_and_no_thing_stands_twice() {
        for (i, c) in COUNTERPARTS.iter().enumerate() {
            assert!(COUNTERPARTS[..i].iter().all(|o| o.thing != c.thing));
            for (component, _) in c.names {
                let of = |bench| kind(bench, component).is_some();
                assert!(super::super::BENCHES.into_iter().any(of), "{component}");
            }
        }
    }

    #[test]
    fn a_size_that_is_compared_is_a_parameter_of_a_name_that_counts() {
        for (thing, _, path, _) in SIZES {
            let is = |(component, effect): &(&str, &str)| {
                path.starts_with(&format!("{component}.{effect}."))
            };
            assert!(names(thing).iter().any(is), "{path}");
        }
    }
}
