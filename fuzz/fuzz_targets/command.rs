//! Fuzzes the reader of commands with payloads. The checks define what must hold.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| jde_fuzzing::command(data));
