//! Drives of the paper's example, recorded and replayed with its own plugins: what is equal, and what is not.

mod drives;
mod troupe;

use jde_board::value::Value;
use jde_host::reload::ReloadOptions;
use jde_host::{Handle, OperatorHandle};
use jde_log::replay::{Drive, ReplayError, ReplayReport, Span, Tolerance, replay_and_compare};
use jde_panel::{Button, Gesture, Touch};

use drives::{SECOND, Scene};

fn again(scene: &Scene, sets: &[&str]) -> ReplayReport {
    let drive = Drive::open(scene.file()).unwrap();
    let application = scene.application(sets);
    replay_and_compare(
        &drive,
        application,
        scene.plugins(),
        Span::default(),
        &Tolerance::default(),
        |_| true,
    )
    .unwrap()
}

#[test]
fn r16_a_drive_in_lockstep_is_decided_again_as_it_was() {
    let scene = Scene::lockstep("lockstep.mcap", 20 * SECOND, &[]);
    let verdict = again(&scene, &[]);
    assert!(
        verdict.is_same(),
        "{:#?} {:#?}",
        verdict.comparison.first,
        verdict.values
    );
    assert_eq!(
        verdict.comparison.same,
        scene.decisions(),
        "every selection is compared"
    );
    assert_eq!((verdict.lost_steps, verdict.missed), (0, Vec::new()));
}

#[test]
fn a_changed_constant_is_found_in_a_drive_in_lockstep() {
    let scene = Scene::lockstep("constant.mcap", 20 * SECOND, &[]);
    let verdict = again(&scene, &["stop.ahead=1.5"]);
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
fn r16_a_drive_in_real_time_is_decided_again_as_it_was() {
    let scene = Scene::real_time("real.mcap", 30 * SECOND, 5.0, &[]);
    let verdict = again(&scene, &[]);
    assert!(
        verdict.is_same(),
        "{:#?} {:#?}",
        verdict.comparison.first,
        verdict.values
    );
    assert_eq!(
        verdict.comparison.same,
        scene.decisions(),
        "every selection is compared"
    );
    assert_eq!((verdict.lost_steps, verdict.missed), (0, Vec::new()));
    let verdict = again(&scene, &["stop.ahead=1.5"]);
    assert!(!verdict.is_same());
}

#[test]
fn r14_what_operators_did_is_done_again() {
    fn schema(handle: &Handle, name: &str) -> usize {
        handle.application().instance(name).unwrap()
    }
    fn ana(handle: &Handle) -> OperatorHandle {
        handle.operator("ana")
    }
    let scene = Scene::operated(
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
    let verdict = again(&scene, &[]);
    assert!(
        verdict.is_same(),
        "{:#?} {:#?}",
        verdict.comparison.first,
        verdict.values
    );
    assert_eq!(
        verdict.comparison.same,
        scene.decisions(),
        "every selection is compared"
    );
    assert_eq!((verdict.missed, verdict.unknown), (Vec::new(), Vec::new()));
}

#[test]
fn r14_a_drive_in_which_a_build_took_over_says_so() {
    let scene = Scene::operated(
        "reloaded.mcap",
        20 * SECOND,
        &[(6 * SECOND, |handle| {
            let vff = handle.application().instance("vff").unwrap();
            let again = drives::built().load("vff", &[]).unwrap();
            handle
                .operator("ana")
                .replace(vff, &again, ReloadOptions::default())
                .unwrap_or_else(|reasons| panic!("{reasons:?}"));
        })],
    );
    let told = scene.told("reloaded");
    assert_eq!(told.len(), 1, "{told:?}");
    assert!(told[0].contains("of memory carried over (version 1)"), "{told:?}");
    let verdict = again(&scene, &[]);
    assert_eq!(verdict.reloads, [("vff".to_owned(), 6 * SECOND)]);
    assert!(
        verdict.is_same(),
        "{:#?} {:#?}",
        verdict.comparison.first,
        verdict.values
    );
    assert_eq!(verdict.comparison.same, scene.decisions());
    assert_eq!((verdict.lost_steps, verdict.missed), (0, Vec::new()));
}

#[test]
fn another_application_is_told_apart_before_it_is_replayed() {
    let scene = Scene::lockstep("other.mcap", 5 * SECOND, &[]);
    let drive = Drive::open(scene.file()).unwrap();
    assert_eq!(drive.differences(&scene.application(&[])), [""; 0]);
    let changed = scene.application(&["stop.ahead=0.9", "goon.period=100 ms"]);
    let differences = drive.differences(&changed);
    assert!(
        differences
            .iter()
            .any(|words| words.starts_with("stop.ahead starts with 0.9")),
        "{differences:?}"
    );
    assert!(
        differences
            .iter()
            .any(|words| words.starts_with("goon.period starts with 0.1 s")),
        "{differences:?}"
    );
    // With the recorded values it is equal again.
    let mut restored = scene.application(&["stop.ahead=0.9", "goon.period=100 ms"]);
    drive.restore(&mut restored, |_| false);
    assert_eq!(drive.differences(&restored), [""; 0]);
    let attached = drive.application().unwrap();
    assert_eq!(attached.name, "safe-navigation.toml");
    assert!(attached.text.contains("safe-navigation"));
}

#[test]
fn a_drive_that_was_cut_off_is_taken_again_up_to_there() {
    let scene = Scene::lockstep("cut.mcap", 20 * SECOND, &[]);
    let bytes = std::fs::read(scene.file()).unwrap();
    std::fs::write(scene.file(), &bytes[..bytes.len() / 2]).unwrap();
    let verdict = again(&scene, &[]);
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
    let scene = Scene::lockstep("partial.mcap", SECOND, &["*.mission", "pioneer.odometry"]);
    let drive = Drive::open(scene.file()).unwrap();
    let lacks = replay_and_compare(
        &drive,
        scene.application(&[]),
        scene.plugins(),
        Span::default(),
        &Tolerance::default(),
        |_| true,
    );
    let Err(ReplayError::Incomplete { what, .. }) = lacks else {
        panic!("{lacks:?}");
    };
    assert!(what.starts_with("`pioneer.laser` is not in it"), "{what}");
}

#[test]
fn r14_what_people_did_to_panels_is_done_again() {
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
    let scene = Scene::operated(
        "touched.mcap",
        30 * SECOND,
        &[
            // Numbers that no short decimal fraction represents exactly.
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
    let verdict = again(&scene, &[]);
    assert!(
        verdict.is_same(),
        "{:#?} {:#?}",
        verdict.comparison.first,
        verdict.values
    );
    assert_eq!(
        verdict.comparison.same,
        scene.decisions(),
        "every selection is compared"
    );
    assert_eq!((verdict.missed, verdict.unknown), (Vec::new(), Vec::new()));
    let told = scene.told("operator");
    assert_eq!(
        told,
        [
            "ana clicked `field` of example at (0.30, 1.41)",
            "ana pressed `clear` of example",
            "ana clicked `field` of example at (5.00, 7.10)",
        ]
    );
    assert_eq!(scene.told("drag").len(), 1, "where a drag that goes on is told");
}
