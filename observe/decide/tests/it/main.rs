//! Replays of recorded drives of the paper's example with its plugins.

mod drives;
mod many_schemas;
mod mock;

use std::sync::Arc;

use jde_app::Application;
use jde_board::value::Value;
use jde_core::SchemaId;
use jde_decide::{ReplayError, ReplayReport, ReplayedDrive, Span, Tolerance, replay_and_compare};
use jde_host::reload::ReloadOptions;
use jde_host::{Handle, OperatorHandle, SensorFault};
use jde_panel::{Button, Gesture, Touch};

use drives::{RecordedDrive, SECOND};

fn replay(recorded: &RecordedDrive, sets: &[&str]) -> ReplayReport {
    replay_with(recorded, recorded.application(sets))
}

fn replay_with(recorded: &RecordedDrive, application: Application) -> ReplayReport {
    let drive = ReplayedDrive::open(recorded.file()).unwrap();
    replay_and_compare(
        &drive,
        application,
        recorded.plugins(),
        Span::default(),
        &Tolerance::default(),
        |_| true,
    )
    .unwrap()
}

/// Fails unless every selection was compared, and all are the same.
#[track_caller]
fn assert_same(verdict: &ReplayReport, recorded: &RecordedDrive) {
    assert!(
        verdict.is_same(),
        "{:#?} {:#?}",
        verdict.comparison.first,
        verdict.values
    );
    assert_eq!(
        verdict.comparison.same,
        recorded.decisions(),
        "every selection is compared"
    );
}

#[test]
fn r16_a_replay_of_lockstep_gives_the_same_selections() {
    let recorded = RecordedDrive::lockstep("lockstep.mcap", 20 * SECOND, &[]);
    let verdict = replay(&recorded, &[]);
    assert_same(&verdict, &recorded);
    assert_eq!((verdict.lost_steps, verdict.missed), (0, Vec::new()));
}

#[test]
fn a_replay_with_a_changed_modulation_reports_different_selections() {
    let recorded = RecordedDrive::lockstep("constant.mcap", 20 * SECOND, &[]);
    let verdict = replay(&recorded, &["stop.ahead=1.5"]);
    assert!(!verdict.is_same());
    let first = &verdict.comparison.first[0];
    assert_eq!(first.group, "example/base");
    assert!(
        first
            .inputs
            .iter()
            .any(|(name, saw)| name == "stop" && !saw.is_empty()),
        "{first:#?}"
    );
}

#[test]
fn r16_a_replay_of_real_time_gives_the_same_selections() {
    let recorded = RecordedDrive::real_time("real.mcap", 30 * SECOND, 5.0, &[]);
    let verdict = replay(&recorded, &[]);
    assert_same(&verdict, &recorded);
    assert_eq!((verdict.lost_steps, verdict.missed), (0, Vec::new()));
    let verdict = replay(&recorded, &["stop.ahead=1.5"]);
    assert!(!verdict.is_same());
}

#[test]
fn r14_a_replay_of_exports_that_failed_gives_the_same_selections() {
    fn fail(handle: &Handle, schema: &str, export: &str, fault: SensorFault) {
        let schema = handle.application().instance(schema).unwrap();
        handle.operator("ana").fail_export(schema, export, fault).unwrap();
    }
    let recorded = RecordedDrive::operated(
        "failing.mcap",
        20 * SECOND,
        &[
            (2 * SECOND, |handle| {
                fail(handle, "pioneer", "laser", SensorFault::Noise { sigma: 0.2 });
            }),
            (4 * SECOND, |handle| {
                fail(handle, "pioneer", "odometry", SensorFault::Frozen)
            }),
            (6 * SECOND, |handle| {
                fail(handle, "pioneer", "laser", SensorFault::Silent)
            }),
            // An export that the replay publishes again, and does not take from the recording.
            (7 * SECOND, |handle| {
                fail(handle, "example", "mission", SensorFault::Frozen)
            }),
            (9 * SECOND, |handle| {
                let pioneer = handle.application().instance("pioneer").unwrap();
                handle.operator("ana").release(pioneer).unwrap();
            }),
            (12 * SECOND, |handle| {
                fail(handle, "example", "mission", SensorFault::Silent)
            }),
        ],
    );
    let verdict = replay(&recorded, &[]);
    assert_same(&verdict, &recorded);
    assert_eq!((verdict.lost_steps, verdict.missed), (0, Vec::new()));
}

