//! Shared by the tests of running applications: schemas whose behaviour the test defines, a stage that
//! records what they did, and one way to run an application on each executor. Tests wait for conditions,
//! never for a time.

#![allow(dead_code, reason = "each test file uses its part")]

pub(crate) mod c;
mod easel;
mod io;
mod rig;
mod schemas;
mod stage;

#[allow(unused_imports, reason = "each test file uses its part")]
pub(crate) use easel::Easel;
#[allow(unused_imports, reason = "each test file uses its part")]
pub(crate) use io::{Call, Io};
#[allow(unused_imports, reason = "each test file uses its part")]
pub(crate) use rig::{Executor, Rig, TEST, plugins, plugins_along, text};
#[allow(unused_imports, reason = "each test file uses its part")]
pub(crate) use schemas::{LIVE, Motor};
pub(crate) use stage::Stage;

pub(crate) const MS: u64 = 1_000_000;

/// Creates a test of each function for every executor.
#[allow(unused_macros, reason = "each test file uses its part")]
macro_rules! on_every_executor {
    ($($name:ident),+ $(,)?) => {
        mod threads { $(#[test] fn $name() { super::$name(crate::common::Executor::Threads); })+ }
        mod pool { $(#[test] fn $name() { super::$name(crate::common::Executor::Pool); })+ }
        mod lockstep { $(#[test] fn $name() { super::$name(crate::common::Executor::Lockstep); })+ }
    };
}

/// Creates a test of each function for the executors in which calls take time.
#[allow(unused_macros, reason = "each test file uses its part")]
macro_rules! in_real_time {
    ($($name:ident),+ $(,)?) => {
        mod threads { $(#[test] fn $name() { super::$name(crate::common::Executor::Threads); })+ }
        mod pool { $(#[test] fn $name() { super::$name(crate::common::Executor::Pool); })+ }
    };
}

#[allow(unused_imports, reason = "each test file uses its part")]
pub(crate) use {in_real_time, on_every_executor};
