//! Lists of ports: their entries, types and settings, and the faults of these.

use std::path::Path;

use jde_abi::describe::Role;
use jde_abi::raw;

use jde_app::{Application, Binding, ImportSource, InstancePort};

use super::catalogue::{check_text, read};

/// A robot, a schema with these entries in its lists, and a reader of its export `there`.
fn text(entries: &str) -> String {
    format!(
        r#"name = "lists"
roots = ["stop"]

[schemas.pioneer]
type = "sim/robot"

[schemas.topics]
type = "topics"
{entries}

[schemas.stop]
type      = "stop"
imports   = {{ laser = "topics.there" }}
actuators = {{ base = "pioneer.velocity" }}
"#
    )
}

fn application(entries: &str) -> Application {
    read(&text(entries), &[]).unwrap_or_else(|faults| panic!("{faults}"))
}

#[track_caller]
fn check(entries: &str, expected: &str) {
    check_text(&text(entries), &[], expected);
}

#[test]
fn imports_have_the_type_of_what_they_read_and_exports_that_of_their_reader() {
    let application = application(
        r#"publish."/a/scan" = "pioneer.laser"
publish."/b" = { from = "topics.seen", theta = "90 deg" }
subscribe."/there" = "there"
subscribe."/seen" = { as = "seen", type = "nav_msgs/msg/Odometry", x = 2 }"#,
    );
    let topics = &application.instances[application.instance("topics").unwrap()];
    let own = topics.schema.ports.len() - 4;
    let found: Vec<_> = topics
        .listed
        .iter()
        .zip(&topics.schema.ports[own..])
        .map(|(listed, port)| (listed.list, &*listed.label, &*port.name, &*port.value_type.name))
        .collect();
    let triggers: Vec<_> = topics.bindings[own + 2..]
        .iter()
        .map(|binding| matches!(binding, Binding::Import { trigger: true, .. }))
        .collect();
    assert_eq!(
        triggers,
        [true, false],
        "a driver passes on what others export, at once"
    );
    assert_eq!(
        found,
        [
            (1, "/there", "there", "sensor_msgs/msg/LaserScan"),
            (1, "/seen", "seen", "nav_msgs/msg/Odometry"),
            (0, "/a/scan", "/a/scan", "sensor_msgs/msg/LaserScan"),
            (0, "/b", "/b", "nav_msgs/msg/Odometry"),
        ]
    );
    let settings = |place: usize| -> [f64; 3] {
        let bytes = topics.listed[place].settings.as_chunks::<8>().0;
        [0, 1, 2].map(|field| f64::from_ne_bytes(bytes[field]))
    };
    assert_eq!(settings(1), [2.0, 0.0, 0.0]);
    assert_eq!(settings(0), [0.0; 3]);
    assert_eq!(settings(3), [0.0, 0.0, std::f64::consts::FRAC_PI_2]);
    let instance = application.instance("topics").unwrap();
    let listed = |port| InstancePort { instance, port };
    assert_eq!(
        topics.bindings[own + 3],
        Binding::Import {
            source: Some(ImportSource::Local(listed(own + 1))),
            trigger: false,
            stale_ns: None,
        }
    );
    let stop = &application.instances[application.instance("stop").unwrap()];
    let source = ImportSource::Local(listed(own));
    assert!(stop.bindings.contains(&Binding::Import {
        source: Some(source),
        trigger: true,
        stale_ns: None,
    }));
}

#[test]
fn two_lists_may_have_an_import_of_one_key() {
    let application = application(
        r#"subscribe."/there" = "there"
publish."/a" = "pioneer.laser"
repeat."/a" = "pioneer.odometry"
"#,
    );
    let topics = &application.instances[application.instance("topics").unwrap()];
    let own = topics.schema.ports.len() - 3;
    let names: Vec<_> = topics.schema.ports[own..]
        .iter()
        .map(|port| &*port.name)
        .collect();
    assert_eq!(names, ["there", "/a", "repeat./a"]);
    check(
        r#"subscribe."/there" = "there"
publish = { "/a" = "pioneer.laser", "repeat./a" = "pioneer.laser" }
repeat = { "/a" = "pioneer.odometry" }"#,
        r#"
apps/good.toml:11:12: `/a` in `repeat` of schema `topics`: schema `topics` has an import `repeat./a` already
    help: give it another name
"#,
    );
}