#[test]
fn r14_a_replay_repeats_the_actions_of_operators() {
    fn schema(handle: &Handle, name: &str) -> SchemaId {
        handle.application().instance(name).unwrap()
    }
    fn ana(handle: &Handle) -> OperatorHandle {
        handle.operator("ana")
    }
    let recorded = RecordedDrive::operated(
        "operated.mcap",
        20 * SECOND,
        &[
            (2 * SECOND, |handle| {
                let stop = schema(handle, "stop");
                ana(handle).modulate(stop, "ahead", &Value::Float(3.0)).unwrap();
            }),
            (4 * SECOND, |handle| {
                ana(handle).hold_asleep(schema(handle, "vff")).unwrap()
            }),
            (6 * SECOND, |handle| {
                ana(handle).release(schema(handle, "stop")).unwrap()
            }),
            (7 * SECOND, |handle| {
                ana(handle).release(schema(handle, "vff")).unwrap()
            }),
            (8 * SECOND, |handle| {
                ana(handle)
                    .set_period(schema(handle, "goon"), SECOND / 5)
                    .unwrap()
            }),
            (9 * SECOND, |handle| {
                ana(handle).force(schema(handle, "stop")).unwrap()
            }),
            (11 * SECOND, |handle| {
                ana(handle).release(schema(handle, "stop")).unwrap()
            }),
        ],
    );
    let verdict = replay(&recorded, &[]);
    assert_same(&verdict, &recorded);
    assert_eq!((verdict.missed, verdict.unknown), (Vec::new(), Vec::new()));
}

#[test]
fn r14_a_replay_reports_the_reloads_of_the_recorded_run() {
    let recorded = RecordedDrive::operated(
        "reloaded.mcap",
        20 * SECOND,
        &[(6 * SECOND, |handle| {
            let vff = handle.application().instance("vff").unwrap();
            let new_build = drives::navigation_plugins().load("vff", &[]).unwrap();
            handle
                .operator("ana")
                .replace(vff, &new_build, ReloadOptions::default())
                .unwrap_or_else(|reasons| panic!("{reasons:?}"));
        })],
    );
    let events = recorded.events("reloaded");
    assert_eq!(events.len(), 1, "{events:?}");
    assert!(
        events[0].contains("of memory carried over (version 1)"),
        "{events:?}"
    );
    let verdict = replay(&recorded, &[]);
    assert_eq!(verdict.reloads, [("vff".to_owned(), 6 * SECOND)]);
    assert_same(&verdict, &recorded);
    assert_eq!((verdict.lost_steps, verdict.missed), (0, Vec::new()));
}

#[test]
fn differences_to_the_recorded_application_are_listed_and_restored() {
    let recorded = RecordedDrive::lockstep("other.mcap", 5 * SECOND, &[]);
    let drive = ReplayedDrive::open(recorded.file()).unwrap();
    assert_eq!(drive.differences(&recorded.application(&[])), [""; 0]);
    let changed = recorded.application(&["stop.ahead=0.9", "goon.period=100 ms"]);
    let differences = drive.differences(&changed);
    assert!(
        differences
            .iter()
            .any(|line| line.starts_with("stop.ahead starts with 0.9")),
        "{differences:?}"
    );
    assert!(
        differences
            .iter()
            .any(|line| line.starts_with("goon.period starts with 0.1 s")),
        "{differences:?}"
    );
    let mut restored = recorded.application(&["stop.ahead=0.9", "goon.period=100 ms"]);
    drive.restore(&mut restored, |_| false);
    assert_eq!(drive.differences(&restored), [""; 0]);
    let attached = drive.application().unwrap();
    assert_eq!(attached.name, "safe-navigation.toml");
    assert!(attached.text.contains("safe-navigation"));
}

