//! Learned policies: a network of an ONNX file decides, and the rules hold as for every schema. It learns nothing.

mod estimate;
mod held;
mod mind;
mod onnx;
mod panel;

pub use estimate::Estimate;
pub use onnx::Onnx;

jde_schema::export!(
    "policy",
    "Decides by the network of an ONNX file.",
    [Onnx, Estimate]
);

#[cfg(test)]
mod tests;
