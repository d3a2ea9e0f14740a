//! Fuzzes the readers of serial lidars with streams of bytes. The checks define what must hold.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| jde_fuzzing::lidar(data));