#[test]
fn an_export_without_a_reader_needs_a_type() {
    check(
        r#"subscribe = { "/there" = "there", "/map" = "map" }"#,
        r#"
apps/good.toml:9:44: `/map` in `subscribe` of schema `topics`: no schema imports `topics.map`, so its type is not known
    help: state it, as in type = "sensor_msgs/msg/LaserScan", or bind an import to it
"#,
    );
    check(
        r#"subscribe = { "/there" = "there", "/map" = { as = "map", type = "nav_msgs/msg/OccupancyGird" } }"#,
        r#"
apps/good.toml:9:65: `/map` in `subscribe` of schema `topics`: nothing defines the type `nav_msgs/msg/OccupancyGird`
    help: did you mean `nav_msgs/msg/OccupancyGrid`?
"#,
    );
    check(
        r#"subscribe = { "/there" = { as = "there", type = "nav_msgs/msg/Odometry" } }"#,
        r#"
apps/good.toml:13:23: `laser` in `imports` of schema `stop` is `sensor_msgs/msg/LaserScan`, and `topics.there` is `nav_msgs/msg/Odometry`
    help: these fit: `pioneer.laser`
"#,
    );
}

#[test]
fn wrong_entries_are_refused_with_their_lines() {
    check(
        r#"subscribe = { "/there" = "there", "/b" = "there" }"#,
        r#"
apps/good.toml:9:42: `/b` in `subscribe` of schema `topics`: schema `topics` has a variable `there` already
    help: give it another name
"#,
    );
    check(
        r#"subscribe = { "/there" = { x = 1 } }"#,
        r#"
apps/good.toml:9:15: `/there` in `subscribe` of schema `topics` has no `as`
    help: name it, as in as = "map"
apps/good.toml:13:23: `laser` in `imports` of schema `stop`: `topics` has no `there`
    help: exports and modulations of `topics`: `connection`
"#,
    );
    check(
        r#"subscribe = { "/there" = "there" }
publish = { "/a" = "pioneer.lasr", "/b" = { x = 1 }, "/c" = 7, laser = "pioneer.laser" }"#,
        r#"
apps/good.toml:10:20: `/a` in `publish` of schema `topics`: `pioneer` has no `lasr`
    help: did you mean `laser`?
apps/good.toml:10:36: `/b` in `publish` of schema `topics` has no `from`
    help: name the variable, as in from = "pioneer.laser"
apps/good.toml:10:61: `/c` in `publish` of schema `topics` must be a text, or a table such as { from = "SCHEMA.VARIABLE" }, not a whole number
apps/good.toml:10:64: `laser` in `publish` of schema `topics`: schema `topics` has an import `laser` already
    help: give it another name
"#,
    );
    check(
        r#"subscribe = { "/there" = "there" }
publish = { "/a" = { from = "pioneer.laser", y = "1 s", z = 2 }, "/b" = "robot2:pioneer.laser" }"#,
        r#"
apps/good.toml:10:50: `/a.y` of `publish` of schema `topics` must be a number in m, and `s` does not convert to that
apps/good.toml:10:57: `/a` of `publish` of schema `topics` has no field `z`
    help: fields: `x`, `y` and `theta`
apps/good.toml:10:73: `/b` in `publish` of schema `topics` is `robot2:pioneer.laser`, and a list takes variables of this application
"#,
    );
    check(
        r#"subscribe = { "/there" = "there", "/b" = { as = "period", type = "geometry_msgs/msg/Twist" } }"#,
        r#"
apps/good.toml:9:49: `/b` in `subscribe` of schema `topics`: schema `topics` has a variable `period` already
    help: give it another name
"#,
    );
    check(
        r#"subscribe = { "/there" = { as = "there", from = "pioneer.laser" } }
publish = { "/a" = { from = "pioneer.laser", type = "nav_msgs/msg/Odometry" } }"#,
        r#"
apps/good.toml:9:42: `/there` of `subscribe` of schema `topics` has no field `from`
    help: fields: `x`, `y` and `theta`
apps/good.toml:10:46: `/a` of `publish` of schema `topics` has no field `type`
    help: fields: `x`, `y` and `theta`
apps/good.toml:14:23: `laser` in `imports` of schema `stop`: `topics` has no `there`
    help: exports and modulations of `topics`: `connection`
"#,
    );
    check(
        r#"subscribe = "there""#,
        r#"
apps/good.toml:9:13: `subscribe` of schema `topics` must be a table, not a text
apps/good.toml:13:23: `laser` in `imports` of schema `stop`: `topics` has no `there`
    help: exports and modulations of `topics`: `connection`
"#,
    );
    check(
        r#"subscribe = { "/there" = "there" }
published = {}"#,
        r#"
apps/good.toml:10:1: unknown key `published` in schema `topics`
    help: did you mean `publish`?
"#,
    );
}

