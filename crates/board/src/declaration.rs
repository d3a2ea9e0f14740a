//! What a variable is declared to be, and what each of its values carries.

use std::sync::Arc;

use jde_abi::describe::{Limits, Type};

use crate::Error;
use crate::finite::Finite;
use crate::store::Cell;

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
    /// The father or an operator writes it (R8). Refused while not finite or outside of its limits.
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
    /// What a modulation takes, whoever writes it (R8).
    pub limits: Limits,
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

    /// Refuses what no variable can be; `finite` knows the floats of the type where they must be finite.
    pub(crate) fn check(&self, finite: Option<&Finite>) -> Result<(), Error> {
        let variable = self.full_name();
        if self.owner.is_empty() || self.name.is_empty() {
            return Err(Error::Nameless {
                owner: self.owner.clone(),
                name: self.name.clone(),
            });
        }
        if self.writers.saturating_add(self.readers) > Cell::MOST_USERS {
            return Err(Error::TooMany {
                variable,
                writers: self.writers,
                readers: self.readers,
                most: Cell::MOST_USERS,
            });
        }
        let Some(initial) = &self.initial else {
            return Ok(());
        };
        if initial.len() != self.value_type.bytes {
            return Err(Error::InitialSize {
                variable,
                value_type: self.value_type.name.clone(),
                expected: self.value_type.bytes,
                got: initial.len(),
            });
        }
        match finite.and_then(|finite| finite.first_not_finite(initial)) {
            Some(field) => Err(Error::InitialNotFinite { variable, field }),
            None => self
                .limits
                .check(&self.value_type, initial)
                .map_err(|not_allowed| Error::InitialNotAllowed {
                    variable,
                    words: not_allowed.words(&self.unit),
                }),
        }
    }
}
