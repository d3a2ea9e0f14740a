//! Fuzzes the receiver of Player's messages with streams of bytes. The checks define what must hold.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| jde_fuzzing::player_stream(data));
