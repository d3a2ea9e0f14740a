//! The tables of the ability [`ABILITY_LISTS`]: a type of schema has lists of ports, whose entries an application
//! file states.

use core::ffi::{c_char, c_void};

use super::{Context, Type};

/// The id of the ability, whose table is a [`Lists`]. It and all that belongs to it exist since minor version 7.
pub const ABILITY_LISTS: &str = "jde.lists";

/// The table that [`super::Schema::ability`] returns for [`ABILITY_LISTS`]. The type has at least one port
/// besides.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Lists {
    /// Bytes of this table.
    pub size: u32,
    /// The number of lists, at least 1.
    pub count: u32,
    /// The lists. The stride is the `size` of the first.
    pub lists: *const PortList,
    /// Receives the ports of all lists. Called once, after `create` and before any other function. What the tables point to stays unchanged until the process ends.
    pub set: Option<unsafe extern "C" fn(*mut c_void, *mut Context, *const ListedPort, count: u32) -> i32>,
}

/// A list of ports: a table of the application file whose entries are imports, exports or commands of any type, each
/// with settings.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct PortList {
    /// Bytes of this table.
    pub size: u32,
    /// What the ports are: [`super::IMPORT`], [`super::EXPORT`], or of a driver [`super::COMMAND`], whose neutral value is all
    /// zeros and which lets the driver iterate at once. Commands exist since minor version 8.
    pub kind: u32,
    /// Its name: that of the table in the application file.
    pub name: *const c_char,
    /// What it means.
    pub doc: *const c_char,
    /// The type of the settings of each entry: a structure whose fields are their keys.
    pub settings: *const Type,
    /// The settings that an entry does not state, `settings->bytes` bytes.
    pub initial: *const c_void,
    /// How long a command is in force without being repeated, ns, at least 1, or how long a value of an export is
    /// valid, as in [`super::Port`]. Since minor version 8.
    pub validity_ns: u64,
}

/// A port of a list.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct ListedPort {
    /// Bytes of this table.
    pub size: u32,
    /// The place of its list among the lists of the type.
    pub list: u32,
    /// Its number in calls.
    pub port: u32,
    /// 0.
    pub reserved: u32,
    /// The entry's key in the application file: any text.
    pub label: *const c_char,
    /// The type of its value.
    pub value_type: *const Type,
    /// Its settings, in the type of the list.
    pub settings: *const c_void,
}
