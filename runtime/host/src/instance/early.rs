//! What a child receives with a call, before it asks: the inputs that such a call usually reads, and memory for
//! the outputs that it usually writes in place.

use std::sync::Arc;

use jde_board::Access;
use jde_isolation::launch::Acceptance;
use jde_isolation::wire::{Frame, FrameKind, IN_PLACE, UNCHANGED, Wire};
use jde_records::turn::Turn;

use super::CallContext;
use super::bound_port::BoundPort;
use super::ports::Ports;
use super::view::View;

/// The calls of a kind that may leave an input unread before they are no longer sent with it.
const KEPT_CALLS: u8 = 8;

/// The ports that can be sent with a call: a bit each in the reply.
const MAX_EARLY_PORTS: usize = 128;

/// The kinds of calls, by [`FrameKind`].
const CALLS: usize = FrameKind::Destroy as usize + 1;

/// What the child has of each port.
pub(super) struct EarlyPorts(Vec<EarlyPort>);

#[derive(Default)]
struct EarlyPort {
    /// For how many calls of each kind it is still sent, unless they use it.
    calls_left: [u8; CALLS],
    /// What the child was sent last.
    held: Option<Held>,
    /// The release since which the plugin has read it.
    read_in: Option<u64>,
    /// Whether the present call was sent with it.
    is_early: bool,
}

/// Identifies what a port showed.
#[derive(PartialEq)]
struct Held {
    status: i32,
    flags: u32,
    words: [u64; 4],
}

impl EarlyPorts {
    pub(super) fn new(ports: usize) -> Self {
        Self(
            (0..ports.min(MAX_EARLY_PORTS))
                .map(|_| EarlyPort::default())
                .collect(),
        )
    }

    /// Queues what this call usually reads and writes.
    pub(super) fn queue(&mut self, call: &mut CallContext<'_>, kind: FrameKind, wire: &mut Wire) {
        let release = call.releases();
        for (number, port) in self.0.iter_mut().enumerate() {
            if port.calls_left[kind as usize] == 0 || port.read_in == Some(release) {
                continue;
            }
            let number = number as u32;
            let frame = match call.variable(number) {
                Some((variable, true)) if !call.is_read_only() => {
                    let place = call.loan(number, |buffer| variable.offset_of(buffer));
                    place.ok().flatten().map(|place| Frame {
                        number,
                        flags: IN_PLACE,
                        words: [0, 0, place as u64, 0],
                        ..Frame::new(FrameKind::Value)
                    })
                }
                Some((_, true)) => None,
                variable => {
                    let variable = variable.map(|(variable, _)| variable);
                    let mut frame = Frame::new(FrameKind::Value);
                    let shown = call.show_early(number, |view| {
                        show(&mut frame, view, variable.as_deref());
                    });
                    shown.map(|shown| {
                        frame.number = number;
                        frame.status = shown.err().unwrap_or_default();
                        port.skip_unchanged(&mut frame);
                        frame
                    })
                }
            };
            port.is_early = frame.is_some();
            if let Some(frame) = frame {
                wire.queue(&frame);
            }
        }
    }

    /// Records that the child asked for a value, and what it was sent.
    pub(super) fn record_request(&mut self, kind: FrameKind, release: u64, reply: &Frame) {
        if let Some(port) = self.0.get_mut(reply.number as usize) {
            port.held = Some(Held::of(reply));
            port.read_in = Some(release);
            port.calls_left[kind as usize] = KEPT_CALLS;
        }
    }

    /// Records that the child wrote a value in place.
    pub(super) fn record_write(&mut self, kind: FrameKind, number: u32) {
        if let Some(port) = self.0.get_mut(number as usize) {
            port.calls_left[kind as usize] = KEPT_CALLS;
        }
    }

    /// Ends the call. `read` contains the early values that the plugin read. Returns false if it read one that
    /// it was not sent.
    pub(super) fn settle(&mut self, call: &CallContext<'_>, kind: FrameKind, read: u128) -> bool {
        let release = call.releases();
        let mut unexplained = read;
        for (number, port) in self.0.iter_mut().enumerate() {
            if !std::mem::take(&mut port.is_early) {
                continue;
            }
            let was_read = read >> number & 1 == 1;
            unexplained &= !(1 << number);
            call.end_early(number as u32, was_read);
            let left = &mut port.calls_left[kind as usize];
            if was_read {
                *left = KEPT_CALLS;
                port.read_in = Some(release);
            } else {
                *left = left.saturating_sub(1);
            }
        }
        unexplained == 0
    }
}

