//! What stays with a call that was given up: it may still read the values it was shown and write to its
//! loans. The successor of its instance gets the same ports without these.

use std::sync::Arc;

use jde_board::{Error, Parted};

use super::ports::{Again, Port, Ports};
use crate::history::Aligned;

/// The values and loans that a call which was given up may still use. It must outlive that call.
pub(crate) struct Remains {
    looked_at: Vec<Port>,
    loaned: Vec<Parted>,
}

impl Ports {
    /// Returns the same ports for a successor, without a journal, and the values and loans since the last
    /// release, whose memory does not move.
    ///
    /// # Errors
    /// A loan cannot be separated from its writer yet. The ports then stay as they are. Loans that were
    /// separated already are discarded when the call returns, unpublished.
    pub(crate) fn hand_on(&mut self) -> Result<(Self, Remains), Error> {
        let mut loaned = Vec::new();
        let mut parted = Ok(());
        for port in &mut self.ports {
            if let Port::Output(writer) | Port::Wish { writer, .. } = port {
                match writer.part() {
                    Ok(room) => loaned.extend(room),
                    Err(error) => parted = Err(error),
                }
            }
        }
        self.loaned.extend(loaned);
        parted?;
        let mut looked_at = Vec::new();
        let ports = self.ports.iter_mut().map(|port| {
            let (successor, remains) = std::mem::replace(port, Port::Unbound).hand_on();
            looked_at.extend(remains);
            successor
        });
        let successor = Self::new(ports.collect());
        let loaned = std::mem::take(&mut self.loaned);
        Ok((successor, Remains { looked_at, loaned }))
    }
}

impl Port {
    /// Returns the port for a successor; and this port, if the call may still read what it shows.
    fn hand_on(self) -> (Self, Option<Self>) {
        match self {
            Self::Input(reader) if reader.latched().is_some() => {
                (Self::Input(reader.another()), Some(Self::Input(reader)))
            }
            Self::Command {
                reader,
                neutral,
                in_force,
            } => {
                let successor = Self::Command {
                    reader: reader.another(),
                    neutral: Aligned::new(neutral.bytes()),
                    in_force: None,
                };
                let remains = Self::Command {
                    reader,
                    neutral,
                    in_force,
                };
                (successor, Some(remains))
            }
            Self::Again(Again {
                history,
                wanted,
                held,
            }) => {
                let successor = Again {
                    history: Arc::clone(&history),
                    wanted,
                    held: None,
                };
                let remains = Again {
                    history,
                    wanted,
                    held,
                };
                (Self::Again(successor), Some(Self::Again(remains)))
            }
            Self::Fixed(reader) => (Self::Fixed(reader.another()), Some(Self::Fixed(reader))),
            port @ (Self::Unbound | Self::Input(_) | Self::Output(_) | Self::Wish { .. }) => (port, None),
        }
    }
}

impl Remains {
    /// Bytes of the values that are kept.
    pub(crate) fn bytes(&self) -> usize {
        let loaned: usize = self.loaned.iter().map(Parted::bytes).sum();
        let looked_at = self.looked_at.iter().filter_map(|port| match port {
            Port::Input(reader) | Port::Fixed(reader) | Port::Command { reader, .. } => {
                reader.latched().map(|latched| latched.bytes.len())
            }
            Port::Unbound | Port::Again(_) | Port::Output(_) | Port::Wish { .. } => None,
        });
        loaned + looked_at.sum::<usize>()
    }
}
