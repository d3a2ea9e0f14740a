//! People in the scans of a laser near the floor: segments that look like legs (Arras, Mozos, Burgard, "Using boosted
//! features for the detection of people in 2D range data", ICRA 2007), and tracks of persons with one or two of them
//! (after Leigh, Pineau, Olmedo, Zhang, "Person tracking and following with 2D laser scanners", ICRA 2015).
//!
//! The crate has no clock, reads no port and starts no thread. Numbers of legs and persons are bounded, and its
//! buffers are used again. Units are metres, seconds and radians; axes follow ROS REP-103.

mod assignment;
mod coefficients;
mod detector;
mod features;
mod kalman;
mod model;
mod segments;
mod track;
mod tracker;

pub use detector::{Detector, DetectorSettings, Leg, MOST_LEGS};
pub use features::{FEATURES, Features};
pub use model::{Stump, confidence};
pub use segments::{Hit, Segment, Segments};
pub use tracker::{MOST_PERSONS, Person, Tracker, TrackerSettings};
