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
    /// Whether `room` is loaned.
    loaned: bool,
    /// What it shows, and since which release.
    cached: Option<(u64, raw::Sample)>,
}

impl IsolatedPort {
    /// All ports, with the files of those that have shared memory.
    pub(crate) fn open_all(about: &[PortInfo], files: Vec<OwnedFd>) -> std::io::Result<Vec<Self>> {
        let mut files = files.into_iter();
        let port = |about: &PortInfo| {
            let mapped = match about.memory {
                None => None,
                Some(extent) => {
                    let file = files.next().ok_or(std::io::ErrorKind::UnexpectedEof)?;
                    Some(Mapping::new(file.as_fd(), extent, about.writes)?)
                }
            };
            Ok(Self {
                info: *about,
                mapped,
                buffer: Vec::new(),
                loaned: false,
                cached: None,
            })
        };
        about.iter().map(port).collect()
    }

    /// What it has shown since that release, if anything.
    pub(crate) fn cached(&self, release: u64) -> Option<raw::Sample> {
        let (_, sample) = self.cached.as_ref().filter(|(since, _)| *since == release)?;
        Some(copy_sample(sample))
    }

    /// Shows the host's answer; `None` if the answer is invalid.
    pub(crate) fn store(&mut self, release: u64, answer: &Frame) -> Option<raw::Sample> {
        let [time_ns, sequence, _, bytes] = answer.words;
        let data = if answer.flags & IN_PLACE != 0 {
            self.address_of(answer)?
        } else {
            let room = self.buffer(answer.bytes.len());
            room.copy_from_slice(&answer.bytes);
            room.as_mut_ptr()
        };
        let sample = raw::Sample {
            data: data.cast::<c_void>(),
            bytes,
            time_ns,
            sequence,
            writer: answer.number,
            flags: answer.flags & !IN_PLACE,
        };
        self.cached = Some((release, copy_sample(&sample)));
        Some(sample)
    }

    /// Memory for a value that is sent with its publication; `None` if the host must provide the memory.
    pub(crate) fn loan(&mut self) -> Option<*mut u8> {
        if !self.info.writes || self.mapped.is_some() {
            return None;
        }
        self.loaned = true;
        let bytes = self.info.bytes;
        Some(self.buffer(bytes).as_mut_ptr())
    }

    /// The memory that the host loaned, shared or in the child.
    pub(crate) fn loan_from(&mut self, answer: &Frame) -> Option<*mut u8> {
        if answer.flags & IN_PLACE != 0 {
            return self.address_of(answer);
        }
        self.loaned = true;
        let bytes = self.info.bytes;
        Some(self.buffer(bytes).as_mut_ptr())
    }

    /// The value to send with its publication; empty if it is in shared memory, or nothing was loaned.
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

    /// The address of a value at the place that the host names.
    fn address_of(&self, answer: &Frame) -> Option<*mut u8> {
        let place = usize::try_from(answer.words[2]).ok()?;
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

/// A copy, because a plugin may change the sample that it was given.
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
