//! A way to a robot: TCP or a pseudo-terminal, and the one client that has come by it. Understands no byte of
//! it, never blocks.

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

/// Most bytes that wait for a client who does not read; a robot's few hundred a second are a minute of it.
const MOST_UNSENT: usize = 64 << 10;

/// Where a client finds a robot.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Place {
    /// At this address.
    Tcp(SocketAddr),
    /// At this serial line, at any speed.
    Terminal(PathBuf),
}

/// A line, and who is on it.
pub(crate) struct Line {
    end: End,
    peer: Option<Peer>,
}

enum End {
    Tcp(TcpListener),
    Terminal {
        pty: Pty,
        /// Keeps the line up between two clients.
        _held: File,
        door: Door,
        /// Whoever is on the line has closed it; what he said before may still be unread.
        closed: bool,
        /// Heard together with that the one before had left, when the next was there already: it may be of
        /// the next.
        late: Vec<u8>,
    },
}

struct Peer {
    stream: Option<TcpStream>,
    name: String,
    unsent: Vec<u8>,
}

/// Who stands at the door; dropped, he is turned away.
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

    /// What to wait for: somebody at the door, bytes, and room for those that are unsent.
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

    /// Who stands at the door. On a terminal nobody does: who speaks is there.
    pub(crate) fn caller(&self) -> Option<Caller> {
        let End::Tcp(listener) = &self.end else {
            return None;
        };
        // Whoever hung up before he was asked, or cannot be spoken to: the next one is asked in the next
        // round.
        let (stream, address) = listener.accept().ok()?;
        Some(Caller {
            stream: jde_port::prepared(stream).ok()?,
            name: address.to_string(),
        })
    }

    /// Lets a caller in, in the place of whoever is on the line.
    pub(crate) fn admit(&mut self, caller: Caller) {
        self.peer = Some(Peer {
            stream: Some(caller.stream),
            name: caller.name,
            unsent: Vec::new(),
        });
    }

    /// Lets in who was heard on a terminal.
    pub(crate) fn admit_heard(&mut self) {
        self.peer = Some(Peer {
            stream: None,
            name: self.name(),
            unsent: Vec::new(),
        });
    }

    /// What whoever is heard on a terminal is called; TCP has a name for each.
    pub(crate) fn name(&self) -> String {
        match &self.end {
            End::Tcp(_) => String::new(),
            End::Terminal { pty, .. } => pty.path().display().to_string(),
        }
    }

    /// What was heard, as much as fits; 0 for nothing. An error is the end of the client, in words. On a
    /// terminal a client may be heard whom nobody has let in.
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
                // Behind what was read: nobody speaks before he is through the door.
                let left = door.look();
                *closed = peer.is_some() && (*closed || left);
                match (&count, peer) {
                    // His last words.
                    (Ok(_), Some(_)) if *closed && door.nobody() => {}
                    (Ok(count), Some(_)) if *closed => {
                        late.extend(&room[..*count]);
                        return Err(self.hang_up("it closed the line"));
                    }
                    (Err(error), Some(_)) if *closed && is_wait(error) => {
                        return Err(self.hang_up("it closed the line"));
                    }
                    // What whoever has left had not been asked to say.
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

    /// Sends bytes after those that wait. An error is the end of the client, in words. Who can no longer be
    /// spoken to may have said something before: [`read`](Self::read) tells of his end.
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

    /// Who is on the line.
    pub(crate) fn peer(&self) -> Option<&str> {
        self.peer.as_ref().map(|peer| peer.name.as_str())
    }

    /// Whether who is on the line may leave unseen: another program may have it open too.
    pub(crate) fn is_terminal(&self) -> bool {
        matches!(self.end, End::Terminal { .. })
    }

    /// Lets go of the client.
    pub(crate) fn hang_up(&mut self, why: &str) -> String {
        self.peer = None;
        if let End::Terminal { pty, closed, .. } = &mut self.end {
            *closed = false;
            // What nobody read is not for the next one. It fails only for what is no terminal.
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

    /// A line on which somebody was heard and let in, and his end of it.
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
            // The system may still be shaking hands.
            if let Some(caller) = line.caller() {
                break caller;
            }
        };
        line.admit(caller);
        line.write(b"unread").expect("it is there");
        let mut room = [0; 1];
        assert_eq!(client.peek(&mut room).expect("it was sent"), 1);
        client.write_all(b"bye").expect("there is room");
        // It has not read what it was sent, so that the system refuses whatever else it is sent.
        drop(client);
        line.write(b"more")
            .expect("its end is told behind its last words");
        assert_eq!(heard(&mut line), Ok(b"bye".to_vec()));
        while heard(&mut line).is_ok() {}
        assert!(line.peer().is_none());
    }
}
