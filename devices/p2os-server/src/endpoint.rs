//! An endpoint of a robot, over TCP or a pseudo-terminal, with at most one client. It interprets no bytes and
//! never blocks.

use core::fmt;
use std::fs::{File, OpenOptions};
use std::io::{self, ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::os::fd::{AsFd, BorrowedFd};
use std::os::unix::fs::OpenOptionsExt;
use std::path::PathBuf;

use jde_device::port::Pty;
use rustix::event::PollFlags;
use rustix::fs::OFlags;

use crate::terminal_watch::TerminalWatch;

/// Most bytes that wait for a client that does not read. At a few hundred bytes a second this is a minute of
/// data.
const MAX_UNSENT: usize = 64 << 10;

/// The address at which a client connects to a robot.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum EndpointAddress {
    /// A TCP address.
    Tcp(SocketAddr),
    /// The path of a serial line; any speed works.
    Terminal(PathBuf),
}

/// An endpoint, and its client.
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
        let guard = OpenOptions::new()
            .read(true)
            .write(true)
            .custom_flags(OFlags::NOCTTY.bits().cast_signed())
            .open(pty.path())?;
        Ok(Self {
            transport: Transport::Terminal {
                watch: TerminalWatch::of(pty.path()),
                pty,
                _guard: guard,
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
        let unsent = self
            .client
            .as_ref()
            .is_some_and(|client| !client.unsent.is_empty());
        let interest = PollFlags::IN
            | if unsent {
                PollFlags::OUT
            } else {
                PollFlags::empty()
            };
        let stream = self.client.as_ref().and_then(|client| client.stream.as_ref());
        let (arrivals, stream) = match &self.transport {
            Transport::Tcp(listener) => (Some(listener.as_fd()), stream.map(AsFd::as_fd)),
            Transport::Terminal { pty, watch, .. } => (watch.poll_fd(), Some(pty.master().as_fd())),
        };
        let arrivals = arrivals.map(|fd| (fd, PollFlags::IN));
        let stream = stream.map(|fd| (fd, interest));
        [arrivals, stream].into_iter().flatten()
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
            stream: jde_device::port::configure_stream(stream).ok()?,
            name: address.to_string(),
        })
    }

    /// Makes a pending client the client, in place of any other.
    pub(crate) fn admit(&mut self, pending: PendingClient) {
        self.client = Some(Client {
            stream: Some(pending.stream),
            name: pending.name,
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

    /// Reads bytes, as many as fit; returns 0 if there are none. An error is the reason why the client's
    /// connection ended. On a terminal it may return bytes of a client that is not admitted yet.
    pub(crate) fn read(&mut self, buffer: &mut [u8]) -> Result<usize, String> {
        let client = self.client.as_ref();
        let read = match (
            &mut self.transport,
            client.and_then(|client| client.stream.as_ref()),
        ) {
            (_, Some(mut stream)) => stream.read(buffer),
            (Transport::Tcp(_), None) => return Ok(0),
            (
                Transport::Terminal {
                    pty,
                    watch,
                    closed,
                    next_bytes,
                    ..
                },
                None,
            ) => {
                let count = if next_bytes.is_empty() {
                    pty.master().read(buffer)
                } else {
                    let count = next_bytes.len().min(buffer.len());
                    buffer[..count].copy_from_slice(&next_bytes[..count]);
                    next_bytes.drain(..count);
                    Ok(count)
                };
                // Update after the read: a client opens the terminal before it writes.
                let was_closed = watch.update();
                *closed = client.is_some() && (*closed || was_closed);
                match (&count, client) {
                    // The client's last bytes.
                    (Ok(_), Some(_)) if *closed && watch.is_unused() => {}
                    (Ok(count), Some(_)) if *closed => {
                        next_bytes.extend(&buffer[..*count]);
                        return Err(self.hang_up("it closed the line"));
                    }
                    (Err(error), Some(_)) if *closed && is_would_block(error) => {
                        return Err(self.hang_up("it closed the line"));
                    }
                    // A client that was not admitted has left; its bytes are dropped.
                    (Ok(_), None) if watch.is_unused() => return Ok(0),
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

    /// Sends bytes after those that wait. An error is the reason why the client's connection ended. A client
    /// that can no longer receive may have sent bytes before: [`read`](Self::read) returns those first, and
    /// then its end.
    pub(crate) fn write(&mut self, bytes: &[u8]) -> Result<(), String> {
        let Some(client) = &mut self.client else {
            return Ok(());
        };
        client.unsent.extend(bytes);
        while !client.unsent.is_empty() {
            let written = match (&client.stream, &self.transport) {
                (Some(stream), _) => (&*stream).write(&client.unsent),
                (None, Transport::Terminal { pty, .. }) => pty.master().write(&client.unsent),
                (None, Transport::Tcp(_)) => unreachable!("a TCP client has a stream"),
            };
            match written {
                Ok(count) => drop(client.unsent.drain(..count)),
                Err(error) if is_would_block(&error) => break,
                Err(_) => client.unsent.clear(),
            }
        }
        if client.unsent.len() > MAX_UNSENT {
            return Err(self.hang_up("it does not read the packets"));
        }
        Ok(())
    }

    /// Returns the name of the client.
    pub(crate) fn client_name(&self) -> Option<&str> {
        self.client.as_ref().map(|client| client.name.as_str())
    }

    /// Returns whether this is a terminal, whose client may disconnect unnoticed: another program may also
    /// have it open.
    pub(crate) fn is_terminal(&self) -> bool {
        matches!(self.transport, Transport::Terminal { .. })
    }

    /// Disconnects the client, and returns `reason`.
    pub(crate) fn hang_up(&mut self, reason: &str) -> String {
        self.client = None;
        if let Transport::Terminal { pty, closed, .. } = &mut self.transport {
            *closed = false;
            // Bytes that the client did not read must not reach the next one. The call fails only for a file
            // that is not a terminal.
            let _ = rustix::termios::tcflush(pty.master(), rustix::termios::QueueSelector::OFlush);
        }
        reason.to_owned()
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
        let mut endpoint = Endpoint::terminal().expect("a terminal");
        let Ok(EndpointAddress::Terminal(path)) = endpoint.address() else {
            panic!("a terminal is at a path");
        };
        let mut client = OpenOptions::new()
            .read(true)
            .write(true)
            .custom_flags(OFlags::NOCTTY.bits().cast_signed())
            .open(path)
            .expect("a terminal");
        client.write_all(b"hello").expect("there is room");
        assert_eq!(receive(&mut endpoint), Ok(b"hello".to_vec()));
        endpoint.admit_sender();
        (endpoint, client)
    }

    fn receive(endpoint: &mut Endpoint) -> Result<Vec<u8>, String> {
        let mut buffer = [0; 64];
        let count = endpoint.read(&mut buffer)?;
        Ok(buffer[..count].to_vec())
    }

    #[test]
    fn the_last_bytes_on_a_terminal_are_read_before_its_end() {
        let (mut endpoint, mut client) = admitted();
        client.write_all(b"bye").expect("there is room");
        drop(client);
        assert_eq!(receive(&mut endpoint), Ok(b"bye".to_vec()));
        assert_eq!(receive(&mut endpoint), Err("it closed the line".to_owned()));
        assert!(endpoint.client_name().is_none());
        assert_eq!(receive(&mut endpoint), Ok(Vec::new()));
    }

    #[test]
    fn the_last_bytes_of_a_connection_are_read_even_if_writing_to_it_fails() {
        let mut endpoint = Endpoint::tcp(([127, 0, 0, 1], 0).into()).expect("a port");
        let Ok(EndpointAddress::Tcp(address)) = endpoint.address() else {
            panic!("a port has an address");
        };
        let mut client = TcpStream::connect(address).expect("the endpoint listens");
        let pending = loop {
            // The system may still be completing the connection.
            if let Some(pending) = endpoint.accept() {
                break pending;
            }
        };
        endpoint.admit(pending);
        endpoint.write(b"unread").expect("the client is connected");
        let mut buffer = [0; 1];
        assert_eq!(client.peek(&mut buffer).expect("a byte"), 1);
        client.write_all(b"bye").expect("there is room");
        // The client has not read everything, so that the system refuses further bytes to it.
        drop(client);
        endpoint
            .write(b"more")
            .expect("the end is reported after the last bytes");
        assert_eq!(receive(&mut endpoint), Ok(b"bye".to_vec()));
        while receive(&mut endpoint).is_ok() {}
        assert!(endpoint.client_name().is_none());
    }
}
