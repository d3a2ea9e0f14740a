//! From the messages of a file to steps. Every node runs once with zeros, which computes all shapes; what depends on
//! weights and shapes alone keeps its numbers and is no step. Shapes depend on no number of an input: whole numbers that do
//! are choices, and nothing but what moves them, adds to them or takes numbers at their places has them.

use std::collections::HashMap;

use crate::external::Beside;
use crate::model::{Declared, Model, Node};
use crate::network::{Network, Port};
use crate::ops::{self, Operator};
use crate::tensor::{Data, TYPE_FLOAT, TYPE_INT64, Tensor, refusal};
use crate::{MAX_BYTES, MAX_OPERATIONS, OPSET_VERSIONS, OnnxError};

/// What may have whole numbers that depend on the inputs, as its first input.
const MOVES: [&str; 9] = [
    "Cast",
    "Expand",
    "Flatten",
    "Identity",
    "Reshape",
    "Slice",
    "Squeeze",
    "Transpose",
    "Unsqueeze",
];

/// A node that runs.
pub(crate) struct NodeStep {
    pub(crate) node: String,
    pub(crate) name: String,
    pub(crate) operator: Operator,
    /// The values that it takes; `None` for an optional one that is left out.
    pub(crate) inputs: Vec<Option<usize>>,
    pub(crate) outputs: Vec<usize>,
    /// As many as outputs, empty between runs.
    pub(crate) room: Vec<Tensor>,
}

/// Values by name, and which of them no input changes.
#[derive(Default)]
struct Values {
    names: HashMap<String, usize>,
    tensors: Vec<Tensor>,
    is_constant: Vec<bool>,
    /// For each value that is places which an `ArgMax` chose: among how many.
    chosen_among: Vec<Option<usize>>,
    bytes: usize,
    operations: u64,
}

impl Values {
    fn add(&mut self, name: &str, tensor: Tensor, is_constant: bool) -> Result<usize, OnnxError> {
        let index = self.tensors.len();
        if !name.is_empty() && self.names.insert(name.to_owned(), index).is_some() {
            return Err(OnnxError::tensor(name, "two things have this name"));
        }
        self.tensors.push(tensor);
        self.is_constant.push(is_constant);
        self.chosen_among.push(None);
        Ok(index)
    }

    /// Counts numbers, all of which stay in memory, and what their computation takes.
    fn hold(&mut self, shape: &[usize], operations: u64) -> Result<(), String> {
        let numbers = shape.iter().fold(1_usize, |all, side| all.saturating_mul(*side));
        self.bytes = self.bytes.saturating_add(numbers.saturating_mul(8));
        self.operations = self.operations.saturating_add(operations);
        if self.bytes as u64 > 4 * MAX_BYTES {
            return Err("its numbers and those before it need too much memory".to_owned());
        }
        match self.operations <= MAX_OPERATIONS {
            true => Ok(()),
            false => Err(format!(
                "it and the nodes before it take {} operations, and {MAX_OPERATIONS} are the most of a network",
                self.operations
            )),
        }
    }

    /// Whether a value is whole numbers that depend on the inputs.
    fn is_choice(&self, index: usize) -> bool {
        !self.is_constant[index] && matches!(self.tensors[index].data, Data::Integer(_))
    }

    /// Refuses choices where a node would take them for a shape.
    fn check_choices(&self, node: &Node, inputs: &[Option<usize>]) -> Result<(), OnnxError> {
        let is_choice = |input: &Option<usize>| input.is_some_and(|index| self.is_choice(index));
        let places = inputs.iter().enumerate().filter(|(_, input)| is_choice(input));
        for (place, _) in places {
            let operator = node.operator.as_str();
            let fits = match operator {
                "Add" | "Sub" | "Mul" | "Shape" => true,
                "GatherElements" => place == 1,
                _ => place == 0 && MOVES.contains(&operator),
            };
            if !fits {
                let message = format!(
                    "its input {place} is whole numbers that depend on the inputs, as an ArgMax gives, which is not run"
                );
                return Err(node.wrong(message));
            }
        }
        Ok(())
    }

