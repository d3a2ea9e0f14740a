//! Shared by the tests of running applications: schemas whose behaviour the test defines, a scenario that
//! records what they did, and a way to run an application on each executor. Tests wait for conditions, never
//! for a time.

#![allow(dead_code, reason = "each test program uses only some of it")]

pub(crate) mod c;
mod foreign;
mod in_rust;
mod io;
mod language;
pub(crate) mod python;
mod scenario;
mod schemas;
mod test_app;

#[allow(unused_imports, reason = "each test program uses only some of it")]
pub(crate) use io::{Call, Io};
#[allow(unused_imports, reason = "each test program uses only some of it")]
pub(crate) use language::Language;
pub(crate) use scenario::Scenario;
#[allow(unused_imports, reason = "each test program uses only some of it")]
pub(crate) use schemas::{LIVE, Mark, Motor, TEST};
#[allow(unused_imports, reason = "each test program uses only some of it")]
pub(crate) use test_app::{Executor, TestApp, plugins, plugins_with, text};

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

/// Creates a test of each function for the schemas in each of these languages. What such a function tests crosses the
/// boundary to the language of a schema; [`on_every_executor`] tests everything in Rust. A comment says why a language is
/// left out.
#[allow(unused_macros, reason = "each test program uses only some of it")]
macro_rules! in_languages {
    ($executor:ident, $languages:tt: $($name:ident),+ $(,)?) => {
        $(mod $name { crate::common::in_each_language!($executor, $name, $languages); })+
    };
}

#[allow(unused_macros, reason = "each test program uses only some of it")]
macro_rules! in_each_language {
    ($executor:ident, $name:ident, [$($language:ident)+]) => {
        $(crate::common::in_language!($executor, $name, $language);)+
    };
}

#[allow(unused_macros, reason = "each test program uses only some of it")]
macro_rules! in_language {
    ($executor:ident, $name:ident, Rust) => {
        #[test] fn rust() { crate::common::in_language!(@run $executor, $name, Rust) }
    };
    ($executor:ident, $name:ident, C) => {
        #[test] fn c() { crate::common::in_language!(@run $executor, $name, C) }
    };
    ($executor:ident, $name:ident, Cpp) => {
        #[test] fn cpp() { crate::common::in_language!(@run $executor, $name, Cpp) }
    };
    ($executor:ident, $name:ident, Python) => {
        #[test]
        #[ignore = "needs the package for Python: cargo xtask test --only python"]
        fn python() { crate::common::in_language!(@run $executor, $name, Python) }
    };
    (@run $executor:ident, $name:ident, $language:ident) => {
        crate::common::Language::$language.run(crate::common::Executor::$executor, super::$name)
    };
}

#[allow(unused_imports, reason = "each test program uses only some of it")]
pub(crate) use {in_each_language, in_language, in_languages, in_real_time, on_every_executor};
