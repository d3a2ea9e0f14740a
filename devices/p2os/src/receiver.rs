//! Finds packets in a stream of bytes that may contain anything else. It holds no more than one packet, and
//! interprets none.

use core::time::Duration;

use crate::packet::{HEADER, MAX_PAYLOAD, MAX_WIRE, Packet, checksum};

/// The longest pause inside a packet, after which its rest is not expected: both ends send a packet in one
/// piece.
pub const MAX_GAP: Duration = Duration::from_millis(100);

/// Processes bytes and returns packets. After garbage it resumes at the next byte that can start a packet.
#[derive(Clone, Debug)]
pub struct Receiver {
    buffer: Vec<u8>,
    last_received: Duration,
    dropped: Dropped,
}

/// The counts of what a receiver discarded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Dropped {
    /// Packets with a wrong checksum.
    pub checksums: u64,
    /// Packets whose rest did not arrive in time.
    pub gaps: u64,
    /// Bytes that belong to no valid packet, including those of the packets above.
    pub bytes: u64,
}

impl Receiver {
    /// Creates an empty receiver.
    #[must_use]
    pub fn new() -> Self {
        Self {
            buffer: Vec::with_capacity(MAX_WIRE),
            last_received: Duration::ZERO,
            dropped: Dropped::default(),
        }
    }

    /// Processes bytes that arrived by `now`, on a monotonic clock, and calls `on_packet` with every packet
    /// that they complete.
    pub fn receive(&mut self, bytes: &[u8], now: Duration, mut on_packet: impl FnMut(Packet)) {
        if bytes.is_empty() {
            return;
        }
        if !self.buffer.is_empty() && now.saturating_sub(self.last_received) > MAX_GAP {
            self.dropped.gaps += 1;
            self.dropped.bytes += self.buffer.len() as u64;
            self.buffer.clear();
        }
        self.last_received = now;
        for byte in bytes {
            self.buffer.push(*byte);
            self.parse_buffer(&mut on_packet);
        }
    }

    /// Returns what was discarded so far.
    #[must_use]
    pub fn dropped(&self) -> Dropped {
        self.dropped
    }

    /// Removes complete packets and garbage from the buffer. Afterwards it is the start of an incomplete
    /// packet, or empty.
    fn parse_buffer(&mut self, on_packet: &mut impl FnMut(Packet)) {
        loop {
            match parse(&self.buffer) {
                Parsed::Wait => return,
                Parsed::Good(packet, length) => {
                    self.buffer.drain(..length);
                    on_packet(packet);
                }
                Parsed::BadChecksum => {
                    self.dropped.checksums += 1;
                    self.skip();
                }
                Parsed::Junk => self.skip(),
            }
        }
    }

    /// Discards one byte: a real packet may start within what looked like one.
    fn skip(&mut self) {
        self.buffer.remove(0);
        self.dropped.bytes += 1;
    }
}

impl Default for Receiver {
    fn default() -> Self {
        Self::new()
    }
}

#[expect(clippy::large_enum_variant, reason = "it lives for one match, on the stack")]
enum Parsed {
    Wait,
    /// A packet, and its number of bytes on the wire.
    Good(Packet, usize),
    BadChecksum,
    Junk,
}

fn parse(buffer: &[u8]) -> Parsed {
    let header = buffer.len().min(2);
    if buffer[..header] != HEADER[..header] {
        return Parsed::Junk;
    }
    let Some(&count) = buffer.get(2) else {
        return Parsed::Wait;
    };
    let count = usize::from(count);
    if !(3..=MAX_PAYLOAD + 2).contains(&count) {
        return Parsed::Junk;
    }
    let Some(body) = buffer.get(3..3 + count) else {
        return Parsed::Wait;
    };
    let (payload, sum) = body.split_at(count - 2);
    if checksum(payload).to_be_bytes() != sum {
        return Parsed::BadChecksum;
    }
    Packet::new(payload).map_or(Parsed::Junk, |packet| Parsed::Good(packet, 3 + count))
}
