//! Streams of bytes for the receiver of packets. What must hold is said in the checks.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| jde_fuzz::receiver(data));
