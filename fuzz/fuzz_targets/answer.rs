//! Fuzzes every reader of a robot's packets with payloads. The checks define what must hold.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| jde_fuzzing::answer(data));
