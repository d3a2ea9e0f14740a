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

use crate::terminal_watch::TerminalWatch;

/// Most bytes that wait for a client that does not read. At a few hundred bytes a second this is a minute of
/// data.
const MAX_UNSENT: usize = 64 << 10;

/// The place where a client reaches a robot.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum EndpointAddress {
    /// A TCP address.
    Tcp(SocketAddr),
    /// The path of a serial line; any speed works.
    Terminal(PathBuf),
}

/// A line, and its client.
pub(crate) struct Endpoint {
    transport: Transport,
    client: Option<Client>,
}

enum Transport {
    Tcp(TcpListener),
    Terminal {
        pty: Pty,
        /// Keeps the terminal open between clients.
        _guard: File,
        watch: TerminalWatch,
        /// The client has closed the terminal; its last bytes may still be unread.
        closed: bool,
        /// Bytes that were read together with the departure of a client, when the next client was already
        /// there. They may be the next client's.
        next_bytes: Vec<u8>,
    },
}

struct Client {
    stream: Option<TcpStream>,
    name: String,
    unsent: Vec<u8>,
}

/// A client that waits to be admitted. Dropping it closes its connection.
pub(crate) struct PendingClient {
    stream: TcpStream,
    pub(crate) name: String,
}

impl Endpoint {
    pub(crate) fn tcp(address: SocketAddr) -> io::Result<Self> {
        let listener = TcpListener::bind(address)?;
        listener.set_nonblocking(true)?;
        Ok(Self {
            transport: Transport::Tcp(listener),
            client: None,
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
            transport: Transport::Terminal {
                watch: TerminalWatch::of(pty.path()),
                pty,
                _guard: held,
                closed: false,
                next_bytes: Vec::new(),
            },
            client: None,
        })
    }

    pub(crate) fn address(&self) -> io::Result<EndpointAddress> {
        match &self.transport {
            Transport::Tcp(listener) => listener.local_addr().map(EndpointAddress::Tcp),
            Transport::Terminal { pty, .. } => Ok(EndpointAddress::Terminal(pty.path().to_owned())),
        }
    }

    /// Returns what to poll: new clients, bytes to read, and room for unsent bytes.
    pub(crate) fn poll_fds(&self) -> impl Iterator<Item = (BorrowedFd<'_>, PollFlags)> {
        let unsent = self.client.as_ref().is_some_and(|peer| !peer.unsent.is_empty());
        let both = PollFlags::IN
            | if unsent {
                PollFlags::OUT
            } else {
                PollFlags::empty()
            };
        let stream = self.client.as_ref().and_then(|peer| peer.stream.as_ref());
        let (door, speaks) = match &self.transport {
            Transport::Tcp(listener) => (Some(listener.as_fd()), stream.map(AsFd::as_fd)),
            Transport::Terminal { pty, watch: door, .. } => (door.poll_fd(), Some(pty.master().as_fd())),
        };
        let door = door.map(|door| (door, PollFlags::IN));
        let speaks = speaks.map(|line| (line, both));
        [door, speaks].into_iter().flatten()
    }

    /// Accepts a waiting client. A terminal has none: its client appears with its first bytes.
    pub(crate) fn accept(&self) -> Option<PendingClient> {
        let Transport::Tcp(listener) = &self.transport else {
            return None;
        };
        // A client that closed before this, or whose connection cannot be configured, is dropped. The next
        // one is accepted in the next round.
        let (stream, address) = listener.accept().ok()?;
        Some(PendingClient {
            stream: jde_port::configure_stream(stream).ok()?,
            name: address.to_string(),
        })
    }

    /// Makes a caller the client, in place of any other.
    pub(crate) fn admit(&mut self, caller: PendingClient) {
        self.client = Some(Client {
            stream: Some(caller.stream),
            name: caller.name,
            unsent: Vec::new(),
        });
    }

    /// Makes the sender of bytes on a terminal the client.
    pub(crate) fn admit_sender(&mut self) {
        self.client = Some(Client {
            stream: None,
            name: self.name(),
            unsent: Vec::new(),
        });
    }

    /// Returns the name of a client on a terminal; TCP clients have their own names.
    pub(crate) fn name(&self) -> String {
        match &self.transport {
            Transport::Tcp(_) => String::new(),
            Transport::Terminal { pty, .. } => pty.path().display().to_string(),
        }
    }

