//! The memory of a child's port: shared with the host, or its own for values in messages.

use std::ffi::c_void;
use std::os::fd::{AsFd, OwnedFd};

use jde_abi::raw;
use jde_board::Mapped;

use super::launch::PortAbout;
use super::wire::{Frame, IN_PLACE};

/// A port of the child.
pub(super) struct Port {
    about: PortAbout,
    mapped: Option<Mapped>,
    /// Aligned for any value.
    room: Vec<u128>,
    /// Whether `room` is loaned.
    loaned: bool,
    /// What it shows, and since which release.
    shown: Option<(u64, raw::Sample)>,
}

impl Port {
    /// All ports, with the files of those that have shared memory.
    pub(super) fn all(about: &[PortAbout], files: Vec<OwnedFd>) -> std::io::Result<Vec<Self>> {
        let mut files = files.into_iter();
        let port = |about: &PortAbout| {
            let mapped = match about.memory {
                None => None,
                Some(extent) => {
                    let file = files.next().ok_or(std::io::ErrorKind::UnexpectedEof)?;
                    Some(Mapped::new(file.as_fd(), extent, about.writes)?)
                }
            };
            Ok(Self {
                about: *about,
                mapped,
                room: Vec::new(),
                loaned: false,
                shown: None,
            })
        };
        about.iter().map(port).collect()
    }

    /// What it has shown since that release, if anything.
    pub(super) fn shown(&self, release: u64) -> Option<raw::Sample> {
        let (_, sample) = self.shown.as_ref().filter(|(since, _)| *since == release)?;
        Some(again(sample))
    }

    /// Shows the host's answer; `None` if the answer is invalid.
    pub(super) fn show(&mut self, release: u64, answer: &Frame) -> Option<raw::Sample> {
        let [time_ns, sequence, _, bytes] = answer.words;
        let data = if answer.flags & IN_PLACE != 0 {
            self.at(answer)?
        } else {
            let room = self.room(answer.bytes.len());
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
        self.shown = Some((release, again(&sample)));
        Some(sample)
    }

    /// Memory for a value that is sent with its publication; `None` if the host must provide the memory.
    pub(super) fn loan(&mut self) -> Option<*mut u8> {
        if !self.about.writes || self.mapped.is_some() {
            return None;
        }
        self.loaned = true;
        let bytes = self.about.bytes;
        Some(self.room(bytes).as_mut_ptr())
    }

    /// The memory that the host loaned, shared or in the child.
    pub(super) fn loan_as(&mut self, answer: &Frame) -> Option<*mut u8> {
        if answer.flags & IN_PLACE != 0 {
            return self.at(answer);
        }
        self.loaned = true;
        let bytes = self.about.bytes;
        Some(self.room(bytes).as_mut_ptr())
    }

    /// The value to send with its publication; empty if it is in shared memory, or nothing was loaned.
    pub(super) fn take_loan(&mut self) -> Vec<u8> {
        if !std::mem::take(&mut self.loaned) {
            return Vec::new();
        }
        let bytes = self.about.bytes;
        self.room(bytes).to_vec()
    }

    /// Discards an unpublished loan.
    pub(super) fn discard(&mut self) {
        self.loaned = false;
    }

    /// The address of a value at the place that the host names.
    fn at(&self, answer: &Frame) -> Option<*mut u8> {
        let place = usize::try_from(answer.words[2]).ok()?;
        self.mapped.as_ref()?.at(place, self.about.bytes)
    }

    fn room(&mut self, bytes: usize) -> &mut [u8] {
        let words = bytes.div_ceil(size_of::<u128>());
        if self.room.len() < words {
            self.room.resize(words, 0);
        }
        &mut bytemuck::cast_slice_mut(&mut self.room)[..bytes]
    }
}

/// A copy, because a plugin may change the sample that it was given.
fn again(sample: &raw::Sample) -> raw::Sample {
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
