//! Shared types: their layout, and the geometry of poses.

mod geometry;
mod layout;
