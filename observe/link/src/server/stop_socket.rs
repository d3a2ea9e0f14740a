//! Requests of this user's processes on this machine to stop everything (R14), each a datagram. To receive one takes
//! no connection, so it succeeds when the process has no descriptor left. It carries out no other request.
//!
//! It also keeps a descriptor in reserve for clients that connect, as those on the network must.

use std::os::fd::{AsFd, OwnedFd};
use std::os::unix::net::{SocketAddr, UnixDatagram};
use std::path::Path;
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Duration;

use super::inbox::Inbox;
use super::operator_workers::JobOutcome;
use super::subject::Subject;
use super::worker::read_request;
use crate::Error;
use crate::message::{Action, OperateReply, Refusal};

/// How often the reserve is looked after. In this time the link admits a client that waits for a descriptor.
const RESERVE_INTERVAL: Duration = Duration::from_millis(200);
/// How long a client may take no reply.
const REPLY_TIMEOUT: Duration = Duration::from_millis(100);
/// Longest request, bytes. The end of a longer one is lost, so it is refused.
const MAX_REQUEST_BYTES: usize = 4 << 10;

/// The socket, until dropped.
pub(super) struct StopSocket {
    socket: Arc<UnixDatagram>,
    inbox: Arc<Inbox>,
    thread: Option<JoinHandle<()>>,
}

impl StopSocket {
    /// Receives requests at `path` on a thread of its own, which has the priority of the application's threads.
    pub(super) fn open(path: &Path, subject: Arc<dyn Subject>, inbox: Arc<Inbox>) -> Result<Self, Error> {
        let open = || {
            let socket = UnixDatagram::bind(path)?;
            socket.set_read_timeout(Some(RESERVE_INTERVAL))?;
            socket.set_write_timeout(Some(REPLY_TIMEOUT))?;
            Ok(Arc::new(socket))
        };
        let socket: Arc<UnixDatagram> = open().map_err(|error: std::io::Error| Error::Listen {
            endpoint: path.display().to_string(),
            reason: error.to_string(),
        })?;
        let schemas = subject.schemas();
        let roots = schemas.groups.into_iter().filter(|group| group.father.is_none());
        let done = OperateReply {
            ok: true,
            roots: roots.flat_map(|group| group.members).collect(),
            ..OperateReply::default()
        };
        let (received, stopping) = (Arc::clone(&socket), Arc::clone(&inbox));
        let thread = std::thread::Builder::new()
            .name("link-stop-all".to_owned())
            .spawn(move || receive(&received, &*subject, &stopping, &done))
            .map_err(Error::Thread)?;
        Ok(Self {
            socket,
            inbox,
            thread: Some(thread),
        })
    }
}

impl Drop for StopSocket {
    fn drop(&mut self) {
        // Without it, the link ends.
        self.inbox.stop();
        // The thread sees the end of the socket. Without it, it sees nothing, and ends with the process.
        if self.socket.shutdown(std::net::Shutdown::Read).is_ok()
            && let Some(thread) = self.thread.take()
        {
            let _ = thread.join();
        }
    }
}

fn receive(socket: &UnixDatagram, subject: &dyn Subject, inbox: &Inbox, done: &OperateReply) {
    let mut reserve = socket.as_fd().try_clone_to_owned().ok();
    let mut bytes = [0; MAX_REQUEST_BYTES];
    loop {
        match socket.recv_from(&mut bytes) {
            // The end of the socket, or an empty request.
            Ok((0, _)) if inbox.is_stopping() => return,
            Ok((length, client)) => {
                let outcome = stop(&bytes[..length], subject);
                // What clients see of the hierarchy is older than the stop.
                let _ = inbox
                    .stop_outcomes
                    .push(JobOutcome::Stopped(Vec::new(), outcome.clone()));
                inbox.wake();
                reply(socket, &client, outcome.as_ref().map(|()| done));
            }
            // No request came in time.
            Err(_) => keep_reserve(&mut reserve, socket),
        }
    }
}

fn stop(request: &[u8], subject: &dyn Subject) -> Result<(), Refusal> {
    let request = read_request(request)?;
    if request.action != Action::StopAll {
        return Err(Refusal::new("this socket takes only requests to stop everything"));
    }
    if request.lease_ms.is_some() {
        return Err(Refusal::lease_on_global());
    }
    subject.act(&request.by, &Action::StopAll)
}

/// A client that does not wait for its reply has no name, or takes none in time.
fn reply(socket: &UnixDatagram, client: &SocketAddr, outcome: Result<&OperateReply, &Refusal>) {
    let message = match outcome {
        Ok(done) => serde_json::to_vec(done),
        Err(refusal) => serde_json::to_vec(refusal),
    };
    let _ = message.map(|message| socket.send_to_addr(&message, client));
}

/// Gives the reserve away when no other descriptor is left, so that the link can admit a client that waits for one,
/// and takes it back as soon as there is one again.
fn keep_reserve(reserve: &mut Option<OwnedFd>, socket: &UnixDatagram) {
    let another = socket.as_fd().try_clone_to_owned();
    *reserve = match (reserve.take(), another) {
        (Some(kept), Ok(_)) => Some(kept),
        (Some(_), Err(_)) => None,
        (None, another) => another.ok(),
    };
}
