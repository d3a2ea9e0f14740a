//! Functions of single numbers, and arithmetic between tensors of shapes that fit. NaN stays NaN in each of them, because
//! a network that loses its numbers must not drive.

use super::{Arity, Compiled, FUNCTION, Inputs, Operator};
use crate::attributes::Attributes;
use crate::tensor::{Data, TYPE_FLOAT, TYPE_INT32, TYPE_INT64, Tensor};

/// The most tensors of one sum or minimum.
const MAX_TENSORS: usize = 64;

/// Compiles an operator of this family.
pub(super) fn compile(
    name: &str,
    attributes: &Attributes<'_>,
    opset: i64,
) -> Result<Option<(Arity, Operator)>, String> {
    let (alpha, beta) = (
        |default| attributes.float("alpha", default),
        |default| attributes.float("beta", default),
    );
    let operator = match name {
        "Relu" => unary(relu),
        "Tanh" => unary(libm::tanhf),
        "Sigmoid" => unary(sigmoid),
        "LeakyRelu" => {
            let alpha = alpha(0.01)?;
            unary(move |x| if x < 0.0 { alpha * x } else { x })
        }
        "Elu" => {
            let alpha = alpha(1.0)?;
            unary(move |x| if x < 0.0 { alpha * libm::expm1f(x) } else { x })
        }
        "Selu" => {
            let (alpha, gamma) = (alpha(1.673_263_2)?, attributes.float("gamma", 1.050_701)?);
            unary(move |x| {
                if x <= 0.0 {
                    gamma * alpha * libm::expm1f(x)
                } else {
                    gamma * x
                }
            })
        }
        "HardSigmoid" => {
            let (alpha, beta) = (alpha(0.2)?, beta(0.5)?);
            unary(move |x| (alpha * x + beta).clamp(0.0, 1.0))
        }
        "HardSwish" => unary(|x| x * (x / 6.0 + 0.5).clamp(0.0, 1.0)),
        "Softplus" => unary(softplus),
        "Softsign" => unary(|x| x / (1.0 + x.abs())),
        "Mish" => unary(|x| x * libm::tanhf(softplus(x))),
        "Gelu" => match attributes.text("approximate", "none")? {
            "none" => unary(|x| 0.5 * x * (1.0 + libm::erff(x * core::f32::consts::FRAC_1_SQRT_2))),
            "tanh" => unary(|x| {
                let inner = (2.0 / core::f32::consts::PI).sqrt() * (x + 0.044_715 * x * x * x);
                0.5 * x * (1.0 + libm::tanhf(inner))
            }),
            other => return Err(format!("`approximate` is `{other}`")),
        },
        "Exp" => unary(libm::expf),
        "Log" => unary(libm::logf),
        "Sqrt" => unary(f32::sqrt),
        "Neg" => unary(|x| -x),
        "Abs" => unary(f32::abs),
        "Reciprocal" => unary(|x| 1.0 / x),
        "Sin" => unary(libm::sinf),
        "Cos" => unary(libm::cosf),
        "Erf" => unary(libm::erff),
        "Floor" => unary(f32::floor),
        "Ceil" => unary(f32::ceil),
        "Clip" if opset < 11 => {
            let (least, most) = (attributes.stated_float("min")?, attributes.stated_float("max")?);
            unary(move |x| clip(x, least, most))
        }
        "Clip" => return Ok(Some(((3, 1), clip_by_inputs()))),
        "Identity" => Box::new(copy),
        "Dropout" => return dropout(attributes, opset).map(Some),
        "Cast" => cast(attributes)?,
        "Add" => binary(|a, b| a + b, Some(i64::checked_add)),
        "Sub" => binary(|a, b| a - b, Some(i64::checked_sub)),
        "Mul" => binary(|a, b| a * b, Some(i64::checked_mul)),
        "Div" => binary(|a, b| a / b, Some(i64::checked_div)),
        "Pow" => binary(libm::powf, None),
        "PRelu" => binary(|x, slope| if x < 0.0 { slope * x } else { x }, None),
        "Min" => folded(lesser),
        "Max" => folded(greater),
        "Sum" => folded(|a, b| a + b),
        _ => return Ok(None),
    };
    let inputs = match name {
        "Add" | "Sub" | "Mul" | "Div" | "Pow" | "PRelu" => 2,
        "Min" | "Max" | "Sum" => MAX_TENSORS,
        _ => 1,
    };
    Ok(Some(((inputs, 1), operator)))
}

