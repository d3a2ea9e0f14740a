//! Shared by the tests of running applications: schemas whose behaviour the test defines, a scenario that
//! records what they did, and a way to run an application on each executor. Tests wait for conditions, never
//! for a time.

#![allow(dead_code, reason = "each test program uses only some of it")]

pub(crate) mod c;
mod foreign;
mod io;
mod panel_motor;
mod scenario;
mod schemas;
mod test_app;

#[allow(unused_imports, reason = "each test program uses only some of it")]
pub(crate) use io::{Call, Io};
#[allow(unused_imports, reason = "each test program uses only some of it")]
pub(crate) use panel_motor::PanelMotor;
pub(crate) use scenario::Scenario;
#[allow(unused_imports, reason = "each test program uses only some of it")]
pub(crate) use schemas::{LIVE, Motor};
#[allow(unused_imports, reason = "each test program uses only some of it")]
pub(crate) use test_app::{Executor, IN_CPP, TEST, TestApp, plugins, plugins_with, text};

pub(crate) const MS: u64 = 1_000_000;

/// Creates a test of each function for every executor.
#[allow(unused_macros, reason = "each test program uses only some of it")]
macro_rules! on_every_executor {
    ($($name:ident),+ $(,)?) => {
        mod threads { $(#[test] fn $name() { super::$name(crate::common::Executor::Threads); })+ }
        mod pool { $(#[test] fn $name() { super::$name(crate::common::Executor::Pool); })+ }
        mod lockstep { $(#[test] fn $name() { super::$name(crate::common::Executor::Lockstep); })+ }
    };
}

/// Creates a test of each function for the executors in which calls take time.
#[allow(unused_macros, reason = "each test program uses only some of it")]
macro_rules! in_real_time {
    ($($name:ident),+ $(,)?) => {
        mod threads { $(#[test] fn $name() { super::$name(crate::common::Executor::Threads); })+ }
        mod pool { $(#[test] fn $name() { super::$name(crate::common::Executor::Pool); })+ }
    };
}

#[allow(unused_imports, reason = "each test program uses only some of it")]
pub(crate) use {in_real_time, on_every_executor};
