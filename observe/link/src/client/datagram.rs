//! A request to stop everything as a datagram to an application on this machine (R14), which needs no descriptor of
//! its own to receive it.

use std::io;
use std::os::linux::net::SocketAddrExt as _;
use std::os::unix::net::{SocketAddr, UnixDatagram};
use std::path::Path;
use std::time::Duration;

use crate::folder::new_id;

/// Longest wait for the reply. A stop takes less than a millisecond.
const REPLY_TIMEOUT: Duration = Duration::from_secs(1);
/// Longest reply, bytes: the roots of a large application.
const MAX_REPLY_BYTES: usize = 64 << 10;

/// Sends a request to the socket at `path`, and returns the reply; an error if the application has no such socket or
/// does not reply in time.
pub(super) fn request(path: &Path, message: &[u8]) -> io::Result<Vec<u8>> {
    let name = new_id().map_err(io::Error::other)?;
    let socket = UnixDatagram::bind_addr(&SocketAddr::from_abstract_name(format!("jde-{name}"))?)?;
    // Only the application's own replies arrive at a connected socket.
    socket.connect(path)?;
    socket.set_read_timeout(Some(REPLY_TIMEOUT))?;
    socket.set_write_timeout(Some(REPLY_TIMEOUT))?;
    socket.send(message)?;
    let mut reply = vec![0; MAX_REPLY_BYTES];
    let length = socket.recv(&mut reply)?;
    reply.truncate(length);
    Ok(reply)
}
