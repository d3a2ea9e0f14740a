//! What is written from a description is read as that description.

#![allow(unsafe_code)]

use std::ffi::c_void;
use std::ptr::null_mut;
use std::sync::Arc;

use jde_abi::describe::{
    Attributes, Child, Field, FieldKind, Form, Kind, Limits, Plugin, Port, Role, RosNotation, Scalar, Schema,
    Type, Validity,
};
use jde_abi::raw;
use jde_abi::read;
use jde_abi::write::{self, Functions};

struct Failing;

impl Functions for Failing {
    unsafe extern "C" fn create(
        _: *const raw::Schema,
        _: *const raw::Host,
        _: *mut raw::Context,
    ) -> *mut c_void {
        null_mut()
    }
}

fn field(name: &str, kind: FieldKind, form: Form, offset: usize) -> Field {
    Field {
        name: name.to_owned(),
        doc: format!("The {name}."),
        unit: String::new(),
        kind,
        form,
        offset,
        notation: RosNotation::default(),
    }
}

fn number() -> Arc<Type> {
    Arc::new(Type {
        name: String::from("std_msgs/msg/Float64"),
        doc: String::new(),
        bytes: 8,
        align: 8,
        fields: vec![field("data", FieldKind::Scalar(Scalar::F64), Form::One, 0)],
    })
}

/// A structure of every form, with gaps before a field and at the end.
fn structure() -> Arc<Type> {
    let text = Form::Text {
        capacity: 5,
        length_offset: 16,
    };
    let sequence = Form::Sequence {
        capacity: 2,
        length_offset: 28,
    };
    Arc::new(Type {
        name: String::from("my_msgs/msg/All"),
        doc: String::from("Everything."),
        bytes: 56,
        align: 8,
        fields: vec![
            field("flag", FieldKind::Scalar(Scalar::Bool), Form::One, 0),
            field("part", FieldKind::Struct(number()), Form::One, 8),
            field("name", FieldKind::Scalar(Scalar::U8), text, 20),
            field("few", FieldKind::Scalar(Scalar::F32), sequence, 36),
            field("fixed", FieldKind::Scalar(Scalar::I16), Form::Array(3), 44),
        ],
    })
}

fn port(name: &str, value_type: Arc<Type>, role: Role) -> Port {
    Port {
        name: name.to_owned(),
        doc: format!("The {name}."),
        unit: String::new(),
        value_type,
        attributes: Attributes::of(role.kind(), u32::MAX),
        role,
        former_name: (name == "speed").then(|| String::from("pace")),
    }
}

fn description() -> Plugin {
    let limits = Limits {
        least: Some(0.0),
        greatest: Some(2.0),
        choices: Vec::new(),
    };
    let modulation = Role::Modulation {
        default: 1.0_f64.to_ne_bytes().to_vec(),
        limits,
    };
    let child = |name: &str, many| Child {
        name: name.to_owned(),
        doc: String::new(),
        motor: true,
        group: String::from("base"),
        optional: false,
        many,
    };
    let motor = Schema {
        name: String::from("motor"),
        doc: String::from("Drives."),
        kind: Kind::Motor,
        period_ns: 100,
        budget_ns: Some(50),
        ports: vec![
            port("laser", structure(), Role::Import),
            port("speed", number(), modulation),
            port("base", structure(), Role::Actuator),
            port("limit", number(), Role::ChildModulation { child: 0 }),
        ],
        children: vec![child("near", false), child("rest", true)],
        arbitrates: true,
        panel: true,
        touch: true,
        memory: true,
        inspects: true,
        guard: None,
        lists: Vec::new(),
    };
    let driver = Schema {
        name: String::from("driver"),
        kind: Kind::Driver,
        budget_ns: None,
        ports: vec![
            port(
                "seen",
                structure(),
                Role::Export {
                    validity: Validity::Lasting,
                },
            ),
            port(
                "velocity",
                number(),
                Role::Command {
                    neutral: vec![0; 8],
                    validity_ns: 7,
                },
            ),
        ],
        children: Vec::new(),
        arbitrates: false,
        panel: false,
        touch: false,
        memory: false,
        inspects: false,
        ..motor.clone()
    };
    Plugin {
        name: String::from("mine"),
        version: String::from("1.2"),
        doc: String::from("A plugin."),
        abi: (raw::ABI_MAJOR, raw::ABI_MINOR),
        throws: false,
        isolated: false,
        schemas: vec![motor, driver],
    }
}

#[test]
fn a_written_description_is_read_unchanged() {
    let table = write::plugin::<Failing>(&description());
    // SAFETY: a table that was just written.
    let read = unsafe { read::plugin(table) };
    assert_eq!(read, Ok(description()));
    // SAFETY: the table has two schemas of this layout.
    let is_checked = |index| unsafe { (*table.schemas.add(index)).check.is_some() };
    assert!(is_checked(0) && !is_checked(1), "only a motor schema is checked");
}
