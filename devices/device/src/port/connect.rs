//! One attempt to connect to a device, on its own thread, because name resolution, networks and lines may
//! block for any time.

use core::time::Duration;
use std::fs::File;
use std::io::{self, ErrorKind, Read, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::os::fd::{AsFd, BorrowedFd};
use std::sync::mpsc::{self, Receiver, TryRecvError};
use std::thread::{self, JoinHandle};

use rustix::net::sockopt;

use super::address::Address;
use super::{modem, serial};

/// How long a host may take to accept: a radio link that loses packets needs a second retry.
const CONNECT_TIMEOUT: Duration = Duration::from_secs(3);

/// An attempt in progress.
#[derive(Debug)]
pub(crate) struct Attempt {
    /// `None` once the attempt is abandoned.
    result: Option<Receiver<Result<Stream, String>>>,
    thread: JoinHandle<()>,
}

/// An open stream that never blocks.
#[derive(Debug)]
pub(crate) enum Stream {
    Tcp(TcpStream),
    Serial(File),
}

impl Attempt {
    pub(crate) fn start(address: &Address) -> Result<Self, String> {
        let (sender, result) = mpsc::channel();
        let target = address.clone();
        let thread = thread::Builder::new()
            .name("connecting".to_owned())
            .spawn(move || {
                // If the attempt is abandoned, the stream closes here.
                let _ = sender.send(open(&target));
            })
            .map_err(|error| format!("{}: cannot create a thread to connect: {error}", address.device()))?;
        Ok(Self {
            result: Some(result),
            thread,
        })
    }

    /// Returns the result of the attempt, once it has ended.
    pub(crate) fn result(&self) -> Option<Result<Stream, String>> {
        match self.result.as_ref()?.try_recv() {
            Ok(result) => Some(result),
            Err(TryRecvError::Empty) => None,
            Err(TryRecvError::Disconnected) => Some(Err("the attempt to connect failed".to_owned())),
        }
    }

    /// Abandons the attempt. The stream that it opens or has opened is closed, so that the device is free for
    /// other programs.
    pub(crate) fn abandon(&mut self) {
        self.result = None;
    }

    /// Returns whether the thread has ended.
    pub(crate) fn is_finished(&self) -> bool {
        self.thread.is_finished()
    }
}

fn open(address: &Address) -> Result<Stream, String> {
    match address {
        Address::Serial { path, baud, framing } => {
            serial::open_port(path, *baud, *framing).map(Stream::Serial)
        }
        Address::Tcp { host, port } => {
            let device = address.device();
            let addresses = (host.as_str(), *port)
                .to_socket_addrs()
                .map_err(|error| format!("{device}: no such host: {error}"))?;
            let mut last = format!("{device}: no such host");
            for address in addresses {
                match TcpStream::connect_timeout(&address, CONNECT_TIMEOUT).and_then(configure_stream) {
                    Ok(stream) => return Ok(Stream::Tcp(stream)),
                    Err(error) => last = format!("{device}: {}", describe_error(&error)),
                }
            }
            Err(last)
        }
    }
}

/// Configures a connection so that it never blocks, sends at once, and fails about 5 s after its peer became
/// unreachable.
///
/// # Errors
/// If the system refuses one of the options.
pub fn configure_stream(stream: TcpStream) -> io::Result<TcpStream> {
    stream.set_nonblocking(true)?;
    // Commands are small and urgent.
    stream.set_nodelay(true)?;
    // A peer that loses its power does not close the connection: probe after 2 s of silence, and fail 3 s
    // later.
    sockopt::set_socket_keepalive(&stream, true)?;
    sockopt::set_tcp_keepidle(&stream, Duration::from_secs(2))?;
    sockopt::set_tcp_keepintvl(&stream, Duration::from_secs(1))?;
    sockopt::set_tcp_keepcnt(&stream, 3)?;
    sockopt::set_tcp_user_timeout(&stream, 5000)?;
    Ok(stream)
}

/// Describes a network error for the person who set up the network.
fn describe_error(error: &io::Error) -> String {
    match error.kind() {
        ErrorKind::ConnectionRefused => {
            "connection refused: nothing listens there; is it switched on, and is the port right?".to_owned()
        }
        ErrorKind::TimedOut => "no answer in time: is it switched on, and is the address right?".to_owned(),
        ErrorKind::HostUnreachable | ErrorKind::NetworkUnreachable => {
            format!("{error}: is the cable connected, and is this machine on its network?")
        }
        ErrorKind::ConnectionReset | ErrorKind::BrokenPipe | ErrorKind::ConnectionAborted => {
            "the other side reset the connection".to_owned()
        }
        _ => error.to_string(),
    }
}

impl Stream {
    /// Describes the end of the stream: the peer is gone.
    pub(crate) fn end_reason(&self) -> &'static str {
        match self {
            Self::Tcp(_) => "the other side closed the connection",
            Self::Serial(_) => "the line is gone: was it unplugged?",
        }
    }

    pub(crate) fn describe_error(&self, error: &io::Error) -> String {
        match self {
            Self::Tcp(_) => describe_error(error),
            Self::Serial(_) => format!("the line is gone: was it unplugged? ({error})"),
        }
    }

    pub(crate) fn set_baud(&self, baud: u32) -> io::Result<()> {
        match self {
            Self::Tcp(_) => Ok(()),
            Self::Serial(line) => serial::set_baud(line, baud),
        }
    }

    pub(crate) fn clear_dtr(&self) {
        if let Self::Serial(line) = self {
            // Many lines, such as pseudo-terminals, have no modem signals.
            let _ = modem::clear_dtr(line);
        }
    }
}

impl Read for Stream {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        match self {
            Self::Tcp(stream) => stream.read(buffer),
            Self::Serial(line) => line.read(buffer),
        }
    }
}

impl Write for Stream {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match self {
            Self::Tcp(stream) => stream.write(bytes),
            Self::Serial(line) => line.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl AsFd for Stream {
    fn as_fd(&self) -> BorrowedFd<'_> {
        match self {
            Self::Tcp(stream) => stream.as_fd(),
            Self::Serial(line) => line.as_fd(),
        }
    }
}
