//! Fuzzes the reader of CARMEN's logs with arbitrary bytes. The checks define what must hold.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| jde_fuzzing::carmen_log(data));
