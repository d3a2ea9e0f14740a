//! The memory of a child's port: shared with the host, or its own for values in messages.

use std::ffi::c_void;
use std::os::fd::{AsFd, OwnedFd};

use jde_abi::raw;
use jde_board::Mapping;

use super::launch::PortInfo;
use super::wire::{Frame, IN_PLACE};

/// A port of the child.
pub(crate) struct IsolatedPort {
    info: PortInfo,
    mapped: Option<Mapping>,
    /// Aligned for any value.
    buffer: Vec<u128>,
    /// Whether `buffer` is loaned.
    loaned: bool,
    /// The sample that it returned, and the release since which it is valid.
    cached: Option<(u64, raw::Sample)>,
}

impl IsolatedPort {
    /// Opens all ports. `files` are the files of those that have shared memory.
    pub(crate) fn open_all(infos: &[PortInfo], files: Vec<OwnedFd>) -> std::io::Result<Vec<Self>> {
        let mut files = files.into_iter();
        let port = |info: &PortInfo| {
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
                buffer: Vec::new(),
                loaned: false,
                cached: None,
            })
        };
        infos.iter().map(port).collect()
    }

    /// Returns the sample that it has returned since that release, if there is one.
    pub(crate) fn cached(&self, release: u64) -> Option<raw::Sample> {
        let (_, sample) = self.cached.as_ref().filter(|(since, _)| *since == release)?;
        Some(copy_sample(sample))
    }

    /// Stores the host's reply as a sample; `None` if the reply is invalid.
    pub(crate) fn store(&mut self, release: u64, reply: &Frame) -> Option<raw::Sample> {
        let [time_ns, sequence, _, bytes] = reply.words;
        let data = if reply.flags & IN_PLACE != 0 {
            self.address_of(reply)?
        } else {
            let buffer = self.buffer(reply.bytes.len());
            buffer.copy_from_slice(&reply.bytes);
            buffer.as_mut_ptr()
        };
        let sample = raw::Sample {
            data: data.cast::<c_void>(),
            bytes,
            time_ns,
            sequence,
            writer: reply.number,
            flags: reply.flags & !IN_PLACE,
        };
        self.cached = Some((release, copy_sample(&sample)));
        Some(sample)
    }

    /// Returns memory for a value that is sent with its publication; `None` if the host must provide the
    /// memory.
    pub(crate) fn loan(&mut self) -> Option<*mut u8> {
        if !self.info.writes || self.mapped.is_some() {
            return None;
        }
        self.loaned = true;
        let bytes = self.info.bytes;
        Some(self.buffer(bytes).as_mut_ptr())
    }

    /// Returns the memory that the host loaned, shared or in the child.
    pub(crate) fn loan_from(&mut self, reply: &Frame) -> Option<*mut u8> {
        if reply.flags & IN_PLACE != 0 {
            return self.address_of(reply);
        }
        self.loaned = true;
        let bytes = self.info.bytes;
        Some(self.buffer(bytes).as_mut_ptr())
    }

    /// Returns the value to send with its publication; empty if it is in shared memory, or no value was
    /// loaned.
    pub(crate) fn take_loan(&mut self) -> Vec<u8> {
        if !std::mem::take(&mut self.loaned) {
            return Vec::new();
        }
        let bytes = self.info.bytes;
        self.buffer(bytes).to_vec()
    }

    /// Discards an unpublished loan.
    pub(crate) fn discard(&mut self) {
        self.loaned = false;
    }

    /// Returns the address of a value at the offset that the host gives.
    fn address_of(&self, reply: &Frame) -> Option<*mut u8> {
        let offset = usize::try_from(reply.words[2]).ok()?;
        self.mapped.as_ref()?.at(offset, self.info.bytes)
    }

    fn buffer(&mut self, bytes: usize) -> &mut [u8] {
        let words = bytes.div_ceil(size_of::<u128>());
        if self.buffer.len() < words {
            self.buffer.resize(words, 0);
        }
        &mut bytemuck::cast_slice_mut(&mut self.buffer)[..bytes]
    }
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
