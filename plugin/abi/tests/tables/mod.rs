//! A small valid plugin, in which a test changes one value. It tests nothing itself.

#![allow(dead_code, reason = "each test program uses only some of it")]

use core::ffi::{CStr, c_void};
use core::ptr;

use jde_abi::{raw, read};

/// All tables of a small valid plugin, each of which a test can change.
pub(crate) struct Tables {
    pub(crate) plugin: raw::Plugin,
    pub(crate) schema: raw::Schema,
    pub(crate) ports: Vec<raw::Port>,
    pub(crate) children: Vec<raw::Child>,
    pub(crate) ty: raw::Type,
    pub(crate) fields: Vec<raw::Field>,
}

#[repr(C, align(8))]
pub(crate) struct Aligned([u8; 32]);

pub(crate) static ZEROS: Aligned = Aligned([0; 32]);

unsafe extern "C" fn create(_: *const raw::Schema, _: *const raw::Host, _: *mut raw::Context) -> *mut c_void {
    ptr::null_mut()
}

unsafe extern "C" fn iterate(_: *mut c_void, _: *mut raw::Context) -> i32 {
    raw::OK
}

pub(crate) fn field(
    name: &'static CStr,
    kind: u32,
    form: u32,
    capacity: u32,
    offset: u64,
    length_offset: u64,
) -> raw::Field {
    raw::Field {
        size: size_of::<raw::Field>() as u32,
        kind,
        form,
        capacity,
        name: name.as_ptr(),
        doc: ptr::null(),
        unit: ptr::null(),
        offset,
        length_offset,
        value_type: ptr::null(),
        flags: 0,
        reserved: 0,
    }
}

pub(crate) fn port(kind: u32, name: &'static CStr) -> raw::Port {
    raw::Port {
        size: size_of::<raw::Port>() as u32,
        kind,
        name: name.as_ptr(),
        doc: c"A port.".as_ptr(),
        unit: ptr::null(),
        value_type: ptr::null(),
        initial: if kind == raw::MODULATION {
            ZEROS.0.as_ptr().cast()
        } else {
            ptr::null()
        },
        min: f64::NAN,
        max: f64::NAN,
        validity_ns: 0,
        flags: 0,
        child: 0,
        choices: ptr::null(),
        choice_count: 0,
        reserved: 0,
        former_name: ptr::null(),
    }
}

pub(crate) fn child(name: &'static CStr) -> raw::Child {
    raw::Child {
        size: size_of::<raw::Child>() as u32,
        kind: raw::MOTOR,
        name: name.as_ptr(),
        group: c"base".as_ptr(),
        doc: ptr::null(),
        flags: 0,
        reserved: 0,
    }
}

/// Returns a plugin with a value of 32 bytes: a byte, three of padding, a number, a sequence of one double, a
/// text of four bytes.
pub(crate) fn tables() -> Box<Tables> {
    Box::new(Tables {
        plugin: raw::Plugin {
            magic: raw::MAGIC,
            abi_major: raw::ABI_MAJOR,
            abi_minor: raw::ABI_MINOR,
            size: size_of::<raw::Plugin>() as u32,
            flags: 0,
            name: c"demo".as_ptr(),
            version: c"1.2.3".as_ptr(),
            doc: ptr::null(),
            schemas: ptr::null(),
            schema_count: 1,
            reserved: 0,
        },
        schema: raw::Schema {
            size: size_of::<raw::Schema>() as u32,
            kind: raw::MOTOR,
            name: c"goon".as_ptr(),
            doc: c"Goes on.".as_ptr(),
            period_ns: 75,
            budget_ns: 0,
            ports: ptr::null(),
            children: ptr::null(),
            port_count: 0,
            child_count: 0,
            create: Some(create),
            destroy: None,
            awake: None,
            check: None,
            iterate: Some(iterate),
            arbitrate: None,
            sleep: None,
            ability: None,
        },
        ports: vec![
            port(raw::IMPORT, c"laser"),
            port(raw::EXPORT, c"pose"),
            port(raw::MODULATION, c"speed"),
            port(raw::ACTUATOR, c"base"),
            port(raw::CHILD_MODULATION, c"target"),
        ],
        children: vec![child(c"brake"), child(c"avoid")],
        ty: raw::Type {
            size: size_of::<raw::Type>() as u32,
            field_count: 0,
            name: c"demo/msg/Value".as_ptr(),
            doc: ptr::null(),
            bytes: 32,
            align: 8,
            fields: ptr::null(),
        },
        fields: vec![
            field(c"kind", raw::U8, raw::ONE, 1, 0, 0),
            field(c"_", raw::U8, raw::PADDING, 3, 1, 0),
            field(c"count", raw::U32, raw::ONE, 1, 4, 0),
            field(c"points", raw::F64, raw::SEQUENCE, 1, 16, 8),
            field(c"note", raw::U8, raw::TEXT, 4, 28, 24),
        ],
    })
}

/// Reads a plugin to which `change` was applied.
pub(crate) fn read_changed(
    change: impl FnOnce(&mut Tables),
) -> Result<jde_abi::describe::Plugin, read::Refusal> {
    let mut tables = tables();
    link(&mut tables);
    change(&mut tables);
    // SAFETY: every pointer of the tables points to a table that `tables` keeps alive.
    unsafe { read::plugin(&raw const tables.plugin) }
}

/// Sets the pointers between the tables.
pub(crate) fn link(tables: &mut Tables) {
    tables.ty.fields = tables.fields.as_ptr();
    tables.ty.field_count = tables.fields.len() as u32;
    for port in &mut tables.ports {
        port.value_type = &raw const tables.ty;
    }
    tables.schema.ports = tables.ports.as_ptr();
    tables.schema.port_count = tables.ports.len() as u32;
    tables.schema.children = tables.children.as_ptr();
    tables.schema.child_count = tables.children.len() as u32;
    tables.plugin.schemas = &raw const tables.schema;
}

#[track_caller]
pub(crate) fn assert_refused(expected: &str, change: impl FnOnce(&mut Tables)) {
    match read_changed(change) {
        Ok(_) => panic!("accepted instead of refused with: {expected}"),
        Err(refusal) => {
            let message = refusal.to_string();
            assert!(message.contains(expected), "the message is: {message}");
        }
    }
}
