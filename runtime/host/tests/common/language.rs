//! The language of the schemas of a test.

use std::cell::Cell;

use jde_abi::raw;
use jde_loader::LoadedPlugin;

use super::Executor;
use super::schemas::TEST;
use super::{foreign, plugins, python};

/// A language in which the schemas of the tests exist.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Language {
    Rust,
    C,
    Cpp,
    /// In processes of their own.
    Python,
}

thread_local! {
    static OF_TEST: Cell<Language> = const { Cell::new(Language::Rust) };
}

impl Language {
    /// The language of the test that this thread runs.
    pub(crate) fn of_test() -> Self {
        OF_TEST.get()
    }

    /// Runs a test with the schemas in this language.
    pub(crate) fn run(self, executor: Executor, test: fn(Executor)) {
        struct Restore;
        impl Drop for Restore {
            fn drop(&mut self) {
                OF_TEST.set(Language::Rust);
            }
        }
        OF_TEST.set(self);
        let _restore = Restore;
        test(executor);
    }

    /// The plugin of the tests in this language. One in Python is a file.
    pub(crate) fn plugin(self) -> &'static raw::Plugin {
        match self {
            Self::Rust | Self::Python => &TEST,
            Self::C => foreign::in_c(),
            Self::Cpp => foreign::in_cpp(),
        }
    }

    /// The plugin of the tests in this language, as a build to reload.
    pub(crate) fn build(self) -> LoadedPlugin {
        match self {
            Self::Python => plugins().open(python::file()).expect("it is a plugin"),
            _ => LoadedPlugin::linked_in(self.plugin()).expect("its tables are valid"),
        }
    }

    /// The line of an application that states a type of the tests, in this language.
    pub(crate) fn type_line(self, line: &str) -> String {
        match self {
            Self::Python => python::type_line(line),
            _ => line.to_owned(),
        }
    }

    /// How many of the ends of instances a scenario records. No function of a schema in Python ends it.
    pub(crate) fn ends(self, number: usize) -> usize {
        if self == Self::Python { 0 } else { number }
    }

    /// Whether a fault has this reason: a panic, in C++ a `std::logic_error` and in Python an exception, with this text.
    /// In Rust its place precedes the text, and in Python it follows.
    pub(crate) fn is_panic(self, reason: &str, call: &str, text: &str) -> bool {
        let Some(reason) = reason.strip_prefix(&format!("panicked in {call}: ")) else {
            return self == Self::Python && reason.starts_with(&format!("fixture.Panic: {text}\n"));
        };
        match self {
            Self::Rust => reason.starts_with("panicked at ") && reason.ends_with(text),
            _ => reason == text,
        }
    }

    /// Whether a fault has this reason: an error with this text. In Python its place follows.
    pub(crate) fn is_error(self, reason: &str, text: &str) -> bool {
        match self {
            Self::Python => reason.starts_with(&format!("fixture.Failure: {text}\n")),
            _ => reason == text,
        }
    }
}
