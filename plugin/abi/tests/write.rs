//! What is written from a description is read as that description.

#![allow(unsafe_code)]

use std::ffi::c_void;
use std::ptr::null_mut;
use std::sync::Arc;

use jde_abi::describe::{
    Child, Field, FieldKind, Form, Kind, Limits, Plugin, Port, Role, RosNotation, Scalar, Schema, Type,
    Validity,
};
use jde_abi::raw::{self, Context};
use jde_abi::read;
use jde_abi::write::{self, Abilities, Functions, Optional};

const FUNCTIONS: Functions = Functions {
    create,
    destroy,
    awake: call,
    check,
    iterate: call,
    arbitrate,
    sleep,
};

struct Without;

impl Abilities for Without {
    const PANEL: raw::Panel = raw::Panel {
        size: size_of::<raw::Panel>() as u32,
        reserved: 0,
        draw: Some(draw),
        touch: Some(touch),
    };
    const STATE: raw::State = raw::State {
        size: size_of::<raw::State>() as u32,
        version: 1,
        save: Some(save),
        restore: Some(restore),
    };
    const INSPECT: raw::Inspect = raw::Inspect {
        size: size_of::<raw::Inspect>() as u32,
        reserved: 0,
        inspect: Some(inspect),
    };
}

unsafe extern "C" fn create(_: *const raw::Schema, _: *const raw::Host, _: *mut Context) -> *mut c_void {
    null_mut()
}
unsafe extern "C" fn destroy(_: *mut c_void) {}
unsafe extern "C" fn call(_: *mut c_void, _: *mut Context) -> i32 {
    raw::OK
}
unsafe extern "C" fn check(_: *mut c_void, _: *mut Context, _: *mut raw::Precondition) -> i32 {
    raw::OK
}
unsafe extern "C" fn arbitrate(
    _: *mut c_void,
    _: *mut Context,
    _: *const raw::Level,
    _: *mut raw::Verdict,
) -> i32 {
    raw::OK
}
unsafe extern "C" fn sleep(_: *mut c_void, _: *mut Context) {}
unsafe extern "C" fn draw(_: *mut c_void, _: *mut Context, _: *const raw::Pen) -> i32 {
    raw::OK
}
unsafe extern "C" fn touch(_: *mut c_void, _: *mut Context, _: *const raw::Gesture) -> i32 {
    raw::OK
}
unsafe extern "C" fn save(_: *mut c_void, _: *mut Context, _: *const raw::Saver) -> i32 {
    raw::OK
}
unsafe extern "C" fn restore(_: *mut c_void, _: *mut Context, _: u32, _: *const c_void, _: u64) -> i32 {
    raw::OK
}
unsafe extern "C" fn inspect(_: *mut c_void, _: *mut Context, _: *const raw::Problems) -> i32 {
    raw::OK
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
        role,
        optional: name == "laser",
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
        fixed: true,
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
            port("laser", structure(), Role::Import { trigger: true }),
            port("speed", number(), modulation),
            port("base", structure(), Role::Actuator),
            port("limit", number(), Role::ChildModulation { child: 0 }),
        ],
        children: vec![child("near", false), child("rest", true)],
        arbitrates: true,
        panel: true,
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
                    trigger: true,
                },
            ),
        ],
        children: Vec::new(),
        arbitrates: false,
        panel: false,
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
    let optional = [
        Optional {
            touch: true,
            memory: true,
        },
        Optional::default(),
    ];
    let table = write::plugin::<Without>(&description(), &FUNCTIONS, &optional);
    // SAFETY: a table that was just written.
    let read = unsafe { read::plugin(table) };
    assert_eq!(read, Ok(description()));
    for (index, expected) in optional.into_iter().enumerate() {
        // SAFETY: the table has two schemas of this layout.
        let (found, schema) = unsafe {
            let schema = &*table.schemas.add(index);
            (Optional::of(schema), schema)
        };
        assert_eq!(found, expected);
        assert_eq!(Optional::from_bits(found.bits()), expected);
        assert_eq!(
            schema.check.is_some(),
            index == 0,
            "only a motor schema is checked"
        );
    }
}