    /// Returns among how many the numbers of a node's output are chosen.
    fn among(&self, node: &Node, step: &NodeStep) -> Option<usize> {
        let first = step.inputs.first().copied().flatten()?;
        match node.operator.as_str() {
            "ArgMax" => {
                let sides = |index: usize| self.tensors[index].shape.iter().product::<usize>();
                sides(first).checked_div(sides(step.outputs[0]))
            }
            "Cast" | "Flatten" | "Identity" | "Reshape" | "Squeeze" | "Unsqueeze" => self.chosen_among[first],
            _ => None,
        }
    }
}

/// Builds the network.
pub(crate) fn build(model: &Model, beside: &mut Beside<'_>) -> Result<Network, OnnxError> {
    let opset = opset(model)?;
    let mut values = Values::default();
    for stored in &model.weights {
        let raw = beside.bytes(stored)?;
        let tensor = stored.tensor(raw)?;
        values.add(&stored.name, tensor, true)?;
    }
    let mut inputs = Vec::new();
    // Files of long ago declare weights as inputs too.
    for declared in &model.inputs {
        if !values.names.contains_key(&declared.name) {
            let port = declared.port()?;
            let wrong = |message: String| OnnxError::tensor(&port.name, message);
            values.hold(&port.shape, 0).map_err(wrong)?;
            let zeros = Tensor::zeros(port.shape.clone()).map_err(wrong)?;
            let index = values.add(&port.name, zeros, false)?;
            inputs.push((port, index));
        }
    }
    let mut steps = Vec::new();
    for node in &model.nodes {
        let mut step = prepare(node, opset, &mut values)?;
        values.check_choices(node, &step.inputs)?;
        step.run(&mut values.tensors, true)?;
        for output in step.outputs.clone() {
            let (shape, operations) = (
                values.tensors[output].shape.clone(),
                values.tensors[output].operations,
            );
            let held = values.hold(&shape, operations);
            held.map_err(|message| node.wrong(message))?;
        }
        let takes_inputs = |input: &Option<usize>| input.is_some_and(|index| !values.is_constant[index]);
        if node.operator == "Shape" || !step.inputs.iter().any(takes_inputs) {
            step.outputs
                .iter()
                .for_each(|output| values.is_constant[*output] = true);
            continue;
        }
        let is_whole = |output: &usize| values.is_choice(*output);
        if node.operator == "Cast"
            && step.outputs.iter().any(is_whole)
            && !step.inputs.iter().flatten().any(is_whole)
        {
            return Err(
                node.wrong("it makes whole numbers of others that depend on the inputs, which is not run")
            );
        }
        values.chosen_among[step.outputs[0]] = values.among(node, &step);
        steps.push(step);
    }
    let outputs = model
        .outputs
        .iter()
        .map(|declared| output(declared, &mut values, &mut steps));
    let outputs = outputs.collect::<Result<Vec<_>, _>>()?;
    if outputs.is_empty() {
        return Err(OnnxError::Model("the network has no output".to_owned()));
    }
    Ok(Network::new(inputs, outputs, steps, values.tensors))
}

/// Returns the version of ONNX's own operators.
fn opset(model: &Model) -> Result<i64, OnnxError> {
    let mut own = model.opsets.iter().filter(|(domain, _)| is_own(domain));
    let (least, most) = (OPSET_VERSIONS.start(), OPSET_VERSIONS.end());
    match own.next() {
        None => Err(OnnxError::Model(
            "the file states no version of ONNX's operators (opset_import)".to_owned(),
        )),
        Some((_, version)) if OPSET_VERSIONS.contains(version) => Ok(*version),
        Some((_, version)) => Err(OnnxError::Model(format!(
            "the network has opset {version}, and {least} to {most} are run: export it with opset_version=17, or convert \
             it with onnx.version_converter"
        ))),
    }
}

fn is_own(domain: &str) -> bool {
    matches!(domain, "" | "ai.onnx")
}

