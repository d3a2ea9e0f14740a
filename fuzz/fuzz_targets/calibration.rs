//! Fuzzes the reader of calibrations of cameras. The checks define what must hold.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| jde_fuzzing::calibration(data));
