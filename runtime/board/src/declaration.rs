//! The declaration of a variable, and the stamp of its values.

use std::sync::Arc;

use jde_abi::describe::{Limits, Type};
use jde_abi::finite::Finite;

use crate::Error;
use crate::store::Cell;

/// Nanoseconds since the application's start.
pub type Nanos = u64;

/// The validity of values that do not expire.
pub const LASTING: Nanos = Nanos::MAX;

/// What accompanies each value of a variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stamp {
    /// When the value was measured or written.
    pub time: Nanos,
    /// Counts the values of the variable from 1; 0 is the initial value.
    pub sequence: u64,
    /// The id of its writer; [`Stamp::NO_WRITER`] for the initial value.
    pub writer: u32,
    /// The last instant at which the value is valid, or the command in force; `u64::MAX` for values that do not
    /// expire.
    pub valid_until: Nanos,
}

impl Stamp {
    /// The writer of an initial value.
    pub const NO_WRITER: u32 = u32::MAX;
}

/// What may write a variable, and what a write means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    /// One schema exports it. NaN and infinities are valid values (a laser beam without an echo).
    Export {
        /// How long a value is valid without a newer one (R19); [`LASTING`] until it is replaced or retracted.
        validity: Nanos,
    },
    /// The father or an operator writes it (R8). A value that is not finite or outside of the limits is
    /// refused.
    Modulation,
    /// It reaches an actuator. A value that is not finite is refused, and so is any value of a writer without
    /// a grant (R7).
    Command {
        /// How long a command is in force without a repetition.
        validity: Nanos,
    },
}

/// The description of a variable to be declared.
#[derive(Clone, Debug)]
pub struct Declaration {
    /// The schema that owns it: its name space. Empty for the topic of another program whose name has one part.
    pub owner: String,
    /// Its name in that name space.
    pub name: String,
    /// What it means.
    pub doc: String,
    /// Unit of a plain number; empty for none.
    pub unit: String,
    /// The type of its values.
    pub value_type: Arc<Type>,
    /// What may write it.
    pub access: Access,
    /// The limits of a modulation, for every writer (R8).
    pub limits: Limits,
    /// Its value before the first write. Without one, readers get no value until then.
    pub initial: Option<Vec<u8>>,
    /// The maximum number of writers at once. An export always has one.
    pub writers: usize,
    /// The maximum number of readers that borrow a large value at once. Further readers copy it. Each costs
    /// the memory of one value.
    pub readers: usize,
}

impl Declaration {
    /// Returns `owner.name`, or the name alone if there is no owner.
    #[must_use]
    pub fn full_name(&self) -> String {
        match self.owner.as_str() {
            "" => self.name.clone(),
            owner => format!("{owner}.{}", self.name),
        }
    }

    /// Refuses an invalid declaration. `finite` lists the floats that must be finite, if any.
    pub(crate) fn check(&self, finite: Option<&Finite>) -> Result<(), Error> {
        let variable = self.full_name();
        if self.name.is_empty() {
            return Err(Error::Unnamed(self.owner.clone()));
        }
        if self.writers.saturating_add(self.readers) > Cell::MAX_USERS {
            return Err(Error::TooMany {
                variable,
                writers: self.writers,
                readers: self.readers,
                most: Cell::MAX_USERS,
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
