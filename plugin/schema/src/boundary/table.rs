//! The tables that the macros generate, as constants.

use core::ffi::CStr;
use core::marker::PhantomData;
use core::ptr;

use jde_abi::raw;
use jde_types::{Modulated, Value};

use super::{abilities, calls, judgement};
use crate::guard::Guard;
use crate::inspect::Inspect;
use crate::memory::Memory;
use crate::panel::Panel;
use crate::schema::{Arbitrate, Schema};

/// The description of a schema type, apart from its ports and children.
pub struct About {
    /// Name of the type.
    pub name: &'static CStr,
    /// What the type does.
    pub doc: &'static CStr,
    /// The kind of schema.
    pub kind: u32,
    /// Default period, ns.
    pub period_ns: u64,
    /// Longest iteration, ns; 0 means the period.
    pub budget_ns: u64,
}

/// The abilities that a schema type has beyond [`Schema`]: an arbitration, a panel, a memory, an inspection, a
/// guard.
/// Its constants hide those of [`Without`].
pub struct Own<S>(PhantomData<S>);

/// The default for each ability that a schema type does not have.
pub trait Without {
    /// No arbitration.
    const ARBITRATE: Option<ArbitrateFn> = None;
    /// No panel.
    const PANEL: Option<raw::Panel> = None;
    /// No memory.
    const STATE: Option<raw::State> = None;
    /// No inspection.
    const INSPECT: Option<raw::Inspect> = None;
    /// No guard.
    const GUARD: Option<raw::Guard> = None;
    /// No guard.
    const IS_GUARD: bool = false;
}

type ArbitrateFn = unsafe extern "C" fn(
    *mut core::ffi::c_void,
    *mut raw::Context,
    *const raw::Level,
    *mut raw::Verdict,
) -> i32;

impl<S: Arbitrate> Own<S> {
    /// The function that arbitrates.
    pub const ARBITRATE: Option<ArbitrateFn> = Some(calls::arbitrate::<S>);
}

impl<S: Panel> Own<S> {
    /// The table of the panel.
    pub const PANEL: Option<raw::Panel> = Some(abilities::panel::<S>());
}

impl<S: Memory> Own<S> {
    /// The table of the memory.
    pub const STATE: Option<raw::State> = Some(abilities::state::<S>());
}

impl<S: Inspect> Own<S> {
    /// The table of the inspection.
    pub const INSPECT: Option<raw::Inspect> = Some(abilities::inspection::<S>());
}

impl<S: Guard> Own<S> {
    /// The table of the guard.
    pub const GUARD: Option<raw::Guard> = Some(judgement::guard::<S>());
    /// It is a guard. Apart from the table, which is read from the table of the schema.
    pub const IS_GUARD: bool = true;
}

impl<S> Without for Own<S> {}

/// Builds the table of a schema type.
#[must_use]
pub const fn schema<S: Schema>(
    about: About,
    ports: &'static [raw::Port],
    children: &'static [raw::Child],
    arbitrate: Option<ArbitrateFn>,
) -> raw::Schema {
    let motor = about.kind == raw::MOTOR;
    assert!(
        motor || arbitrate.is_none(),
        "only a motor schema can arbitrate among children"
    );
    raw::Schema {
        size: size_of::<raw::Schema>() as u32,
        kind: about.kind,
        name: about.name.as_ptr(),
        doc: about.doc.as_ptr(),
        period_ns: about.period_ns,
        budget_ns: about.budget_ns,
        ports: ports.as_ptr(),
        children: children.as_ptr(),
        port_count: ports.len() as u32,
        child_count: children.len() as u32,
        create: Some(calls::create::<S>),
        destroy: Some(calls::destroy::<S>),
        awake: Some(calls::awake::<S>),
        check: if motor { Some(calls::check::<S>) } else { None },
        iterate: Some(calls::iterate::<S>),
        arbitrate,
        sleep: Some(calls::sleep::<S>),
        ability: if S::HAS_ABILITY {
            Some(abilities::ability::<S>)
        } else {
            None
        },
    }
}

/// Builds the table of an import.
#[must_use]
pub const fn import<T: Value>(name: &'static CStr, doc: &'static CStr, unit: &'static CStr) -> raw::Port {
    port::<T>(raw::IMPORT, name, doc, unit)
}

