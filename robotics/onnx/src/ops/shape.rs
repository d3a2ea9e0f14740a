//! What moves numbers and computes none: shapes, parts, orders.

use super::elementwise::{broadcast, steps};
use super::{Arity, Compiled, Inputs, Operator, PLACE, around, axes, axis};
use crate::attributes::Attributes;
use crate::tensor::{Data, Tensor};

/// The most inputs of a concatenation, and outputs of a split.
const MAX_TENSORS: usize = 64;

/// Compiles an operator of this family.
pub(super) fn compile(
    name: &str,
    attributes: &Attributes<'_>,
    opset: i64,
) -> Result<Option<(Arity, Operator)>, String> {
    Ok(Some(match name {
        "Constant" => ((0, 1), constant(attributes)?),
        "ConstantOfShape" => ((1, 1), filled(attributes)?),
        "Shape" => {
            let (start, end) = (attributes.integer("start", 0)?, attributes.stated("end")?);
            ((1, 1), shape_of(start, end))
        }
        "Reshape" => {
            let zero_is_zero = attributes.integer("allowzero", 0)? != 0;
            (
                (2, 1),
                Box::new(move |inputs, outputs| {
                    let input = inputs.get(0)?;
                    let shape = reshaped(&input.shape, inputs.get(1)?.whole()?, zero_is_zero)?;
                    outputs[0].copy_from(input, &shape)
                }),
            )
        }
        "Flatten" => {
            let at = attributes.integer("axis", 1)?;
            (
                (1, 1),
                Box::new(move |inputs, outputs| {
                    let input = inputs.get(0)?;
                    let rank = input.shape.len();
                    let at = if at == rank as i64 { rank } else { axis(at, rank)? };
                    let sides = [
                        input.shape[..at].iter().product(),
                        input.shape[at..].iter().product(),
                    ];
                    outputs[0].copy_from(input, &sides)
                }),
            )
        }
        "Squeeze" => by_axes(attributes, opset, squeezed)?,
        "Unsqueeze" => by_axes(attributes, opset, unsqueezed)?,
        "Transpose" => {
            let order = attributes.integers("perm")?.map(<[i64]>::to_vec);
            (
                (1, 1),
                Box::new(move |inputs, outputs| transpose(inputs.get(0)?, order.as_deref(), &mut outputs[0])),
            )
        }
        "Concat" => {
            let at = attributes.stated("axis")?.ok_or("it states no `axis`")?;
            (
                (MAX_TENSORS, 1),
                Box::new(move |inputs, outputs| concat(inputs, at, &mut outputs[0])),
            )
        }
        "Slice" => ((5, 1), slices(attributes, opset)?),
        "Split" => ((2, MAX_TENSORS), split(attributes, opset)?),
        "Gather" => {
            let at = attributes.integer("axis", 0)?;
            (
                (2, 1),
                Box::new(move |inputs, outputs| gather(inputs.get(0)?, inputs.get(1)?, at, &mut outputs[0])),
            )
        }
        "Expand" => (
            (2, 1),
            Box::new(|inputs, outputs| {
                let input = inputs.get(0)?;
                let shape = broadcast(&input.shape, &sides(inputs.get(1)?.whole()?)?)?;
                let steps = steps(&input.shape, shape.len());
                pick(
                    input,
                    &shape,
                    0,
                    &steps.iter().map(|step| *step as isize).collect::<Vec<_>>(),
                    &mut outputs[0],
                )
            }),
        ),
        _ => return Ok(None),
    }))
}

fn constant(attributes: &Attributes<'_>) -> Compiled {
    let one = |number| Tensor::new(Vec::new(), Data::Float(vec![number]));
    let whole = |number| Tensor::new(Vec::new(), Data::Integer(vec![number]));
    let row = |numbers: &[f32]| Tensor::new(vec![numbers.len()], Data::Float(numbers.to_vec()));
    let stated = [
        attributes.tensor("value")?,
        attributes.stated_float("value_float")?.map(one),
        attributes.floats("value_floats")?.map(row),
        attributes.stated("value_int")?.map(whole),
        attributes
            .integers("value_ints")?
            .map(|numbers| Tensor::integers(numbers.to_vec())),
    ];
    let value = stated
        .into_iter()
        .flatten()
        .next()
        .ok_or("it states no value that is run")?;
    if let Data::Float(numbers) = &value.data
        && !numbers.iter().all(|number| number.is_finite())
    {
        return Err("its value must be finite".to_owned());
    }
    Ok(Box::new(move |_, outputs| {
        outputs[0].copy_from(&value, &value.shape)
    }))
}