#[test]
fn a_type_without_a_reader_is_that_of_its_file_with_the_stated_capacities() {
    let folder = tempfile::tempdir().unwrap();
    let messages = folder.path().join("my_msgs/msg");
    std::fs::create_dir_all(&messages).unwrap();
    for (name, text) in [
        (
            "Cloud",
            "std_msgs/Header header\nPoint[] points\nfloat32[] weights\nstring name\n",
        ),
        ("Point", "float64 x\nfloat64 y\n"),
        ("Wide", "wstring name\n"),
        ("Nested", "float64 pressure # tyre [bar]\nWide[] wides\n"),
        ("Lost", "Nothing what\n"),
    ] {
        std::fs::write(messages.join(format!("{name}.msg")), text).unwrap();
    }
    // A comment in Latin-1, and one whose unit is none of jde.
    let tyre = b"float64 heat # [\xb0C]\nfloat64 pressure # [bar]\nfloat64 speed # [m/s]\n";
    std::fs::write(messages.join("Tyre.msg"), tyre).unwrap();
    std::fs::write(messages.join("Modern.idl"), "module my_msgs {};").unwrap();
    std::fs::create_dir_all(folder.path().join("my_msgs/srv")).unwrap();
    std::fs::write(folder.path().join("my_msgs/srv/Half.srv"), "int8 x\n").unwrap();
    let text = |name: &str, capacity: &str| {
        let entry = format!(
            "subscribe = {{ \"/there\" = \"there\", \"/c\" = {{ as = \"c\", type = \"my_msgs/msg/{name}\"{capacity} }} }}"
        );
        format!(
            "interfaces = [{:?}]\n{}",
            folder.path().display().to_string(),
            text(&entry)
        )
    };
    let application = read(&text("Cloud", ", capacity = { points = 100, name = 20 }"), &[]).unwrap();
    let topics = &application.instances[application.instance("topics").unwrap()];
    let cloud = &topics.listed[1].value_type;
    let fields: Vec<_> = cloud
        .fields
        .iter()
        .map(|field| (&*field.name, field.form.capacity()))
        .collect();
    assert_eq!(
        fields,
        [("header", 1), ("points", 100), ("weights", 256), ("name", 20)]
    );
    let of = |name: &str, capacity: &str| read(&text(name, capacity), &[]).unwrap_err().to_string();
    let tyre = read(&text("Tyre", ""), &[]).unwrap();
    let tyre = &tyre.instances[tyre.instance("topics").unwrap()].listed[1].value_type;
    let units: Vec<_> = tyre.fields.iter().map(|field| &*field.unit).collect();
    assert_eq!(units, ["", "", "m/s"]);
    assert!(of("Wide", "").contains("`my_msgs/msg/Wide` cannot be used: line 1"));
    assert!(of("Nested", "").contains("cannot be used: `my_msgs/Wide`: line 1: a field of `wstring`"));
    let lost = of("Lost", "");
    assert!(
        lost.contains("`my_msgs/msg/Nothing` is not defined, and `my_msgs/msg/Lost` contains it"),
        "{lost}"
    );
    let idl = of("Modern", "");
    assert!(idl.contains("Modern.idl is in IDL, which is not read"), "{idl}");
    let half = text("Cloud", "").replace("my_msgs/msg/Cloud", "my_msgs/srv/Half_Request");
    let half = read(&half, &[]).unwrap_err().to_string();
    assert!(
        half.contains("Half.srv has 0 lines `---`, and 1 are between its parts: Request, Response"),
        "{half}"
    );
    assert!(of("Cloud", ", capacity = 0").contains("must be 1 to 67108864, not 0"));
    let other = of("Cloud", ", capacity = { pionts = 9 }");
    assert!(
        other.contains("`capacity` states `pionts`, and the fields without a bound are"),
        "{other}"
    );
    let unknown = of("Other", "");
    assert!(unknown.contains("nothing defines the type `my_msgs/msg/Other`"));
    assert!(
        unknown.contains("interfaces = [\"msgs\"], or source ROS 2"),
        "{unknown}"
    );
    let elsewhere = text("Cloud", "").replacen("interfaces = [", "interfaces = [\"nowhere\", ", 1);
    let missing = read(&elsewhere, &[]).unwrap_err().to_string();
    assert!(missing.contains("there is no folder `nowhere`"), "{missing}");
}

