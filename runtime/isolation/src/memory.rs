//! The memory of a child's port: shared with the host, or its own for values in messages.

use std::ffi::c_void;
use std::os::fd::{AsFd, OwnedFd};

use jde_abi::finite::Finite;
use jde_abi::raw;
use jde_board::Mapping;

use super::launch::{Acceptance, PortInfo};
use super::messages::{Bytes, Input, Value};

/// A port of the child.
pub(crate) struct IsolatedPort {
    info: PortInfo,
    mapped: Option<Mapping>,
    /// Finds the values of a command or of a modulation that are refused.
    finite: Option<Finite>,
    /// Aligned for any value.
    buffer: Vec<u128>,
    /// Whether `buffer` is loaned.
    loaned: bool,
    /// What the host sent last: a value, or the status of an input without one.
    held: Option<Result<raw::Sample, i32>>,
    shown: Shown,
    /// The memory for the next value that came with the call.
    early_loan: Option<*mut u8>,
}

/// Whether the plugin may be shown what is held.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Shown {
    /// No: another value may be newer.
    No,
    /// It came with the present call, and was not read yet.
    Early,
    /// It was read since this release.
    Since(u64),
}

impl IsolatedPort {
    /// Opens all ports. `files` are the files of those that have shared memory.
    pub(crate) fn open_all(
        infos: &[PortInfo],
        files: &mut impl Iterator<Item = OwnedFd>,
    ) -> std::io::Result<Vec<Self>> {
        let mut port = |info: &PortInfo| {
            let mapped = match info.memory {
                None => None,
                Some(extent) => {
                    let file = files.next().ok_or(std::io::ErrorKind::UnexpectedEof)?;
                    Some(Mapping::new(file.as_fd(), extent, info.writes)?)
                }
            };
            Ok(Self {
                info: *info,
                mapped,
                finite: None,
                buffer: Vec::new(),
                loaned: false,
                held: None,
                shown: Shown::No,
                early_loan: None,
            })
        };
        infos.iter().map(&mut port).collect()
    }

    /// Sets the type of its values.
    pub(crate) fn set_type(&mut self, value_type: &jde_abi::describe::Type) {
        if matches!(
            self.info.acceptance,
            Acceptance::IfFinite | Acceptance::IfAuthorized
        ) {
            self.finite = Some(Finite::new(value_type));
        }
    }

    /// Returns what it has returned since that release, or what came with the call; and whether it is read for
    /// the first time.
    pub(crate) fn show(&mut self, release: u64) -> Option<(Result<raw::Sample, i32>, bool)> {
        let is_first = match self.shown {
            Shown::No => return None,
            Shown::Since(since) if since != release => return None,
            Shown::Since(_) => false,
            Shown::Early => true,
        };
        self.shown = Shown::Since(release);
        Some((copy_result(self.held.as_ref()?), is_first))
    }

    /// Stores an input that came with the call. `None` if it is invalid.
    pub(crate) fn store_early(&mut self, input: Result<Input<'_>, i32>) -> Option<()> {
        self.hold(input)?;
        self.shown = Shown::Early;
        Some(())
    }

    /// Stores memory for a value that came with the call. `None` if it is invalid.
    pub(crate) fn store_early_loan(&mut self, place: usize) -> Option<()> {
        self.early_loan = Some(self.address_of(place)?);
        Some(())
    }

    /// Stores the host's reply as a sample, and returns it; `None` if the reply is invalid.
    pub(crate) fn store(
        &mut self,
        release: u64,
        input: Result<Input<'_>, i32>,
    ) -> Option<Result<raw::Sample, i32>> {
        self.hold(input)?;
        self.shown = Shown::Since(release);
        Some(copy_result(self.held.as_ref()?))
    }

    fn hold(&mut self, input: Result<Input<'_>, i32>) -> Option<()> {
        let Input { stamp, value } = match input {
            Ok(input) => input,
            Err(status) => {
                self.held = Some(Err(status));
                return Some(());
            }
        };
        let (data, bytes) = match value {
            Value::InPlace(place) => (self.address_of(place)?, self.info.bytes),
            Value::Unchanged => {
                let Some(Ok(sample)) = &self.held else {
                    return None;
                };
                (sample.data.cast::<u8>().cast_mut(), sample.bytes as usize)
            }
            Value::Sent(Bytes(sent)) => {
                let buffer = self.buffer(sent.len());
                buffer.copy_from_slice(sent);
                (buffer.as_mut_ptr(), sent.len())
            }
        };
        self.held = Some(Ok(raw::Sample {
            data: data.cast::<c_void>(),
            bytes: bytes as u64,
            time_ns: stamp.time_ns,
            sequence: stamp.sequence,
            writer: stamp.writer,
            flags: stamp.flags,
        }));
        Some(())
    }