fn relu(x: f32) -> f32 {
    // Not `max`, which makes 0 of NaN.
    if x < 0.0 { 0.0 } else { x }
}

/// The logistic function.
pub(super) fn sigmoid(x: f32) -> f32 {
    1.0 / (1.0 + libm::expf(-x))
}

fn softplus(x: f32) -> f32 {
    match x > 0.0 {
        true => x + libm::log1pf(libm::expf(-x)),
        false => libm::log1pf(libm::expf(x)),
    }
}

fn lesser(a: f32, b: f32) -> f32 {
    if a.is_nan() || a < b { a } else { b }
}

/// The greater of two numbers; NaN if one is.
pub(super) fn greater(a: f32, b: f32) -> f32 {
    if a.is_nan() || a > b { a } else { b }
}

fn clip(x: f32, least: Option<f32>, most: Option<f32>) -> f32 {
    let x = least.map_or(x, |least| if x < least { least } else { x });
    most.map_or(x, |most| if x > most { most } else { x })
}

fn clip_by_inputs() -> Operator {
    Box::new(|inputs, outputs| {
        let bound = |index| match inputs.optional(index).map(Tensor::floats) {
            None => Ok(None),
            Some(Ok([bound])) => Ok(Some(*bound)),
            Some(_) => Err("its bounds must be single numbers of 32 bits".to_owned()),
        };
        let (least, most) = (bound(1)?, bound(2)?);
        map(inputs, outputs, |x| clip(x, least, most))
    })
}

fn copy(inputs: &Inputs<'_>, outputs: &mut [Tensor]) -> Result<(), String> {
    let input = inputs.get(0)?;
    outputs[0].copy_from(input, &input.shape)
}

/// Dropout does nothing outside of training.
fn dropout(attributes: &Attributes<'_>, opset: i64) -> Result<(Arity, Operator), String> {
    attributes.ignore(&["ratio", "seed"]);
    if opset < 12 {
        return Ok(((1, 1), Box::new(copy)));
    }
    let operator: Operator = Box::new(|inputs, outputs| match inputs.optional(2) {
        None => copy(inputs, outputs),
        Some(_) => Err("it states whether it trains: export the network for inference".to_owned()),
    });
    Ok(((3, 1), operator))
}

/// Between numbers of 32 bits and whole ones.
fn cast(attributes: &Attributes<'_>) -> Compiled {
    attributes.ignore(&["saturate", "round_mode"]);
    let to = attributes.integer("to", 0)?;
    if ![TYPE_FLOAT, TYPE_INT32, TYPE_INT64].contains(&to) {
        return Err(crate::tensor::refusal(to));
    }
    Ok(cast_to(to))
}

pub(super) fn cast_to(to: i64) -> Operator {
    Box::new(move |inputs, outputs| {
        let input = inputs.get(0)?;
        match (&input.data, to) {
            (Data::Float(_), TYPE_FLOAT) | (Data::Integer(_), TYPE_INT32 | TYPE_INT64) => {
                outputs[0].copy_from(input, &input.shape)?
            }
            (Data::Integer(whole), _) => {
                let room = outputs[0].room(&input.shape, 1)?;
                room.iter_mut()
                    .zip(whole)
                    .for_each(|(to, from)| *to = *from as f32);
            }
            (Data::Float(numbers), _) => {
                outputs[0].put_whole(&input.shape, numbers.iter().map(|number| *number as i64))?;
            }
        }
        Ok(())
    })
}

fn unary(function: impl Fn(f32) -> f32 + Send + 'static) -> Operator {
    Box::new(move |inputs, outputs| map(inputs, outputs, &function))
}

fn map(inputs: &Inputs<'_>, outputs: &mut [Tensor], function: impl Fn(f32) -> f32) -> Result<(), String> {
    let input = inputs.get(0)?;
    let room = outputs[0].room(&input.shape, FUNCTION)?;
    for (to, from) in room.iter_mut().zip(input.floats()?) {
        *to = function(*from);
    }
    Ok(())
}