#[test]
fn a_recording_with_the_former_name_of_a_parameter_is_replayed() {
    let recorded = RecordedDrive::lockstep("former.mcap", 20 * SECOND, &[]);
    let drive = ReplayedDrive::open(recorded.file()).unwrap();
    let renamed = |sets: &[&str]| {
        let mut application = recorded.application(sets);
        let stop = application.instance("stop").unwrap();
        let ports = &mut Arc::make_mut(&mut application.instances[stop].schema).ports;
        let port = ports.iter_mut().find(|port| port.name == "ahead").unwrap();
        port.former_name = Some(std::mem::replace(&mut port.name, "distance".to_owned()));
        application
    };
    let mut application = renamed(&["stop.ahead=1.5"]);
    drive.restore(&mut application, |_| false);
    let present = &renamed(&[]).instances;
    for (one, other) in application.instances.iter().zip(present) {
        assert_eq!(one.bindings, other.bindings, "{}", one.name);
    }
    let verdict = replay_with(&recorded, application);
    assert_same(&verdict, &recorded);
}

#[test]
fn a_truncated_recording_is_replayed_up_to_its_end() {
    let recorded = RecordedDrive::lockstep("cut.mcap", 20 * SECOND, &[]);
    let bytes = std::fs::read(recorded.file()).unwrap();
    std::fs::write(recorded.file(), &bytes[..bytes.len() / 2]).unwrap();
    let verdict = replay(&recorded, &[]);
    assert!(
        verdict.is_same(),
        "{:#?} {:#?}",
        verdict.comparison.first,
        verdict.values
    );
    assert!(verdict.damage.is_some());
    assert!(
        (SECOND..19 * SECOND).contains(&verdict.until),
        "{}",
        verdict.until
    );
    assert_eq!(verdict.lost_steps, 0);
}

#[test]
fn a_recording_without_what_schemas_import_is_refused() {
    let recorded = RecordedDrive::lockstep("partial.mcap", SECOND, &["*.mission", "pioneer.odometry"]);
    let drive = ReplayedDrive::open(recorded.file()).unwrap();
    let result = replay_and_compare(
        &drive,
        recorded.application(&[]),
        recorded.plugins(),
        Span::default(),
        &Tolerance::default(),
        |_| true,
    );
    let Err(ReplayError::Incomplete { what, .. }) = result else {
        panic!("{result:?}");
    };
    assert!(what.starts_with("`pioneer.laser` is not in it"), "{what}");
}

#[test]
fn r14_a_replay_repeats_the_gestures_on_panels() {
    fn touch(handle: &Handle, widget: &str, touch: Touch) {
        let example = handle.application().instance("example").unwrap();
        let gesture = Gesture {
            widget: widget.to_owned(),
            touch,
        };
        handle.touch("ana", example, gesture).unwrap();
    }
    fn click(handle: &Handle, x: f64, y: f64) {
        let at = [x, y, 0.0];
        let button = Button::Primary;
        touch(handle, "field", Touch::Clicked { at, button });
    }
    let recorded = RecordedDrive::operated(
        "touched.mcap",
        30 * SECOND,
        &[
            // Numbers without a short decimal representation.
            (2 * SECOND, |handle| click(handle, 0.1 + 0.2, 2.0_f64.sqrt())),
            (9 * SECOND, |handle| touch(handle, "clear", Touch::Pressed)),
            (12 * SECOND, |handle| {
                let dragged = Touch::Dragged {
                    from: [0.0; 3],
                    to: [0.1 + 0.2, 0.0, 0.0],
                    button: Button::Primary,
                    ended: false,
                };
                touch(handle, "field", dragged);
            }),
            (15 * SECOND, |handle| click(handle, 5.0, 7.1)),
        ],
    );
    let verdict = replay(&recorded, &[]);
    assert_same(&verdict, &recorded);
    assert_eq!((verdict.missed, verdict.unknown), (Vec::new(), Vec::new()));
    assert_eq!(
        recorded.events("operator"),
        [
            "ana clicked `field` of example at (0.30, 1.41)",
            "ana pressed `clear` of example",
            "ana clicked `field` of example at (5.00, 7.10)",
        ]
    );
    assert_eq!(
        recorded.events("drag").len(),
        1,
        "a drag that continues has its own kind"
    );
}
