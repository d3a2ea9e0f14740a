//! The messages of an ONNX file (<https://onnx.ai/onnx/repo-docs/IR.html>) as they are written. It judges only what no
//! reader can overlook.

use crate::OnnxError;
use crate::wire::{Fields, Malformed, Wire};

/// A file's network.
#[derive(Debug, Default)]
pub(crate) struct Model {
    /// The version of each set of operators.
    pub(crate) opsets: Vec<(String, i64)>,
    pub(crate) nodes: Vec<Node>,
    pub(crate) weights: Vec<Stored>,
    pub(crate) inputs: Vec<Declared>,
    pub(crate) outputs: Vec<Declared>,
    has_graph: bool,
}

/// A node as it is written.
#[derive(Clone, Debug, Default)]
pub(crate) struct Node {
    pub(crate) name: String,
    pub(crate) operator: String,
    pub(crate) domain: String,
    /// The values that it takes; an empty name is none.
    pub(crate) inputs: Vec<String>,
    pub(crate) outputs: Vec<String>,
    pub(crate) attributes: Vec<Attribute>,
}

/// An attribute as it is written.
#[derive(Clone, Debug, Default)]
pub(crate) struct Attribute {
    pub(crate) name: String,
    pub(crate) kind: i64,
    pub(crate) float: f32,
    pub(crate) integer: i64,
    pub(crate) text: Vec<u8>,
    pub(crate) tensor: Option<Stored>,
    pub(crate) floats: Vec<f32>,
    pub(crate) integers: Vec<i64>,
    pub(crate) texts: Vec<Vec<u8>>,
}

/// Stored numbers.
#[derive(Clone, Debug, Default)]
pub(crate) struct Stored {
    pub(crate) name: String,
    pub(crate) shape: Vec<i64>,
    pub(crate) data_type: i64,
    pub(crate) floats: Vec<f32>,
    pub(crate) integers: Vec<i64>,
    pub(crate) raw: Option<Vec<u8>>,
    /// Where they are, if in another file.
    pub(crate) external: Vec<(String, String)>,
    pub(crate) is_external: bool,
    /// Whether it has a part that is not read.
    pub(crate) is_segment: bool,
}

/// An input or an output of the network. A dimension without a number is `None`.
#[derive(Clone, Debug, Default)]
pub(crate) struct Declared {
    pub(crate) name: String,
    pub(crate) data_type: i64,
    pub(crate) shape: Option<Vec<Option<i64>>>,
}

type Read<T> = Result<T, OnnxError>;

impl Model {
    /// Reads a file.
    pub(crate) fn parse(bytes: &[u8]) -> Read<Self> {
        let mut model = Self::default();
        for field in Fields(bytes) {
            match field? {
                (7, graph) => model.graph(graph.bytes()?)?,
                (8, opset) => {
                    let (mut domain, mut version) = (String::new(), 0);
                    for field in Fields(opset.bytes()?) {
                        match field? {
                            (1, text) => domain = text.text()?,
                            (2, number) => version = number.integer()?,
                            _ => {}
                        }
                    }
                    model.opsets.push((domain, version));
                }
                (25, _) => {
                    return Err(OnnxError::Model(
                        "the file has functions of its own, which are not run: export it without them, or inline \
                         them with onnx.inliner.inline_local_functions"
                            .to_owned(),
                    ));
                }
                _ => {}
            }
        }
        match model.has_graph {
            true => Ok(model),
            false => Err(OnnxError::Model(
                "the file has no network; is it an ONNX file?".to_owned(),
            )),
        }
    }

    fn graph(&mut self, bytes: &[u8]) -> Read<()> {
        self.has_graph = true;
        for field in Fields(bytes) {
            match field? {
                (1, node) => self.nodes.push(Node::read(node.bytes()?)?),
                (5, weights) => self.weights.push(Stored::read(weights.bytes()?)?),
                (11, input) => self.inputs.push(Declared::read(input.bytes()?)?),
                (12, output) => self.outputs.push(Declared::read(output.bytes()?)?),
                (15, _) => {
                    return Err(OnnxError::Model(
                        "the file has sparse weights, which are not run: store them as dense ones".to_owned(),
                    ));
                }
                _ => {}
            }
        }
        Ok(())
    }
}

