//! The hot paths of jde, each to be passed so many times: by clocks, in the rows of the benches, and by counters of instructions, in
//! the gate of `cargo xtask test`. It measures nothing itself.

mod level;
mod periods;
mod words;

pub use level::Level;
pub use periods::Periods;
pub use words::{Words, ends, variable};
