//! Panels of schemas without a window: they are printed as text, operated, recorded and played.

use serde_json::Value;

use crate::attached::{Sandbox, navigation};
use crate::support::{jde_with_plugins, output_of};

/// Returns the topics of the panels in a recording.
fn topics(sandbox: &Sandbox, file: &str) -> Vec<String> {
    let info = sandbox.json(&["info", file]);
    let topics = info["topics"].as_array().expect("topics").iter();
    let panels = topics.filter(|topic| topic["type"] == "jde_msgs/msg/Panel");
    panels
        .inspect(|topic| assert!(topic["messages"].as_u64() > Some(0), "{topic}"))
        .map(|topic| topic["topic"].as_str().expect("a topic").to_owned())
        .collect()
}

/// Returns whether an item of the panel's list contains a text.
fn has_text(panel: &Value, part: &str) -> bool {
    let items = panel["list"]["items"].as_array();
    items.is_some_and(|items| {
        let texts = items.iter().filter_map(|item| item["text"]["text"].as_str());
        texts.into_iter().any(|text| text.contains(part))
    })
}

#[test]
fn r14_a_panel_is_printed_as_text_and_its_widgets_are_operated() {
    let sandbox = Sandbox::new();
    let _robot = navigation(&sandbox);
    let list = sandbox.run_ok(&["panel"]);
    assert!(list.contains("example") && list.contains("goon"), "{list}");
    let shown = sandbox.run_ok(&["panel", "example"]);
    for part in [
        "Safe navigation",
        "[ Clear target ]  clear",
        "plane with",
        "field",
        "cruise",
    ] {
        assert!(shown.contains(part), "{part} in {shown}");
    }
    sandbox.until(&["panel", "example"], |panel| has_text(panel, "To target 1"));
    sandbox.run_ok(&["panel", "example", "--click", "field", "-4.5", "2.0"]);
    sandbox.until(&["panel", "example"], |panel| {
        has_text(panel, "To the target of ana@")
    });
    let events = sandbox.run_ok(&["events", "--once", "--last", "100"]);
    assert!(events.contains("ana@") && events.contains("field"), "{events}");
    sandbox.run_ok(&["panel", "example", "--touch", "clear"]);
    sandbox.until(&["panel", "example"], |panel| has_text(panel, "To target 1"));
    for (args, part) in [
        (&["panel", "exampel"][..], "did you mean `example`?"),
        (&["panel", "pioneer"], "has no panel of its own"),
        (&["panel", "example", "--touch", "claer"], "did you mean `clear`?"),
        (&["panel", "example", "--touch", "clear"], "cannot be pressed now"),
        (&["panel", "example", "--touch", "field"], "--click field X Y"),
        (
            &["panel", "example", "--click", "field", "1", "north"],
            "`north` is not a number",
        ),
    ] {
        let output = sandbox.run(args);
        assert_eq!(output.status, Some(2), "{args:?}: {output:?}");
        assert!(output.err.contains(part), "{args:?}: {output:?}");
    }
}

#[test]
fn panels_are_recorded_on_request_and_shown_at_playback() {
    let sandbox = Sandbox::new();
    let file = sandbox.folder().join("drive.mcap");
    let file = file.to_str().unwrap();
    let mut run = sandbox.command(jde_with_plugins(&[
        "run",
        "safe-navigation",
        "--plain",
        "--record",
        file,
    ]));
    let run = output_of(run.args(["--panels=example,go*", "--panel-rate", "10", "--for", "2s"]));
    assert!(
        run.err.contains("recorded") || run.out.contains("recorded"),
        "{run:?}"
    );
    assert_eq!(topics(&sandbox, file), ["/panels/example", "/panels/goon"]);
    let playing = sandbox.replay(file.as_ref(), &["--loop"]);
    sandbox.until(&["panel", "example"], |panel| has_text(panel, "To target 1"));
    let click = sandbox.run(&["panel", "example", "--click", "field", "1", "1"]);
    // The message depends on the position: no panel is recorded at the beginning of the loop.
    if click.status == Some(2) {
        assert!(click.err.contains("this is a recording"), "{click:?}");
    } else {
        assert!(click.err.contains("nothing of it was recorded"), "{click:?}");
    }
    let none = sandbox.run(&["panel", "vff"]);
    assert!(
        none.status == Some(2) && none.err.contains("no panel"),
        "{none:?}"
    );
    drop(playing);

    let _robot = navigation(&sandbox);
    let outside = sandbox.folder().join("outside.mcap");
    let outside = outside.to_str().unwrap();
    sandbox.run_ok(&["record", outside, "goon.*", "--panels", "--for", "1s"]);
    let recorded = topics(&sandbox, outside);
    assert!(recorded.contains(&"/panels/vff".to_owned()), "{recorded:?}");
}

#[test]
fn an_unknown_panel_neither_creates_nor_overwrites_a_recording() {
    let sandbox = Sandbox::new();
    let _robot = navigation(&sandbox);
    let [new, old] = ["x.mcap", "old.mcap"].map(|name| sandbox.folder().join(name));
    std::fs::write(&old, "an old recording").unwrap();
    let [new, old] = [&new, &old].map(|file| file.to_str().unwrap());
    let run = ["run", "safe-navigation", "--for", "1s", "--record"];
    for verb in [&["record"][..], &run] {
        for file in [&[new][..], &[old, "--overwrite"]] {
            let mut command = sandbox.command(jde_with_plugins(verb));
            let wrong = output_of(command.args(file).arg("--panels=exampel"));
            assert_eq!(wrong.status, Some(2), "{wrong:?}");
            assert!(wrong.err.contains("did you mean `example`?"), "{wrong:?}");
        }
    }
    assert!(!std::fs::exists(new).unwrap());
    assert_eq!(std::fs::read(old).unwrap(), b"an old recording");
}
