//! The tables of the ability [`ABILITY_GUARD`]: a schema judges the commands of others before they take effect
//! (R18).

use core::ffi::{c_char, c_void};

use super::Type;

/// The id of the ability, whose table is a [`Guard`]. It and all that belongs to it exist since minor version
/// 6.
pub const ABILITY_GUARD: &str = "jde.guard";

/// The table that [`super::Schema::ability`] returns for [`ABILITY_GUARD`]. Only a perceptive schema has it.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Guard {
    /// Bytes of this table.
    pub size: u32,
    /// The number of the export by whose newest value the guard judges.
    pub state: u32,
    /// The type of the commands that it judges.
    pub command: *const Type,
    /// Judges a command. `state` is the newest value of the export, `age_ns` old; `command` is the command.
    /// Both are readable for the length of the call.
    ///
    /// Called in the thread that commands, and in the guard's after its iteration for a command that is in force,
    /// any number of times at once and without an instance. The result depends on the arguments alone. It changes
    /// nothing that lasts beyond the call, waits for nothing, and returns within microseconds. One that does not
    /// return is a hang of the guard. Any result but [`super::OK`] refuses the command.
    pub judge: Option<
        unsafe extern "C" fn(
            state: *const c_void,
            age_ns: u64,
            command: *const c_void,
            out: *mut Judgement,
        ) -> i32,
    >,
}

/// The judgement of a command, which the host lends.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Judgement {
    /// Bytes of this table.
    pub size: u32,
    /// Whether the command may take effect: 0 or 1; or [`LIMITED`]. 0 when the call begins.
    pub accepted: u32,
    /// Why it is refused or limited, as UTF-8 that ends with a NUL; ignored if it is accepted.
    pub reason: [c_char; 128],
    /// Room for a command of the guard's type: what takes effect if the command is limited. Since minor version 8;
    /// the size states whether the host has it.
    pub command: *mut c_void,
}

/// The judgement: not the judged command takes effect, but [`Judgement::command`]. Since minor version 8; a host of
/// before refuses the command.
pub const LIMITED: u32 = 2;
