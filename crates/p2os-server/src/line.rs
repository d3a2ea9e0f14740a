//! A line to a robot, over TCP or a pseudo-terminal, with at most one client. It interprets no bytes and
//! never blocks.

use core::fmt;
use std::fs::{File, OpenOptions};
use std::io::{self, ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::os::fd::{AsFd, BorrowedFd};
use std::os::unix::fs::OpenOptionsExt;
use std::path::PathBuf;

use jde_port::Pty;
use rustix::event::PollFlags;
use rustix::fs::OFlags;

use crate::door::Door;

/// Most bytes that wait for a client that does not read. At a few hundred bytes a second this is a minute of
/// data.
const MOST_UNSENT: usize = 64 << 10;

/// The place where a client reaches a robot.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Place {
    /// A TCP address.
    Tcp(SocketAddr),
    /// The path of a serial line; any speed works.
    Terminal(PathBuf),
}

/// A line, and its client.
pub(crate) struct Line {
    end: End,
    peer: Option<Peer>,
}

enum End {
    Tcp(TcpListener),
    Terminal {
        pty: Pty,
        /// Keeps the terminal open between clients.
        _held: File,
        door: Door,
        /// The client has closed the terminal; its last bytes may still be unread.
        closed: bool,
        /// Bytes that were read together with the departure of a client, when the next client was already
        /// there. They may be the next client's.
        late: Vec<u8>,
    },
}

struct Peer {
    stream: Option<TcpStream>,
    name: String,
    unsent: Vec<u8>,
}

/// A client that waits to be admitted. Dropping it closes its connection.
pub(crate) struct Caller {
    stream: TcpStream,
    pub(crate) name: String,
}

impl Line {
    pub(crate) fn tcp(address: SocketAddr) -> io::Result<Self> {
        let listener = TcpListener::bind(address)?;
        listener.set_nonblocking(true)?;
        Ok(Self {
            end: End::Tcp(listener),
            peer: None,
        })
    }

    pub(crate) fn terminal() -> io::Result<Self> {
        let pty = Pty::open()?;
        rustix::io::ioctl_fionbio(pty.master(), true)?;
        let held = OpenOptions::new()
            .read(true)
            .write(true)
            .custom_flags(OFlags::NOCTTY.bits().cast_signed())
            .open(pty.path())?;
        Ok(Self {
            end: End::Terminal {
                door: Door::of(pty.path()),
                pty,
                _held: held,
                closed: false,
                late: Vec::new(),
            },
            peer: None,
        })
    }

    pub(crate) fn place(&self) -> io::Result<Place> {
        match &self.end {
            End::Tcp(listener) => listener.local_addr().map(Place::Tcp),
            End::Terminal { pty, .. } => Ok(Place::Terminal(pty.path().to_owned())),
        }
    }

    /// Returns what to poll: new clients, bytes to read, and room for unsent bytes.
    pub(crate) fn waits(&self) -> impl Iterator<Item = (BorrowedFd<'_>, PollFlags)> {
        let unsent = self.peer.as_ref().is_some_and(|peer| !peer.unsent.is_empty());
        let both = PollFlags::IN
            | if unsent {
                PollFlags::OUT
            } else {
                PollFlags::empty()
            };
        let stream = self.peer.as_ref().and_then(|peer| peer.stream.as_ref());
        let (door, speaks) = match &self.end {
            End::Tcp(listener) => (Some(listener.as_fd()), stream.map(AsFd::as_fd)),
            End::Terminal { pty, door, .. } => (door.wakes(), Some(pty.master().as_fd())),
        };
        let door = door.map(|door| (door, PollFlags::IN));
        let speaks = speaks.map(|line| (line, both));
        [door, speaks].into_iter().flatten()
    }

    /// Accepts a waiting client. A terminal has none: its client appears with its first bytes.
    pub(crate) fn caller(&self) -> Option<Caller> {
        let End::Tcp(listener) = &self.end else {
            return None;
        };
        // A client that closed before this, or whose connection cannot be configured, is dropped. The next
        // one is accepted in the next round.
        let (stream, address) = listener.accept().ok()?;
        Some(Caller {
            stream: jde_port::prepared(stream).ok()?,
            name: address.to_string(),
        })
    }

    /// Makes a caller the client, in place of any other.
    pub(crate) fn admit(&mut self, caller: Caller) {
        self.peer = Some(Peer {
            stream: Some(caller.stream),
            name: caller.name,
            unsent: Vec::new(),
        });
    }

    /// Makes the sender of bytes on a terminal the client.
    pub(crate) fn admit_heard(&mut self) {
        self.peer = Some(Peer {
            stream: None,
            name: self.name(),
            unsent: Vec::new(),
        });
    }

    /// Returns the name of a client on a terminal; TCP clients have their own names.
    pub(crate) fn name(&self) -> String {
        match &self.end {
            End::Tcp(_) => String::new(),
            End::Terminal { pty, .. } => pty.path().display().to_string(),
        }
    }

