//! A TCP relay between a driver and its robot that can be cut: data stop, and neither end is notified.

use std::io::{Read as _, Write as _};
use std::net::{TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::{Context as _, Result};

/// The relay.
pub(super) struct TcpProxy {
    /// The address for the driver.
    pub(super) address: String,
    cut: Arc<AtomicBool>,
}

impl TcpProxy {
    /// Connects to a robot that listens at `address`.
    pub(super) fn to(address: &str) -> Result<Self> {
        let robot = address.trim_start_matches("tcp:").to_owned();
        let listener = TcpListener::bind("127.0.0.1:0").context("no port for the relay")?;
        let address = format!("tcp:{}", listener.local_addr()?);
        let cut = Arc::new(AtomicBool::new(false));
        let is_cut = Arc::clone(&cut);
        // The threads end when both sockets are closed.
        std::thread::spawn(move || {
            if let Ok((driver, _)) = listener.accept()
                && let Ok(robot) = TcpStream::connect(robot)
            {
                copy_stream(&driver, &robot, &is_cut);
                copy_stream(&robot, &driver, &is_cut);
            }
        });
        Ok(Self { address, cut })
    }

    /// Stops all data.
    pub(super) fn cut(&self) {
        self.cut.store(true, Ordering::Relaxed);
    }
}

fn copy_stream(from: &TcpStream, to: &TcpStream, cut: &Arc<AtomicBool>) {
    let (Ok(mut from), Ok(mut to)) = (from.try_clone(), to.try_clone()) else {
        return;
    };
    let cut = Arc::clone(cut);
    std::thread::spawn(move || {
        let mut bytes = [0; 4096];
        while let Ok(count @ 1..) = from.read(&mut bytes) {
            if !cut.load(Ordering::Relaxed) && to.write_all(&bytes[..count]).is_err() {
                break;
            }
        }
        // Ends the other direction as well.
        let _ = to.shutdown(std::net::Shutdown::Both);
    });
}
