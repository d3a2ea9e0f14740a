//! What a variable is declared to be, and what each of its values carries.

use std::sync::Arc;

use jde_abi::describe::Type;

/// Nanoseconds since the application's start.
pub type Nanos = u64;

/// What each value of a variable carries.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stamp {
    /// When it was measured or written.
    pub time: Nanos,
    /// Counts the values of the variable from 1; 0 is the initial value.
    pub sequence: u64,
    /// Who wrote it; [`Stamp::NOBODY`] for the initial value.
    pub writer: u32,
    /// When a command stops being in force; `u64::MAX` for values that stay.
    pub valid_until: Nanos,
}

impl Stamp {
    /// The writer of an initial value.
    pub const NOBODY: u32 = u32::MAX;
}

/// Who may write a variable, and what writing means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    /// One schema exports it. NaN and infinities are values like any other (a laser that sees nothing).
    Export,
    /// The father or an operator writes it (R8). Refused while not finite.
    Modulation,
    /// Reaches an actuator. Refused while not finite, and from whoever holds no grant (R7).
    Command {
        /// How long a command is in force without being repeated.
        validity: Nanos,
    },
}

/// A variable to be.
#[derive(Clone, Debug)]
pub struct Declaration {
    /// The schema that has it: its name space.
    pub owner: String,
    /// Its name in that name space.
    pub name: String,
    /// What it means.
    pub doc: String,
    /// Unit of a plain number; empty for none.
    pub unit: String,
    /// What its values are made of.
    pub value_type: Arc<Type>,
    /// Who may write it.
    pub access: Access,
    /// Its value before anybody writes; without one readers see nothing until then.
    pub initial: Option<Vec<u8>>,
    /// Most writers at once; an export has one, whatever is stated here.
    pub writers: usize,
    /// Most readers that borrow a large value at once; further readers work, by copying. Each costs room for a value.
    pub readers: usize,
}

impl Declaration {
    /// `owner.name`.
    #[must_use]
    pub fn full_name(&self) -> String {
        format!("{}.{}", self.owner, self.name)
    }
}