    /// Returns memory for a value that is sent with its publication, or that came with the call; `None` if the
    /// host must provide the memory.
    pub(crate) fn loan(&mut self) -> Option<*mut u8> {
        if let Some(early) = self.early_loan {
            self.loaned = true;
            return Some(early);
        }
        if !self.info.writes || self.mapped.is_some() {
            return None;
        }
        Some(self.loan_buffer())
    }

    /// Returns the memory that the host loaned, at that place in shared memory or in the child; `None` if the place is
    /// invalid.
    pub(crate) fn loan_from(&mut self, place: Option<usize>) -> Option<*mut u8> {
        let Some(place) = place else {
            return Some(self.loan_buffer());
        };
        let loan = self.address_of(place)?;
        self.early_loan = Some(loan);
        self.loaned = true;
        Some(loan)
    }

    fn loan_buffer(&mut self) -> *mut u8 {
        self.loaned = true;
        let bytes = self.info.bytes;
        self.buffer(bytes).as_mut_ptr()
    }

    /// Whether the host accepts the loan, as far as the child knows: false if it must be asked.
    pub(crate) fn is_accepted(&self, has_authority: impl FnOnce() -> bool) -> bool {
        let is_finite = || {
            let bytes = self.buffer.get(..self.info.bytes.div_ceil(size_of::<u128>()));
            let bytes = bytes.map(|words| &bytemuck::cast_slice::<_, u8>(words)[..self.info.bytes]);
            self.finite
                .as_ref()
                .zip(bytes)
                .is_some_and(|(finite, bytes)| finite.first_not_finite(bytes).is_none())
        };
        self.loaned
            && match self.info.acceptance {
                Acceptance::ByHost => false,
                Acceptance::Always => true,
                Acceptance::IfFinite => self.mapped.is_none() && is_finite(),
                Acceptance::IfAuthorized => self.mapped.is_none() && is_finite() && has_authority(),
            }
    }

    /// Whether it is an export, whose last value can be retracted.
    pub(crate) fn is_export(&self) -> bool {
        self.info.acceptance == Acceptance::Always
    }

    /// Returns the value to send with its publication; `None` if it is in shared memory, or no value was loaned.
    pub(crate) fn take_loan(&mut self) -> Option<Bytes<&[u8]>> {
        let is_shared = self.early_loan.take().is_some();
        if !std::mem::take(&mut self.loaned) || is_shared {
            return None;
        }
        let bytes = self.info.bytes;
        Some(Bytes(self.buffer(bytes)))
    }

    /// Discards an unpublished loan, and a value that came with the call and was not read.
    pub(crate) fn end_call(&mut self) {
        self.loaned = false;
        self.early_loan = None;
        if self.shown == Shown::Early {
            self.shown = Shown::No;
        }
    }

    /// Returns the address of a value at the offset that the host gives.
    fn address_of(&self, place: usize) -> Option<*mut u8> {
        self.mapped.as_ref()?.at(place, self.info.bytes)
    }

    fn buffer(&mut self, bytes: usize) -> &mut [u8] {
        let words = bytes.div_ceil(size_of::<u128>());
        if self.buffer.len() < words {
            self.buffer.resize(words, 0);
        }
        &mut bytemuck::cast_slice_mut(&mut self.buffer)[..bytes]
    }
}

fn copy_result(held: &Result<raw::Sample, i32>) -> Result<raw::Sample, i32> {
    held.as_ref().map(copy_sample).map_err(|status| *status)
}

/// Copies a sample, because a plugin may change the one that it receives.
fn copy_sample(sample: &raw::Sample) -> raw::Sample {
    let raw::Sample {
        data,
        bytes,
        time_ns,
        sequence,
        writer,
        flags,
    } = *sample;
    raw::Sample {
        data,
        bytes,
        time_ns,
        sequence,
        writer,
        flags,
    }
}
