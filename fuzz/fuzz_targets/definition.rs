//! Fuzzes the reader of definitions of ROS 2. The checks define what must hold.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| jde_fuzzing::definition(data));
