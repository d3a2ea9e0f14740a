//! Streams of bytes for the reader of the camera's frames. What must hold is said in the checks.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| jde_fuzz::head(data));
