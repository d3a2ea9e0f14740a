//! Drives of the example of the paper, recorded and taken again with its own plugins: what is as it was, and what is not.

mod drives;

use jde_log::replay::{Drive, ReplayError, Span, Verdict, decide};

use drives::{Scene, SECOND};

fn again(scene: &Scene, sets: &[&str]) -> Verdict {
    let drive = Drive::open(scene.file()).unwrap();
    let application = scene.application(sets);
    decide(&drive, application, scene.plugins(), Span::default(), |_| true).unwrap()
}

#[test]
fn r16_a_drive_in_lockstep_is_decided_again_as_it_was() {
    let scene = Scene::lockstep("lockstep.mcap", 20 * SECOND, &[]);
    let verdict = again(&scene, &[]);
    assert!(verdict.is_same(), "{:#?}", verdict.comparison.first);
    assert_eq!(verdict.comparison.same, scene.decisions(), "every selection is compared");
    assert_eq!((verdict.lost_steps, verdict.missed), (0, Vec::new()));
}

#[test]
fn a_changed_constant_is_found_in_a_drive_in_lockstep() {
    let scene = Scene::lockstep("constant.mcap", 20 * SECOND, &[]);
    let verdict = again(&scene, &["stop.ahead=1.5"]);
    assert!(!verdict.is_same());
    let first = &verdict.comparison.first[0];
    assert_eq!(first.group, "example/base");
    assert!(first.saw.iter().any(|(name, saw)| name == "stop" && !saw.is_empty()), "{first:#?}");
}

#[test]
fn r16_a_drive_in_real_time_is_decided_again_as_it_was() {
    let scene = Scene::real_time("real.mcap", 30 * SECOND, 5.0, &[]);
    let verdict = again(&scene, &[]);
    assert!(verdict.is_same(), "{:#?}", verdict.comparison.first);
    assert_eq!(verdict.comparison.same, scene.decisions(), "every selection is compared");
    assert_eq!((verdict.lost_steps, verdict.missed), (0, Vec::new()));
    let verdict = again(&scene, &["stop.ahead=1.5"]);
    assert!(!verdict.is_same());
}

#[test]
fn a_recording_without_what_schemas_import_is_refused() {
    let scene = Scene::lockstep("partial.mcap", SECOND, &["*.mission", "pioneer.odometry"]);
    let drive = Drive::open(scene.file()).unwrap();
    let lacks = decide(&drive, scene.application(&[]), scene.plugins(), Span::default(), |_| true);
    let Err(ReplayError::Lacks { what, .. }) = lacks else {
        panic!("{lacks:?}");
    };
    assert!(what.starts_with("`pioneer.laser` is not in it"), "{what}");
}
