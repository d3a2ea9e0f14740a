//! What a driver and its robot are connected by, to be cut: then nothing passes, and nobody is told.

use std::io::{Read as _, Write as _};
use std::net::{TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::{Context as _, Result};

/// A cable.
pub(super) struct Cable {
    /// Where the driver connects to.
    pub(super) address: String,
    cut: Arc<AtomicBool>,
}

impl Cable {
    /// To a robot that listens there.
    pub(super) fn to(address: &str) -> Result<Self> {
        let robot = address.trim_start_matches("tcp:").to_owned();
        let plug = TcpListener::bind("127.0.0.1:0").context("no port for a cable")?;
        let address = format!("tcp:{}", plug.local_addr()?);
        let cut = Arc::new(AtomicBool::new(false));
        let held = Arc::clone(&cut);
        // Its threads end with the sockets, which end with what is at both ends.
        std::thread::spawn(move || {
            if let Ok((driver, _)) = plug.accept()
                && let Ok(robot) = TcpStream::connect(robot)
            {
                carry(&driver, &robot, &held);
                carry(&robot, &driver, &held);
            }
        });
        Ok(Self { address, cut })
    }

    /// From now on nothing passes.
    pub(super) fn cut(&self) {
        self.cut.store(true, Ordering::Relaxed);
    }
}

fn carry(from: &TcpStream, to: &TcpStream, cut: &Arc<AtomicBool>) {
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
        // The other way ends too.
        let _ = to.shutdown(std::net::Shutdown::Both);
    });
}
