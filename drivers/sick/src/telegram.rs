//! Telegrams on the wire: framed, checked, and found again after any garbage. This module does not interpret
//! them.
//!
//! From SICK's "Telegrams for configuring and operating the LMS 2xx": STX, address, length (2 bytes, low
//! first) of the part from the command to before the checksum, command, data, a status byte in replies, and a
//! checksum of everything before it (2 bytes, low first).

const STX: u8 = 0x02;
const NACK: u8 = 0x15;
/// The host sends to address 0. The scanner replies from 0x80 plus its own number.
const TO_ANY: u8 = 0x00;
const FROM_SCANNER: u8 = 0x80;
/// STX, address and length.
const HEAD: usize = 4;
const CHECKSUM: usize = 2;
/// Longest telegram by the manual, including head and checksum, bytes.
const MAX_TELEGRAM: usize = 812;
const POLYNOMIAL: u16 = 0x8005;

/// A message from the scanner.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Received {
    /// The scanner could not read the last telegram.
    Nack,
    /// A reply or an unsolicited telegram.
    Telegram(Telegram),
}

/// A telegram from the scanner.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Telegram {
    /// The command of the request with its highest bit set.
    pub(crate) command: u8,
    pub(crate) data: Vec<u8>,
    /// The state of the scanner.
    pub(crate) status: u8,
    /// Size on the wire, bytes.
    pub(crate) size: usize,
}

/// Finds telegrams in the received bytes, however they are split and whatever lies between them.
#[derive(Debug, Default)]
pub(crate) struct Receiver {
    bytes: Vec<u8>,
    start: usize,
}

/// Builds a telegram of the host.
pub(crate) fn request(payload: &[u8]) -> Vec<u8> {
    framed(TO_ANY, payload)
}

/// Builds a telegram to or from an address. The payload is a command and its data.
pub(crate) fn framed(address: u8, payload: &[u8]) -> Vec<u8> {
    let [low, high] = (payload.len() as u16).to_le_bytes();
    let mut telegram = vec![STX, address, low, high];
    telegram.extend_from_slice(payload);
    telegram.extend_from_slice(&checksum(&telegram).to_le_bytes());
    telegram
}

/// The checksum of the manual. Each byte enters twice, the second time as the high byte, after a shift by one
/// bit.
fn checksum(bytes: &[u8]) -> u16 {
    let (mut sum, mut before) = (0_u16, 0);
    for &byte in bytes {
        let carry = sum & 0x8000 != 0;
        sum <<= 1;
        if carry {
            sum ^= POLYNOMIAL;
        }
        sum ^= u16::from_le_bytes([byte, before]);
        before = byte;
    }
    sum
}

impl Receiver {
    /// Appends received bytes.
    pub(crate) fn receive(&mut self, bytes: &[u8]) {
        self.bytes.drain(..self.start);
        self.start = 0;
        self.bytes.extend_from_slice(bytes);
    }

    /// Discards a partial telegram, which is invalid after a change of speed.
    pub(crate) fn clear(&mut self) {
        self.bytes.clear();
        self.start = 0;
    }

    /// Returns the next message; `None` until more bytes arrive.
    pub(crate) fn next(&mut self) -> Option<Received> {
        loop {
            let rest = &self.bytes[self.start..];
            match *rest.first()? {
                STX => match telegram(rest) {
                    ParseResult::Complete(telegram) => {
                        self.start += telegram.size;
                        return Some(Received::Telegram(telegram));
                    }
                    ParseResult::Partial => return None,
                    ParseResult::Garbage => self.start += 1,
                },
                NACK => {
                    self.start += 1;
                    return Some(Received::Nack);
                }
                _ => self.start += 1,
            }
        }
    }
}

enum ParseResult {
    Complete(Telegram),
    /// Valid so far, but incomplete.
    Partial,
    Garbage,
}

