//! Tells systemd of a run that is a service: that it has started, and then that it is alive (sd_notify(3)).
//!
//! Before each message a thread takes the application's lock. A run whose lock is never free sends none, and
//! systemd restarts it.

use std::ffi::OsStr;
use std::io;
use std::os::linux::net::SocketAddrExt;
use std::os::unix::ffi::OsStrExt;
use std::os::unix::net::{SocketAddr, UnixDatagram};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;

use jde_host::Handle;

/// Sends messages until it is dropped.
pub(super) struct ServiceNotifier {
    stop: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl ServiceNotifier {
    /// Reports the start, and then on a new thread that the run is alive, twice within the time that systemd
    /// allows. Returns `None` if systemd did not start this process, or has no watchdog for it.
    ///
    /// # Errors
    /// The socket that systemd names cannot be used, or the thread cannot be started.
    pub(super) fn start(handle: Handle) -> io::Result<Option<Self>> {
        let Some(name) = std::env::var_os("NOTIFY_SOCKET") else {
            return Ok(None);
        };
        let address = address(&name)?;
        let socket = UnixDatagram::unbound()?;
        socket.set_nonblocking(true)?;
        socket.send_to_addr(b"READY=1", &address)?;
        let Some(interval) = interval(
            std::env::var("WATCHDOG_USEC").ok(),
            std::env::var("WATCHDOG_PID").ok(),
        ) else {
            return Ok(None);
        };
        let (stop, stopped) = channel();
        let notify = move || {
            while let Err(RecvTimeoutError::Timeout) = stopped.recv_timeout(interval) {
                drop(handle.snapshot());
                // The next message replaces one that is lost.
                let _ = socket.send_to_addr(b"WATCHDOG=1", &address);
            }
        };
        let thread = std::thread::Builder::new()
            .name("service".to_owned())
            .spawn(notify)?;
        Ok(Some(Self {
            stop: Some(stop),
            thread: Some(thread),
        }))
    }
}

impl Drop for ServiceNotifier {
    fn drop(&mut self) {
        drop(self.stop.take());
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// Returns the address of a socket: a path, or an abstract name after `@`.
fn address(name: &OsStr) -> io::Result<SocketAddr> {
    match name.as_bytes().strip_prefix(b"@") {
        Some(name) => SocketAddr::from_abstract_name(name),
        None => SocketAddr::from_pathname(name),
    }
}

/// Returns half the time that systemd allows between two messages; `None` if it expects none of this process.
fn interval(microseconds: Option<String>, process: Option<String>) -> Option<Duration> {
    let is_meant = process.is_none_or(|process| process == std::process::id().to_string());
    let microseconds = microseconds?.parse().ok().filter(|_| is_meant)?;
    Some(Duration::from_micros(microseconds) / 2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_watchdog_of_this_process_is_served_at_half_its_time() {
        let own = std::process::id().to_string();
        let of =
            |time: &str, process: Option<&str>| interval(Some(time.to_owned()), process.map(str::to_owned));
        assert_eq!(of("2000000", None), Some(Duration::from_secs(1)));
        assert_eq!(of("2000000", Some(&own)), Some(Duration::from_secs(1)));
        assert_eq!(of("2000000", Some("1")), None);
        assert_eq!(of("soon", None), None);
        assert_eq!(interval(None, None), None);
    }
}
