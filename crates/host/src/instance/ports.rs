//! The ports of one instance: what they are bound to on the board, and what they show during a call.

use jde_board::{Reader, Refused, Writer};
use jde_core::Nanos;

/// All ports of an instance, by number.
#[derive(Default)]
pub(crate) struct Ports {
    ports: Vec<Port>,
}

/// What a port is bound to.
pub(crate) enum Port {
    /// Nothing.
    Unbound,
    /// An import or a modulation.
    Input(Reader),
    /// A driver's command, with the value that is in force when nobody's is.
    Command {
        reader: Reader,
        neutral: Aligned,
        /// Whether the latched command was in force when it was first looked at: it counts that long (R8).
        in_force: Option<bool>,
    },
    /// An export.
    Output(Writer),
    /// A driver's command or a child's modulation.
    Wish {
        writer: Writer,
        /// Refused the last time: so that a row of refusals is told once.
        refused: bool,
    },
}

/// Bytes aligned for any value.
pub(crate) struct Aligned {
    words: Vec<u128>,
    bytes: usize,
}

/// What a port shows.
pub(crate) struct View<'a> {
    pub(crate) bytes: &'a [u8],
    pub(crate) time: Nanos,
    pub(crate) sequence: u64,
    pub(crate) writer: u32,
    pub(crate) neutral: bool,
}

/// Why a port cannot be read or written.
pub(crate) enum PortError {
    Unbound,
    NoValue,
    WrongPort,
    NothingLoaned,
    Refused { why: Refused, first: bool },
}

impl Ports {
    pub(crate) fn new(ports: Vec<Port>) -> Self {
        Self { ports }
    }

    /// The value of an input, the same until [`Self::release`].
    pub(crate) fn read(&mut self, port: usize, now: Nanos) -> Result<View<'_>, PortError> {
        match self.ports.get_mut(port).ok_or(PortError::WrongPort)? {
            Port::Unbound => Err(PortError::Unbound),
            Port::Output(_) | Port::Wish { .. } => Err(PortError::WrongPort),
            Port::Input(reader) => {
                let latched = reader.latch().ok_or(PortError::NoValue)?;
                Ok(View {
                    bytes: latched.bytes,
                    time: latched.stamp.time,
                    sequence: latched.stamp.sequence,
                    writer: latched.stamp.writer,
                    neutral: false,
                })
            }
            Port::Command {
                reader,
                neutral,
                in_force,
            } => match reader.latch() {
                Some(latched)
                    if latched.stamp.sequence > 0
                        && *in_force.get_or_insert(latched.stamp.valid_until >= now) =>
                {
                    Ok(View {
                        bytes: latched.bytes,
                        time: latched.stamp.time,
                        sequence: latched.stamp.sequence,
                        writer: latched.stamp.writer,
                        neutral: false,
                    })
                }
                _ => Ok(View {
                    bytes: neutral.bytes(),
                    time: now,
                    sequence: 0,
                    writer: u32::MAX,
                    neutral: true,
                }),
            },
        }
    }

    /// Room for the next value of an output.
    pub(crate) fn loan(&mut self, port: usize) -> Result<&mut [u8], PortError> {
        match self.ports.get_mut(port).ok_or(PortError::WrongPort)? {
            Port::Unbound => Err(PortError::Unbound),
            Port::Input(_) | Port::Command { .. } => Err(PortError::WrongPort),
            Port::Output(writer) | Port::Wish { writer, .. } => Ok(writer.loan()),
        }
    }

    /// Publishes what was loaned. A command is in force for two of the schema's periods at least: who is slow by design is
    /// not taken for one that has gone silent.
    pub(crate) fn publish(
        &mut self,
        port: usize,
        time: Nanos,
        now: Nanos,
        period: Nanos,
    ) -> Result<(), PortError> {
        let failed = |why| match why {
            Refused::NothingLoaned => PortError::NothingLoaned,
            why => PortError::Refused { why, first: true },
        };
        match self.ports.get_mut(port).ok_or(PortError::WrongPort)? {
            Port::Unbound => Err(PortError::Unbound),
            Port::Input(_) | Port::Command { .. } => Err(PortError::WrongPort),
            Port::Output(writer) => writer.publish(time, now).map(drop).map_err(failed),
            Port::Wish { writer, refused } => match writer.publish_for(time, now, period.saturating_mul(2)) {
                Ok(_) => {
                    *refused = false;
                    Ok(())
                }
                Err(Refused::NothingLoaned) => Err(PortError::NothingLoaned),
                Err(why) => Err(PortError::Refused {
                    why,
                    first: !std::mem::replace(refused, true),
                }),
            },
        }
    }

    /// Takes back the newest value of an export.
    pub(crate) fn retract(&mut self, port: usize) -> Result<(), PortError> {
        match self.ports.get_mut(port) {
            Some(Port::Output(writer)) => {
                writer.retract();
                Ok(())
            }
            _ => Err(PortError::WrongPort),
        }
    }

    /// Lets go of every value read; the next read sees the newest.
    pub(crate) fn release(&mut self) {
        for port in &mut self.ports {
            match port {
                Port::Input(reader) => reader.release(),
                Port::Command { reader, in_force, .. } => {
                    reader.release();
                    *in_force = None;
                }
                Port::Unbound | Port::Output(_) | Port::Wish { .. } => {}
            }
        }
    }

    /// Forgets loans that were not published.
    pub(crate) fn discard_loans(&mut self) {
        for port in &mut self.ports {
            match port {
                Port::Output(writer) | Port::Wish { writer, .. } => writer.discard(),
                Port::Unbound | Port::Input(_) | Port::Command { .. } => {}
            }
        }
    }

    /// Time of the newest value read since the last release.
    pub(crate) fn newest(&self) -> Nanos {
        let times = self.ports.iter().filter_map(|port| match port {
            Port::Input(reader) | Port::Command { reader, .. } => {
                reader.latched().map(|latched| latched.stamp.time)
            }
            Port::Unbound | Port::Output(_) | Port::Wish { .. } => None,
        });
        times.max().unwrap_or(0)
    }
}

impl Aligned {
    pub(crate) fn new(bytes: &[u8]) -> Self {
        let mut words = vec![0_u128; bytes.len().div_ceil(16)];
        for (word, chunk) in words.iter_mut().zip(bytes.chunks(16)) {
            let mut whole = [0; 16];
            whole[..chunk.len()].copy_from_slice(chunk);
            *word = u128::from_ne_bytes(whole);
        }
        Self {
            words,
            bytes: bytes.len(),
        }
    }

    fn bytes(&self) -> &[u8] {
        // SAFETY: the words hold at least `bytes` initialized bytes.
        unsafe { std::slice::from_raw_parts(self.words.as_ptr().cast::<u8>(), self.bytes) }
    }
}