impl EarlyPort {
    /// Removes the value from a message if the child has it.
    fn skip_unchanged(&mut self, frame: &mut Frame) {
        let held = Held::of(frame);
        if self.held.as_ref() == Some(&held) && !frame.bytes.is_empty() {
            frame.flags |= UNCHANGED;
            frame.bytes.clear();
        }
        self.held = Some(held);
    }
}

impl Held {
    fn of(frame: &Frame) -> Self {
        let Frame {
            status, flags, words, ..
        } = *frame;
        Self { status, flags, words }
    }
}

/// Fills in what a port shows: where it is in shared memory, or its bytes.
pub(super) fn show(frame: &mut Frame, view: &View<'_>, variable: Option<&jde_board::Variable>) {
    let sample = view.sample();
    frame.flags = sample.flags;
    frame.words = [sample.time_ns, sample.sequence, 0, u64::from(sample.writer)];
    match variable.and_then(|variable| variable.offset_of(view.bytes)) {
        Some(place) => {
            frame.flags |= IN_PLACE;
            frame.words[2] = place as u64;
        }
        None => frame.bytes = view.bytes.to_vec(),
    }
}

/// What is shown to a process of its own before it asks. A value counts as read only once the plugin reads it;
/// otherwise it is released.
impl Ports {
    /// Returns what it takes for a value of an output to be published.
    pub(crate) fn acceptance(&self, port: usize) -> Acceptance {
        match self.ports.get(port) {
            Some(BoundPort::Output(_)) => Acceptance::Always,
            Some(BoundPort::ForeignOutput {
                writer,
                guards,
                limits,
                ..
            }) => {
                let declaration = writer.variable().describe();
                match declaration.access {
                    _ if !guards.is_empty() || limits.is_some() || !declaration.limits.is_none() => {
                        Acceptance::ByHost
                    }
                    Access::Command { .. } => Acceptance::IfAuthorized,
                    Access::Modulation => Acceptance::IfFinite,
                    Access::Export { .. } => Acceptance::ByHost,
                }
            }
            _ => Acceptance::ByHost,
        }
    }

    /// Whether showing an input early makes no difference: no guard judges it, and the call cannot change it.
    pub(super) fn can_show_early(&self, port: usize) -> bool {
        match self.ports.get(port) {
            Some(BoundPort::Input(reader) | BoundPort::Fixed(reader)) => {
                !self.ports.iter().any(|port| match port {
                    BoundPort::Output(writer) | BoundPort::ForeignOutput { writer, .. } => {
                        Arc::ptr_eq(writer.variable(), reader.variable())
                    }
                    _ => false,
                })
            }
            Some(BoundPort::Command { guards, .. }) => guards.is_empty(),
            Some(BoundPort::Unbound) => true,
            Some(BoundPort::Recorded(_) | BoundPort::Output(_) | BoundPort::ForeignOutput { .. }) | None => {
                false
            }
        }
    }

    /// Runs `show`, whose reads do not count.
    pub(super) fn without_record<R>(&mut self, show: impl FnOnce(&mut Self) -> R) -> R {
        let (log, had_reads) = (self.read_log.take(), self.has_reads);
        let shown = show(self);
        (self.read_log, self.has_reads) = (log, had_reads);
        shown
    }

    /// Counts an early value as read at the beginning of the call, or releases it.
    pub(super) fn end_early(&mut self, port: usize, was_read: bool) {
        let Some(bound) = self.ports.get_mut(port) else {
            return;
        };
        match bound {
            _ if was_read => self.has_reads = true,
            BoundPort::Input(reader) => reader.release(),
            BoundPort::Command { reader, in_force, .. } => {
                reader.release();
                *in_force = None;
            }
            _ => {}
        }
        if let (true, BoundPort::Input(reader) | BoundPort::Fixed(reader), Some(log)) =
            (was_read, bound, &mut self.read_log)
            && let Some(input @ &mut Turn::UNUSED) = log.inputs.get_mut(port)
        {
            let latched = reader.latched();
            *input = latched.map_or(Turn::NO_VALUE, |latched| latched.stamp.sequence as u32);
        }
    }
}
