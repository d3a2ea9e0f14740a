//! A network that is ready to run: its inputs, its outputs, and one run.

use std::collections::BTreeMap;
use std::path::Path;

use sha2::{Digest, Sha256};

use crate::external::Beside;
use crate::graph::{self, NodeStep};
use crate::model::Model;
use crate::ops::Inputs;
use crate::tensor::Tensor;
use crate::{MAX_BYTES, OnnxError};

/// An input or an output of a network.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Port {
    /// Its name.
    pub name: String,
    /// Its dimensions, the last fastest. A dimension that the file leaves open, such as that of a batch, is 1.
    pub shape: Vec<usize>,
    /// Of an output whose numbers are places that an `ArgMax` chose: among how many.
    pub chosen_among: Option<usize>,
}

/// A network that was checked, with its weights and the numbers of its last run.
///
/// After [`load`](Self::load) a run takes the same memory each time. The same inputs give the same outputs to the bit.
pub struct Network {
    pub(crate) inputs: Vec<(Port, usize)>,
    pub(crate) outputs: Vec<(Port, usize)>,
    pub(crate) steps: Vec<NodeStep>,
    pub(crate) values: Vec<Tensor>,
    hash: String,
}

impl Port {
    /// Returns how many numbers it has.
    #[must_use]
    pub fn count(&self) -> usize {
        self.shape.iter().product()
    }
}

impl Network {
    /// Reads the network of a file, and the weights beside it.
    ///
    /// # Errors
    /// A file cannot be read, or something in it is not run. Nothing is left out: the error names the node.
    pub fn load(path: &Path) -> Result<Self, OnnxError> {
        let bytes = jde_files::read(path, MAX_BYTES).map_err(|error| {
            OnnxError::file(path.display().to_string(), format!("it cannot be read: {error}"))
        })?;
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
        Self::parse(&bytes, Some(folder.unwrap_or(Path::new("."))))
    }

    /// Reads the network in these bytes. Weights in other files are below `folder`; without one they are refused.
    ///
    /// # Errors
    /// As of [`load`](Self::load).
    pub fn parse(bytes: &[u8], folder: Option<&Path>) -> Result<Self, OnnxError> {
        let model = Model::parse(bytes)?;
        let mut beside = Beside::new(folder);
        let mut network = graph::build(&model, &mut beside)?;
        let mut hash = Sha256::new();
        hash.update(bytes);
        for (name, bytes) in beside.files.into_iter().collect::<BTreeMap<_, _>>() {
            hash.update(name.as_bytes());
            hash.update(&bytes);
        }
        network.hash = hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect();
        Ok(network)
    }

    pub(crate) fn new(
        inputs: Vec<(Port, usize)>,
        outputs: Vec<(Port, usize)>,
        steps: Vec<NodeStep>,
        values: Vec<Tensor>,
    ) -> Self {
        Self {
            inputs,
            outputs,
            steps,
            values,
            hash: String::new(),
        }
    }

    /// Returns the inputs, in the file's order.
    pub fn inputs(&self) -> impl ExactSizeIterator<Item = &Port> {
        self.inputs.iter().map(|(port, _)| port)
    }

    /// Returns the outputs, in the file's order.
    pub fn outputs(&self) -> impl ExactSizeIterator<Item = &Port> {
        self.outputs.iter().map(|(port, _)| port)
    }

    /// Returns the SHA-256 of the file, and of the files beside it that it reads, in hexadecimal digits.
    #[must_use]
    pub fn hash(&self) -> &str {
        &self.hash
    }

    /// Returns the numbers of an input, which the next run takes. Before they are written they are zeros.
    ///
    /// # Panics
    /// If there are fewer inputs.
    pub fn input_mut(&mut self, index: usize) -> &mut [f32] {
        let (port, value) = &self.inputs[index];
        let numbers = self.values[*value].floats_mut();
        debug_assert_eq!(numbers.as_ref().map_or(0, |numbers| numbers.len()), port.count());
        numbers.expect("an input has numbers")
    }

    /// Returns the numbers of an output of the last run. They may be NaN or infinite.
    ///
    /// # Panics
    /// If there are fewer outputs.
    #[must_use]
    pub fn output(&self, index: usize) -> &[f32] {
        self.values[self.outputs[index].1]
            .floats()
            .expect("an output has numbers")
    }

    /// Computes the outputs from the inputs.
    ///
    /// # Errors
    /// NaN is among the numbers of which an `ArgMax` takes the highest, or whole numbers overflow; the error names the node.
    /// Shapes do not change after a network was loaded. The outputs are then undefined.
    pub fn run(&mut self) -> Result<(), OnnxError> {
        self.steps
            .iter_mut()
            .try_for_each(|step| step.run(&mut self.values, false))
    }
}

impl core::fmt::Debug for Network {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "Network({} nodes, {})", self.steps.len(), self.hash)
    }
}

impl NodeStep {
    /// Computes the node. A trial asks for shapes only.
    pub(crate) fn run(&mut self, values: &mut [Tensor], is_trial: bool) -> Result<(), OnnxError> {
        for (room, output) in self.room.iter_mut().zip(&self.outputs) {
            core::mem::swap(room, &mut values[*output]);
        }
        let inputs = Inputs::new(&self.inputs, values, is_trial);
        let ran = (self.operator)(&inputs, &mut self.room);
        for (room, output) in self.room.iter_mut().zip(&self.outputs) {
            core::mem::swap(room, &mut values[*output]);
        }
        ran.map_err(|message| OnnxError::Node {
            node: self.node.clone(),
            operator: self.name.clone(),
            message,
        })
    }
}
