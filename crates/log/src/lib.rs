//! Recordings: the variables and decisions of a run in MCAP files that describe themselves by ROS 2 definitions, so that
//! Foxglove, Rerun, PlotJuggler and ROS 2 read them as they are.
//!
//! A robot never waits for a recording: what cannot be kept is counted and said. Knows no schema and decides nothing.

pub mod cdr;
pub mod definition;
