//! Learned policies: a network of an ONNX file decides, and the rules hold as for every schema. It learns nothing.

mod chunks;
mod estimate;
mod held;
mod mind;
mod onnx;
mod panel;
mod steps;

pub use chunks::Chunks;
pub use estimate::Estimate;
pub use onnx::Onnx;
pub use steps::Steps;

jde_schema::export!(
    "policy",
    "Decides by the network of an ONNX file.",
    [Onnx, Estimate, Chunks, Steps]
);

#[cfg(test)]
mod tests;
