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

/// The functions of a type of schema, with the meaning of the fields of [`raw::Schema`].
#[derive(Clone, Copy)]
#[allow(missing_docs, reason = "the fields of `raw::Schema` describe them")]
pub struct Functions {
    pub create: unsafe extern "C" fn(*const raw::Schema, *const raw::Host, *mut raw::Context) -> *mut c_void,
    pub destroy: unsafe extern "C" fn(*mut c_void),
    pub awake: unsafe extern "C" fn(*mut c_void, *mut raw::Context) -> i32,
    pub check: unsafe extern "C" fn(*mut c_void, *mut raw::Context, *mut raw::Precondition) -> i32,
    pub iterate: unsafe extern "C" fn(*mut c_void, *mut raw::Context) -> i32,
    pub arbitrate:
        unsafe extern "C" fn(*mut c_void, *mut raw::Context, *const raw::Level, *mut raw::Verdict) -> i32,
    pub sleep: unsafe extern "C" fn(*mut c_void, *mut raw::Context),
}

/// The tables of the abilities, each with all its functions.
pub trait Abilities: 'static {
    /// Of [`raw::ABILITY_PANEL`].
    const PANEL: raw::Panel;
    /// Of [`raw::ABILITY_STATE`].
    const STATE: raw::State;
    /// Of [`raw::ABILITY_INSPECT`].
    const INSPECT: raw::Inspect;
}

/// The optional functions of a type that its description does not state.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Optional {
    /// `touch` of the panel.
    pub touch: bool,
    /// The memory.
    pub memory: bool,
}

impl Optional {
    /// Returns the optional functions of a table.
    ///
    /// # Safety
    /// The table follows the rules of [`raw`].
    #[must_use]
    pub unsafe fn of(table: &raw::Schema) -> Self {
        // SAFETY: the caller's.
        let (panel, state) = unsafe {
            (
                crate::table::ability::<raw::Panel>(table, raw::ABILITY_PANEL),
                crate::table::ability::<raw::State>(table, raw::ABILITY_STATE),
            )
        };
        Self {
            touch: matches!(panel, Ok(Some(panel)) if panel.touch.is_some()),
            memory: matches!(state, Ok(Some(_))),
        }
    }

    /// Returns them as bits, which [`Self::from_bits`] reads.
    #[must_use]
    pub fn bits(self) -> u32 {
        u32::from(self.touch) | u32::from(self.memory) << 1
    }

    /// Returns the functions that [`Self::bits`] wrote.
    #[must_use]
    pub fn from_bits(bits: u32) -> Self {
        Self {
            touch: bits & 1 != 0,
            memory: bits & 2 != 0,
        }
    }
}

/// Returns the table of a plugin. Each type has `functions`, but `check` only if it is a motor schema, and others as
/// far as its description and its part of `optional` state them. Guards and lists of ports are not written.
#[must_use]
pub fn plugin<A: Abilities>(
    plugin: &Plugin,
    functions: &Functions,
    optional: &[Optional],
) -> &'static raw::Plugin {
    let schemas: Vec<raw::Schema> = plugin
        .schemas
        .iter()
        .enumerate()
        .map(|(index, schema)| {
            let optional = optional.get(index).copied().unwrap_or_default();
            self::schema::<A>(schema, functions, optional)
        })
        .collect();
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

fn schema<A: Abilities>(schema: &Schema, functions: &Functions, optional: Optional) -> raw::Schema {
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
        create: Some(functions.create),
        destroy: Some(functions.destroy),
        awake: Some(functions.awake),
        check: (schema.kind == Kind::Motor).then_some(functions.check),
        iterate: Some(functions.iterate),
        arbitrate: schema.arbitrates.then_some(functions.arbitrate),
        sleep: Some(functions.sleep),
        ability: Some(ability::<A>(
            flag(schema.panel, PANEL)
                | flag(optional.touch, TOUCH)
                | flag(optional.memory, STATE)
                | flag(schema.inspects, INSPECT),
        )),
    }
}

fn port(port: &Port) -> raw::Port {
    let mut table = raw::Port {
        size: size_of::<raw::Port>() as u32,
        kind: raw::EXPORT,
        name: text(&port.name),
        doc: text(&port.doc),
        unit: text(&port.unit),
        value_type: value_type(&port.value_type),
        initial: ptr::null(),
        min: f64::NAN,
        max: f64::NAN,
        validity_ns: 0,
        flags: flag(port.optional, raw::OPTIONAL),
        child: 0,
        choices: ptr::null(),
        choice_count: 0,
        reserved: 0,
    };
    match &port.role {
        Role::Import { trigger } => {
            table.kind = raw::IMPORT;
            table.flags |= flag(*trigger, raw::TRIGGER);
        }
        Role::Export { validity } => table.validity_ns = validity.to_ns(),
        Role::Modulation {
            default,
            limits,
            fixed,
        } => {
            table.kind = raw::MODULATION;
            table.initial = bytes(default);
            table.min = limits.least.unwrap_or(f64::NAN);
            table.max = limits.greatest.unwrap_or(f64::NAN);
            table.flags |= flag(*fixed, raw::FIXED);
            let choices: Vec<*const c_char> = limits.choices.iter().map(|choice| text(choice)).collect();
            table.choice_count = choices.len() as u32;
            table.choices = array(choices);
        }
        Role::Command {
            neutral,
            validity_ns,
            trigger,
        } => {
            table.kind = raw::COMMAND;
            table.flags |= flag(*trigger, raw::TRIGGER);
            table.initial = bytes(neutral);
            table.validity_ns = *validity_ns;
        }
        Role::Actuator => table.kind = raw::ACTUATOR,
        Role::ChildModulation { child } => {
            table.kind = raw::CHILD_MODULATION;
            table.child = *child as u32;
        }
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
fn ability<A: Abilities>(set: u32) -> Ability {
    macro_rules! functions {
        ($($set:literal)*) => { [$(ability_of::<A, $set>),*] };
    }
    let all: [Ability; 16] = functions!(0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15);
    all[set as usize]
}

/// # Safety
/// As for [`raw::Schema::ability`].
unsafe extern "C" fn ability_of<A: Abilities, const SET: u32>(id: *const c_char) -> *const c_void {
    if id.is_null() {
        return ptr::null();
    }
    // SAFETY: the host's text.
    match unsafe { CStr::from_ptr(id) }.to_str() {
        Ok(raw::ABILITY_PANEL) if SET & PANEL != 0 => {
            let panel = if SET & TOUCH != 0 {
                const { &A::PANEL }
            } else {
                const {
                    &raw::Panel {
                        touch: None,
                        ..A::PANEL
                    }
                }
            };
            ptr::from_ref(panel).cast()
        }
        Ok(raw::ABILITY_STATE) if SET & STATE != 0 => ptr::from_ref(const { &A::STATE }).cast(),
        Ok(raw::ABILITY_INSPECT) if SET & INSPECT != 0 => ptr::from_ref(const { &A::INSPECT }).cast(),
        _ => ptr::null(),
    }
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