#[test]
fn a_capacity_of_a_type_that_no_file_defines_is_refused() {
    check(
        r#"subscribe = { "/there" = { as = "there", capacity = 9 }, "/c" = { as = "c", type = "nav_msgs/msg/Path", capacity = { poses = 9 } } }"#,
        r#"
apps/good.toml:9:33: `/there` in `subscribe` of schema `topics`: `capacity` is of a type that a file defines, and this is that of the port that is bound to it, which has its own
apps/good.toml:9:84: `/c` in `subscribe` of schema `topics`: the type `nav_msgs/msg/Path` cannot be used: `capacity` is of a type that a file defines, and this is that of a standard interface, which has its own
"#,
    );
}

#[test]
fn r12_a_cycle_of_drivers_is_refused_at_the_entry_of_a_list() {
    check(
        r#"subscribe = { "/there" = "there", "/a" = { as = "seen", type = "nav_msgs/msg/Odometry" } }
publish = { "/b" = "other.seen" }

[schemas.other]
type      = "topics"
subscribe = { "/b" = { as = "seen", type = "nav_msgs/msg/Odometry" } }
publish   = { "/c" = "topics.seen" }"#,
        r#"
apps/good.toml:15:22: these schemas would keep each other awake for ever: topics -> other -> topics
    help: break the cycle: let one of them read another variable, or none; of a driver, a second one can take what they export
"#,
    );
}

#[test]
fn a_type_is_that_of_a_recording_which_the_application_names() {
    let folder = tempfile::tempdir().unwrap();
    let bag = folder.path().join("drive.mcap");
    let text = |recording: &Path| {
        let entry = r#"subscribe = { "/there" = "there", "/c" = { as = "c", type = "my_msgs/msg/Cloud", capacity = { points = 9 } } }"#;
        format!(
            "interfaces = [{:?}]\n{}",
            recording.display().to_string(),
            text(entry)
        )
    };
    let options = mcap::WriteOptions::new().compression(None);
    let mut writer = options.create(std::fs::File::create(&bag).unwrap()).unwrap();
    let definition = "std_msgs/Header header\nPoint[] points\n====\nMSG: my_msgs/Point\nfloat64 x\n====\nMSG: std_msgs/Header\n\
        builtin_interfaces/Time stamp\nstring frame_id\n";
    let schema = writer.add_schema("my_msgs/msg/Cloud", "ros2msg", definition.as_bytes());
    writer
        .add_channel(schema.unwrap(), "/cloud", "cdr", &Default::default())
        .unwrap();
    let refused = read(&text(&bag), &[]).unwrap_err().to_string();
    assert!(
        refused.contains("the definitions in ") && refused.contains("cannot be read: "),
        "{refused}"
    );
    writer.finish().unwrap();
    let application = read(&text(&bag), &[]).unwrap_or_else(|faults| panic!("{faults}"));
    let topics = &application.instances[application.instance("topics").unwrap()];
    let fields: Vec<_> = topics.listed[1]
        .value_type
        .fields
        .iter()
        .map(|field| (&*field.name, field.form.capacity()))
        .collect();
    assert_eq!(fields, [("header", 1), ("points", 9)]);
    let missing = read(&text(&folder.path().join("none.mcap")), &[])
        .unwrap_err()
        .to_string();
    assert!(
        missing.contains("apps/good.toml:1:15: the definitions in "),
        "{missing}"
    );
}

