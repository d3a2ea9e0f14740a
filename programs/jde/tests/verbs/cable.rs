//! The connection of a driver and its robot, for tests that interrupt it.

use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A cable between a driver and its robot. Once cut, it drops all data, and neither end gets an error.
pub(crate) struct Cable {
    pub(crate) address: String,
    cut: Arc<AtomicBool>,
}

impl Cable {
    /// Connects a cable to a robot that listens at `address`.
    pub(crate) fn to(address: &str) -> Self {
        let robot = address.trim_start_matches("tcp:").to_owned();
        let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
        let address = format!("tcp:{}", listener.local_addr().expect("an address"));
        let cut = Arc::new(AtomicBool::new(false));
        let is_cut = Arc::clone(&cut);
        // The threads end with the sockets, which end with the processes at both ends.
        std::thread::spawn(move || {
            let (driver, _) = listener.accept().expect("the driver connects");
            let robot = TcpStream::connect(robot).expect("the robot accepts connections");
            let directions = [(&driver, &robot), (&robot, &driver)];
            let directions = directions.map(|(from, to)| (from.try_clone(), to.try_clone()));
            for (from, to) in directions {
                let (mut from, mut to) = (from.expect("a socket"), to.expect("a socket"));
                let is_cut = Arc::clone(&is_cut);
                std::thread::spawn(move || {
                    let mut bytes = [0; 4096];
                    while let Ok(count @ 1..) = from.read(&mut bytes) {
                        let connected = !is_cut.load(Ordering::SeqCst);
                        if connected && to.write_all(&bytes[..count]).is_err() {
                            return;
                        }
                    }
                });
            }
        });
        Self { address, cut }
    }

    /// Drops all data from now on.
    pub(crate) fn cut(&self) {
        self.cut.store(true, Ordering::SeqCst);
    }
}
