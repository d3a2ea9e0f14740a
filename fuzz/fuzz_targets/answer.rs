//! Payloads for every reader of what robots say. What must hold is said in the checks.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| jde_fuzz::answer(data));
