//! Shared helpers for the tests of applications: a catalogue of plugin descriptions, an application without
//! faults, and functions that edit its text and check the faults. Loads no plugin.
//!
//! long because one catalogue serves all tests.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use jde_abi::describe::{
    Attributes, Child, Field, FieldKind, Form, Guard, Kind, Limits, ListKind, Plugin, Port, PortList, Role,
    RosNotation, Scalar, Schema, Type, Validity,
};
use jde_abi::raw;
use jde_app::{Application, Catalogue, Faults, Override, Unusable, parse};

/// An export whose values are valid for some of its schema's periods.
const EXPORT: Role = Role::Export {
    validity: Validity::Periods,
};

/// An application without faults.
pub(crate) const GOOD: &str = include_str!("../apps/good.toml");
/// The path under which the text is read.
pub(crate) const FILE: &str = "apps/good.toml";

/// Returns the faults of the good application after these replacements.
pub(crate) fn faults(edits: &[(&str, &str)]) -> String {
    match read(&edited(edits), &[]) {
        Ok(_) => "no fault".to_owned(),
        Err(faults) => faults.to_string(),
    }
}

/// Checks that the good application has exactly these faults after the replacements.
#[track_caller]
pub(crate) fn check(edits: &[(&str, &str)], expected: &str) {
    check_with(edits, &[], expected);
}

/// Like [`check`], with options.
#[track_caller]
pub(crate) fn check_with(edits: &[(&str, &str)], options: &[&str], expected: &str) {
    check_text(&edited(edits), options, expected);
}

/// Checks that a text has exactly these faults.
#[track_caller]
pub(crate) fn check_text(text: &str, options: &[&str], expected: &str) {
    let actual = match read(text, options) {
        Ok(_) => "no fault".to_owned(),
        Err(faults) => faults.to_string(),
    };
    assert_eq!(actual, expected.trim(), "\n--- actual:\n{actual}\n");
}

/// Reads the good application after these replacements, which must not cause a fault.
pub(crate) fn application(edits: &[(&str, &str)]) -> Application {
    application_with(edits, &[])
}

/// Like [`application`], with options.
pub(crate) fn application_with(edits: &[(&str, &str)], options: &[&str]) -> Application {
    read(&edited(edits), options).unwrap_or_else(|faults| panic!("{faults}"))
}

/// Reads a text as the content of [`FILE`], which need not exist.
pub(crate) fn read(text: &str, options: &[&str]) -> Result<Application, Faults> {
    let options: Vec<Override> = options
        .iter()
        .map(|option| option.parse().expect(option))
        .collect();
    parse(text, Path::new(FILE), &options, &DescribedPlugins)
}

/// Returns the text of the good application after replacing the first text of each pair by the second.
#[track_caller]
pub(crate) fn edited(edits: &[(&str, &str)]) -> String {
    let mut text = GOOD.to_owned();
    for (from, to) in edits {
        assert_eq!(
            text.matches(from).count(),
            1,
            "`{from}` does not occur exactly once"
        );
        text = text.replace(from, to);
    }
    text
}

/// A catalogue that describes its plugins and loads none.
pub(crate) struct DescribedPlugins;

impl Catalogue for DescribedPlugins {
    fn plugin(&self, name: &str, extra_dirs: &[PathBuf]) -> Result<Arc<Plugin>, Unusable> {
        let unusable = |reason: &str, is_missing| Unusable {
            reason: reason.to_owned(),
            is_missing,
        };
        if name == "nav2" {
            return Err(unusable(
                "it was built for ABI 2.0, newer than this host's 1.0",
                false,
            ));
        }
        let is_found = name != "extra" || extra_dirs.iter().any(|dir| dir.ends_with("apps/more"));
        let mut plugins = plugins().into_iter().filter(|_| is_found);
        let found = plugins.find(|plugin| plugin.name == name);
        found
            .map(Arc::new)
            .ok_or_else(|| unusable("no folder has it", true))
    }

