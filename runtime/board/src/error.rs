//! The errors of declaring and opening variables, and the reasons for which a value is refused.

/// Why a variable cannot be declared, found or opened.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Error {
    /// The name is in use.
    #[error("variable `{0}` is already declared; a schema has one variable of a name")]
    Duplicate(String),
    /// The name is empty. States the owner.
    #[error("a variable of `{0}` has no name")]
    Unnamed(String),
    /// No such variable.
    #[error("there is no variable `{name}`{}", .nearest.as_ref().map_or(String::new(), |near| format!("; did you mean `{near}`?")))]
    Unknown {
        /// The requested name.
        name: String,
        /// The nearest existing name.
        nearest: Option<String>,
    },
    /// The size of the initial value differs from that of the variable's type.
    #[error("the initial value of `{variable}` has {got} bytes; its type `{value_type}` has {expected}")]
    InitialSize {
        /// The variable.
        variable: String,
        /// Its type.
        value_type: String,
        /// Bytes that the type has.
        expected: usize,
        /// Bytes that were given.
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
        /// The value and the limits, in words.
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
        /// The maximum of both together.
        most: usize,
    },
    /// The system has no memory that other processes can map.
    #[error("no memory for `{variable}` that another process can map: {error}")]
    NoMemory {
        /// The variable.
        variable: String,
        /// The system's error.
        error: String,
    },
    /// The maximum number of writers is open.
    #[error("`{variable}` allows {most} writer(s), and {writers} already writes it; `{name}` cannot", writers = .taken.join(", "))]
    TooManyWriters {
        /// The variable.
        variable: String,
        /// The writer that was to be opened.
        name: String,
        /// The maximum number of writers.
        most: usize,
        /// The open writers.
        taken: Vec<String>,
    },
    /// A loan of an abandoned call cannot be set aside, because no slot is free.
    #[error(
        "all {most} slots of `{variable}` that readers may hold are in use; wait until a reader releases one"
    )]
    TooManyReaders {
        /// The variable.
        variable: String,
        /// The number of slots that readers may hold.
        most: usize,
    },
    /// The size of the Rust type differs from that of the variable's type.
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

/// Why a value is refused. [`VariableStatus`](crate::VariableStatus) counts all but the last two.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Refused {
    /// The writer holds no grant at this instant (R7), or the host tries to put a value into an export, which
    /// is not counted.
    #[error("the writer has no authority over this variable at this instant")]
    NoAuthority,
    /// The value holds a NaN or an infinity.
    #[error("the value is not finite; values of commands and modulations must be finite")]
    NotFinite,
    /// The value is outside of the limits of the modulation.
    #[error("the value is outside the limits of the modulation")]
    OutOfRange,
    /// A publish without a loan.
    #[error("no value is loaned; loan, fill, then publish")]
    NothingLoaned,
    /// The size of the value differs from that of the type.
    #[error("the value does not have as many bytes as the variable's type")]
    WrongSize,
}
