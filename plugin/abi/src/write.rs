//! Writes tables from descriptions, the opposite of [`crate::read`]: for plugins whose types are known only at
//! run time, such as classes of another language.
//!
//! A table of a plugin stays unchanged until the process ends, so what this module writes is never freed.

#![allow(unsafe_code)]

use core::ffi::{CStr, c_char, c_void};
use core::ptr;
use std::ffi::CString;

use crate::describe::{Field, FieldKind, Form, Kind, Plugin, Port, Role, RosNotation, Scalar, Schema, Type};
use crate::raw;

/// What every type of schema of a plugin offers. Each function is that of the field of its name in [`raw::Schema`],
/// [`raw::Panel`], [`raw::State`] or [`raw::Inspect`]; those that are not stated fail.
#[allow(
    missing_docs,
    clippy::missing_safety_doc,
    reason = "the fields of the tables describe the functions"
)]
pub trait Functions: 'static {
    /// The version of the format of the memory.
    const MEMORY: u32 = 1;

    unsafe extern "C" fn create(
        schema: *const raw::Schema,
        host: *const raw::Host,
        cx: *mut raw::Context,
    ) -> *mut c_void;
    unsafe extern "C" fn destroy(_: *mut c_void) {}
    unsafe extern "C" fn awake(_: *mut c_void, _: *mut raw::Context) -> i32 {
        raw::FAILED
    }
    unsafe extern "C" fn check(_: *mut c_void, _: *mut raw::Context, _: *mut raw::Precondition) -> i32 {
        raw::FAILED
    }
    unsafe extern "C" fn iterate(_: *mut c_void, _: *mut raw::Context) -> i32 {
        raw::FAILED
    }
    unsafe extern "C" fn arbitrate(
        _: *mut c_void,
        _: *mut raw::Context,
        _: *const raw::Level,
        _: *mut raw::Verdict,
    ) -> i32 {
        raw::FAILED
    }
    unsafe extern "C" fn sleep(_: *mut c_void, _: *mut raw::Context) {}
    unsafe extern "C" fn draw(_: *mut c_void, _: *mut raw::Context, _: *const raw::Pen) -> i32 {
        raw::FAILED
    }
    unsafe extern "C" fn touch(_: *mut c_void, _: *mut raw::Context, _: *const raw::Gesture) -> i32 {
        raw::FAILED
    }
    unsafe extern "C" fn save(_: *mut c_void, _: *mut raw::Context, _: *const raw::Saver) -> i32 {
        raw::FAILED
    }
    unsafe extern "C" fn restore(
        _: *mut c_void,
        _: *mut raw::Context,
        _: u32,
        _: *const c_void,
        _: u64,
    ) -> i32 {
        raw::FAILED
    }
    unsafe extern "C" fn inspect(_: *mut c_void, _: *mut raw::Context, _: *const raw::Problems) -> i32 {
        raw::FAILED
    }
}

/// Returns the table of a plugin. Each type has the functions `F`, but `check` only if it is a motor schema, and others as
/// far as its description states them. Guards and lists of ports are not written.
#[must_use]
pub fn plugin<F: Functions>(plugin: &Plugin) -> &'static raw::Plugin {
    let schemas: Vec<raw::Schema> = plugin.schemas.iter().map(schema::<F>).collect();
    leak(raw::Plugin {
        magic: raw::MAGIC,
        abi_major: raw::ABI_MAJOR,
        abi_minor: raw::ABI_MINOR,
        size: size_of::<raw::Plugin>() as u32,
        flags: raw::PLUGIN_CATCHES,
        name: text(&plugin.name),
        version: text(&plugin.version),
        doc: text(&plugin.doc),
        schema_count: schemas.len() as u32,
        schemas: array(schemas),
        reserved: 0,
    })
}

