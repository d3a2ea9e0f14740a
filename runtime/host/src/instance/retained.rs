//! The values and loans that stay with a call that was given up: it may still read these values and write to
//! these loans. The successor of its instance gets the same ports without them.

use std::sync::Arc;

use jde_board::{DetachedLoan, Error};
use jde_loader::AlignedBytes;

use super::bound_port::{BoundPort, RecordedInput};
use super::ports::Ports;

/// The values and loans that a call which was given up may still use. It must outlive that call.
pub(crate) struct RetainedValues {
    read_ports: Vec<BoundPort>,
    loaned: Vec<DetachedLoan>,
}

impl Ports {
    /// Returns the same ports for a successor, without a journal, and the values and loans since the last
    /// release, whose memory does not move.
    ///
    /// # Errors
    /// A loan cannot be separated from its writer yet. The ports then stay as they are. Loans that were
    /// separated already are discarded when the call returns, unpublished.
    pub(crate) fn split_off(&mut self) -> Result<(Self, RetainedValues), Error> {
        let mut loaned = Vec::new();
        let mut result = Ok(());
        for port in &mut self.ports {
            if let BoundPort::Output(writer) | BoundPort::ForeignOutput { writer, .. } = port {
                match writer.detach_loan() {
                    Ok(loan) => loaned.extend(loan),
                    Err(error) => result = Err(error),
                }
            }
        }
        self.separated_loans.extend(loaned);
        result?;
        let mut read_ports = Vec::new();
        let ports = self.ports.iter_mut().map(|port| {
            let (successor, remains) = std::mem::replace(port, BoundPort::Unbound).split();
            read_ports.extend(remains);
            successor
        });
        let mut successor = Self::new(ports.collect(), Arc::clone(&self.faults));
        successor.measurements = std::mem::take(&mut self.measurements);
        successor.chunks = std::mem::take(&mut self.chunks);
        successor.guarding = self.guarding.take();
        let loaned = std::mem::take(&mut self.separated_loans);
        Ok((successor, RetainedValues { read_ports, loaned }))
    }
}

impl BoundPort {
    /// Returns the port for a successor; and this port, if the call may still read what it shows.
    fn split(self) -> (Self, Option<Self>) {
        match self {
            Self::Input(reader) if reader.latched().is_some() => {
                (Self::Input(reader.duplicate()), Some(Self::Input(reader)))
            }
            Self::Command {
                reader,
                neutral,
                in_force,
                guards,
                driver,
            } => {
                let successor = Self::Command {
                    reader: reader.duplicate(),
                    neutral: AlignedBytes::new(neutral.bytes()),
                    in_force: None,
                    guards: Arc::clone(&guards),
                    driver,
                };
                let remains = Self::Command {
                    reader,
                    neutral,
                    in_force,
                    guards,
                    driver,
                };
                (successor, Some(remains))
            }
            Self::Recorded(RecordedInput {
                history,
                is_import,
                number,
                resolved,
            }) => {
                let successor = RecordedInput {
                    history: Arc::clone(&history),
                    is_import,
                    number,
                    resolved: None,
                };
                let remains = RecordedInput {
                    history,
                    is_import,
                    number,
                    resolved,
                };
                (Self::Recorded(successor), Some(Self::Recorded(remains)))
            }
            Self::Fixed(reader) => (Self::Fixed(reader.duplicate()), Some(Self::Fixed(reader))),
            port @ (Self::Unbound | Self::Input(_) | Self::Output(_) | Self::ForeignOutput { .. }) => {
                (port, None)
            }
        }
    }
}

impl RetainedValues {
    /// Returns the size of the values, in bytes.
    pub(crate) fn bytes(&self) -> usize {
        let loaned: usize = self.loaned.iter().map(DetachedLoan::bytes).sum();
        let shown = self.read_ports.iter().filter_map(|port| match port {
            BoundPort::Input(reader) | BoundPort::Fixed(reader) | BoundPort::Command { reader, .. } => {
                reader.latched().map(|latched| latched.bytes.len())
            }
            BoundPort::Unbound
            | BoundPort::Recorded(_)
            | BoundPort::Output(_)
            | BoundPort::ForeignOutput { .. } => None,
        });
        loaned + shown.sum::<usize>()
    }
}
