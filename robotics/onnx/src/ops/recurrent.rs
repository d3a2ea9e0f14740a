//! Recurrent layers: RNN, GRU and LSTM in one direction, with the usual functions. The gates of a file are in ONNX's
//! order, which is not that of PyTorch; whoever exports changes it.

use super::elementwise::sigmoid;
use super::matrix::dot;
use super::{Arity, FUNCTION, Inputs, Operator};
use crate::attributes::Attributes;
use crate::tensor::Tensor;

/// A kind of layer.
#[derive(Clone, Copy, PartialEq)]
enum Layer {
    Rnn,
    /// Whether the reset gate multiplies the product of the state instead of the state.
    Gru {
        is_linear_before_reset: bool,
    },
    Lstm,
}

/// Compiles an operator of this family.
pub(super) fn compile(
    name: &str,
    attributes: &Attributes<'_>,
    _: i64,
) -> Result<Option<(Arity, Operator)>, String> {
    let layer = match name {
        "RNN" => Layer::Rnn,
        "GRU" => Layer::Gru {
            is_linear_before_reset: attributes.integer("linear_before_reset", 0)? != 0,
        },
        "LSTM" => Layer::Lstm,
        _ => return Ok(None),
    };
    let direction = attributes.text("direction", "forward")?;
    if direction != "forward" {
        return Err(format!(
            "`direction` is `{direction}`, and only `forward` is run: a policy knows no future"
        ));
    }
    attributes.only("layout", 0, "the first dimension is time")?;
    if attributes.stated_float("clip")?.is_some() {
        return Err("`clip` is not run".to_owned());
    }
    if layer == Layer::Lstm {
        attributes.only("input_forget", 0, "the gates are separate")?;
    }
    let usual: &[&str] = match layer {
        Layer::Rnn => &["Tanh"],
        Layer::Gru { .. } => &["Sigmoid", "Tanh"],
        Layer::Lstm => &["Sigmoid", "Tanh", "Tanh"],
    };
    if let Some(stated) = attributes.texts("activations")?
        && !stated
            .iter()
            .map(|name| name.to_lowercase())
            .eq(usual.iter().map(|name| name.to_lowercase()))
    {
        return Err(format!(
            "`activations` are {stated:?}, and only {usual:?} are run"
        ));
    }
    let hidden = attributes.stated("hidden_size")?;
    let (most_inputs, most_outputs) = if layer == Layer::Lstm { (8, 3) } else { (6, 2) };
    let operator: Operator = Box::new(move |inputs, outputs| run(layer, hidden, inputs, outputs));
    Ok(Some(((most_inputs, most_outputs), operator)))
}

/// The weights of one layer.
struct Weights<'a> {
    w: &'a [f32],
    r: &'a [f32],
    /// The biases of the input, and those of the state.
    biases: Option<(&'a [f32], &'a [f32])>,
    width: usize,
    hidden: usize,
}

impl Weights<'_> {
    /// The input's part of a gate's unit.
    fn input(&self, unit: usize, x: &[f32]) -> f32 {
        dot(&self.w[unit * self.width..][..self.width], x) + self.biases.map_or(0.0, |(own, _)| own[unit])
    }

    /// The state's part of a gate's unit.
    fn state(&self, unit: usize, h: &[f32]) -> f32 {
        dot(&self.r[unit * self.hidden..][..self.hidden], h)
            + self.biases.map_or(0.0, |(_, state)| state[unit])
    }

    fn sum(&self, unit: usize, x: &[f32], h: &[f32]) -> f32 {
        self.input(unit, x) + self.state(unit, h)
    }
}