    fn type_names(&self) -> Vec<String> {
        let types = plugins().into_iter().flat_map(|plugin| {
            let schemas = plugin.schemas.into_iter();
            schemas.map(move |schema| format!("{}/{}", plugin.name, schema.name))
        });
        types.collect()
    }
}

fn plugins() -> Vec<Plugin> {
    let laser = || trigger("laser", "sensor_msgs/msg/LaserScan");
    let base = || port("base", "geometry_msgs/msg/Twist", Role::Actuator);
    let cruise = |name: &str, of: &str| port(name, of, Role::ChildModulation { child: 2 });
    vec![
        plugin("sim", vec![robot()]),
        plugin(
            "teleop",
            vec![schema("teleop", Kind::Motor, vec![optional(laser()), base()])],
        ),
        plugin("stop", vec![schema("stop", Kind::Motor, vec![laser(), base()])]),
        plugin("look", vec![look()]),
        plugin(
            "nav",
            vec![schema("vff", Kind::Motor, vec![laser(), base()]), goon()],
        ),
        plugin("extra", vec![schema("only", Kind::Motor, vec![base()])]),
        plugin(
            "twin",
            vec![schema(
                "twin",
                Kind::Motor,
                vec![base(), port("spare", "geometry_msgs/msg/Twist", Role::Actuator)],
            )],
        ),
        plugin("odd", vec![odd()]),
        plugin("near", vec![near(laser())]),
        plugin("topics", vec![topics()]),
        plugin("boss", vec![boss()]),
        plugin(
            "crew",
            vec![Schema {
                children: vec![Child {
                    many: true,
                    ..child("children", "all", true)
                }],
                ..schema("crew", Kind::Motor, vec![])
            }],
        ),
        plugin(
            "example",
            vec![Schema {
                children: vec![
                    child("brake", "base", false),
                    child("avoid", "base", true),
                    child("cruise", "base", true),
                    child("gaze", "head", true),
                    Child {
                        motor: false,
                        group: String::new(),
                        ..child("lookout", "", true)
                    },
                ],
                ..schema(
                    "example",
                    Kind::Motor,
                    vec![
                        laser(),
                        Port {
                            unit: "rad".to_owned(),
                            ..port("heading", "std_msgs/msg/Float64", Role::Import)
                        },
                        port("mission", "jde_msgs/msg/Mission", EXPORT),
                        optional(base()),
                        Port {
                            unit: "m/s".to_owned(),
                            ..cruise("speed", "std_msgs/msg/Float64")
                        },
                        cruise("period", "std_msgs/msg/Float64"),
                    ],
                )
            }],
        ),
        plugin(
            "judge",
            vec![Schema {
                arbitrates: true,
                children: vec![child("one", "base", false), child("two", "base", true)],
                ..schema("judge", Kind::Motor, vec![])
            }],
        ),
    ]
}

fn robot() -> Schema {
    let velocity = Role::Command {
        neutral: vec![0; 16],
        validity_ns: 500_000_000,
    };
    let ports = vec![
        port("laser", "sensor_msgs/msg/LaserScan", EXPORT),
        port("odometry", "nav_msgs/msg/Odometry", EXPORT),
        export_heading(),
        Port {
            unit: "m".to_owned(),
            ..port("travelled", "std_msgs/msg/Float64", EXPORT)
        },
        port("velocity", "geometry_msgs/msg/Twist", velocity),
        Port {
            unit: "path".to_owned(),
            ..modulation("world", "std_msgs/msg/String", (None, None))
        },
        Port {
            unit: "model".to_owned(),
            ..modulation("model", "std_msgs/msg/String", (None, None))
        },
        modulation("start", "geometry_msgs/msg/Pose2D", (None, None)),
        modulation("noise", "std_msgs/msg/Float64", (Some(0.0), Some(1.0))),
        modulation("beams", "std_msgs/msg/UInt8", (None, None)),
        modulation("label", "std_msgs/msg/String", (None, None)),
        modulation("quiet", "std_msgs/msg/Bool", (None, None)),
        modulation("weights", "jde_msgs/msg/Weights", (None, None)),
        modulation("places", "jde_msgs/msg/Places", (None, None)),
    ];
    schema("robot", Kind::Driver, ports)
}