/// Whole numbers are those of shapes.
type Whole = fn(i64, i64) -> Option<i64>;

fn binary(function: fn(f32, f32) -> f32, whole: Option<Whole>) -> Operator {
    Box::new(move |inputs, outputs| {
        let (a, b) = (inputs.get(0)?, inputs.get(1)?);
        if let (Data::Integer(first), Data::Integer(second), Some(whole)) = (&a.data, &b.data, whole) {
            let shape = broadcast(&a.shape, &b.shape)?;
            outputs[0].put_whole(&shape, core::iter::repeat(0))?;
            let mut numbers = Vec::new();
            pairs(&shape, a, b, |left, right| {
                numbers.push(whole(first[left], second[right]))
            });
            let numbers: Option<Vec<i64>> = numbers.into_iter().collect();
            let numbers = numbers.ok_or("its whole numbers overflow")?;
            return outputs[0].put_whole(&shape, numbers.into_iter());
        }
        combine(a, b, FUNCTION, &mut outputs[0], function)
    })
}

/// Combines all inputs, from the first to the last.
fn folded(function: fn(f32, f32) -> f32) -> Operator {
    Box::new(move |inputs, outputs| {
        copy(inputs, outputs)?;
        for index in 1..inputs.len() {
            let sum = core::mem::take(&mut outputs[0]);
            // What the last one counts is all of them.
            combine(
                &sum,
                inputs.get(index)?,
                index * FUNCTION,
                &mut outputs[0],
                function,
            )?;
        }
        outputs[0].floats().map(drop)
    })
}

/// Computes a function of each pair of numbers, which takes so many operations.
pub(super) fn combine(
    a: &Tensor,
    b: &Tensor,
    each: usize,
    to: &mut Tensor,
    function: fn(f32, f32) -> f32,
) -> Result<(), String> {
    let (first, second) = (a.floats()?, b.floats()?);
    let shape = broadcast(&a.shape, &b.shape)?;
    let room = to.room(&shape, each)?;
    if a.shape == b.shape {
        for ((to, a), b) in room.iter_mut().zip(first).zip(second) {
            *to = function(*a, *b);
        }
        return Ok(());
    }
    let mut to = room.iter_mut();
    pairs(&shape, a, b, |left, right| {
        if let Some(to) = to.next() {
            *to = function(first[left], second[right]);
        }
    });
    Ok(())
}

/// Returns the shape of two tensors together, by numpy's rule.
pub(super) fn broadcast(a: &[usize], b: &[usize]) -> Result<Vec<usize>, String> {
    let rank = a.len().max(b.len());
    let side = |shape: &[usize], at: usize| (at + shape.len()).checked_sub(rank).map_or(1, |at| shape[at]);
    (0..rank)
        .map(|at| match (side(a, at), side(b, at)) {
            (a, b) if a == b || b == 1 => Ok(a),
            (1, b) => Ok(b),
            _ => Err(format!("the shapes {a:?} and {b:?} do not fit")),
        })
        .collect()
}

/// Calls `take` with the places of each pair, in the order of the common shape.
fn pairs(shape: &[usize], a: &Tensor, b: &Tensor, mut take: impl FnMut(usize, usize)) {
    let (steps_a, steps_b) = (steps(&a.shape, shape.len()), steps(&b.shape, shape.len()));
    let mut at = vec![0; shape.len()];
    let (mut left, mut right) = (0, 0);
    for _ in 0..shape.iter().product() {
        take(left, right);
        for axis in (0..shape.len()).rev() {
            at[axis] += 1;
            left += steps_a[axis];
            right += steps_b[axis];
            if at[axis] < shape[axis] {
                break;
            }
            left -= at[axis] * steps_a[axis];
            right -= at[axis] * steps_b[axis];
            at[axis] = 0;
        }
    }
}

/// Returns how far the next number along each axis of a common shape is; 0 along an axis that repeats.
pub(super) fn steps(own: &[usize], rank: usize) -> Vec<usize> {
    let mut steps = vec![0; rank];
    let mut step = 1;
    for (to, side) in steps.iter_mut().rev().zip(own.iter().rev()) {
        *to = if *side == 1 { 0 } else { step };
        step *= side;
    }
    steps
}
