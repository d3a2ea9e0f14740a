//! Maps: from a file, and of what a robot has seen. They correct no pose.

mod file;
mod local;

pub use file::File;
pub use local::Local;

jde_schema::export!(
    "map",
    "Maps from files, and of what a robot has seen.",
    [File, Local]
);

#[cfg(test)]
mod tests;