fn prepare(node: &Node, opset: i64, values: &mut Values) -> Result<NodeStep, OnnxError> {
    if !is_own(&node.domain) {
        let message = format!(
            "operators of `{}` are not run; export the network with ONNX's own",
            node.domain
        );
        return Err(node.wrong(message));
    }
    let operator = ops::compile(node, opset).map_err(|message| node.wrong(message))?;
    let find = |name: &String| match name.as_str() {
        "" => Ok(None),
        name => match values.names.get(name) {
            Some(index) => Ok(Some(*index)),
            None => Err(node.wrong(format!(
                "it takes `{name}`, which no input, weight or node before it gives"
            ))),
        },
    };
    let inputs = node.inputs.iter().map(find).collect::<Result<Vec<_>, _>>()?;
    let outputs = node
        .outputs
        .iter()
        .map(|name| values.add(name, Tensor::default(), false));
    let outputs = outputs.collect::<Result<Vec<_>, _>>()?;
    Ok(NodeStep {
        node: node.name.clone(),
        name: node.operator.clone(),
        operator,
        inputs,
        room: vec![Tensor::default(); outputs.len()],
        outputs,
    })
}

impl Declared {
    fn port(&self) -> Result<Port, OnnxError> {
        let wrong = |message: String| OnnxError::tensor(&self.name, message);
        if self.data_type != TYPE_FLOAT {
            return Err(wrong(refusal(self.data_type)));
        }
        let stated = self
            .shape
            .as_ref()
            .ok_or_else(|| wrong("this input states no shape".to_owned()))?;
        let side = |(at, side): (usize, &Option<i64>)| match side {
            Some(side) => usize::try_from(*side).map_err(|_| wrong(format!("its dimension {at} is {side}"))),
            None if at + 1 < stated.len() => Ok(1),
            None => Err(wrong(
                "its last dimension has no number; export the network with a fixed one".to_owned(),
            )),
        };
        Ok(Port {
            name: self.name.clone(),
            shape: stated.iter().enumerate().map(side).collect::<Result<_, _>>()?,
            chosen_among: None,
        })
    }
}

/// Returns an output with its value. Choices become numbers of 32 bits, as all that a network gives.
fn output(
    declared: &Declared,
    values: &mut Values,
    steps: &mut Vec<NodeStep>,
) -> Result<(Port, usize), OnnxError> {
    let wrong = |message: String| OnnxError::tensor(&declared.name, message);
    let index = values.names.get(&declared.name);
    let mut index = *index.ok_or_else(|| wrong("no node gives this output".to_owned()))?;
    let chosen_among = values.chosen_among[index];
    let is_choice = chosen_among.is_some() && values.is_choice(index);
    let expected = if is_choice { TYPE_INT64 } else { TYPE_FLOAT };
    if declared.data_type != expected || !is_choice && matches!(values.tensors[index].data, Data::Integer(_))
    {
        return Err(wrong(refusal(declared.data_type)));
    }
    if is_choice {
        let given = values.add("", Tensor::default(), false)?;
        let mut step = NodeStep {
            node: declared.name.clone(),
            name: "Cast".to_owned(),
            operator: ops::as_floats(),
            inputs: vec![Some(index)],
            outputs: vec![given],
            room: vec![Tensor::default()],
        };
        step.run(&mut values.tensors, true)?;
        steps.push(step);
        index = given;
    }
    let shape = &values.tensors[index].shape;
    if let Some(stated) = &declared.shape {
        let fits =
            |(stated, side): (&Option<i64>, &usize)| stated.is_none_or(|stated| stated == *side as i64);
        if stated.len() != shape.len() || !stated.iter().zip(shape).all(fits) {
            return Err(wrong(format!(
                "the file states the shape {stated:?}, and it has {shape:?}"
            )));
        }
    }
    let port = Port {
        name: declared.name.clone(),
        shape: shape.clone(),
        chosen_among: if is_choice { chosen_among } else { None },
    };
    Ok((port, index))
}
