//! Shared types: their layout, the geometry of poses, and contents that other programs send.

mod geometry;
mod layout;
mod measured;
mod ros;
