//! The hot paths of jde, for repeated runs: the benches time them, and the gate of `cargo xtask test` counts
//! their instructions. This crate measures nothing itself.

mod guarded;
mod level;
mod periods;
mod words;

pub use guarded::{BEAMS, Base, Drive, SPEED, Watch, surroundings};
pub use level::Level;
pub use periods::Periods;
pub use words::{EXPORT, Words, ends, variable};
