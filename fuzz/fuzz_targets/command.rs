//! Payloads for the reader of commands. What must hold is said in the checks, which the ordinary tests run too.
#![no_main]

#[allow(dead_code)]
#[path = "../../crates/p2os/tests/common/checks.rs"]
mod checks;

libfuzzer_sys::fuzz_target!(|data: &[u8]| checks::command(data));
