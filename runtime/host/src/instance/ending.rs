//! How the calls of an instance end.

use jde_abi::raw;
use jde_core::Nanos;

/// The result of a check.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CheckResult {
    pub(crate) ready: bool,
    pub(crate) urgency: f64,
    /// Time of the newest value that the check read.
    pub(crate) newest: Nanos,
}

/// How an iteration ended that did not fail.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Iterated {
    Done,
    /// It could not act: an input has no value, in these words (R19). What it exported has ended.
    WithoutValue(String),
}

/// Returns the error of a call in words.
pub(super) fn call_result(what: &str, status: i32, failure: Option<String>) -> Result<(), String> {
    match (status, failure) {
        (raw::OK, _) => Ok(()),
        (raw::PANICKED, reason) => Err(format!(
            "panicked in {what}: {}",
            reason.as_deref().unwrap_or("no message")
        )),
        (_, Some(reason)) => Err(reason),
        (status, None) => Err(format!("{what} returned error {status} without a reason")),
    }
}

/// Returns how a check or an iteration ended, which may lack a value.
pub(super) fn iterated(what: &str, status: i32, failure: Option<String>) -> Result<Iterated, String> {
    match status {
        raw::OK => Ok(Iterated::Done),
        raw::NO_VALUE => {
            let words = failure.unwrap_or_else(|| String::from("an input has no value"));
            Ok(Iterated::WithoutValue(words))
        }
        _ => call_result(what, status, failure).map(|()| Iterated::Done),
    }
}
