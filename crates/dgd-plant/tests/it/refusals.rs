//! Plans that are refused, and why.

use dgd_plant::{Plan, PlantError, record};

#[test]
fn empty_and_endless_recordings_are_refused_with_their_length() {
    let mut plan = Plan::short(1);
    plan.series = vec![0];
    assert_eq!(record(&plan), Err(PlantError::Samples { found: 0 }));
    plan.series = vec![9_000_000];
    assert_eq!(record(&plan), Err(PlantError::Samples { found: 9_000_000 }));
    plan.series = vec![usize::MAX, 2];
    assert_eq!(
        record(&plan),
        Err(PlantError::Samples { found: usize::MAX })
    );
}

#[test]
fn plan_without_a_schedule_is_refused() {
    let mut plan = Plan::short(1);
    plan.schedule.clear();
    assert_eq!(record(&plan), Err(PlantError::NoSchedule));
}

#[test]
fn impossible_geometry_is_refused_by_name() {
    let mut plan = Plan::short(1);
    plan.well.return_line_id_m = -0.1;
    let expected = PlantError::NotPositive {
        name: "well.return_line_id_m",
        found: -0.1,
    };
    assert_eq!(record(&plan), Err(expected.clone()));
    assert_eq!(
        expected.to_string(),
        "`well.return_line_id_m` is -0.1, expected a positive number"
    );
}