fn filled(attributes: &Attributes<'_>) -> Compiled {
    let zero = || Tensor::new(vec![1], Data::Float(vec![0.0]));
    let value = attributes.tensor("value")?.unwrap_or_else(zero);
    Ok(Box::new(move |inputs, outputs| {
        let shape = sides(inputs.get(0)?.whole()?)?;
        let zero = vec![0; shape.len()];
        pick(&value, &shape, 0, &zero, &mut outputs[0])
    }))
}

fn shape_of(start: i64, end: Option<i64>) -> Operator {
    Box::new(move |inputs, outputs| {
        let shape = &inputs.get(0)?.shape;
        let rank = shape.len() as i64;
        let place = |stated: i64| if stated < 0 { stated + rank } else { stated }.clamp(0, rank) as usize;
        let (start, end) = (place(start), place(end.unwrap_or(rank)));
        let sides = shape.get(start..end).unwrap_or_default();
        outputs[0] = Tensor::integers(sides.iter().map(|side| *side as i64).collect());
        Ok(())
    })
}

fn sides(stated: &[i64]) -> Result<Vec<usize>, String> {
    let sides: Option<Vec<usize>> = stated.iter().map(|side| usize::try_from(*side).ok()).collect();
    sides.ok_or_else(|| format!("{stated:?} is no shape"))
}

/// Returns a stated shape, in which 0 is the same as before and -1 what is left.
fn reshaped(from: &[usize], stated: &[i64], zero_is_zero: bool) -> Result<Vec<usize>, String> {
    let wrong = || format!("{from:?} cannot have the shape {stated:?}");
    let mut shape = Vec::new();
    let mut open = None;
    for (at, side) in stated.iter().enumerate() {
        shape.push(match side {
            -1 if open.is_none() => {
                open = Some(at);
                1
            }
            0 if !zero_is_zero => *from.get(at).ok_or_else(wrong)?,
            side => usize::try_from(*side).map_err(|_| wrong())?,
        });
    }
    let whole = from.iter().product::<usize>();
    let known = shape
        .iter()
        .try_fold(1_usize, |known, side| known.checked_mul(*side));
    let known = known.ok_or_else(wrong)?;
    if let Some(at) = open {
        if known == 0 || whole % known != 0 {
            return Err(wrong());
        }
        shape[at] = whole / known;
    }
    Ok(shape)
}

/// Returns a shape with other axes.
type Change = fn(&[usize], Option<&[i64]>) -> Result<Vec<usize>, String>;

/// Changes a shape by axes, which are an attribute up to opset 12 and an input since.
fn by_axes(attributes: &Attributes<'_>, opset: i64, change: Change) -> Result<(Arity, Operator), String> {
    let stated = if opset < 13 {
        attributes.integers("axes")?.map(<[i64]>::to_vec)
    } else {
        None
    };
    let operator: Operator = Box::new(move |inputs, outputs| {
        let input = inputs.get(0)?;
        let given = inputs.optional(1).map(Tensor::whole).transpose()?;
        let shape = change(&input.shape, stated.as_deref().or(given))?;
        outputs[0].copy_from(input, &shape)
    });
    Ok(((if opset < 13 { 1 } else { 2 }, 1), operator))
}

fn squeezed(shape: &[usize], stated: Option<&[i64]>) -> Result<Vec<usize>, String> {
    let removed = match stated {
        Some(stated) => axes(stated, shape.len())?,
        None => (0..shape.len()).filter(|axis| shape[*axis] == 1).collect(),
    };
    match removed.iter().all(|axis| shape[*axis] == 1) {
        true => Ok((0..shape.len())
            .filter(|axis| !removed.contains(axis))
            .map(|axis| shape[axis])
            .collect()),
        false => Err(format!("an axis of {shape:?} that it removes is not 1")),
    }
}

fn unsqueezed(shape: &[usize], stated: Option<&[i64]>) -> Result<Vec<usize>, String> {
    let stated = stated.ok_or("it states no axes")?;
    let mut result = shape.to_vec();
    for axis in axes(stated, shape.len() + stated.len())? {
        result.insert(axis.min(result.len()), 1);
    }
    Ok(result)
}

