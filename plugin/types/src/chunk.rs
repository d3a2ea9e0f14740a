//! Future commands of a base, and the one of them that came due.

use crate::{Padding, Seq, Twist, Value};

/// Future commands of a base, made of what was seen at one instant: the time of the value. It is no command. A motor schema
/// that imports it gives each of its commands when it comes due.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/Chunk")]
pub struct Chunk {
    /// From one command to the next. The first is due at the time of the value; the last is meant for as long as the others.
    #[value(unit = "s")]
    pub spacing: f64,
    /// How sure its maker is, from 0 (not at all) to 1.
    pub certainty: f64,
    /// The weight of each chunk in a blend, as a share of the weight of the chunk before it.
    pub blend: f64,
    /// How many chunks before it its commands are blended with; 0 if it replaces them.
    pub blended: u32,
    /// Unused bytes.
    pub padding: Padding<4>,
    /// The commands, in the order in which they come due.
    pub commands: Seq<Twist, 128>,
}

/// A command of a chunk that came due.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/ChunkStep")]
pub struct ChunkStep {
    /// The number of the chunk among those of its maker.
    pub chunk: u64,
    /// How long before this step it was seen what the chunk is made of.
    #[value(unit = "s")]
    pub age: f64,
    /// The place of the command in the chunk, from 1.
    pub step: u32,
    /// How many commands the chunk has.
    pub steps: u32,
    /// How many chunks before it have a share in the command.
    pub blended: u32,
    /// Unused bytes.
    pub padding: Padding<4>,
    /// The command, as it was given: before limits and the judgement of guards.
    pub command: Twist,
}
