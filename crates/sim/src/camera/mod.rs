//! Cameras.

mod light;

pub(crate) use light::Light;