fn transpose(input: &Tensor, order: Option<&[i64]>, to: &mut Tensor) -> Result<(), String> {
    let rank = input.shape.len();
    let order = match order {
        None => (0..rank).rev().collect(),
        Some(order) if axes(order, rank)?.len() == rank => order
            .iter()
            .map(|stated| axis(*stated, rank))
            .collect::<Result<Vec<_>, _>>()?,
        Some(order) => return Err(format!("`perm` {order:?} is not of {rank} axes")),
    };
    let own = strides(&input.shape);
    let shape: Vec<usize> = order.iter().map(|axis| input.shape[*axis]).collect();
    let steps: Vec<isize> = order.iter().map(|axis| own[*axis] as isize).collect();
    pick(input, &shape, 0, &steps, to)
}

/// Returns how far the next number along each axis is.
fn strides(shape: &[usize]) -> Vec<usize> {
    let mut strides = vec![1; shape.len()];
    for axis in (1..shape.len()).rev() {
        strides[axis - 1] = strides[axis] * shape[axis];
    }
    strides
}

/// Takes the numbers of a shape, from a first one on, in steps along each axis.
fn pick(
    from: &Tensor,
    shape: &[usize],
    first: usize,
    steps: &[isize],
    to: &mut Tensor,
) -> Result<(), String> {
    let mut at = vec![0; shape.len()];
    let mut place = first as isize;
    let places = core::iter::from_fn(move || {
        let taken = place;
        for axis in (0..at.len()).rev() {
            at[axis] += 1;
            place += steps[axis];
            if at[axis] < shape[axis] {
                break;
            }
            place -= at[axis] as isize * steps[axis];
            at[axis] = 0;
        }
        Some(taken as usize)
    });
    match &from.data {
        Data::Float(numbers) => to
            .room(shape, PLACE)?
            .iter_mut()
            .zip(places)
            .for_each(|(to, place)| *to = numbers[place]),
        Data::Integer(numbers) => to.put_whole(shape, places.map(|place| numbers[place]))?,
    }
    Ok(())
}

fn concat(inputs: &Inputs<'_>, at: i64, to: &mut Tensor) -> Result<(), String> {
    let first = inputs.get(0)?;
    let at = axis(at, first.shape.len())?;
    let parts = (0..inputs.len())
        .map(|index| inputs.get(index))
        .collect::<Result<Vec<_>, _>>()?;
    let mut shape = first.shape.clone();
    shape[at] = 0;
    for part in &parts {
        let fits = part.shape.len() == shape.len()
            && (0..shape.len()).all(|axis| axis == at || part.shape[axis] == shape[axis]);
        if !fits {
            return Err(format!(
                "the shapes {:?} and {:?} do not fit",
                first.shape, part.shape
            ));
        }
        shape[at] += part.shape[at];
    }
    if let Data::Integer(_) = first.data {
        let wholes = parts
            .iter()
            .map(|part| part.whole())
            .collect::<Result<Vec<_>, _>>()?;
        if shape.len() != 1 {
            return Err("whole numbers are joined in a row only".to_owned());
        }
        *to = Tensor::integers(wholes.concat());
        return Ok(());
    }
    let (before, ..) = around(&shape, at);
    let room = to.room(&shape, 1)?;
    let mut written = 0;
    for outer in 0..before {
        for part in &parts {
            let numbers = part.floats()?;
            let length = numbers.len() / before;
            room[written..][..length].copy_from_slice(&numbers[outer * length..][..length]);
            written += length;
        }
    }
    Ok(())
}

/// Up to opset 9, what is taken is stated by attributes.
fn slices(attributes: &Attributes<'_>, opset: i64) -> Compiled {
    if opset < 10 {
        let list = |name| Ok::<_, String>(attributes.integers(name)?.map(<[i64]>::to_vec));
        let starts = list("starts")?.ok_or("it states no `starts`")?;
        let (ends, along) = (list("ends")?.ok_or("it states no `ends`")?, list("axes")?);
        return Ok(Box::new(move |inputs, outputs| {
            slice(
                inputs.get(0)?,
                &starts,
                &ends,
                along.as_deref(),
                None,
                &mut outputs[0],
            )
        }));
    }
    Ok(Box::new(|inputs, outputs| {
        let list = |index| inputs.optional(index).map(Tensor::whole).transpose();
        let (starts, ends) = (inputs.get(1)?.whole()?, inputs.get(2)?.whole()?);
        slice(inputs.get(0)?, starts, ends, list(3)?, list(4)?, &mut outputs[0])
    }))
}

