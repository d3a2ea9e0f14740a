//! Fuzzes the reader of recordings and bags. The checks define what must hold.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| jde_fuzzing::recording(data));
