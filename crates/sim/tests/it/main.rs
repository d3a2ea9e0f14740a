//! The simulator: worlds, robots and sensors.

mod bumpers;
mod cameras;
pub mod checks;
mod depths;
mod edits;
mod faults;
mod floors;
mod footprints;
mod imports;
mod inertial;
mod kinematics;
mod line_sensors;
mod loose;
mod maps;
mod models;
mod motion;
mod movers;
mod mutants;
mod noise;
mod rays;
mod robots;
mod sensors;
mod stage_worlds;
mod tags;
mod wheels;
mod worlds;
