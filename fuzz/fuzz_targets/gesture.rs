//! Bytes for the reader of what people do to panels. What must hold is said in the checks.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| jde_fuzz::gesture(data));
