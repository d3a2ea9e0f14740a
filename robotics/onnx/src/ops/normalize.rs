//! Softmax, and normalisations by statistics.

use super::elementwise::greater;
use super::{Arity, FUNCTION, Operator, PLACE, around, axis};
use crate::attributes::Attributes;
use crate::tensor::Tensor;

/// Compiles an operator of this family.
pub(super) fn compile(
    name: &str,
    attributes: &Attributes<'_>,
    opset: i64,
) -> Result<Option<(Arity, Operator)>, String> {
    Ok(Some(match name {
        "Softmax" | "LogSoftmax" => {
            let is_log = name == "LogSoftmax";
            // Up to opset 12 all dimensions from the axis on are one.
            let joins = opset < 13;
            let at = attributes.integer("axis", if joins { 1 } else { -1 })?;
            (
                (1, 1),
                Box::new(move |inputs, outputs| softmax(inputs.get(0)?, at, joins, is_log, &mut outputs[0])),
            )
        }
        "LayerNormalization" => {
            attributes.only("stash_type", 1, "sums have 32 bits")?;
            let (at, epsilon) = (
                attributes.integer("axis", -1)?,
                attributes.float("epsilon", 1e-5)?,
            );
            (
                (3, 1),
                Box::new(move |inputs, outputs| {
                    layer(
                        inputs.get(0)?,
                        inputs.get(1)?,
                        inputs.optional(2),
                        at,
                        epsilon,
                        &mut outputs[0],
                    )
                }),
            )
        }
        "BatchNormalization" => {
            attributes.ignore(&["momentum"]);
            attributes.only("training_mode", 0, "export the network for inference")?;
            let epsilon = attributes.float("epsilon", 1e-5)?;
            (
                (5, 1),
                Box::new(move |inputs, outputs| {
                    let statistics = [inputs.get(1)?, inputs.get(2)?, inputs.get(3)?, inputs.get(4)?];
                    batch(inputs.get(0)?, statistics, epsilon, &mut outputs[0])
                }),
            )
        }
        _ => return Ok(None),
    }))
}

fn softmax(input: &Tensor, at: i64, joins: bool, is_log: bool, to: &mut Tensor) -> Result<(), String> {
    let rank = input.shape.len();
    let at = if joins && at == rank as i64 {
        return Err("its axis is beyond the dimensions".to_owned());
    } else {
        axis(at, rank)?
    };
    let (before, mut side, mut after) = around(&input.shape, at);
    if joins {
        (side, after) = (side * after, 1);
    }
    let numbers = input.floats()?;
    let room = to.room(&input.shape, 2 * FUNCTION)?;
    for outer in 0..before {
        for inner in 0..after {
            let place = |index: usize| (outer * side + index) * after + inner;
            let most = (0..side)
                .map(|index| numbers[place(index)])
                .fold(f32::NEG_INFINITY, greater);
            let mut sum = 0.0;
            for index in 0..side {
                let raised = libm::expf(numbers[place(index)] - most);
                room[place(index)] = raised;
                sum += raised;
            }
            for index in 0..side {
                let to = &mut room[place(index)];
                *to = if is_log {
                    numbers[place(index)] - most - libm::logf(sum)
                } else {
                    *to / sum
                };
            }
        }
    }
    Ok(())
}

fn layer(
    input: &Tensor,
    scale: &Tensor,
    bias: Option<&Tensor>,
    at: i64,
    epsilon: f32,
    to: &mut Tensor,
) -> Result<(), String> {
    let at = axis(at, input.shape.len())?;
    let own = &input.shape[at..];
    let length = own.iter().product::<usize>();
    let fits = |tensor: &Tensor| tensor.shape == own;
    if !fits(scale) || !bias.is_none_or(fits) || length == 0 {
        return Err(format!("its scale and bias must have the shape {own:?}"));
    }
    let (numbers, scale) = (input.floats()?, scale.floats()?);
    let bias = bias.map(Tensor::floats).transpose()?;
    let room = to.room(&input.shape, PLACE)?;
    for (to, row) in room.chunks_exact_mut(length).zip(numbers.chunks_exact(length)) {
        let mean = row.iter().sum::<f32>() / length as f32;
        let variance = row.iter().map(|x| (x - mean) * (x - mean)).sum::<f32>() / length as f32;
        let factor = 1.0 / (variance + epsilon).sqrt();
        for (index, (to, x)) in to.iter_mut().zip(row).enumerate() {
            *to = (x - mean) * factor * scale[index] + bias.map_or(0.0, |bias| bias[index]);
        }
    }
    Ok(())
}

fn batch(input: &Tensor, statistics: [&Tensor; 4], epsilon: f32, to: &mut Tensor) -> Result<(), String> {
    let &[rows, channels, ..] = input.shape.as_slice() else {
        return Err("it takes at least two dimensions".to_owned());
    };
    if statistics.iter().any(|tensor| tensor.shape != [channels]) {
        return Err(format!("its statistics must have the shape {:?}", [channels]));
    }
    let [scale, bias, mean, variance] = statistics;
    let (scale, bias, mean, variance) = (
        scale.floats()?,
        bias.floats()?,
        mean.floats()?,
        variance.floats()?,
    );
    let length = input.shape[2..].iter().product::<usize>();
    let numbers = input.floats()?;
    let room = to.room(&input.shape, PLACE)?;
    for row in 0..rows {
        for channel in 0..channels {
            let factor = scale[channel] / (variance[channel] + epsilon).sqrt();
            let start = (row * channels + channel) * length;
            for (to, x) in room[start..][..length]
                .iter_mut()
                .zip(&numbers[start..][..length])
            {
                *to = (x - mean[channel]) * factor + bias[channel];
            }
        }
    }
    Ok(())
}
