//! WebSocket frames (RFC 6455) as they are read from a client and written to it. A library for WebSockets ends the connection
//! at a text that is no UTF-8 and at a message that is too long; here both end nothing but themselves: a long one is read
//! and dropped. Without extensions.

use std::io;

use tokio::io::{AsyncRead, AsyncReadExt as _, BufReader, sink};

/// The longest message of a client, bytes: subscriptions to thousands of channels.
const MAX_MESSAGE: usize = 256 << 10;
/// The longest content of a ping or a close, bytes, by the standard.
const MAX_CONTROL: u64 = 125;

/// What a frame is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub(super) enum Opcode {
    Text = 1,
    Binary = 2,
    Close = 8,
    Ping = 9,
    Pong = 10,
}

/// What arrived.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Arrival {
    Text(String),
    Binary(Vec<u8>),
    Ping(Vec<u8>),
    Pong,
    Close,
    /// A message that cannot be read, and why.
    Broken(String),
}

/// Reads the frames of a client.
pub(super) struct FrameReader<R> {
    stream: BufReader<R>,
    /// The message whose end has not arrived.
    open: Option<Open>,
}

struct Open {
    is_text: bool,
    bytes: Vec<u8>,
    is_long: bool,
}

struct Head {
    is_last: bool,
    opcode: u8,
    mask: [u8; 4],
    length: u64,
}

impl<R: AsyncRead + Unpin> FrameReader<R> {
    pub(super) fn new(stream: R) -> Self {
        Self {
            stream: BufReader::new(stream),
            open: None,
        }
    }

    /// Reads up to the end of the next message. A call that is cancelled leaves nothing to read.
    ///
    /// # Errors
    /// The client is gone, or what it sends are no frames.
    pub(super) async fn next(&mut self) -> io::Result<Arrival> {
        loop {
            let head = self.head().await?;
            let arrival = match head.opcode {
                0..=2 => self.data(&head).await?,
                8..=10 => Some(self.control(&head).await?),
                other => {
                    self.skip(head.length).await?;
                    Some(Arrival::Broken(format!(
                        "frames of the kind {other} have no meaning"
                    )))
                }
            };
            if let Some(arrival) = arrival {
                return Ok(arrival);
            }
        }
    }

    async fn head(&mut self) -> io::Result<Head> {
        let [first, second] = [self.stream.read_u8().await?, self.stream.read_u8().await?];
        // Clients mask, and bits for extensions are for those that were agreed on.
        if first & 0x70 != 0 || second & 0x80 == 0 {
            return Err(io::ErrorKind::InvalidData.into());
        }
        let length = match second & 0x7f {
            126 => u64::from(self.stream.read_u16().await?),
            127 => self.stream.read_u64().await?,
            short => u64::from(short),
        };
        let mut mask = [0; 4];
        self.stream.read_exact(&mut mask).await?;
        Ok(Head {
            is_last: first & 0x80 != 0,
            opcode: first & 0x0f,
            mask,
            length,
        })
    }

    /// Reads a frame of a message. Returns the message at its end.
    async fn data(&mut self, head: &Head) -> io::Result<Option<Arrival>> {
        let before = self.open.take();
        let is_continued = head.opcode == 0;
        if is_continued != before.is_some() {
            self.skip(head.length).await?;
            let reason = "a part of a message arrived without the others";
            return Ok(Some(Arrival::Broken(reason.to_owned())));
        }
        let mut open = before.unwrap_or_else(|| Open {
            is_text: head.opcode == Opcode::Text as u8,
            bytes: Vec::new(),
            is_long: false,
        });
        let room = MAX_MESSAGE - open.bytes.len();
        open.is_long |= head.length > room as u64;
        if open.is_long {
            open.bytes = Vec::new();
            self.skip(head.length).await?;
        } else {
            let bytes = self.payload(head).await?;
            open.bytes.extend(bytes);
        }
        if !head.is_last {
            self.open = Some(open);
            return Ok(None);
        }
        Ok(Some(open.into_arrival()))
    }

    async fn control(&mut self, head: &Head) -> io::Result<Arrival> {
        if head.length > MAX_CONTROL || !head.is_last {
            return Err(io::ErrorKind::InvalidData.into());
        }
        let bytes = self.payload(head).await?;
        Ok(match head.opcode {
            8 => Arrival::Close,
            9 => Arrival::Ping(bytes),
            _ => Arrival::Pong,
        })
    }

