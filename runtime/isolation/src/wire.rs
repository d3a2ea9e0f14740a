//! The messages between the host and a child: frames of a fixed head and some bytes, over a Unix socket.
//!
//! Both ends are the same build, so numbers are in the machine's byte order. The host trusts no frame: an
//! unexpected one ends the child.

use std::io::{self, BufReader, Read, Write};
use std::net::Shutdown;
use std::os::unix::net::UnixStream;
use std::time::Duration;

/// The size of a head, bytes.
const HEAD: usize = 56;
/// The most bytes after a head: more than any value or panel has, and harmless to allocate.
const MAX_BYTES: u64 = 256 << 20;

/// The kind of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameKind {
    /// The first message: the type to load, its ports and its limits. The host sends this and the calls
    /// below, and the child replies to each with [`Self::Done`].
    Start,
    /// From the host, before a call and without a reply: the value of an input that the call may read, or
    /// memory for the next value of an output.
    Value,
    /// Call: create an instance.
    Create,
    /// Call: wake it up.
    Awake,
    /// Call: evaluate its precondition.
    Check,
    /// Call: iterate.
    Iterate,
    /// Call: evaluate its precondition, and iterate if that is true.
    CheckAndIterate,
    /// Call: arbitrate among its children.
    Arbitrate,
    /// Call: put it to sleep.
    Sleep,
    /// Call: draw its panel.
    Draw,
    /// Call: deliver a gesture on its panel.
    Touch,
    /// Call: save its memory.
    Save,
    /// Call: restore saved memory.
    Restore,
    /// Call: end the instance.
    Destroy,
    /// The host's reply to a request.
    Reply,
    /// Request of the child during a call: the value of an input.
    Read,
    /// Request of the child during a call: memory for the next value of an output.
    Loan,
    /// From the child during a call: publish the loan. A request unless it is [`UNANSWERED`].
    Publish,
    /// From the child during a call: retract the last value. A request unless it is [`UNANSWERED`].
    Retract,
    /// Request of the child during a call: wake a child.
    Wake,
    /// Request of the child during a call: put a child to sleep.
    PutToSleep,
    /// Request of the child during a call: the state of a child.
    Child,
    /// Request of the child during a call: change the policy of a group.
    SetPolicy,
    /// Request of the child during a call: from now on its debugger holds the call, or no longer does (number 0).
    Hold,
    /// From the child, without a reply: a line for the log.
    Log,
    /// From the child, without a reply: the reason why the call fails.
    Fail,
    /// From the child: the call ended. The second and third word contain the ports whose early values it
    /// read, a bit each; the fourth the first time that it obtained from the clock, plus one.
    Done,
}

impl FrameKind {
    const ALL: [Self; 27] = [
        Self::Start,
        Self::Value,
        Self::Create,
        Self::Awake,
        Self::Check,
        Self::Iterate,
        Self::CheckAndIterate,
        Self::Arbitrate,
        Self::Sleep,
        Self::Draw,
        Self::Touch,
        Self::Save,
        Self::Restore,
        Self::Destroy,
        Self::Reply,
        Self::Read,
        Self::Loan,
        Self::Publish,
        Self::Retract,
        Self::Wake,
        Self::PutToSleep,
        Self::Child,
        Self::SetPolicy,
        Self::Hold,
        Self::Log,
        Self::Fail,
        Self::Done,
    ];
}

/// A value or loan is in mapped memory, at the offset in the third word.
pub const IN_PLACE: u32 = 1 << 31;
/// The precondition is true.
pub const READY: u32 = 1;
/// The call may change nothing.
pub const CHANGES_NOTHING: u32 = 2;
/// The host answers every change, because this call may not do all that its authority allows.
pub const ANSWERED: u32 = 4;
/// The child knows the outcome and waits for no reply.
pub const UNANSWERED: u32 = 8;
/// The value is the one that the child was sent last, and is not repeated.
pub const UNCHANGED: u32 = 1 << 30;

/// One message. The meaning of numbers and words is defined where a kind is built.
#[derive(Debug)]
pub struct Frame {
    /// Its kind.
    pub kind: FrameKind,
    /// A port, a role or a version.
    pub number: u32,
    /// A status of the ABI.
    pub status: i32,
    /// The flags of its kind.
    pub flags: u32,
    /// The numbers of its kind.
    pub words: [u64; 4],
    /// The data of its kind.
    pub bytes: Vec<u8>,
}

/// One end of the stream.
#[derive(Debug)]
pub struct Wire {
    stream: BufReader<UnixStream>,
    /// The messages to be sent.
    output: Vec<u8>,
}

