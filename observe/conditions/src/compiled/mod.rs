//! Expressions over numbers and bools, evaluated about fifty times as fast as by CEL's interpreter, which
//! allocates each value and searches each name. What is not of this kind (texts, lists that are made, structures
//! in lists) is not compiled, and CEL evaluates it. The results are the same: a test compares them for random
//! expressions.

mod compiler;
mod evaluation;
mod number;

use jde_abi::describe::{Scalar, Type};

pub(crate) use compiler::compile;
pub(crate) use number::Number;
use number::{Binary, Unary};

/// Finds an input by the name that the expression has for it. Returns its place and type.
pub(crate) type FindInput<'a> = dyn Fn(&str) -> Option<(usize, &'a Type)> + 'a;

/// A part of an expression.
pub(crate) enum ExpressionNode {
    Constant(Number),
    /// A scalar of an input.
    Field {
        input: usize,
        offset: usize,
        scalar: Scalar,
    },
    Unary(Unary, Box<ExpressionNode>),
    Binary(Binary, Box<[ExpressionNode; 2]>),
    And(Box<[ExpressionNode; 2]>),
    Or(Box<[ExpressionNode; 2]>),
    If(Box<[ExpressionNode; 3]>),
    /// Whether it is not false; also true if it has no value.
    NotFalse(Box<ExpressionNode>),
    Size(List),
    Element(List, Box<ExpressionNode>),
    /// The greatest or least element.
    Extreme(List, Binary),
    Fold(Box<Fold>),
    /// The element of the fold that is so many folds further out.
    FoldElement(usize),
    /// The result so far of that fold.
    FoldResult(usize),
}

/// A list of scalars in an input.
pub(crate) struct List {
    input: usize,
    offset: usize,
    length_offset: Option<usize>,
    capacity: usize,
    scalar: Scalar,
}

/// `exists`, `all` or `exists_one`.
pub(crate) struct Fold {
    list: List,
    initial: ExpressionNode,
    goes_on: ExpressionNode,
    step: ExpressionNode,
    result: ExpressionNode,
}
