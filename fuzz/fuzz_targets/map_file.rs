//! Fuzzes the reader of ROS maps with YAML files and images. The checks define what must hold.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| jde_fuzzing::map_file(data));