/// A guard of speeds.
fn near(laser: Port) -> Schema {
    Schema {
        guard: Some(Guard {
            state: 1,
            command: Arc::new(value_type("geometry_msgs/msg/Twist")),
        }),
        ..schema(
            "near",
            Kind::Perceptive,
            vec![laser, port("nearest", "std_msgs/msg/Float64", EXPORT)],
        )
    }
}

/// A driver with lists of ports.
fn topics() -> Schema {
    let list = |(name, kind): (&str, ListKind)| PortList {
        name: name.to_owned(),
        doc: String::new(),
        kind,
        settings: Arc::new(value_type("geometry_msgs/msg/Pose2D")),
        initial: vec![0; 24],
    };
    let lists = [
        ("publish", ListKind::Imports),
        (
            "subscribe",
            ListKind::Exports {
                validity: Validity::Periods,
            },
        ),
        ("repeat", ListKind::Imports),
        ("call", ListKind::Commands { validity_ns: 7 }),
    ];
    let role = Role::Import;
    let laser = optional(port("laser", "sensor_msgs/msg/LaserScan", role));
    let connection = port("connection", "std_msgs/msg/Bool", EXPORT);
    Schema {
        lists: lists.map(list).into(),
        ..schema("topics", Kind::Driver, vec![laser, connection])
    }
}

/// A driver whose laser scan has the standard name and another layout.
fn odd() -> Schema {
    let standard = value_type("sensor_msgs/msg/LaserScan");
    let laser = Port {
        value_type: Arc::new(Type {
            bytes: 16,
            ..standard
        }),
        ..port("laser", "", EXPORT)
    };
    schema("odd", Kind::Driver, vec![laser])
}

/// A father whose modulations do not fit its child.
fn boss() -> Schema {
    let write = |name: &str, of: &str| port(name, of, Role::ChildModulation { child: 0 });
    let ports = vec![
        write("speed", "geometry_msgs/msg/Pose2D"),
        write("pace", "geometry_msgs/msg/Pose2D"),
        write("period", "std_msgs/msg/UInt8"),
    ];
    Schema {
        children: vec![child("work", "all", false)],
        ..schema("boss", Kind::Motor, ports)
    }
}

fn goon() -> Schema {
    let speed = Port {
        unit: "m/s".to_owned(),
        former_name: Some("pace".to_owned()),
        ..modulation("speed", "std_msgs/msg/Float64", (Some(0.0), Some(1.2)))
    };
    let near = Port {
        unit: "rad".to_owned(),
        ..trigger("near", "std_msgs/msg/Float64")
    };
    let base = port("base", "geometry_msgs/msg/Twist", Role::Actuator);
    schema(
        "goon",
        Kind::Motor,
        vec![speed, base, optional(near), export_heading()],
    )
}

fn look() -> Schema {
    let bearing = Port {
        unit: "rad".to_owned(),
        ..trigger("bearing", "std_msgs/msg/Float64")
    };
    let tilt = Port {
        unit: "rad".to_owned(),
        ..modulation("tilt", "std_msgs/msg/Float64", (None, None))
    };
    let laser = trigger("laser", "sensor_msgs/msg/LaserScan");
    schema(
        "look",
        Kind::Perceptive,
        vec![laser, optional(bearing), tilt, export_heading()],
    )
}

fn export_heading() -> Port {
    Port {
        unit: "rad".to_owned(),
        ..port("heading", "std_msgs/msg/Float64", EXPORT)
    }
}

fn plugin(name: &str, schemas: Vec<Schema>) -> Plugin {
    Plugin {
        throws: false,
        isolated: false,
        name: name.to_owned(),
        version: "1".to_owned(),
        doc: String::new(),
        abi: (1, 0),
        schemas,
    }
}