fn slice(
    input: &Tensor,
    starts: &[i64],
    ends: &[i64],
    along: Option<&[i64]>,
    by: Option<&[i64]>,
    to: &mut Tensor,
) -> Result<(), String> {
    let rank = input.shape.len();
    let given = along.map_or(starts.len(), <[i64]>::len);
    if starts.len() != ends.len()
        || given != starts.len()
        || by.is_some_and(|by| by.len() != starts.len())
        || given > rank
    {
        return Err("its starts, ends, axes and steps do not fit".to_owned());
    }
    let own = strides(&input.shape);
    let mut shape = input.shape.clone();
    let mut steps: Vec<isize> = own.iter().map(|step| *step as isize).collect();
    let mut first = 0;
    for index in 0..starts.len() {
        let at = axis(along.map_or(index as i64, |along| along[index]), rank)?;
        let (side, step) = (input.shape[at] as i64, by.map_or(1, |by| by[index]));
        let (least, most) = if step < 0 { (-1, side - 1) } else { (0, side) };
        let place = |stated: i64| {
            if stated < 0 {
                stated.saturating_add(side)
            } else {
                stated
            }
        };
        let start = place(starts[index]).clamp(0, most.max(0));
        let end = place(ends[index]).clamp(least, most.max(least));
        let length = match step {
            0 => return Err("a step of it is 0".to_owned()),
            1.. => (end - start).max(0).div_euclid(step) + i64::from((end - start).max(0) % step != 0),
            _ => {
                let step = step.checked_neg().ok_or("a step of it is too large")?;
                (start - end).max(0) / step + i64::from((start - end).max(0) % step != 0)
            }
        };
        shape[at] = length as usize;
        first += start as usize * own[at];
        steps[at] = (step as isize).saturating_mul(own[at] as isize);
        if length <= 1 {
            steps[at] = 0;
        }
    }
    pick(input, &shape, first, &steps, to)
}

fn split(attributes: &Attributes<'_>, opset: i64) -> Compiled {
    let at = attributes.integer("axis", 0)?;
    let stated = if opset < 13 {
        attributes.integers("split")?.map(<[i64]>::to_vec)
    } else {
        None
    };
    let parts = if opset < 18 {
        None
    } else {
        attributes.stated("num_outputs")?
    };
    Ok(Box::new(move |inputs, outputs| {
        let input = inputs.get(0)?;
        let at = axis(at, input.shape.len())?;
        let (side, many) = (input.shape[at], outputs.len());
        let given = inputs.optional(1).map(Tensor::whole).transpose()?;
        let lengths = match stated.as_deref().or(given) {
            Some(stated) => sides(stated)?,
            None if parts.is_some_and(|parts| parts != many as i64) => {
                return Err(format!(
                    "it has {many} outputs, and `num_outputs` is another number"
                ));
            }
            // The last part is shorter if they are not equal, which only newer versions permit.
            None if side % many == 0 || parts.is_some() => {
                let length = side.div_ceil(many);
                (0..many)
                    .map(|part| side.saturating_sub(part * length).min(length))
                    .collect()
            }
            None => return Err(format!("{side} cannot be split into {many} equal parts")),
        };
        if lengths.len() != many
            || lengths
                .iter()
                .try_fold(0_usize, |sum, part| sum.checked_add(*part))
                != Some(side)
        {
            return Err(format!("the parts {lengths:?} are not the {side} of its input"));
        }
        let mut start = 0;
        for (to, length) in outputs.iter_mut().zip(lengths) {
            let (start_at, end) = (start as i64, (start + length) as i64);
            slice(input, &[start_at], &[end], Some(&[at as i64]), None, to)?;
            start += length;
        }
        Ok(())
    }))
}

fn gather(input: &Tensor, indices: &Tensor, at: i64, to: &mut Tensor) -> Result<(), String> {
    let at = axis(at, input.shape.len())?;
    let (before, side, after) = around(&input.shape, at);
    let places = indices
        .whole()?
        .iter()
        .map(|index| axis(*index, side))
        .collect::<Result<Vec<_>, _>>()?;
    let shape = [&input.shape[..at], &indices.shape, &input.shape[at + 1..]].concat();
    let all = (0..before).flat_map(|outer| places.iter().map(move |place| (outer * side + place) * after));
    match &input.data {
        Data::Float(numbers) => {
            let room = to.room(&shape, 1)?;
            if after > 0 {
                room.chunks_exact_mut(after)
                    .zip(all)
                    .for_each(|(to, start)| to.copy_from_slice(&numbers[start..][..after]));
            }
        }
        Data::Integer(numbers) => {
            let taken = all.flat_map(|start| numbers[start..][..after].iter().copied());
            to.put_whole(&shape, taken)?;
        }
    }
    Ok(())
}
