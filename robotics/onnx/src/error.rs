//! Why a network does not run. Each message names the node or the tensor, and what to do.

/// Why a network does not run.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum OnnxError {
    /// A file cannot be read.
    #[error("{file}: {message}")]
    File {
        /// Its path, as it was given or stated.
        file: String,
        /// What is wrong.
        message: String,
    },
    /// The file as a whole is not a network that is run.
    #[error("{0}")]
    Model(String),
    /// A node is none that is run.
    #[error("node `{node}` ({operator}): {message}")]
    Node {
        /// The name of the node; that of its first output if it has none.
        node: String,
        /// Its operator.
        operator: String,
        /// What is wrong, and what to do.
        message: String,
    },
    /// Weights, an input or an output are none that are run.
    #[error("tensor `{tensor}`: {message}")]
    Tensor {
        /// Its name.
        tensor: String,
        /// What is wrong, and what to do.
        message: String,
    },
}

impl OnnxError {
    pub(crate) fn tensor(tensor: impl Into<String>, message: impl Into<String>) -> Self {
        Self::Tensor {
            tensor: tensor.into(),
            message: message.into(),
        }
    }

    pub(crate) fn file(file: impl Into<String>, message: impl Into<String>) -> Self {
        Self::File {
            file: file.into(),
            message: message.into(),
        }
    }
}
