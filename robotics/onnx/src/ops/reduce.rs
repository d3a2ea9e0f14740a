//! Sums, means and extremes along axes.

use super::elementwise::{combine, greater};
use super::{Arity, FUNCTION, Operator, PLACE, axes};
use crate::attributes::Attributes;
use crate::tensor::Tensor;

/// How the numbers of one result are combined.
#[derive(Clone, Copy)]
struct Reduction {
    first: f32,
    add: fn(f32, f32) -> f32,
    finish: fn(f32, f32) -> f32,
}

/// Compiles an operator of this family.
pub(super) fn compile(
    name: &str,
    attributes: &Attributes<'_>,
    opset: i64,
) -> Result<Option<(Arity, Operator)>, String> {
    let sum: fn(f32, f32) -> f32 = |sum, number| sum + number;
    let result: fn(f32, f32) -> f32 = |sum, _| sum;
    let reduction = |first, add, finish| Reduction { first, add, finish };
    let most = reduction(f32::NEG_INFINITY, greater, result);
    let is_log = name == "ReduceLogSumExp";
    let reduction = match name {
        "ReduceSum" | "ReduceLogSumExp" => reduction(0.0, sum, result),
        "ReduceMean" => reduction(0.0, sum, |sum, count| sum / count),
        "ReduceSumSquare" => reduction(0.0, |sum, number| sum + number * number, result),
        "ReduceL2" => reduction(0.0, |sum, number| sum + number * number, |sum, _| sum.sqrt()),
        "ReduceMax" => most,
        "ReduceMin" => reduction(f32::INFINITY, |a, b| -greater(-a, -b), result),
        _ => return Ok(None),
    };
    // Since this version the axes are an input.
    let by_input = if name == "ReduceSum" { 13 } else { 18 };
    let keeps = attributes.integer("keepdims", 1)? != 0;
    let stated = if opset < by_input {
        attributes.integers("axes")?.map(<[i64]>::to_vec)
    } else {
        None
    };
    let nothing = opset >= by_input && attributes.integer("noop_with_empty_axes", 0)? != 0;
    let operator: Operator = Box::new(move |inputs, outputs| {
        let input = inputs.get(0)?;
        let given = inputs.optional(1).map(Tensor::whole).transpose()?;
        let along = stated.as_deref().or(given).filter(|axes| !axes.is_empty());
        if along.is_none() && nothing {
            return Err("it states no axes, and that it then does nothing: leave the node out".to_owned());
        }
        let along = match along {
            Some(along) => axes(along, input.shape.len())?,
            None => (0..input.shape.len()).collect(),
        };
        if !is_log {
            return reduce(input, &along, keeps, reduction, &mut outputs[0]);
        }
        // The exponentials of differences to the greatest number, of which none is too large.
        let (mut greatest, mut raised) = (Tensor::default(), Tensor::default());
        reduce(input, &along, true, most, &mut greatest)?;
        let raise = |number, most| libm::expf(number - shift(most));
        combine(input, &greatest, 2 * FUNCTION, &mut raised, raise)?;
        reduce(&raised, &along, keeps, reduction, &mut outputs[0])?;
        outputs[0].operations += greatest.operations + raised.operations;
        for (to, most) in outputs[0].floats_mut()?.iter_mut().zip(greatest.floats()?) {
            *to = libm::logf(*to) + shift(*most);
        }
        Ok(())
    });
    let most_inputs = if opset < by_input { 1 } else { 2 };
    Ok(Some(((most_inputs, 1), operator)))
}

/// What exponents are less by: nothing if the greatest number is infinite.
fn shift(most: f32) -> f32 {
    if most.is_infinite() { 0.0 } else { most }
}

fn reduce(
    input: &Tensor,
    along: &[usize],
    keeps: bool,
    by: Reduction,
    to: &mut Tensor,
) -> Result<(), String> {
    let kept: Vec<usize> = (0..input.shape.len())
        .map(|axis| {
            if along.contains(&axis) {
                1
            } else {
                input.shape[axis]
            }
        })
        .collect();
    let steps = super::elementwise::steps(&kept, kept.len());
    let numbers = input.floats()?;
    let count = along.iter().map(|axis| input.shape[*axis]).product::<usize>();
    if count == 0 {
        return Err("it combines no numbers".to_owned());
    }
    let room = to.room(&kept, count.saturating_mul(PLACE))?;
    room.fill(by.first);
    let mut at = vec![0; kept.len()];
    let mut place = 0;
    for number in numbers {
        room[place] = (by.add)(room[place], *number);
        for axis in (0..at.len()).rev() {
            at[axis] += 1;
            place += steps[axis];
            if at[axis] < input.shape[axis] {
                break;
            }
            place -= at[axis] * steps[axis];
            at[axis] = 0;
        }
    }
    room.iter_mut()
        .for_each(|to| *to = (by.finish)(*to, count as f32));
    if !keeps {
        to.shape = (0..kept.len())
            .filter(|axis| !along.contains(axis))
            .map(|axis| kept[axis])
            .collect();
    }
    Ok(())
}