    /// Reads bytes, as many as fit; returns 0 if there are none. An error is the end of the client, in words.
    /// On a terminal it may return bytes of a client that is not admitted yet.
    pub(crate) fn read(&mut self, room: &mut [u8]) -> Result<usize, String> {
        let peer = self.client.as_ref();
        let read = match (&mut self.transport, peer.and_then(|peer| peer.stream.as_ref())) {
            (_, Some(mut stream)) => stream.read(room),
            (Transport::Tcp(_), None) => return Ok(0),
            (
                Transport::Terminal {
                    pty,
                    watch: door,
                    closed,
                    next_bytes: late,
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
                let left = door.update();
                *closed = peer.is_some() && (*closed || left);
                match (&count, peer) {
                    // The client's last bytes.
                    (Ok(_), Some(_)) if *closed && door.is_unused() => {}
                    (Ok(count), Some(_)) if *closed => {
                        late.extend(&room[..*count]);
                        return Err(self.hang_up("it closed the line"));
                    }
                    (Err(error), Some(_)) if *closed && is_would_block(error) => {
                        return Err(self.hang_up("it closed the line"));
                    }
                    // A client that was not admitted has left; its bytes are dropped.
                    (Ok(_), None) if door.is_unused() => return Ok(0),
                    _ => {}
                }
                count
            }
        };
        match read {
            Ok(0) => Err(self.hang_up("it closed the connection")),
            Ok(count) => Ok(count),
            Err(error) if is_would_block(&error) => Ok(0),
            Err(error) => Err(self.hang_up(&error.to_string())),
        }
    }

    /// Sends bytes after those that wait. An error is the end of the client, in words. A client that can no
    /// longer receive may have sent bytes before: [`read`](Self::read) returns those first, and then its end.
    pub(crate) fn write(&mut self, bytes: &[u8]) -> Result<(), String> {
        let Some(peer) = &mut self.client else {
            return Ok(());
        };
        peer.unsent.extend(bytes);
        while !peer.unsent.is_empty() {
            let wrote = match (&peer.stream, &self.transport) {
                (Some(stream), _) => (&*stream).write(&peer.unsent),
                (None, Transport::Terminal { pty, .. }) => pty.master().write(&peer.unsent),
                (None, Transport::Tcp(_)) => unreachable!("who came by TCP has a stream"),
            };
            match wrote {
                Ok(count) => drop(peer.unsent.drain(..count)),
                Err(error) if is_would_block(&error) => break,
                Err(_) => peer.unsent.clear(),
            }
        }
        if peer.unsent.len() > MAX_UNSENT {
            return Err(self.hang_up("it does not read what it is sent"));
        }
        Ok(())
    }

    /// Returns the name of the client.
    pub(crate) fn client_name(&self) -> Option<&str> {
        self.client.as_ref().map(|peer| peer.name.as_str())
    }

    /// Returns whether this is a terminal, whose client may leave unnoticed: another program may also have it
    /// open.
    pub(crate) fn is_terminal(&self) -> bool {
        matches!(self.transport, Transport::Terminal { .. })
    }

    /// Ends the client, and returns `why`.
    pub(crate) fn hang_up(&mut self, why: &str) -> String {
        self.client = None;
        if let Transport::Terminal { pty, closed, .. } = &mut self.transport {
            *closed = false;
            // Bytes that the client did not read must not reach the next one. The call fails only for a file
            // that is not a terminal.
            let _ = rustix::termios::tcflush(pty.master(), rustix::termios::QueueSelector::OFlush);
        }
        why.to_owned()
    }
}

fn is_would_block(error: &io::Error) -> bool {
    matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted)
}

impl fmt::Display for EndpointAddress {
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
    fn admitted() -> (Endpoint, File) {
        let mut line = Endpoint::terminal().expect("a terminal");
        let Ok(EndpointAddress::Terminal(path)) = line.address() else {
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
        line.admit_sender();
        (line, client)
    }

    fn heard(line: &mut Endpoint) -> Result<Vec<u8>, String> {
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
        assert!(line.client_name().is_none());
        assert_eq!(heard(&mut line), Ok(Vec::new()));
    }

    #[test]
    fn last_words_on_a_connection_are_heard_though_it_cannot_be_answered() {
        let mut line = Endpoint::tcp(([127, 0, 0, 1], 0).into()).expect("a port");
        let Ok(EndpointAddress::Tcp(address)) = line.address() else {
            panic!("a port has an address");
        };
        let mut client = TcpStream::connect(address).expect("somebody listens");
        let caller = loop {
            // The system may still be completing the connection.
            if let Some(caller) = line.accept() {
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
        assert!(line.client_name().is_none());
    }
}