fn telegram(bytes: &[u8]) -> ParseResult {
    match bytes.get(1) {
        None => return ParseResult::Partial,
        Some(address) if address & FROM_SCANNER == 0 => return ParseResult::Garbage,
        Some(_) => {}
    }
    let &[_, _, low, high, ..] = bytes else {
        return ParseResult::Partial;
    };
    let length = usize::from(u16::from_le_bytes([low, high]));
    let size = HEAD + length + CHECKSUM;
    if length < 2 || size > MAX_TELEGRAM {
        return ParseResult::Garbage;
    }
    let Some(whole) = bytes.get(..size) else {
        return ParseResult::Partial;
    };
    let (checked, sum) = whole.split_at(size - CHECKSUM);
    let &[_, _, _, _, command, ref data @ .., status] = checked else {
        return ParseResult::Garbage;
    };
    if checksum(checked).to_le_bytes() != sum {
        return ParseResult::Garbage;
    }
    ParseResult::Complete(Telegram {
        command,
        data: data.to_vec(),
        status,
        size,
    })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn requests_are_those_of_the_manual_to_the_byte() {
        assert_eq!(request(&[0x31]), [0x02, 0x00, 0x01, 0x00, 0x31, 0x15, 0x12]);
        assert_eq!(
            request(&[0x20, 0x24]),
            [0x02, 0x00, 0x02, 0x00, 0x20, 0x24, 0x34, 0x08]
        );
        assert_eq!(
            request(&[0x20, 0x42]),
            [0x02, 0x00, 0x02, 0x00, 0x20, 0x42, 0x52, 0x08]
        );
        assert_eq!(
            request(&[0x20, 0x48]),
            [0x02, 0x00, 0x02, 0x00, 0x20, 0x48, 0x58, 0x08]
        );
        assert_eq!(
            request(&[0x30, 0x01]),
            [0x02, 0x00, 0x02, 0x00, 0x30, 0x01, 0x31, 0x18]
        );
        let variant = request(&[0x3b, 180, 0, 100, 0]);
        assert_eq!(
            variant,
            [0x02, 0x00, 0x05, 0x00, 0x3b, 0xb4, 0x00, 0x64, 0x00, 0x97, 0x49]
        );
        let password = request(b"\x20\x00SICK_LMS");
        assert_eq!(password[password.len() - 2..], [0xbe, 0xc5]);
    }

    fn reply(data: &[u8]) -> Vec<u8> {
        framed(0x80, &[&[0xb0], data, &[0x10]].concat())
    }

    fn receive_all(pieces: impl IntoIterator<Item = Vec<u8>>) -> Vec<Received> {
        let mut receiver = Receiver::default();
        let mut all = Vec::new();
        for piece in pieces {
            receiver.receive(&piece);
            while let Some(message) = receiver.next() {
                all.push(message);
            }
        }
        all
    }

    fn data(messages: &[Received]) -> Vec<&[u8]> {
        messages
            .iter()
            .map(|message| match message {
                Received::Nack => &[][..],
                Received::Telegram(telegram) => &*telegram.data,
            })
            .collect()
    }

    #[test]
    fn a_false_start_hides_no_telegram_after_it() {
        // Each looks like the start of a telegram: STX, the address of a reply, a length.
        for false_start in [
            &[0x02_u8][..],
            &[0x02, 0x80],
            &[0x02, 0x80, 0x05, 0x00],
            &[0x02, 0x02, 0x80],
        ] {
            let bytes = [false_start, &reply(b"one"), &reply(b"two")].concat();
            assert_eq!(data(&receive_all([bytes])), [b"one", b"two"]);
        }
    }

    #[test]
    fn a_telegram_that_is_too_long_is_rejected() {
        let longest = MAX_TELEGRAM - HEAD - CHECKSUM - 2;
        assert_eq!(receive_all([reply(&vec![0xff; longest])]).len(), 1);
        assert_eq!(receive_all([reply(&vec![0xff; longest + 1])]), []);
    }

    #[test]
    fn ten_thousand_telegrams_with_a_wrong_byte_are_rejected() {
        let whole = reply(b"ranges and more ranges");
        let mut number = 7_u32;
        let mut random = || {
            number = number.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (number >> 16) as usize
        };
        for _ in 0..10_000 {
            let mut corrupted = whole.clone();
            let index = random() % corrupted.len();
            corrupted[index] ^= (1 + random() % 255) as u8;
            let all = receive_all([corrupted.clone(), reply(b"next"), vec![0; MAX_TELEGRAM]]);
            let accepted: Vec<_> = data(&all).into_iter().filter(|data| !data.is_empty()).collect();
            assert_eq!(accepted, [b"next"], "{corrupted:?}");
        }
    }

    proptest! {
        #[test]
        fn telegrams_are_found_after_any_split(cuts in prop::collection::vec(1_usize..40, 1..40)) {
            let bytes = [reply(b"one"), vec![NACK], reply(&[0x02, 0x80, 0x15, 0x06]), reply(b"")].concat();
            let mut rest = &bytes[..];
            let mut pieces = Vec::new();
            for cut in cuts.iter().cycle() {
                if rest.is_empty() {
                    break;
                }
                let (piece, more) = rest.split_at(rest.len().min(*cut));
                pieces.push(piece.to_vec());
                rest = more;
            }
            let all = receive_all(pieces);
            prop_assert_eq!(data(&all), [&b"one"[..], &[], &[0x02, 0x80, 0x15, 0x06], &[]]);
        }

        #[test]
        fn no_bytes_panic(pieces in prop::collection::vec(prop::collection::vec(any::<u8>(), 0..900), 0..6)) {
            receive_all(pieces);
        }
    }
}