#[test]
fn the_parts_of_a_service_or_an_action_are_those_of_its_file() {
    let folder = tempfile::tempdir().unwrap();
    let [services, actions] = ["srv", "action"].map(|kind| folder.path().join("my_msgs").join(kind));
    for kind in [&services, &actions] {
        std::fs::create_dir_all(kind).unwrap();
    }
    let dock = "---\n# Whether it is docked.\nbool docked\nstring why\n---\nfloat32 distance\n";
    std::fs::write(actions.join("Dock.action"), dock).unwrap();
    let grasp = "# Where.\ngeometry_msgs/Point place\nuint8 HARD=1\n---\nbool done\nstring why\n";
    std::fs::write(services.join("Grasp.srv"), grasp).unwrap();
    std::fs::write(services.join("Reset.srv"), "---\n").unwrap();
    let fields = |name: &str| {
        let entry =
            format!("subscribe = {{ \"/there\" = \"there\", \"/c\" = {{ as = \"c\", type = \"{name}\" }} }}");
        let interfaces = folder.path().display().to_string();
        let application = read(&format!("interfaces = [{interfaces:?}]\n{}", text(&entry)), &[])
            .map_err(|faults| faults.to_string())?;
        let topics = &application.instances[application.instance("topics").unwrap()];
        let value_type = &topics.listed[1].value_type;
        assert_eq!((&*value_type.name, value_type.bytes > 0), (name, true));
        let fields = value_type.fields.iter();
        Ok::<_, String>(fields.map(|field| field.name.clone()).collect::<Vec<_>>())
    };
    assert_eq!(fields("my_msgs/srv/Grasp_Request").unwrap(), ["place"]);
    assert_eq!(fields("my_msgs/srv/Grasp_Response").unwrap(), ["done", "why"]);
    assert!(fields("my_msgs/srv/Reset_Request").unwrap().is_empty());
    assert!(fields("my_msgs/srv/Reset_Response").unwrap().is_empty());
    assert_eq!(fields("std_srvs/srv/SetBool_Request").unwrap(), ["data"]);
    assert!(fields("my_msgs/action/Dock_Goal").unwrap().is_empty());
    assert_eq!(fields("my_msgs/action/Dock_Feedback").unwrap(), ["distance"]);
    assert_eq!(fields("my_msgs/action/Dock_Result").unwrap(), ["docked", "why"]);
    assert_eq!(
        fields("my_msgs/action/Dock_GetResult_Response").unwrap(),
        ["status", "result"]
    );
    for missing in [
        "my_msgs/srv/Grasp",
        "my_msgs/srv/Grasp_Event",
        "my_msgs/srv/Other_Request",
        "my_msgs/action/Dock",
        "my_msgs/action/Other_GetResult_Response",
    ] {
        let error = fields(missing).unwrap_err();
        assert!(error.contains("nothing defines the type"), "{error}");
    }
}

/// A robot and a schema that commands `goal` of a schema with these entries in its lists.
fn commanding(entries: &str) -> String {
    text(entries)
        .replace("topics.there", "pioneer.laser")
        .replace("pioneer.velocity", "topics.goal")
}

#[test]
fn a_command_has_the_type_of_the_actuator_that_is_bound_to_it() {
    let text = commanding(r#"call."/drive" = { as = "goal", x = 2 }"#);
    let application = read(&text, &[]).unwrap_or_else(|faults| panic!("{faults}"));
    let topics = &application.instances[application.instance("topics").unwrap()];
    let own = topics.schema.ports.len() - 1;
    let port = &topics.schema.ports[own];
    assert_eq!((&*port.name, &*port.doc), ("goal", "To `/drive`."));
    assert_eq!(port.value_type.name, "geometry_msgs/msg/Twist");
    let role = Role::Command {
        neutral: vec![0; port.value_type.bytes],
        validity_ns: 7,
    };
    assert!(port.has(raw::TRIGGER));
    assert_eq!((&port.role, &topics.bindings[own]), (&role, &Binding::Command));
    let stop = &application.instances[application.instance("stop").unwrap()];
    let instance = application.instance("topics").unwrap();
    assert!(stop.bindings.contains(&Binding::Actuator {
        target: Some(InstancePort { instance, port: own })
    }));
}

#[test]
fn a_command_that_nobody_gives_needs_a_type() {
    check_text(
        &commanding(r#"call = { "/drive" = "goal", "/dock" = "dock" }"#),
        &[],
        r#"
apps/good.toml:9:39: `/dock` in `call` of schema `topics`: no schema commands `topics.dock`, so its type is not known
    help: state it, as in type = "sensor_msgs/msg/LaserScan", or bind an actuator to it
"#,
    );
    check_text(
        &commanding(r#"call = { "/drive" = { x = 1 } }"#),
        &[],
        r#"
apps/good.toml:9:10: `/drive` in `call` of schema `topics` has no `as`
    help: name it, as in as = "dock"
apps/good.toml:14:22: `base` in `actuators` of schema `stop`: `topics` has no `goal`
"#,
    );
}
