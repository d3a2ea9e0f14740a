//! Fuzzes the reader of the camera's frames with streams of bytes. The checks define what must hold.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| jde_fuzzing::head(data));