impl Frame {
    /// Returns an empty message.
    pub fn new(kind: FrameKind) -> Self {
        Self {
            kind,
            number: 0,
            status: 0,
            flags: 0,
            words: [0; 4],
            bytes: Vec::new(),
        }
    }
}

impl Wire {
    /// Wraps one end of a stream.
    pub fn new(stream: UnixStream) -> Self {
        Self {
            stream: BufReader::new(stream),
            output: Vec::new(),
        }
    }

    /// Sets how long reads and writes wait for the other end; without a limit if `timeout` is `None`.
    pub fn set_timeout(&self, timeout: Option<Duration>) -> io::Result<()> {
        let stream = self.stream.get_ref();
        stream.set_read_timeout(timeout)?;
        stream.set_write_timeout(timeout)
    }

    /// Shuts the stream down, so that the other end detects its end.
    pub fn close(&self) {
        // Fails only if the other end is gone already.
        drop(self.stream.get_ref().shutdown(Shutdown::Both));
    }

    /// Sends a message, after those in the queue.
    pub fn send(&mut self, frame: &Frame) -> io::Result<()> {
        self.queue(frame);
        let sent = self.stream.get_mut().write_all(&self.output);
        self.output.clear();
        sent
    }

    /// Queues a message, to be sent with the next.
    pub fn queue(&mut self, frame: &Frame) {
        for number in [frame.kind as u32, frame.number, frame.status as u32, frame.flags] {
            self.output.extend(number.to_ne_bytes());
        }
        for word in frame.words.iter().chain([&(frame.bytes.len() as u64)]) {
            self.output.extend(word.to_ne_bytes());
        }
        self.output.extend_from_slice(&frame.bytes);
    }

    /// Receives the next frame.
    ///
    /// # Errors
    /// Errors of the system; `UnexpectedEof` if the other end is gone; `InvalidData` if the bytes are not
    /// a frame.
    pub fn receive(&mut self) -> io::Result<Frame> {
        let mut head = [0; HEAD];
        self.stream.read_exact(&mut head)?;
        let number = |index: usize| u32::from_ne_bytes(field_at(&head, 4 * index));
        let word = |index: usize| u64::from_ne_bytes(field_at(&head, 16 + 8 * index));
        let kind = FrameKind::ALL.get(number(0) as usize).copied();
        let (Some(kind), length @ ..=MAX_BYTES) = (kind, word(4)) else {
            return Err(io::ErrorKind::InvalidData.into());
        };
        let mut bytes = vec![0; length as usize];
        self.stream.read_exact(&mut bytes)?;
        Ok(Frame {
            kind,
            number: number(1),
            status: number(2) as i32,
            flags: number(3),
            words: [word(0), word(1), word(2), word(3)],
            bytes,
        })
    }
}

fn field_at<const N: usize>(head: &[u8; HEAD], offset: usize) -> [u8; N] {
    *head[offset..].first_chunk().expect("a head has all its fields")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pair() -> (Wire, UnixStream) {
        let (first, second) = UnixStream::pair().expect("a pair");
        (Wire::new(first), second)
    }

    #[test]
    fn a_frame_arrives_as_it_was_sent() {
        let (mut wire, other) = pair();
        for kind in FrameKind::ALL {
            let sent = Frame {
                kind,
                number: 7,
                status: -3,
                flags: IN_PLACE | READY,
                words: [1, u64::MAX, 3, 4],
                bytes: vec![9; 20_000],
            };
            wire.send(&sent).expect("a sent message");
            let received = Wire::new(other.try_clone().expect("a copy")).receive();
            assert_eq!(format!("{:?}", received.expect("a frame")), format!("{sent:?}"));
        }
    }

    #[test]
    fn invalid_frames_are_refused() {
        let lengths = [(99_u32, 0_u64), (0, MAX_BYTES + 1), (0, u64::MAX)];
        for (kind, length) in lengths {
            let (mut wire, mut other) = pair();
            let mut head = [0; HEAD];
            head[..4].copy_from_slice(&kind.to_ne_bytes());
            head[48..].copy_from_slice(&length.to_ne_bytes());
            other.write_all(&head).expect("a sent message");
            let error = wire.receive().expect_err("no frame");
            assert_eq!(error.kind(), io::ErrorKind::InvalidData);
        }
    }

    #[test]
    fn the_end_of_the_stream_is_detected() {
        let (mut wire, mut other) = pair();
        other.write_all(&[0; 11]).expect("a sent message");
        drop(other);
        let error = wire.receive().expect_err("no complete frame");
        assert_eq!(error.kind(), io::ErrorKind::UnexpectedEof);
    }
}