fn schema<F: Functions>(schema: &Schema) -> raw::Schema {
    let ports: Vec<raw::Port> = schema.ports.iter().map(port).collect();
    let child = |child: &crate::describe::Child| raw::Child {
        size: size_of::<raw::Child>() as u32,
        kind: if child.motor { raw::MOTOR } else { raw::PERCEPTIVE },
        name: text(&child.name),
        group: text(&child.group),
        doc: text(&child.doc),
        flags: flag(child.optional, raw::OPTIONAL) | flag(child.many, raw::MANY),
        reserved: 0,
    };
    let children: Vec<raw::Child> = schema.children.iter().map(child).collect();
    raw::Schema {
        size: size_of::<raw::Schema>() as u32,
        kind: match schema.kind {
            Kind::Perceptive => raw::PERCEPTIVE,
            Kind::Motor => raw::MOTOR,
            Kind::Driver => raw::DRIVER,
        },
        name: text(&schema.name),
        doc: text(&schema.doc),
        period_ns: schema.period_ns,
        budget_ns: schema.budget_ns.unwrap_or(0),
        port_count: ports.len() as u32,
        ports: array(ports),
        child_count: children.len() as u32,
        children: array(children),
        create: Some(F::create),
        destroy: Some(F::destroy),
        awake: Some(F::awake),
        check: (schema.kind == Kind::Motor).then_some(F::check as _),
        iterate: Some(F::iterate),
        arbitrate: schema.arbitrates.then_some(F::arbitrate as _),
        sleep: Some(F::sleep),
        ability: Some(ability::<F>(
            flag(schema.panel, PANEL)
                | flag(schema.touch, TOUCH)
                | flag(schema.memory, STATE)
                | flag(schema.inspects, INSPECT),
        )),
    }
}

fn port(port: &Port) -> raw::Port {
    let mut table = raw::Port {
        size: size_of::<raw::Port>() as u32,
        kind: port.role.kind(),
        name: text(&port.name),
        doc: text(&port.doc),
        unit: text(&port.unit),
        value_type: value_type(&port.value_type),
        initial: ptr::null(),
        min: f64::NAN,
        max: f64::NAN,
        validity_ns: 0,
        flags: port.attributes.flags(),
        child: 0,
        choices: ptr::null(),
        choice_count: 0,
        reserved: 0,
        former_name: port.former_name.as_deref().map_or(ptr::null(), text),
    };
    match &port.role {
        Role::Import | Role::Actuator => {}
        Role::Export { validity } => table.validity_ns = validity.to_ns(),
        Role::Modulation { default, limits } => {
            table.initial = bytes(default);
            table.min = limits.least.unwrap_or(f64::NAN);
            table.max = limits.greatest.unwrap_or(f64::NAN);
            let choices: Vec<*const c_char> = limits.choices.iter().map(|choice| text(choice)).collect();
            table.choice_count = choices.len() as u32;
            table.choices = array(choices);
        }
        Role::Command { neutral, validity_ns } => {
            table.initial = bytes(neutral);
            table.validity_ns = *validity_ns;
        }
        Role::ChildModulation { child } => table.child = *child as u32,
    }
    table
}

/// Returns the table of a type of value.
#[must_use]
pub fn value_type(ty: &Type) -> &'static raw::Type {
    let mut fields: Vec<raw::Field> = ty.fields.iter().map(field).collect();
    for (offset, bytes) in gaps(ty) {
        fields.push(raw::Field {
            form: raw::PADDING,
            capacity: bytes as u32,
            ..field(&Field {
                name: String::from("_"),
                doc: String::new(),
                unit: String::new(),
                kind: FieldKind::Scalar(Scalar::U8),
                form: Form::One,
                offset,
                notation: RosNotation::default(),
            })
        });
    }
    leak(raw::Type {
        size: size_of::<raw::Type>() as u32,
        field_count: fields.len() as u32,
        name: text(&ty.name),
        doc: text(&ty.doc),
        bytes: ty.bytes as u64,
        align: ty.align as u64,
        fields: array(fields),
    })
}

/// Returns the offset and the length of the bytes that belong to no field.
fn gaps(ty: &Type) -> Vec<(usize, usize)> {
    let mut spans: Vec<(usize, usize)> = ty
        .fields
        .iter()
        .map(|field| {
            let start = field.form.length_offset().unwrap_or(field.offset);
            (start, field.offset + field.kind.bytes() * field.form.capacity())
        })
        .collect();
    spans.sort_unstable();
    spans.push((ty.bytes, ty.bytes));
    let mut reached = 0;
    let mut gaps = Vec::new();
    for (start, end) in spans {
        if start > reached {
            gaps.push((reached, start - reached));
        }
        reached = end;
    }
    gaps
}

