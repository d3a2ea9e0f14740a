//! A custom value that two plugins share: `ball`, in Rust, publishes it, and `near`, in C, reads it. Both take
//! its definition from `robotics/ball`. If one plugin was built with another definition, the error names the
//! field.

use std::fs;
use std::path::Path;
use std::process::Command;

use jde_core::State;
use jde_host::{Lockstep, Options};
use jde_loader::Plugins;

use crate::delivered::{self, ROOT, SECOND};

/// A world with a ball in front of a robot that faces it.
const WORLD: &str = r#"
walls = [{ name = "room", points = [[0, 0], [6, 0], [6, 5], [0, 5]], closed = true }]
balls = [{ name = "ball", center = [3.2, 2.5], radius = 0.11, color = "orange" }]
robots = { pioneer = { start = { x = 2, y = 2.5, heading_deg = 0 } } }
"#;

const APP: &str = r#"
roots   = ["near"]
plugins = ["."]

[schemas.pioneer]
type  = "sim/robot"
world = "world.toml"

[schemas.camera]
type  = "sim/camera"
world = "world.toml"
robot = "pioneer"

[schemas.finder]
type    = "ball/finder"
imports = { image = "camera.image", pan_tilt = "pioneer.pan_tilt" }

[schemas.near]
type    = "near"
reach   = 2.0
imports = { ball = "finder.ball" }
"#;

/// Returns a folder with the application and the plugin `near`, built after `change` of its header and source.
fn build(change: impl Fn(String) -> String) -> (tempfile::TempDir, Plugins) {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, text) in [("app.toml", APP), ("world.toml", WORLD)] {
        fs::write(folder.path().join(name), text).expect("it is written");
    }
    let sources = Path::new(ROOT).join("robotics/ball/c");
    for name in ["ball.h", "near.c"] {
        let text = fs::read_to_string(sources.join(name)).expect("the source exists");
        fs::write(folder.path().join(name), change(text)).expect("it is written");
    }
    let output = Command::new("cc")
        .args([
            "-shared", "-fPIC", "-std=c11", "-Wall", "-Wextra", "-Werror", "-I",
        ])
        .arg(Path::new(ROOT).join("include"))
        .arg("-o")
        .args([folder.path().join("libnear.so"), folder.path().join("near.c")])
        .output()
        .expect("a C compiler named cc is installed");
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    (folder, delivered::plugins())
}

#[test]
fn the_type_of_the_value_is_the_same_in_rust_and_in_c() {
    let (folder, plugins) = build(|text| text);
    let port = |plugin: &str, schema: &str| {
        let plugin = plugins
            .load(plugin, &[folder.path().to_owned()])
            .expect("it was built");
        let schemas = &plugin.description.schemas;
        let schema = schemas
            .iter()
            .find(|known| known.name == schema)
            .expect("the schema exists");
        let port = schema
            .ports
            .iter()
            .find(|port| port.name == "ball")
            .expect("the port exists");
        port.value_type.clone()
    };
    let (rust, c) = (port("ball", "finder"), port("near", "near"));
    assert_eq!(rust.difference(&c), None);
    assert!(rust.same_as(&c));
}

#[test]
fn the_c_plugin_reads_what_the_rust_plugin_publishes() {
    let (folder, plugins) = build(|text| text);
    let application = jde_app::load(&folder.path().join("app.toml"), &[], &plugins)
        .unwrap_or_else(|faults| panic!("{faults}"));
    let mut running = Lockstep::start(application, &plugins, Options::default()).expect("it starts");
    running.run_until(2 * SECOND);
    let snapshot = running.handle().snapshot();
    let near = snapshot.schemas.iter().find(|schema| schema.name == "near");
    assert_eq!(
        near.map(|near| near.state),
        Some(State::Winner),
        "the ball is 1.2 m away"
    );
}

#[test]
fn a_plugin_of_another_definition_is_refused_with_the_field_that_differs() {
    let earlier = |text: String| {
        let text = text.replace("double distance;", "float distance;\n    float nothing;");
        text.replace(
            "distance), 0u, JDE_F64, JDE_ONE, 1u,",
            "distance), 0u, JDE_F32, JDE_ONE, 1u,",
        )
        .replace(
            "    JDE_FIELD(\"column\"",
            "    JDE_FIELD(\"_\", offsetof(ball, nothing), 0u, JDE_U8, JDE_PADDING, 4u, \"\", \"\", NULL),\n    JDE_FIELD(\"column\"",
        )
    };
    let (folder, plugins) = build(earlier);
    let faults = jde_app::load(&folder.path().join("app.toml"), &[], &plugins).expect_err("they differ");
    let message = faults.to_string();
    for expected in [
        "app.toml:21:20: ",
        "`finder.ball` is `jde_msgs/msg/Ball` too, but of another layout: field `distance` is float32 here and float64 there",
        "build both plugins with the same definition of the type, from a crate or a header that both use",
    ] {
        assert!(message.contains(expected), "`{expected}` is not in: {message}");
    }
}
