//! Fuzzes the readers of worlds of other programs, Stage among them. The checks define what must hold.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| jde_fuzzing::import(data));
