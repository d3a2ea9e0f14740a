//! Payloads for the reader of commands. What must hold is said in the checks.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| jde_fuzz::command(data));