fn run(layer: Layer, stated: Option<i64>, inputs: &Inputs<'_>, outputs: &mut [Tensor]) -> Result<(), String> {
    let gates: usize = match layer {
        Layer::Rnn => 1,
        Layer::Gru { .. } => 3,
        Layer::Lstm => 4,
    };
    let (x, w, r) = (inputs.get(0)?, inputs.get(1)?, inputs.get(2)?);
    let (&[times, batch, width], &[1, _, hidden]) = (x.shape.as_slice(), r.shape.as_slice()) else {
        return Err(format!(
            "it takes times, a batch and numbers, not {:?} with {:?}",
            x.shape, r.shape
        ));
    };
    // A matrix without rows may state any width.
    let units = gates.saturating_mul(hidden);
    let fits = w.shape == [1, units, width] && r.shape == [1, units, hidden];
    if !fits || stated.is_some_and(|stated| stated != hidden as i64) {
        return Err(format!("the weights {:?} and {:?} do not fit", w.shape, r.shape));
    }
    if inputs.optional(4).is_some() || inputs.optional(7).is_some() {
        return Err("lengths of sequences and peepholes are not run".to_owned());
    }
    let biases = match inputs.optional(3) {
        Some(bias) if bias.shape == [1, units.saturating_mul(2)] => Some(bias.floats()?.split_at(units)),
        Some(bias) => return Err(format!("its bias has the shape {:?}", bias.shape)),
        None => None,
    };
    let each = gates.saturating_mul(width.saturating_add(hidden).saturating_add(FUNCTION));
    let all = outputs[0].room(&[times, 1, batch, hidden], each)?;
    let start = |index| match inputs.optional(index) {
        Some(state) if state.shape == [1, batch, hidden] => Ok(state.floats()?.to_vec()),
        Some(state) => Err(format!(
            "its state has the shape {:?}, not {:?}",
            state.shape,
            [1, batch, hidden]
        )),
        None => Ok(vec![0.0; batch * hidden]),
    };
    let weights = Weights {
        w: w.floats()?,
        r: r.floats()?,
        biases,
        width,
        hidden,
    };
    let mut h = start(5)?;
    let mut c = if layer == Layer::Lstm {
        start(6)?
    } else {
        Vec::new()
    };
    let numbers = x.floats()?;
    let mut next = vec![0.0; hidden];
    for (row, to) in all.chunks_exact_mut(hidden.max(1)).enumerate() {
        let one = row % batch;
        let x = &numbers[row * width..][..width];
        let (own, cell) = (
            &mut h[one * hidden..][..hidden],
            c.get_mut(one * hidden..(one + 1) * hidden),
        );
        match (layer, cell) {
            (Layer::Lstm, Some(cell)) => lstm(&weights, x, own, cell, &mut next),
            (
                Layer::Gru {
                    is_linear_before_reset,
                },
                _,
            ) => gru(&weights, x, own, is_linear_before_reset, &mut next),
            (Layer::Rnn | Layer::Lstm, _) => {
                next.iter_mut()
                    .enumerate()
                    .for_each(|(unit, to)| *to = libm::tanhf(weights.sum(unit, x, own)));
            }
        }
        own.copy_from_slice(&next);
        to.copy_from_slice(&next);
    }
    for (output, last) in outputs[1..].iter_mut().zip([h, c]) {
        output.room(&[1, batch, hidden], 1)?.copy_from_slice(&last);
    }
    Ok(())
}

/// The gates are update, reset and hidden.
fn gru(weights: &Weights<'_>, x: &[f32], h: &[f32], is_linear_before_reset: bool, next: &mut [f32]) {
    let hidden = weights.hidden;
    let gate = |unit| sigmoid(weights.sum(unit, x, h));
    let reset: Vec<f32> = (0..hidden).map(|unit| gate(hidden + unit)).collect();
    let reset_state: Vec<f32> = reset.iter().zip(h).map(|(reset, h)| reset * h).collect();
    for (unit, to) in next.iter_mut().enumerate() {
        let update = gate(unit);
        let at = 2 * hidden + unit;
        let state = match is_linear_before_reset {
            true => reset[unit] * weights.state(at, h),
            false => weights.state(at, &reset_state),
        };
        *to = (1.0 - update) * libm::tanhf(weights.input(at, x) + state) + update * h[unit];
    }
}

/// The gates are input, output, forget and cell.
fn lstm(weights: &Weights<'_>, x: &[f32], h: &[f32], cell: &mut [f32], next: &mut [f32]) {
    let hidden = weights.hidden;
    let sum = |gate: usize, unit: usize| weights.sum(gate * hidden + unit, x, h);
    for (unit, to) in next.iter_mut().enumerate() {
        let (input, output, forget) = (
            sigmoid(sum(0, unit)),
            sigmoid(sum(1, unit)),
            sigmoid(sum(2, unit)),
        );
        cell[unit] = forget * cell[unit] + input * libm::tanhf(sum(3, unit));
        *to = output * libm::tanhf(cell[unit]);
    }
}