    /// Reads the payload of a frame that is known to be short.
    async fn payload(&mut self, head: &Head) -> io::Result<Vec<u8>> {
        let mut bytes = vec![0; head.length as usize];
        self.stream.read_exact(&mut bytes).await?;
        for (byte, mask) in bytes.iter_mut().zip(head.mask.iter().cycle()) {
            *byte ^= mask;
        }
        Ok(bytes)
    }

    async fn skip(&mut self, length: u64) -> io::Result<()> {
        let skipped = tokio::io::copy(&mut (&mut self.stream).take(length), &mut sink()).await?;
        if skipped < length {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        Ok(())
    }
}

impl Open {
    fn into_arrival(self) -> Arrival {
        if self.is_long {
            return Arrival::Broken(format!("the message is longer than {MAX_MESSAGE} bytes"));
        }
        if !self.is_text {
            return Arrival::Binary(self.bytes);
        }
        String::from_utf8(self.bytes).map_or_else(
            |_| Arrival::Broken("the text is no UTF-8".to_owned()),
            Arrival::Text,
        )
    }
}

/// Returns the head of a whole message of this length.
pub(super) fn head(opcode: Opcode, length: usize) -> Vec<u8> {
    let mut head = vec![0x80 | opcode as u8];
    match length {
        0..=125 => head.push(length as u8),
        126..=0xffff => {
            head.push(126);
            head.extend_from_slice(&(length as u16).to_be_bytes());
        }
        _ => {
            head.push(127);
            head.extend_from_slice(&(length as u64).to_be_bytes());
        }
    }
    head
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(first: u8, payload: &[u8]) -> Vec<u8> {
        let mut bytes = head(Opcode::Text, payload.len());
        (bytes[0], bytes[1]) = (first, bytes[1] | 0x80);
        bytes.extend([1, 2, 3, 4]);
        bytes.extend(
            payload
                .iter()
                .zip([1, 2, 3, 4].iter().cycle())
                .map(|(byte, mask)| byte ^ mask),
        );
        bytes
    }

    fn read(bytes: &[u8]) -> Vec<Arrival> {
        let runtime = tokio::runtime::Builder::new_current_thread().build().unwrap();
        runtime.block_on(async {
            let mut reader = FrameReader::new(bytes);
            let mut all = Vec::new();
            while let Ok(arrival) = reader.next().await {
                all.push(arrival);
            }
            all
        })
    }

    fn text(text: &str) -> Arrival {
        Arrival::Text(text.to_owned())
    }

    #[test]
    fn messages_of_any_length_and_in_parts_are_read_with_pings_between() {
        let long = "x".repeat(70_000);
        let bytes = [
            frame(0x81, b"one"),
            frame(0x82, &[0xff; 300]),
            frame(0x81, long.as_bytes()),
            frame(0x01, b"two "),
            frame(0x89, b"!"),
            frame(0x80, b"parts"),
            frame(0x88, b""),
        ];
        let expected = [
            text("one"),
            Arrival::Binary(vec![0xff; 300]),
            text(&long),
            Arrival::Ping(b"!".to_vec()),
            text("two parts"),
            Arrival::Close,
        ];
        assert_eq!(read(&bytes.concat()), expected);
    }

    #[test]
    fn broken_messages_end_nothing_but_themselves() {
        let huge = vec![b'x'; MAX_MESSAGE + 1];
        for broken in [
            frame(0x81, &[0xc3, 0x28]),
            frame(0x81, &huge),
            [frame(0x02, &huge[..MAX_MESSAGE]), frame(0x80, b"x")].concat(),
            frame(0x80, b"x"),
            frame(0x83, b"x"),
            frame(0x8b, &huge),
            frame(0x03, b""),
        ] {
            let arrived = read(&[broken, frame(0x81, b"next")].concat());
            assert!(
                matches!(&arrived[..], [Arrival::Broken(_), next] if *next == text("next")),
                "{arrived:?}"
            );
        }
    }

    #[test]
    fn what_is_no_frame_ends_the_connection() {
        let unmasked = [0x81, 1, b'x'];
        for end in [
            &unmasked[..],
            &frame(0xc1, b"x"),
            &frame(0x09, b""),
            &frame(0x89, &[0; 126]),
        ] {
            assert_eq!(read(&[end, &frame(0x81, b"next")].concat()), []);
        }
    }
}
