//! Bytes for the reader of panels. What must hold is said in the checks.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| jde_fuzz::list(data));
