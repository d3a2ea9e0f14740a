//! The simulator: what its world, its robots and their sensors do.

mod bumpers;
mod cameras;
mod faults;
mod loose;
mod maps;
mod motion;
mod movers;
mod mutants;
mod rays;
mod robots;
mod sensors;
mod wheels;
mod worlds;
