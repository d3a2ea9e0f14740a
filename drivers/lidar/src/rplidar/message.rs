//! Requests and replies on the wire. This module does not interpret them, and does no I/O.
//!
//! From SLAMTEC's "RPLIDAR Interface Protocol": a request is 0xA5, a command and, if the command has data, their
//! length, the data and the exclusive or of all bytes before. A reply is 0xA5, 0x5A, a word with the length of the data
//! in its lower 30 bits and how many follow in its upper two, the type and the data. Numbers are sent low byte first.

const REQUEST: u8 = 0xa5;
const REPLY: [u8; 2] = [0xa5, 0x5a];
/// Bytes before the data of a reply.
const HEAD: usize = 7;
/// Commands from this bit on have data.
const HAS_DATA: u8 = 0x80;
/// Longest data of a reply that the driver asks for, with a margin, bytes.
const MAX_DATA: usize = 256;

/// A reply.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Reply {
    /// The only one to a request.
    Single { kind: u8, data: Vec<u8> },
    /// Measurements of this type follow until the lidar is stopped.
    Stream { kind: u8 },
}

/// Finds replies in the received bytes, however they are split and whatever lies between them.
#[derive(Debug, Default)]
pub(crate) struct Receiver {
    bytes: Vec<u8>,
}

/// Builds a request.
pub(crate) fn request(command: u8, data: &[u8]) -> Vec<u8> {
    let mut request = vec![REQUEST, command];
    if command & HAS_DATA != 0 {
        request.push(data.len() as u8);
        request.extend_from_slice(data);
        request.push(request.iter().fold(0, |sum, byte| sum ^ byte));
    }
    request
}

impl Receiver {
    /// Appends received bytes.
    pub(crate) fn receive(&mut self, bytes: &[u8]) {
        self.bytes.extend_from_slice(bytes);
    }

    /// Discards what was received.
    pub(crate) fn clear(&mut self) {
        self.bytes.clear();
    }

    /// Returns the bytes after the last reply: the first measurements of a stream.
    pub(crate) fn take_rest(&mut self) -> Vec<u8> {
        core::mem::take(&mut self.bytes)
    }

    /// Returns the next reply; `None` until more bytes arrive.
    pub(crate) fn next(&mut self) -> Option<Reply> {
        let (mut start, mut reply) = (0, None);
        while let Some(rest) = self.bytes.get(start..).filter(|rest| !rest.is_empty()) {
            let is_head = rest.iter().zip(REPLY).all(|(byte, expected)| *byte == expected);
            let Some((head, data)) = rest.split_first_chunk::<HEAD>().filter(|_| is_head) else {
                if is_head {
                    break;
                }
                start += 1;
                continue;
            };
            let [_, _, word @ .., kind] = *head;
            let word = u32::from_le_bytes(word);
            let (size, count) = ((word & 0x3fff_ffff) as usize, word >> 30);
            if count == 1 {
                start += HEAD;
                reply = Some(Reply::Stream { kind });
                break;
            } else if count > 1 || size > MAX_DATA {
                start += 1;
            } else {
                let Some(data) = data.get(..size) else { break };
                start += HEAD + size;
                let data = data.to_vec();
                reply = Some(Reply::Single { kind, data });
                break;
            }
        }
        self.bytes.drain(..start);
        reply
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Replies of the protocol's description: health, and the start of a scan.
    const HEALTH: [u8; 10] = [0xa5, 0x5a, 3, 0, 0, 0, 6, 2, 0x34, 0x12];
    const SCAN: [u8; 7] = [0xa5, 0x5a, 5, 0, 0, 0x40, 0x81];

    fn receive_all(pieces: &[&[u8]]) -> Vec<Reply> {
        let mut receiver = Receiver::default();
        let mut all = Vec::new();
        for piece in pieces {
            receiver.receive(piece);
            all.extend(core::iter::from_fn(|| receiver.next()));
        }
        all
    }

    fn expected() -> [Reply; 2] {
        let data = vec![2, 0x34, 0x12];
        [Reply::Single { kind: 6, data }, Reply::Stream { kind: 0x81 }]
    }

    #[test]
    fn requests_are_those_of_the_description_to_the_byte() {
        assert_eq!(request(0x25, &[]), [0xa5, 0x25]);
        assert_eq!(request(0x82, &[0; 5]), [0xa5, 0x82, 5, 0, 0, 0, 0, 0, 0x22]);
        assert_eq!(request(0xf0, &[0x94, 0x02]), [0xa5, 0xf0, 2, 0x94, 0x02, 0xc1]);
    }

    #[test]
    fn replies_are_found_between_text_and_false_heads() {
        let text = b"RP LIDAR System.\r\nFirmware Ver 1.29\r\n";
        for noise in [
            &text[..],
            &[0xa5],
            &[0xa5, 0x5a, 0xff, 0xff, 0, 0, 9],
            &[0xa5, 0xa5],
        ] {
            assert_eq!(receive_all(&[&[noise, &HEALTH, &SCAN].concat()]), expected());
        }
    }

    proptest! {
        #[test]
        fn replies_are_found_after_any_split(cut in 0..17_usize) {
            let bytes = [&HEALTH[..], &SCAN].concat();
            let (head, tail) = bytes.split_at(cut);
            prop_assert_eq!(receive_all(&[head, tail]), expected());
        }
    }
}
