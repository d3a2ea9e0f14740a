//! Fuzzes the reader of CARMEN's logs with arbitrary bytes. The checks define what must hold.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| jde_fuzz::carmen_log(data));