/// Builds the table of an export.
#[must_use]
pub const fn export<T: Value>(
    name: &'static CStr,
    doc: &'static CStr,
    unit: &'static CStr,
    validity_ns: u64,
) -> raw::Port {
    raw::Port {
        validity_ns,
        ..port::<T>(raw::EXPORT, name, doc, unit)
    }
}

/// Builds the table of a modulation. Its former name is empty if it has none.
#[must_use]
pub const fn modulation<T: Modulated>(
    (name, former_name): (&'static CStr, &'static CStr),
    doc: &'static CStr,
    unit: &'static CStr,
    default: &'static T::Wire,
    (min, max): (f64, f64),
) -> raw::Port {
    let choices = T::CHOICES.len();
    raw::Port {
        initial: ptr::from_ref(default).cast(),
        min: if choices > 0 { 0.0 } else { min },
        max: if choices > 0 { choices as f64 - 1.0 } else { max },
        choices: if choices > 0 {
            T::CHOICES.as_ptr()
        } else {
            ptr::null()
        },
        choice_count: choices as u32,
        former_name: if former_name.is_empty() {
            ptr::null()
        } else {
            former_name.as_ptr()
        },
        ..port::<T::Wire>(raw::MODULATION, name, doc, unit)
    }
}

/// Builds the table of a command.
#[must_use]
pub const fn command<T: Value>(
    name: &'static CStr,
    doc: &'static CStr,
    unit: &'static CStr,
    neutral: &'static T,
    validity_ns: u64,
) -> raw::Port {
    raw::Port {
        initial: ptr::from_ref(neutral).cast(),
        validity_ns,
        ..port::<T>(raw::COMMAND, name, doc, unit)
    }
}

/// Builds the table of an actuator.
#[must_use]
pub const fn actuator<T: Value>(name: &'static CStr, doc: &'static CStr, unit: &'static CStr) -> raw::Port {
    port::<T>(raw::ACTUATOR, name, doc, unit)
}

/// Builds the table of a modulation of a child.
#[must_use]
pub const fn child_modulation<T: Modulated>(
    name: &'static CStr,
    doc: &'static CStr,
    unit: &'static CStr,
    child: u32,
) -> raw::Port {
    raw::Port {
        child,
        ..port::<T::Wire>(raw::CHILD_MODULATION, name, doc, unit)
    }
}

/// Returns the table of a port with the flags of its attributes.
#[must_use]
pub const fn with_flags(port: raw::Port, flags: u32) -> raw::Port {
    raw::Port { flags, ..port }
}

/// Builds the table of a role for a child.
#[must_use]
pub const fn child(
    kind: u32,
    name: &'static CStr,
    group: &'static CStr,
    doc: &'static CStr,
    flags: u32,
) -> raw::Child {
    raw::Child {
        size: size_of::<raw::Child>() as u32,
        kind,
        name: name.as_ptr(),
        group: group.as_ptr(),
        doc: doc.as_ptr(),
        flags,
        reserved: 0,
    }
}

/// Builds the table of a plugin. Each text ends with a NUL.
#[must_use]
pub const fn plugin(
    name: &'static str,
    version: &'static str,
    doc: &'static str,
    aborts: bool,
    schemas: &'static [raw::Schema],
) -> raw::Plugin {
    raw::Plugin {
        magic: raw::MAGIC,
        abi_major: raw::ABI_MAJOR,
        abi_minor: raw::ABI_MINOR,
        size: size_of::<raw::Plugin>() as u32,
        flags: if aborts { raw::PLUGIN_ABORTS } else { 0 },
        name: text(name),
        version: text(version),
        doc: text(doc),
        schemas: schemas.as_ptr(),
        schema_count: schemas.len() as u32,
        reserved: 0,
    }
}

const fn text(text: &'static str) -> *const core::ffi::c_char {
    match CStr::from_bytes_with_nul(text.as_bytes()) {
        Ok(text) => text.as_ptr(),
        Err(_) => panic!("the name, version and doc of a plugin contain no NUL"),
    }
}

const fn port<T: Value>(
    kind: u32,
    name: &'static CStr,
    doc: &'static CStr,
    unit: &'static CStr,
) -> raw::Port {
    raw::Port {
        size: size_of::<raw::Port>() as u32,
        kind,
        name: name.as_ptr(),
        doc: doc.as_ptr(),
        unit: unit.as_ptr(),
        value_type: T::TYPE,
        initial: ptr::null(),
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
