//! The C API for programs that run applications: `libjde.so`. `include/jde_run.h` is generated from [`tables`] and
//! from the functions of the other modules; docs/embedding.md explains it.
//!
//! A handle is a number that is never used twice, and no address: a call with a handle that is closed is an error in
//! words. No Rust type and no panic crosses.

#![allow(unsafe_code, reason = "the functions are C's, and take pointers")]
#![allow(
    clippy::missing_safety_doc,
    reason = "the head of the header states what holds for every pointer"
)]

pub mod application;
pub mod boundary;
mod executable;
mod handles;
pub mod operations;
pub mod run;
pub mod tables;
pub mod values;
