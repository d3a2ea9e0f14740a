//! Variables of a given number of words, with their readers and writers. For the paths and rows about
//! variables and commands.

use std::sync::Arc;

use anyhow::{Context as _, Result};
use jde_abi::describe::{Field, FieldKind, Form, RosNotation, Scalar, Type};
use jde_board::typed::{TypedReader, TypedWriter};
use jde_board::{Access, Board, Declaration, Variable};

/// An export whose values expire, but not at time 0.
pub const EXPORT: Access = Access::Export {
    validity: 1_000_000_000,
};

/// The value of a variable: words of 8 bytes.
pub type Words<const WORDS: usize> = [u64; WORDS];

/// Makes a variable of `words` words that `readers` readers can borrow at the same time.
///
/// # Errors
/// If the board refuses the variable. A retry fails too.
pub fn variable(words: usize, access: Access, readers: usize) -> Result<Arc<Variable>> {
    let field = Field {
        name: String::from("data"),
        doc: String::new(),
        unit: String::new(),
        kind: FieldKind::Scalar(Scalar::U64),
        form: Form::Array(words),
        offset: 0,
        notation: RosNotation::default(),
    };
    let value_type = Type {
        name: String::from("bench/Words"),
        doc: String::new(),
        bytes: words * 8,
        align: 8,
        fields: vec![field],
    };
    let declaration = Declaration {
        owner: String::from("bench"),
        name: String::from("value"),
        doc: String::new(),
        unit: String::new(),
        value_type: Arc::new(value_type),
        access,
        limits: jde_abi::describe::Limits::default(),
        initial: None,
        writers: 1,
        readers,
    };
    Board::new()
        .declare(declaration)
        .context("a variable was refused")
}

/// Makes a variable with a first value, and returns its writer and a reader.
///
/// # Errors
/// If the board refuses the variable. A retry fails too.
pub fn ends<const WORDS: usize>(
    access: Access,
) -> Result<(TypedWriter<Words<WORDS>>, TypedReader<Words<WORDS>>)> {
    let variable = variable(WORDS, access, 1)?;
    let mut writer = TypedWriter::open(&variable, 1, "writer")?;
    let reader = TypedReader::open(&variable, "reader")?;
    writer.write([1; WORDS], 0, 0)?;
    Ok((writer, reader))
}