impl Node {
    fn read(bytes: &[u8]) -> Read<Self> {
        let mut node = Self::default();
        for field in Fields(bytes) {
            match field? {
                (1, text) => node.inputs.push(text.text()?),
                (2, text) => node.outputs.push(text.text()?),
                (3, text) => node.name = text.text()?,
                (4, text) => node.operator = text.text()?,
                (5, attribute) => node.attributes.push(Attribute::read(attribute.bytes()?)?),
                (7, text) => node.domain = text.text()?,
                _ => {}
            }
        }
        if node.name.is_empty() {
            node.name = node.outputs.first().cloned().unwrap_or_default();
        }
        Ok(node)
    }

    /// Says what is wrong with the node.
    pub(crate) fn wrong(&self, message: impl Into<String>) -> OnnxError {
        OnnxError::Node {
            node: self.name.clone(),
            operator: self.operator.clone(),
            message: message.into(),
        }
    }
}

impl Attribute {
    fn read(bytes: &[u8]) -> Read<Self> {
        let mut read = Self::default();
        for field in Fields(bytes) {
            match field? {
                (1, text) => read.name = text.text()?,
                (2, number) => read.float = number.float()?,
                (3, number) => read.integer = number.integer()?,
                (4, text) => read.text = text.bytes()?.to_vec(),
                (5, tensor) => read.tensor = Some(Stored::read(tensor.bytes()?)?),
                (7, numbers) => numbers.floats(&mut read.floats)?,
                (8, numbers) => numbers.integers(&mut read.integers)?,
                (9, text) => read.texts.push(text.bytes()?.to_vec()),
                (20, kind) => read.kind = kind.integer()?,
                _ => {}
            }
        }
        Ok(read)
    }
}

impl Stored {
    fn read(bytes: &[u8]) -> Read<Self> {
        let mut read = Self::default();
        for field in Fields(bytes) {
            match field? {
                (1, numbers) => numbers.integers(&mut read.shape)?,
                (2, number) => read.data_type = number.integer()?,
                (3, _) => read.is_segment = true,
                (4, numbers) => numbers.floats(&mut read.floats)?,
                (5 | 7, numbers) => numbers.integers(&mut read.integers)?,
                (8, text) => read.name = text.text()?,
                (9, raw) => read.raw = Some(raw.bytes()?.to_vec()),
                (13, entry) => read.external.push(entry_of(entry)?),
                (14, place) => read.is_external = place.integer()? != 0,
                _ => {}
            }
        }
        Ok(read)
    }
}

fn entry_of(entry: Wire<'_>) -> Result<(String, String), Malformed> {
    let (mut key, mut value) = (String::new(), String::new());
    for field in Fields(entry.bytes()?) {
        match field? {
            (1, text) => key = text.text()?,
            (2, text) => value = text.text()?,
            _ => {}
        }
    }
    Ok((key, value))
}

impl Declared {
    fn read(bytes: &[u8]) -> Read<Self> {
        let mut read = Self::default();
        for field in Fields(bytes) {
            match field? {
                (1, text) => read.name = text.text()?,
                (2, kind) => read.kind(kind.bytes()?)?,
                _ => {}
            }
        }
        Ok(read)
    }

    /// Reads the type, if it is a tensor; `data_type` stays 0 for any other.
    fn kind(&mut self, bytes: &[u8]) -> Result<(), Malformed> {
        for field in Fields(bytes) {
            let (1, tensor) = field? else { continue };
            for field in Fields(tensor.bytes()?) {
                match field? {
                    (1, number) => self.data_type = number.integer()?,
                    (2, shape) => self.shape = Some(shape_of(shape.bytes()?)?),
                    _ => {}
                }
            }
        }
        Ok(())
    }
}

fn shape_of(bytes: &[u8]) -> Result<Vec<Option<i64>>, Malformed> {
    let mut shape = Vec::new();
    for field in Fields(bytes) {
        let (1, dimension) = field? else { continue };
        let mut number = None;
        for field in Fields(dimension.bytes()?) {
            if let (1, stated) = field? {
                number = Some(stated.integer()?);
            }
        }
        shape.push(number);
    }
    Ok(shape)
}