fn field(field: &Field) -> raw::Field {
    let (kind, part) = match &field.kind {
        FieldKind::Scalar(scalar) => (scalar_kind(*scalar), ptr::null()),
        FieldKind::Struct(ty) => (raw::STRUCT, ptr::from_ref(value_type(ty))),
    };
    raw::Field {
        size: size_of::<raw::Field>() as u32,
        kind,
        form: match field.form {
            Form::One => raw::ONE,
            Form::Array(_) => raw::ARRAY,
            Form::Sequence { .. } => raw::SEQUENCE,
            Form::Text { .. } => raw::TEXT,
        },
        capacity: field.form.capacity() as u32,
        name: text(&field.name),
        doc: text(&field.doc),
        unit: text(&field.unit),
        offset: field.offset as u64,
        length_offset: field.form.length_offset().unwrap_or(0) as u64,
        value_type: part,
        flags: [
            (field.notation.is_byte, raw::BYTE),
            (field.notation.is_bounded, raw::BOUNDED),
        ]
        .into_iter()
        .filter_map(|(is_set, flag)| is_set.then_some(flag))
        .sum(),
        reserved: 0,
    }
}

fn scalar_kind(scalar: Scalar) -> u32 {
    match scalar {
        Scalar::Bool => raw::BOOL,
        Scalar::U8 => raw::U8,
        Scalar::U16 => raw::U16,
        Scalar::U32 => raw::U32,
        Scalar::U64 => raw::U64,
        Scalar::I8 => raw::I8,
        Scalar::I16 => raw::I16,
        Scalar::I32 => raw::I32,
        Scalar::I64 => raw::I64,
        Scalar::F32 => raw::F32,
        Scalar::F64 => raw::F64,
    }
}

const PANEL: u32 = 1;
const TOUCH: u32 = 2;
const STATE: u32 = 4;
const INSPECT: u32 = 8;

type Ability = unsafe extern "C" fn(*const c_char) -> *const c_void;

/// Returns the function for a set of abilities. It gets no argument from which it could find its type, so each
/// set has a function of its own.
fn ability<F: Functions>(set: u32) -> Ability {
    macro_rules! functions {
        ($($set:literal)*) => { [$(ability_of::<F, $set>),*] };
    }
    let all: [Ability; 16] = functions!(0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15);
    all[set as usize]
}

/// # Safety
/// As for [`raw::Schema::ability`].
unsafe extern "C" fn ability_of<F: Functions, const SET: u32>(id: *const c_char) -> *const c_void {
    if id.is_null() {
        return ptr::null();
    }
    // SAFETY: the host's text.
    match unsafe { CStr::from_ptr(id) }.to_str() {
        Ok(raw::ABILITY_PANEL) if SET & PANEL != 0 => table_of(
            const {
                &raw::Panel {
                    size: size_of::<raw::Panel>() as u32,
                    reserved: 0,
                    draw: Some(F::draw),
                    touch: if SET & TOUCH != 0 { Some(F::touch) } else { None },
                }
            },
        ),
        Ok(raw::ABILITY_STATE) if SET & STATE != 0 => table_of(
            const {
                &raw::State {
                    size: size_of::<raw::State>() as u32,
                    version: F::MEMORY,
                    save: Some(F::save),
                    restore: Some(F::restore),
                }
            },
        ),
        Ok(raw::ABILITY_INSPECT) if SET & INSPECT != 0 => table_of(
            const {
                &raw::Inspect {
                    size: size_of::<raw::Inspect>() as u32,
                    reserved: 0,
                    inspect: Some(F::inspect),
                }
            },
        ),
        _ => ptr::null(),
    }
}

fn table_of<T>(table: &'static T) -> *const c_void {
    ptr::from_ref(table).cast()
}

fn flag(is_set: bool, flag: u32) -> u32 {
    if is_set { flag } else { 0 }
}

/// Writes a text up to its first NUL.
pub(crate) fn text(text: &str) -> *const c_char {
    let until = text.split('\0').next().unwrap_or_default();
    CString::new(until).unwrap_or_default().into_raw()
}

/// Copies the bytes of a value, aligned for any type.
pub(crate) fn bytes(value: &[u8]) -> *const c_void {
    let mut words = vec![0_u128; value.len().div_ceil(size_of::<u128>())];
    let first = words.as_mut_ptr().cast::<u8>();
    // SAFETY: the words have at least as many bytes as the value, and no other user.
    unsafe { first.copy_from_nonoverlapping(value.as_ptr(), value.len()) };
    words.leak().as_ptr().cast()
}

fn array<T>(list: Vec<T>) -> *const T {
    list.leak().as_ptr()
}

fn leak<T>(table: T) -> &'static T {
    Box::leak(Box::new(table))
}
