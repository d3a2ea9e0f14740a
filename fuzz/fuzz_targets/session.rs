//! Fuzzes the client's session with robots that send arbitrary bytes. The checks define what must hold.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| jde_fuzzing::session(data));
