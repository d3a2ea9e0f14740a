//! Panels of schemas without a window: printed as text, operated, recorded and played.

use serde_json::Value;

use crate::attached::{Place, navigation};
use crate::support::{jde_with_plugins, said};

fn topics(place: &Place, file: &str) -> Vec<String> {
    let info = place.json(&["info", file]);
    let topics = info["topics"].as_array().expect("topics").iter();
    let panels = topics.filter(|topic| topic["encoding"] == "cbor");
    panels
        .inspect(|topic| assert!(topic["messages"].as_u64() > Some(0), "{topic}"))
        .map(|topic| topic["topic"].as_str().expect("a topic").to_owned())
        .collect()
}

/// Whether a list contains this text.
fn says(panel: &Value, words: &str) -> bool {
    let items = panel["list"]["items"].as_array();
    items.is_some_and(|items| {
        let texts = items.iter().filter_map(|item| item["text"]["text"].as_str());
        texts.into_iter().any(|text| text.contains(words))
    })
}

#[test]
fn r14_a_panel_is_shown_in_words_and_touched_by_somebody() {
    let place = Place::new();
    let _robot = navigation(&place);
    let list = place.told(&["panel"]);
    assert!(list.contains("example") && list.contains("goon"), "{list}");
    let shown = place.told(&["panel", "example"]);
    for part in [
        "Safe navigation",
        "[ Clear target ]  clear",
        "plane with",
        "field",
        "cruise",
    ] {
        assert!(shown.contains(part), "{part} in {shown}");
    }
    place.until(&["panel", "example"], |panel| says(panel, "To target 1"));
    place.told(&["panel", "example", "--click", "field", "-4.5", "2.0"]);
    place.until(&["panel", "example"], |panel| {
        says(panel, "To the target of ana@")
    });
    let events = place.told(&["events", "--once", "--last", "100"]);
    assert!(events.contains("ana@") && events.contains("field"), "{events}");
    place.told(&["panel", "example", "--touch", "clear"]);
    place.until(&["panel", "example"], |panel| says(panel, "To target 1"));
    for (args, part) in [
        (&["panel", "exampel"][..], "did you mean `example`?"),
        (&["panel", "pioneer"], "has no panel of its own"),
        (&["panel", "example", "--touch", "claer"], "did you mean `clear`?"),
        (&["panel", "example", "--touch", "clear"], "cannot be pressed now"),
        (&["panel", "example", "--touch", "field"], "--click field X Y"),
        (
            &["panel", "example", "--click", "field", "1", "north"],
            "`north` is no number",
        ),
    ] {
        let said = place.says(args);
        assert_eq!(said.status, Some(2), "{args:?}: {said:?}");
        assert!(said.err.contains(part), "{args:?}: {said:?}");
    }
}

#[test]
fn panels_are_recorded_on_request_and_shown_again_at_their_time() {
    let place = Place::new();
    let file = place.folder().join("drive.mcap");
    let file = file.to_str().unwrap();
    let mut run = place.command(jde_with_plugins(&[
        "run",
        "safe-navigation",
        "--plain",
        "--record",
        file,
    ]));
    let ran = said(run.args(["--panels=example,go*", "--panel-rate", "10", "--for", "2s"]));
    assert!(
        ran.err.contains("recorded") || ran.out.contains("recorded"),
        "{ran:?}"
    );
    assert_eq!(topics(&place, file), ["/panels/example", "/panels/goon"]);
    let playing = place.replay(file.as_ref(), &["--loop"]);
    place.until(&["panel", "example"], |panel| says(panel, "To target 1"));
    let touched = place.says(&["panel", "example", "--click", "field", "1", "1"]);
    // At the beginning of the loop no drawing of the panel has been recorded yet.
    if touched.status == Some(2) {
        assert!(touched.err.contains("this is a recording"), "{touched:?}");
    } else {
        assert!(touched.err.contains("nothing of it was recorded"), "{touched:?}");
    }
    let none = place.says(&["panel", "vff"]);
    assert!(
        none.status == Some(2) && none.err.contains("no panel"),
        "{none:?}"
    );
    drop(playing);

    let _robot = navigation(&place);
    let outside = place.folder().join("outside.mcap");
    let outside = outside.to_str().unwrap();
    place.told(&["record", outside, "goon.*", "--panels", "--for", "1s"]);
    let recorded = topics(&place, outside);
    assert!(recorded.contains(&"/panels/vff".to_owned()), "{recorded:?}");
}

#[test]
fn a_slip_in_a_panels_name_makes_no_recording_and_costs_none() {
    let place = Place::new();
    let _robot = navigation(&place);
    let [new, old] = ["x.mcap", "old.mcap"].map(|name| place.folder().join(name));
    std::fs::write(&old, "a drive of long ago").unwrap();
    let [new, old] = [&new, &old].map(|file| file.to_str().unwrap());
    let run = ["run", "safe-navigation", "--for", "1s", "--record"];
    for verb in [&["record"][..], &run] {
        for file in [&[new][..], &[old, "--overwrite"]] {
            let mut command = place.command(jde_with_plugins(verb));
            let wrong = said(command.args(file).arg("--panels=exampel"));
            assert_eq!(wrong.status, Some(2), "{wrong:?}");
            assert!(wrong.err.contains("did you mean `example`?"), "{wrong:?}");
        }
    }
    assert!(!std::fs::exists(new).unwrap());
    assert_eq!(std::fs::read(old).unwrap(), b"a drive of long ago");
}