fn schema(name: &str, kind: Kind, ports: Vec<Port>) -> Schema {
    Schema {
        name: name.to_owned(),
        doc: String::new(),
        kind,
        period_ns: 100_000_000,
        budget_ns: None,
        ports,
        children: Vec::new(),
        arbitrates: false,
        panel: false,
        touch: false,
        memory: false,
        inspects: false,
        guard: None,
        lists: Vec::new(),
    }
}

fn child(name: &str, group: &str, optional: bool) -> Child {
    Child {
        name: name.to_owned(),
        doc: String::new(),
        motor: true,
        group: group.to_owned(),
        optional,
        many: false,
    }
}

fn port(name: &str, ty: &str, role: Role) -> Port {
    Port {
        name: name.to_owned(),
        doc: String::new(),
        unit: String::new(),
        value_type: Arc::new(value_type(ty)),
        role,
        attributes: Attributes::default(),
        former_name: None,
    }
}

fn modulation(name: &str, ty: &str, (least, greatest): (Option<f64>, Option<f64>)) -> Port {
    let default = vec![0; value_type(ty).bytes];
    port(
        name,
        ty,
        Role::Modulation {
            default,
            limits: Limits {
                least,
                greatest,
                ..Limits::default()
            },
        },
    )
}

fn optional(port: Port) -> Port {
    let flags = port.attributes.flags() | raw::OPTIONAL;
    Port {
        attributes: Attributes::of(port.role.kind(), flags),
        ..port
    }
}

fn trigger(name: &str, ty: &str) -> Port {
    Port {
        attributes: Attributes::of(raw::IMPORT, raw::TRIGGER),
        ..port(name, ty, Role::Import)
    }
}

fn value_type(name: &str) -> Type {
    use Scalar::{Bool, F32, F64, U8, U64};
    let one = |name: &str, unit: &str, scalar, offset| field(name, unit, scalar, Form::One, offset);
    let (bytes, fields) = match name {
        "std_msgs/msg/Float64" => (8, vec![one("data", "", F64, 0)]),
        "std_msgs/msg/UInt8" => (1, vec![one("data", "", U8, 0)]),
        "std_msgs/msg/Bool" => (1, vec![one("data", "", Bool, 0)]),
        "std_msgs/msg/String" => (
            68,
            vec![field(
                "data",
                "",
                U8,
                Form::Text {
                    capacity: 64,
                    length_offset: 0,
                },
                4,
            )],
        ),
        "geometry_msgs/msg/Pose2D" => (
            24,
            vec![
                one("x", "m", F64, 0),
                one("y", "m", F64, 8),
                one("theta", "rad", F64, 16),
            ],
        ),
        "jde_msgs/msg/Weights" => (
            16,
            vec![field(
                "data",
                "m",
                F32,
                Form::Sequence {
                    capacity: 3,
                    length_offset: 0,
                },
                4,
            )],
        ),
        "jde_msgs/msg/Places" => {
            let form = Form::Sequence {
                capacity: 2,
                length_offset: 0,
            };
            let places = Field {
                kind: FieldKind::Struct(Arc::new(value_type("geometry_msgs/msg/Pose2D"))),
                ..field("poses", "", U8, form, 8)
            };
            (56, vec![places])
        }
        // The tests bind every other type only by its name and layout.
        "geometry_msgs/msg/Twist" => (
            16,
            vec![one("linear", "m/s", F64, 0), one("angular", "rad/s", F64, 8)],
        ),
        _ => (8, vec![one("stamp", "", U64, 0)]),
    };
    Type {
        name: name.to_owned(),
        doc: String::new(),
        bytes,
        align: 1,
        fields,
    }
}

fn field(name: &str, unit: &str, scalar: Scalar, form: Form, offset: usize) -> Field {
    Field {
        name: name.to_owned(),
        doc: String::new(),
        unit: unit.to_owned(),
        kind: FieldKind::Scalar(scalar),
        form,
        offset,
        notation: RosNotation::default(),
    }
}