    /// Reads bytes, as many as fit; returns 0 if there are none. An error is the end of the client, in words.
    /// On a terminal it may return bytes of a client that is not admitted yet.
    pub(crate) fn read(&mut self, room: &mut [u8]) -> Result<usize, String> {
        let peer = self.peer.as_ref();
        let read = match (&mut self.end, peer.and_then(|peer| peer.stream.as_ref())) {
            (_, Some(mut stream)) => stream.read(room),
            (End::Tcp(_), None) => return Ok(0),
            (
                End::Terminal {
                    pty,
                    door,
                    closed,
                    late,
                    ..
                },
                None,
            ) => {
                let count = if late.is_empty() {
                    pty.master().read(room)
                } else {
                    let count = late.len().min(room.len());
                    room[..count].copy_from_slice(&late[..count]);
                    late.drain(..count);
                    Ok(count)
                };
                // After the read: a client opens the terminal before it writes.
                let left = door.look();
                *closed = peer.is_some() && (*closed || left);
                match (&count, peer) {
                    // The client's last bytes.
                    (Ok(_), Some(_)) if *closed && door.nobody() => {}
                    (Ok(count), Some(_)) if *closed => {
                        late.extend(&room[..*count]);
                        return Err(self.hang_up("it closed the line"));
                    }
                    (Err(error), Some(_)) if *closed && is_wait(error) => {
                        return Err(self.hang_up("it closed the line"));
                    }
                    // A client that was not admitted has left; its bytes are dropped.
                    (Ok(_), None) if door.nobody() => return Ok(0),
                    _ => {}
                }
                count
            }
        };
        match read {
            Ok(0) => Err(self.hang_up("it closed the connection")),
            Ok(count) => Ok(count),
            Err(error) if is_wait(&error) => Ok(0),
            Err(error) => Err(self.hang_up(&error.to_string())),
        }
    }

    /// Sends bytes after those that wait. An error is the end of the client, in words. A client that can no
    /// longer receive may have sent bytes before: [`read`](Self::read) returns those first, and then its end.
    pub(crate) fn write(&mut self, bytes: &[u8]) -> Result<(), String> {
        let Some(peer) = &mut self.peer else {
            return Ok(());
        };
        peer.unsent.extend(bytes);
        while !peer.unsent.is_empty() {
            let wrote = match (&peer.stream, &self.end) {
                (Some(stream), _) => (&*stream).write(&peer.unsent),
                (None, End::Terminal { pty, .. }) => pty.master().write(&peer.unsent),
                (None, End::Tcp(_)) => unreachable!("who came by TCP has a stream"),
            };
            match wrote {
                Ok(count) => drop(peer.unsent.drain(..count)),
                Err(error) if is_wait(&error) => break,
                Err(_) => peer.unsent.clear(),
            }
        }
        if peer.unsent.len() > MOST_UNSENT {
            return Err(self.hang_up("it does not read what it is sent"));
        }
        Ok(())
    }

    /// Returns the name of the client.
    pub(crate) fn peer(&self) -> Option<&str> {
        self.peer.as_ref().map(|peer| peer.name.as_str())
    }

    /// Returns whether this is a terminal, whose client may leave unnoticed: another program may also have it
    /// open.
    pub(crate) fn is_terminal(&self) -> bool {
        matches!(self.end, End::Terminal { .. })
    }

    /// Ends the client, and returns `why`.
    pub(crate) fn hang_up(&mut self, why: &str) -> String {
        self.peer = None;
        if let End::Terminal { pty, closed, .. } = &mut self.end {
            *closed = false;
            // Bytes that the client did not read must not reach the next one. The call fails only for a file
            // that is not a terminal.
            let _ = rustix::termios::tcflush(pty.master(), rustix::termios::QueueSelector::OFlush);
        }
        why.to_owned()
    }
}

fn is_wait(error: &io::Error) -> bool {
    matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted)
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Tcp(address) => write!(f, "tcp:{address}"),
            Self::Terminal(path) => write!(f, "serial:{}", path.display()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a terminal with an admitted client, and the client's end of it.
    fn admitted() -> (Line, File) {
        let mut line = Line::terminal().expect("a terminal");
        let Ok(Place::Terminal(path)) = line.place() else {
            panic!("a terminal is at a path");
        };
        let mut client = OpenOptions::new()
            .read(true)
            .write(true)
            .custom_flags(OFlags::NOCTTY.bits().cast_signed())
            .open(path)
            .expect("a terminal");
        client.write_all(b"hello").expect("there is room");
        assert_eq!(heard(&mut line), Ok(b"hello".to_vec()));
        line.admit_heard();
        (line, client)
    }

    fn heard(line: &mut Line) -> Result<Vec<u8>, String> {
        let mut room = [0; 64];
        let count = line.read(&mut room)?;
        Ok(room[..count].to_vec())
    }

    #[test]
    fn last_words_on_a_terminal_are_heard_before_it_is_closed() {
        let (mut line, mut client) = admitted();
        client.write_all(b"bye").expect("there is room");
        drop(client);
        assert_eq!(heard(&mut line), Ok(b"bye".to_vec()));
        assert_eq!(heard(&mut line), Err("it closed the line".to_owned()));
        assert!(line.peer().is_none());
        assert_eq!(heard(&mut line), Ok(Vec::new()));
    }

    #[test]
    fn last_words_on_a_connection_are_heard_though_it_cannot_be_answered() {
        let mut line = Line::tcp(([127, 0, 0, 1], 0).into()).expect("a port");
        let Ok(Place::Tcp(address)) = line.place() else {
            panic!("a port has an address");
        };
        let mut client = TcpStream::connect(address).expect("somebody listens");
        let caller = loop {
            // The system may still be completing the connection.
            if let Some(caller) = line.caller() {
                break caller;
            }
        };
        line.admit(caller);
        line.write(b"unread").expect("it is there");
        let mut room = [0; 1];
        assert_eq!(client.peek(&mut room).expect("it was sent"), 1);
        client.write_all(b"bye").expect("there is room");
        // The client has not read everything, so that the system refuses further bytes to it.
        drop(client);
        line.write(b"more")
            .expect("its end is told behind its last words");
        assert_eq!(heard(&mut line), Ok(b"bye".to_vec()));
        while heard(&mut line).is_ok() {}
        assert!(line.peer().is_none());
    }
}
