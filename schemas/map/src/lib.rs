//! Maps: from a file, and of what a robot has seen. They correct no pose.

mod file;
mod local;

pub use file::File;
pub use local::Local;

/// The most cells along a side of a square map.
const MAX_SIDE: u32 = 960;
/// The most cells of a map, as many as the exported type has room for.
const MAX_CELLS: usize = (MAX_SIDE * MAX_SIDE) as usize;

jde_schema::export!(
    "map",
    "Maps from files, and of what a robot has seen.",
    [File, Local]
);

#[cfg(test)]
mod tests;
