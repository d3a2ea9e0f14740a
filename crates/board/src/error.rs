//! What can go wrong when variables are declared and opened, and why a value is not taken.

/// Why a variable cannot be declared, found or opened.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Error {
    /// The name is in use.
    #[error("variable `{0}` is already declared; a schema has one variable of a name")]
    Duplicate(String),
    /// A part of the name is empty.
    #[error("variable `{owner}.{name}` needs both an owner and a name")]
    Nameless {
        /// The owner, as given.
        owner: String,
        /// The name, as given.
        name: String,
    },
    /// No such variable.
    #[error("there is no variable `{name}`{}", .nearest.as_ref().map_or(String::new(), |near| format!("; did you mean `{near}`?")))]
    Unknown {
        /// The name asked for.
        name: String,
        /// The nearest one there is.
        nearest: Option<String>,
    },
    /// The initial value is not one of the variable's type.
    #[error("the initial value of `{variable}` has {got} bytes; its type `{value_type}` has {expected}")]
    InitialSize {
        /// The variable.
        variable: String,
        /// Its type.
        value_type: String,
        /// Bytes of the type.
        expected: usize,
        /// Bytes given.
        got: usize,
    },
    /// The initial value of a modulation or command holds a NaN or an infinity.
    #[error("the initial value of `{variable}` is not finite in `{field}`; give a finite number")]
    InitialNotFinite {
        /// The variable.
        variable: String,
        /// The field.
        field: String,
    },
    /// The initial value of a modulation is outside of its limits.
    #[error("the initial value of `{variable}` {words}")]
    InitialNotAllowed {
        /// The variable.
        variable: String,
        /// What it is and what is allowed.
        words: String,
    },
    /// More readers and writers than a cell can have.
    #[error("`{variable}` is declared for {writers} writers and {readers} readers; together at most {most}")]
    TooMany {
        /// The variable.
        variable: String,
        /// Writers declared.
        writers: usize,
        /// Readers declared.
        readers: usize,
        /// Most of both.
        most: usize,
    },
    /// The system has no memory that other processes could map.
    #[error("there is no memory for `{variable}` that another process could map: {error}")]
    NoMemory {
        /// The variable.
        variable: String,
        /// What the system says.
        error: String,
    },
    /// All writers are taken.
    #[error("`{variable}` takes {most} writer(s), and {writers} writes it; `{name}` cannot", writers = .taken.join(", "))]
    WritersTaken {
        /// The variable.
        variable: String,
        /// Who asked.
        name: String,
        /// Most writers.
        most: usize,
        /// Who writes it.
        taken: Vec<String>,
    },
    /// A loan cannot be left to somebody who was given up.
    #[error("all {most} slots of `{variable}` that readers may hold are taken; wait until one lets go")]
    Crowded {
        /// The variable.
        variable: String,
        /// The slots.
        most: usize,
    },
    /// The Rust type does not fit the variable's.
    #[error(
        "`{variable}` is a `{value_type}` of {expected} bytes, and `{rust}` has {got}; open it with the type it was declared with"
    )]
    TypeSize {
        /// The variable.
        variable: String,
        /// Its type.
        value_type: String,
        /// The Rust type.
        rust: &'static str,
        /// Bytes of the variable's type.
        expected: usize,
        /// Bytes of the Rust type.
        got: usize,
    },
    /// The Rust type needs a stricter alignment than values have.
    #[error("`{rust}` needs alignment {align}, and values of `{variable}` have at most 16")]
    TypeAlign {
        /// The variable.
        variable: String,
        /// The Rust type.
        rust: &'static str,
        /// Its alignment.
        align: usize,
    },
}

/// Why a value is not taken. Counted in [`VariableStatus`](crate::VariableStatus), but for the last two.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Refused {
    /// The writer holds no grant at this instant (R7), or the host puts a value into an export.
    #[error("the writer has no authority over this variable at this instant")]
    NoAuthority,
    /// The value holds a NaN or an infinity.
    #[error("the value is not finite, and commands and modulations must be")]
    NotFinite,
    /// The value is outside of what the modulation takes.
    #[error("the value is outside of what the modulation takes")]
    OutOfRange,
    /// Published without a loan.
    #[error("nothing was loaned; loan, fill, then publish")]
    NothingLoaned,
    /// A value of another size than the type's.
    #[error("the value does not have as many bytes as the variable's type")]
    WrongSize,
}
