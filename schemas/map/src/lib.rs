//! Maps of what a robot has seen. They correct no pose and keep nothing of the places that the robot has left.

mod local;

pub use local::Local;

jde_schema::export!("map", "Maps of what a robot has seen.", [Local]);

#[cfg(test)]
mod tests;
