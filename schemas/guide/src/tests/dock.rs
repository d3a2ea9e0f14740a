//! Docking, and charging at the dock.

use super::*;

#[test]
fn it_docks_from_a_low_charge_until_a_high_one() {
    let mut test = Test::mapped();
    test.charge(0.26);
    assert_eq!(test.awake(), ["patrol"]);
    test.charge(0.24);
    assert_eq!(test.awake(), ["approach", "patrol"]);
    let (child, reason) = test.choice(&["approach", "patrol"]);
    assert_eq!(
        (child.as_deref(), reason.as_str()),
        (Some("approach"), "the battery is at 24 %")
    );
    assert_eq!(test.target("dock_target"), Some(FAR_POSE));
    test.mission("approached", Mission::DONE, "");
    test.step();
    assert_eq!(test.target("dock_target"), Some(NEAR_POSE));
    test.step();
    assert_eq!(
        test.target("dock_target"),
        Some(NEAR_POSE),
        "that was another place"
    );
    test.mission("approached", Mission::FAILED, "it came no nearer");
    test.step();
    assert_eq!((test.awake(), test.target("dock_target")), (vec!["dock"], None));
    test.mission("docked", Mission::DONE, "docked");
    test.charge(0.6);
    assert_eq!(test.awake(), ["dock"], "it charges");
    test.charge(f32::NAN);
    assert_eq!(test.awake(), ["dock"]);
    test.charge(0.91);
    assert_eq!(test.awake(), ["patrol"]);
    test.charge(0.24);
    assert_eq!(test.target("dock_target"), Some(FAR_POSE), "from the beginning");
}

#[test]
fn without_the_tag_it_comes_to_the_dock_anew() {
    let mut test = Test::mapped();
    test.charge(0.2);
    test.at_dock();
    test.bench.set_child("dock", State::Winner);
    test.steps(100);
    assert_eq!(test.awake(), ["dock"], "it drives there");
    test.bench.set_child("dock", State::Checking);
    test.steps(45);
    assert_eq!(test.awake(), ["dock"], "it waits for a sight");
    test.steps(10);
    assert_eq!(test.target("dock_target"), Some(FAR_POSE));
}

#[test]
fn a_dock_that_does_not_charge_is_driven_to_anew() {
    let mut test = Test::mapped();
    test.charge(0.2);
    test.at_dock();
    test.mission("docked", Mission::DONE, "docked");
    test.battery(0.2, 8.0);
    test.steps(100);
    assert_eq!(test.awake(), ["dock"], "it charges");
    test.battery(0.2, -1.6);
    test.steps(45);
    assert_eq!(test.awake(), ["dock"]);
    test.steps(10);
    assert_eq!(test.target("dock_target"), Some(FAR_POSE));
    assert!(test.has_logged("does not charge"), "{:?}", test.bench.log());
}

#[test]
fn the_status_of_the_battery_precedes_its_current() {
    // Unknown, charging, discharging, not charging, full, and no status that is known.
    let cases = [
        (0, 0.5, true),
        (0, -0.5, false),
        (1, -0.01, true),
        (2, 0.5, false),
        (3, 0.5, false),
        (4, -0.01, true),
        (9, -0.5, false),
    ];
    for (power_supply_status, current, charges) in cases {
        let mut test = Test::mapped();
        test.charge(0.2);
        test.at_dock();
        test.mission("docked", Mission::DONE, "docked");
        let battery = BatteryState {
            percentage: 0.2,
            current,
            power_supply_status,
            ..BatteryState::default()
        };
        test.bench.import("battery", &battery);
        test.steps(55);
        let stays = test.awake() == ["dock"];
        assert_eq!(stays, charges, "status {power_supply_status}, {current} A");
    }
}
