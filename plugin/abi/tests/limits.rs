//! Contradictory modulations, and invalid names and units, are refused with their place.

#![allow(unsafe_code)]

mod tables;

use core::ptr;

use jde_abi::describe::Role;
use jde_abi::raw;
use tables::{Tables, assert_refused, read_changed};

/// Changes the modulation of the plugin into a plain number, and then applies `change`.
fn number(change: impl FnOnce(&mut raw::Port)) -> impl FnOnce(&mut Tables) {
    static NUMBER: raw::Type = raw::Type {
        size: size_of::<raw::Type>() as u32,
        field_count: 1,
        name: c"std_msgs/msg/Float64".as_ptr(),
        doc: ptr::null(),
        bytes: 8,
        align: 8,
        fields: &raw const FIELD,
    };
    static FIELD: raw::Field = raw::Field {
        size: size_of::<raw::Field>() as u32,
        kind: raw::F64,
        form: raw::ONE,
        capacity: 1,
        name: c"data".as_ptr(),
        doc: ptr::null(),
        unit: ptr::null(),
        offset: 0,
        length_offset: 0,
        value_type: ptr::null(),
        flags: 0,
        reserved: 0,
    };
    |t| {
        t.ports[2].value_type = &raw const NUMBER;
        change(&mut t.ports[2]);
    }
}

#[test]
fn contradictory_modulations_are_refused_with_their_place() {
    static NOT_A_NUMBER: f64 = f64::NAN;
    let at = |message: &str| format!("schema `goon`, port `speed`: {message}");
    assert_refused(
        &at("its default is 0, and at least 0.1 is allowed"),
        number(|port| port.min = 0.1),
    );
    assert_refused(
        &at("its default is 0 m, and at most -1 m is allowed"),
        number(|port| (port.max, port.unit) = (-1.0, c"m".as_ptr())),
    );
    assert_refused(
        &at("min is 1 and max -1, between which nothing is"),
        number(|port| (port.min, port.max) = (1.0, -1.0)),
    );
    assert_refused(
        &at("its default is NaN, and a number is allowed"),
        number(|port| port.initial = (&raw const NOT_A_NUMBER).cast()),
    );
    assert_refused(
        &at("`metre` is no unit; use m, "),
        number(|port| port.unit = c"metre".as_ptr()),
    );
    assert_refused("field `count`: `metre` is no unit", |t| {
        t.fields[2].unit = c"metre".as_ptr()
    });
    assert_refused(
        &at("it limits a demo/msg/Value, and only plain numbers have limits"),
        |t| t.ports[2].min = 0.0,
    );
    read_changed(number(|port| {
        (port.min, port.max, port.unit) = (0.0, f64::INFINITY, c"rad/s2".as_ptr());
    }))
    .expect("the modulation is valid");
}

#[test]
fn choices_name_the_numbers_from_0_on() {
    struct Names([*const core::ffi::c_char; 2]);
    // SAFETY: the texts never change.
    unsafe impl Sync for Names {}
    static NAMES: Names = Names([c"slow".as_ptr(), c"fast".as_ptr()]);
    static TWICE: Names = Names([c"slow".as_ptr(), c"slow".as_ptr()]);
    let choice = |count: u32, max: f64, names: &'static Names| {
        number(move |port| {
            (port.choices, port.choice_count) = (names.0.as_ptr(), count);
            (port.min, port.max) = (0.0, max);
        })
    };
    let plugin = read_changed(choice(2, 1.0, &NAMES)).expect("the choices are valid");
    let Role::Modulation { limits, .. } = &plugin.schemas[0].ports[2].role else {
        panic!("the port is a modulation")
    };
    assert_eq!(limits.choices, ["slow", "fast"]);
    assert_eq!((limits.choice("fast"), limits.choice("faster")), (Some(1), None));
    assert_refused(
        "of 2 choices min is 0 and max the last one's number",
        choice(2, 2.0, &NAMES),
    );
    assert_refused("two choices are called `slow`", choice(2, 1.0, &TWICE));
    assert_refused("4000000000 choices", choice(4_000_000_000, 1.0, &NAMES));
    assert_refused(
        "the pointer to them is null",
        number(|port| port.choice_count = 1),
    );
}

#[test]
fn a_former_name_is_of_a_modulation_and_of_no_other_port() {
    let formerly = |name: &'static core::ffi::CStr| number(move |port| port.former_name = name.as_ptr());
    let plugin = read_changed(formerly(c"pace")).expect("the former name is valid");
    let schema = &plugin.schemas[0];
    assert_eq!(schema.ports[2].former_name.as_deref(), Some("pace"));
    assert_eq!(schema.modulation_named("pace"), Some(2));
    assert_eq!(schema.modulation_named(&schema.ports[2].name), Some(2));
    assert_eq!(schema.modulation_named("place"), None);
    let name = &schema.ports[1].name;
    assert!(
        !matches!(schema.ports[1].role, Role::Import),
        "`{name}` shares a name space"
    );
    assert_refused("a port's former name is `a b`", formerly(c"a b"));
    assert_refused("only a modulation has a former name", |t| {
        t.ports[0].former_name = c"pace".as_ptr()
    });
    assert_refused("two ports are called", |t| {
        t.ports[2].former_name = t.ports[1].name;
    });
}

#[test]
fn names_that_every_schema_has_are_refused_for_variables() {
    let message = "every schema has this name with a meaning of its own";
    assert_refused(message, |t| t.ports[1].name = c"period".as_ptr());
    assert_refused(message, |t| {
        t.schema.kind = raw::DRIVER;
        t.schema.child_count = 0;
        t.schema.port_count = 3;
        t.ports[2].kind = raw::COMMAND;
        t.ports[2].validity_ns = 1;
        t.ports[2].name = c"period".as_ptr();
    });
    read_changed(|t| t.ports[0].name = c"period".as_ptr()).expect("an import has a name space of its own");
    read_changed(|t| t.ports[4].name = c"period".as_ptr()).expect("a father writes the period of its child");
}
