//! Changes of the world that are written to a robot's driver. A refused one is reported and has no effect.

use jde_schema::prelude::*;
use jde_sim::{Edits, RobotId, World};

use crate::Robot;
use crate::worlds::RobotClaim;

/// The changes of a world that a driver was requested to make.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/EditCount")]
pub struct EditCount {
    /// How many were made.
    pub done: u64,
    /// How many were refused. A text with faults counts as one.
    pub refused: u64,
    /// Why the last one was refused; empty if none was.
    pub note: Text<252>,
}

/// What a driver has taken from its modulation.
#[derive(Clone, Copy, Default)]
pub(crate) struct EditProgress {
    /// The sequence number of the last value.
    sequence: u64,
    /// The number of the last edit that had one.
    number: u64,
    count: EditCount,
}

impl EditProgress {
    fn refuse(&mut self, cx: &Context, reason: &str) {
        self.count.refused += 1;
        self.count.note = Text::truncated(reason);
        warn!(cx, "the world stays as it is: {reason}");
    }
}

impl Robot {
    /// Makes the changes of a new value of the modulation. Returns the count of all so far.
    pub(crate) fn edit(&self, cx: &Context, world: &mut World, claim: &RobotClaim) -> EditCount {
        let robot = claim.robot();
        let mut all = claim.edits();
        let progress = all.entry(robot).or_default();
        let value = self.edit.sample(cx);
        if progress.sequence != value.sequence() {
            progress.sequence = value.sequence();
            match Edits::parse(value.as_str()) {
                Ok(edits) => take(cx, world, robot, progress, &edits),
                Err(error) => progress.refuse(cx, &error.to_string()),
            }
        }
        progress.count
    }
}

fn take(cx: &Context, world: &mut World, robot: RobotId, progress: &mut EditProgress, edits: &Edits) {
    for (index, edit) in (0..).zip(&edits.edits) {
        if let Some(first) = edits.number {
            // A writer repeats edits that the driver may not have read.
            if first + index <= progress.number {
                continue;
            }
            progress.number = first + index;
        }
        match world.edit(robot, edit) {
            Ok(()) => progress.count.done += 1,
            Err(error) => progress.refuse(cx, &error.to_string()),
        }
    }
}

#[cfg(test)]
mod tests;
