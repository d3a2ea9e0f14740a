//! What a child receives with a call, before it asks: the inputs that such a call usually reads, and memory for
//! the outputs that it usually writes in place.

use std::mem::Discriminant;
use std::sync::Arc;

use jde_board::{Access, Variable};
use jde_isolation::launch::Acceptance;
use jde_isolation::messages::{Bytes, Function, Input, Reply, Stamp, ToChild, Value};
use jde_isolation::wire::Wire;
use jde_records::turn::Turn;

use super::CallContext;
use super::bound_port::BoundPort;
use super::ports::Ports;
use super::view::View;

/// The calls of a kind that may leave an input unread before they are no longer sent with it.
const KEPT_CALLS: u8 = 8;

/// The ports that can be sent with a call: a bit each in the reply.
const MAX_EARLY_PORTS: usize = 128;

/// The function that is called.
pub(super) type CallKind = Discriminant<Function>;

/// What the child has of each port.
pub(super) struct EarlyPorts(Vec<EarlyPort>);

#[derive(Default)]
struct EarlyPort {
    /// For how many calls of a kind it is still sent, unless they use it; of other kinds for none.
    calls_left: Vec<(CallKind, u8)>,
    /// What the child was sent last.
    held: Option<Held>,
    /// The release since which the plugin has read it.
    read_in: Option<u64>,
    /// Whether the present call was sent with it.
    is_early: bool,
}

/// Identifies what a port showed: a value and its place in mapped memory, or a status.
type Held = Result<(Stamp, Option<usize>), i32>;

impl EarlyPorts {
    pub(super) fn new(ports: usize) -> Self {
        Self(
            (0..ports.min(MAX_EARLY_PORTS))
                .map(|_| EarlyPort::default())
                .collect(),
        )
    }

    /// Queues what this call usually reads and writes.
    pub(super) fn queue(&mut self, call: &mut CallContext<'_>, kind: CallKind, wire: &mut Wire) {
        let release = call.releases();
        for (number, port) in self.0.iter_mut().enumerate() {
            if *port.calls_left(kind) == 0 || port.read_in == Some(release) {
                continue;
            }
            let number = number as u32;
            port.is_early = match call.variable(number) {
                Some((_, true)) if call.is_read_only() => false,
                Some((variable, true)) => match loan(call, number, Some(variable)) {
                    Ok(Some(place)) => {
                        wire.queue(&ToChild::EarlyLoan { port: number, place });
                        true
                    }
                    Ok(None) | Err(_) => false,
                },
                variable => {
                    let variable = variable.map(|(variable, _)| variable);
                    let shown = call.show_early(number, |view| {
                        port.queue(number, Ok(show(view, variable.as_deref())), wire);
                    });
                    if let Some(Err(status)) = shown {
                        port.queue(number, Err(status), wire);
                    }
                    shown.is_some()
                }
            };
        }
    }

    /// Queues the reply to a child that asks for the value of an input, and records what it was sent.
    pub(super) fn reply(&mut self, call: &mut CallContext<'_>, kind: CallKind, number: u32, wire: &mut Wire) {
        let variable = call.variable(number).map(|(variable, _)| variable);
        let shown = call.show(number, |view| {
            let input = show(view, variable.as_deref());
            wire.queue(&ToChild::Reply(Reply::Input(Ok(input))));
            held(&input)
        });
        if let Err(status) = shown {
            wire.queue(&ToChild::Reply(Reply::Input(Err(status))));
        }
        if let Some(port) = self.0.get_mut(number as usize) {
            port.held = Some(shown);
            port.read_in = Some(call.releases());
            *port.calls_left(kind) = KEPT_CALLS;
        }
    }

    /// Records that the child wrote a value in place.
    pub(super) fn record_write(&mut self, kind: CallKind, number: u32) {
        if let Some(port) = self.0.get_mut(number as usize) {
            *port.calls_left(kind) = KEPT_CALLS;
        }
    }

    /// Ends the call. `read` contains the early values that the plugin read. Returns false if it read one that
    /// it was not sent.
    pub(super) fn settle(&mut self, call: &CallContext<'_>, kind: CallKind, read: u128) -> bool {
        let release = call.releases();
        let mut unexplained = read;
        for (number, port) in self.0.iter_mut().enumerate() {
            if !std::mem::take(&mut port.is_early) {
                continue;
            }
            let was_read = read >> number & 1 == 1;
            unexplained &= !(1 << number);
            call.end_early(number as u32, was_read);
            if was_read {
                port.read_in = Some(release);
            }
            let left = port.calls_left(kind);
            *left = if was_read {
                KEPT_CALLS
            } else {
                left.saturating_sub(1)
            };
        }
        unexplained == 0
    }
}

impl EarlyPort {
    /// For how many calls of a kind it is still sent, unless they use it.
    fn calls_left(&mut self, kind: CallKind) -> &mut u8 {
        let known = self.calls_left.iter().position(|(known, _)| *known == kind);
        let place = known.unwrap_or_else(|| {
            self.calls_left.push((kind, 0));
            self.calls_left.len() - 1
        });
        &mut self.calls_left[place].1
    }

    /// Queues what it shows, without the value if the child has it.
    fn queue(&mut self, port: u32, mut input: Result<Input<'_>, i32>, wire: &mut Wire) {
        let now = input.as_ref().map(held).map_err(|status| *status);
        if let Ok(Input {
            value: value @ Value::Sent(_),
            ..
        }) = &mut input
            && self.held == Some(now)
        {
            *value = Value::Unchanged;
        }
        self.held = Some(now);
        wire.queue(&ToChild::Early { port, input });
    }
}

fn held(input: &Input<'_>) -> (Stamp, Option<usize>) {
    let place = match input.value {
        Value::InPlace(place) => Some(place),
        Value::Sent(_) | Value::Unchanged => None,
    };
    (input.stamp, place)
}

/// What a port shows, and where it is in shared memory, or its bytes.
fn show<'a>(view: &View<'a>, variable: Option<&Variable>) -> Input<'a> {
    let sample = view.sample();
    Input {
        stamp: Stamp {
            time_ns: sample.time_ns,
            sequence: sample.sequence,
            writer: sample.writer,
            flags: sample.flags,
        },
        value: match variable.and_then(|variable| variable.offset_of(view.bytes)) {
            Some(place) => Value::InPlace(place),
            None => Value::Sent(Bytes(view.bytes)),
        },
    }
}

/// Loans memory for the next value of an output. Returns its offset in mapped memory; `None` if the child sends the
/// value.
pub(super) fn loan(
    call: &mut CallContext<'_>,
    port: u32,
    variable: Option<Arc<Variable>>,
) -> Result<Option<usize>, i32> {
    call.lend(port, |buffer| {
        variable.and_then(|variable| variable.offset_of(buffer))
    })
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

    /// Whether showing an input early makes no difference: no guard judges it, the call cannot change it, and who looks
    /// first learns nothing by it.
    pub(super) fn can_show_early(&self, port: usize) -> bool {
        match self.ports.get(port) {
            Some(BoundPort::Input(_)) if self.chunks.contains(port) => false,
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
