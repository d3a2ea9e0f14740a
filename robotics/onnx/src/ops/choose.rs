//! Choices by numbers that depend on the inputs: which one is the highest, and what is at chosen places. A number that is
//! NaN has no place among the others, so nothing is chosen then.

use super::{Arity, Operator, PLACE, around, axis};
use crate::MAX_OPERATIONS;
use crate::attributes::Attributes;
use crate::tensor::{Data, Tensor};

/// Compiles an operator of this family.
pub(super) fn compile(
    name: &str,
    attributes: &Attributes<'_>,
    opset: i64,
) -> Result<Option<(Arity, Operator)>, String> {
    Ok(Some(match name {
        "ArgMax" => {
            let at = attributes.integer("axis", 0)?;
            let keeps = attributes.integer("keepdims", 1)? != 0;
            let takes_last = opset >= 12 && attributes.integer("select_last_index", 0)? != 0;
            (
                (1, 1),
                Box::new(move |inputs, outputs| {
                    highest(
                        inputs.get(0)?,
                        at,
                        (keeps, takes_last),
                        inputs.is_trial,
                        &mut outputs[0],
                    )
                }),
            )
        }
        "GatherElements" => {
            let at = attributes.integer("axis", 0)?;
            (
                (2, 1),
                Box::new(move |inputs, outputs| gather(inputs.get(0)?, inputs.get(1)?, at, &mut outputs[0])),
            )
        }
        _ => return Ok(None),
    }))
}

/// Finds the place of the highest number along an axis, among equal ones the first or the last.
fn highest(
    input: &Tensor,
    at: i64,
    (keeps, takes_last): (bool, bool),
    is_trial: bool,
    to: &mut Tensor,
) -> Result<(), String> {
    let at = axis(at, input.shape.len())?;
    let (before, side, after) = around(&input.shape, at);
    if side == 0 {
        return Err("it chooses among no numbers".to_owned());
    }
    let numbers = input.floats()?;
    // Each of them is compared, however few are chosen.
    let operations = (numbers.len() as u64).saturating_mul(PLACE as u64);
    if operations > MAX_OPERATIONS {
        return Err(format!(
            "its input of the shape {:?} takes {operations} operations, and {MAX_OPERATIONS} are the most of a network",
            input.shape
        ));
    }
    let mut shape = input.shape.clone();
    match keeps {
        true => shape[at] = 1,
        false => drop(shape.remove(at)),
    }
    // Zeros of a trial say nothing of the numbers that come.
    if let Some(place) = numbers.iter().position(|number| number.is_nan())
        && !is_trial
    {
        return Err(format!(
            "number {place} of its input is NaN, so none is the highest"
        ));
    }
    let places = (0..before).flat_map(|outer| (0..after).map(move |inner| (outer, inner)));
    to.put_whole(
        &shape,
        places.map(|(outer, inner)| {
            let number = |index: usize| numbers[(outer * side + index) * after + inner];
            let exceeds = |index: usize, best: usize| match takes_last {
                true => number(index) >= number(best),
                false => number(index) > number(best),
            };
            (1..side).fold(0, |best, index| if exceeds(index, best) { index } else { best }) as i64
        }),
    )?;
    to.operations = operations;
    Ok(())
}

/// Takes from each row along an axis the number at a place of its own.
fn gather(input: &Tensor, indices: &Tensor, at: i64, to: &mut Tensor) -> Result<(), String> {
    let rank = input.shape.len();
    let at = axis(at, rank)?;
    let fits = indices.shape.len() == rank
        && (0..rank).all(|axis| axis == at || indices.shape[axis] <= input.shape[axis]);
    if !fits {
        return Err(format!(
            "places of the shape {:?} do not fit numbers of the shape {:?}",
            indices.shape, input.shape
        ));
    }
    let side = input.shape[at];
    let places = indices.whole()?.iter().enumerate().map(|(index, place)| {
        let (mut rest, mut step, mut from) = (index, 1, 0);
        for along in (0..rank).rev() {
            let own = rest % indices.shape[along];
            rest /= indices.shape[along];
            from += step * if along == at { axis(*place, side)? } else { own };
            step *= input.shape[along];
        }
        Ok::<usize, String>(from)
    });
    match &input.data {
        Data::Float(numbers) => {
            let room = to.room(&indices.shape, PLACE)?;
            for (to, place) in room.iter_mut().zip(places) {
                *to = numbers[place?];
            }
            Ok(())
        }
        Data::Integer(numbers) => {
            let taken = places.map(|place| place.map(|place| numbers[place]));
            let taken = taken.collect::<Result<Vec<_>, _>>()?;
            to.put_whole(&indices.shape, taken.into_iter())
        }
    }
}
