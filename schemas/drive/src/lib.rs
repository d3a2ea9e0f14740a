//! Local control of a base among what a laser sees: to a target, along a path, along a wall, along a line on
//! the floor, or nowhere in particular. The schemas know no robot, no map and no other schema: the base is a
//! footprint with limits.
//!
//! Each checks its command before it acts: the footprint stays clear of every laser point until the base
//! stands still. They see nothing behind a laser that looks ahead, so none of them drives backward, except
//! `dwa` and `mppi` over what they remember to be free.

mod body;
mod dwa;
mod line;
mod mppi;
mod path;
mod ports;
mod track;
mod vfh;
mod wall;
mod wander;

pub use dwa::Dwa;
pub use line::Line;
pub use mppi::Mppi;
pub use path::Path;
pub use vfh::Vfh;
pub use wall::Wall;
pub use wander::Wander;

jde_schema::export!(
    "drive",
    "Drives to a target, along a path, a wall or a line, or nowhere in particular.",
    [Dwa, Line, Mppi, Path, Vfh, Wall, Wander]
);

#[cfg(test)]
mod bench;
