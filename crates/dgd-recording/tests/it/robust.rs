use crate::wells::well;
use dgd_recording::{Column, Recording, Table, propose_channels, quantum, survey, survey_clock};
use proptest::prelude::*;

fn value() -> impl Strategy<Value = f64> {
    prop_oneof![
        8 => -10.0..1e3f64,
        4 => (-5..50i32).prop_map(f64::from),
        1 => any::<f64>(),
        1 => Just(f64::NAN),
    ]
}

fn column() -> impl Strategy<Value = Column> {
    let tag = prop_oneof![
        3 => prop::sample::select(vec![
            "t", "FT1", "FT2", "FT3", "FT4", "PT1", "PT2", "PT3", "PT4", "PT5", "SPM", "gom.FT4",
        ])
        .prop_map(str::to_owned),
        1 => any::<String>(),
    ];
    let unit = prop::option::of(prop_oneof![
        prop::sample::select(vec!["s", "gpm", "psia", "psig", "%", "bar"]).prop_map(str::to_owned),
        any::<String>(),
    ]);
    (tag, unit, prop::collection::vec(value(), 0..60)).prop_map(|(tag, unit, values)| Column {
        tag,
        unit,
        values,
    })
}

proptest! {
    #[test]
    fn no_table_panics(columns in prop::collection::vec(column(), 0..16)) {
        let table = Table { columns, ..Table::default() };
        let _ = propose_channels(&survey(&table));
        if let Ok((recording, _)) = Recording::from_table(table, &well()) {
            let _ = recording.onto_grid();
        }
    }

    #[test]
    fn any_stamps_give_an_even_clock_or_an_error(
        stamps in prop::collection::vec(value(), 1..80),
    ) {
        let n = stamps.len();
        let series = || (0..n).map(|i| i as f64).collect::<Vec<f64>>();
        let recording = Recording {
            time_s: stamps.clone(),
            mud_pump_flow_m3_s: series(),
            booster_flow_m3_s: series(),
            topfill_flow_m3_s: series(),
            return_flow_m3_s: series(),
            pump_inlet_pressure_pa: vec![series()],
            pump_outlet_pressure_pa: vec![series()],
            riser_pressure_pa: None,
            pump_speed_pct: series(),
        };
        if let Ok((gridded, step_s, _)) = recording.onto_grid() {
            prop_assert!(step_s > 0.0);
            prop_assert!(gridded.len() <= 100_001);
            for (_, values) in gridded.series() {
                prop_assert_eq!(values.len(), gridded.len());
            }
            for pair in gridded.time_s.windows(2) {
                prop_assert!(pair[1] > pair[0]);
            }
            // Every sample on the grid is one of the file, used once.
            let mut used: Vec<f64> = gridded.pump_speed_pct.into_iter().filter(|w| w.is_finite()).collect();
            let count = used.len();
            used.sort_by(f64::total_cmp);
            used.dedup();
            prop_assert_eq!(used.len(), count);
        }
        if let Ok(clock) = survey_clock(&stamps) {
            prop_assert!(clock.steps() <= 100_001);
            let _ = clock.issues();
        }
    }

    #[test]
    fn a_quantum_is_no_finer_than_the_values(
        values in prop::collection::vec((0..4i32).prop_map(f64::from), 0..100),
    ) {
        prop_assert!(quantum(&values).is_none_or(|step| step >= 1.0));
    }
}
