//! The operators. Each is compiled once from its node and its version, and computes as <https://onnx.ai/onnx/operators>
//! defines it; attributes that it does not know are refused.

mod choose;
mod elementwise;
mod matrix;
mod normalize;
mod recurrent;
mod reduce;
mod shape;
mod window;

use crate::attributes::Attributes;
use crate::model::Node;
use crate::tensor::{TYPE_FLOAT, Tensor};

/// Computes the outputs of a node from its inputs. An error says what does not fit.
pub(crate) type Operator = Box<dyn Fn(&Inputs<'_>, &mut [Tensor]) -> Result<(), String> + Send>;

/// Operations of a number, in multiplications of a product of matrices: that a function is computed of; that is found
/// among others by its place; and of a window, for each of its taps.
const FUNCTION: usize = 16;
const PLACE: usize = 8;
const TAP: usize = 4;

/// How many inputs and outputs an operator has at most.
type Arity = (usize, usize);

/// An operator, or what of it is not run.
type Compiled = Result<Operator, String>;

/// The inputs of one run of a node.
pub(crate) struct Inputs<'a> {
    indices: &'a [Option<usize>],
    values: &'a [Tensor],
    /// Whether only shapes are asked for, and the numbers are none of a policy.
    is_trial: bool,
}

impl<'a> Inputs<'a> {
    pub(crate) fn new(indices: &'a [Option<usize>], values: &'a [Tensor], is_trial: bool) -> Self {
        Self {
            indices,
            values,
            is_trial,
        }
    }

    /// Returns an input that must be there.
    fn get(&self, index: usize) -> Result<&'a Tensor, String> {
        self.optional(index)
            .ok_or_else(|| format!("its input {index} is missing"))
    }

    /// Returns an input that may be left out.
    fn optional(&self, index: usize) -> Option<&'a Tensor> {
        self.indices
            .get(index)
            .copied()
            .flatten()
            .map(|index| &self.values[index])
    }

    fn len(&self) -> usize {
        self.indices.len()
    }
}

/// Returns whole numbers as numbers of 32 bits.
pub(crate) fn as_floats() -> Operator {
    elementwise::cast_to(TYPE_FLOAT)
}

/// Compiles a node.
///
/// # Errors
/// What of it is not run.
pub(crate) fn compile(node: &Node, opset: i64) -> Compiled {
    let attributes = Attributes::of(node);
    let families = [
        elementwise::compile,
        matrix::compile,
        shape::compile,
        reduce::compile,
        choose::compile,
        normalize::compile,
        window::compile,
        recurrent::compile,
    ];
    for family in families {
        if let Some((arity, operator)) = family(&node.operator, &attributes, opset)? {
            attributes.finish()?;
            check_arity(node, arity)?;
            return Ok(operator);
        }
    }
    Err("this operator is not run; docs/policy.md lists those that are".to_owned())
}

fn check_arity(node: &Node, (inputs, outputs): Arity) -> Result<(), String> {
    if node.inputs.len() > inputs {
        return Err(format!(
            "it has {} inputs, and {inputs} are run",
            node.inputs.len()
        ));
    }
    if node.outputs.is_empty() || node.outputs.len() > outputs {
        return Err(format!(
            "it has {} outputs, and 1 to {outputs} are run",
            node.outputs.len()
        ));
    }
    Ok(())
}

/// Returns an axis of a shape with that many dimensions; negative ones count from the end.
fn axis(stated: i64, rank: usize) -> Result<usize, String> {
    let from_start = if stated < 0 { stated + rank as i64 } else { stated };
    match usize::try_from(from_start) {
        Ok(axis) if axis < rank => Ok(axis),
        _ => Err(format!("there is no axis {stated} of {rank} dimensions")),
    }
}

/// Returns the axes, each once and in order.
fn axes(stated: &[i64], rank: usize) -> Result<Vec<usize>, String> {
    let mut axes = stated
        .iter()
        .map(|stated| axis(*stated, rank))
        .collect::<Result<Vec<_>, _>>()?;
    axes.sort_unstable();
    match axes.windows(2).all(|pair| pair[0] != pair[1]) {
        true => Ok(axes),
        false => Err(format!("the axes {stated:?} name one twice")),
    }
}

/// Returns the products of the dimensions before an axis, of the axis, and after it.
fn around(shape: &[usize], axis: usize) -> (usize, usize, usize) {
    let (before, after) = (&shape[..axis], &shape[axis + 1..]);
    (before.iter().product(), shape[axis], after.iter().product())
}
