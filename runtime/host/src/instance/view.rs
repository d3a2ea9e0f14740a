//! What a port shows during a call, and its form for plugins.

use std::ffi::c_void;

use jde_abi::raw;
use jde_board::Stamp;
use jde_core::Nanos;

/// What a port shows.
pub(crate) struct View<'a> {
    pub(crate) bytes: &'a [u8],
    pub(crate) time: Nanos,
    pub(crate) sequence: u64,
    pub(crate) writer: u32,
    pub(crate) neutral: bool,
}

impl<'a> View<'a> {
    /// A published value.
    pub(super) fn of(bytes: &'a [u8], stamp: &Stamp) -> Self {
        Self {
            bytes,
            time: stamp.time,
            sequence: stamp.sequence,
            writer: stamp.writer,
            neutral: false,
        }
    }

    /// The value in the form that plugins receive.
    pub(crate) fn sample(&self) -> raw::Sample {
        let default_flag = if self.sequence == 0 {
            raw::SAMPLE_DEFAULT
        } else {
            0
        };
        raw::Sample {
            data: self.bytes.as_ptr().cast::<c_void>(),
            bytes: self.bytes.len() as u64,
            time_ns: self.time,
            sequence: self.sequence,
            writer: self.writer,
            flags: if self.neutral {
                raw::SAMPLE_NEUTRAL
            } else {
                default_flag
            },
        }
    }
}
