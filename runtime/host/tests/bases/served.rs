//! A room served by a thread, which can disappear and return at the same address.

use std::os::unix::fs::symlink;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use jde_p2os_server::{EndpointAddress, Event, EventKind, Options, Server};
use jde_sim::World;
use jde_watchdog::Watchdog;
use parking_lot::Mutex;
use tempfile::TempDir;

use crate::fixture::ROOM;

/// Real time between two checks of the stop flag.
const STEP: Duration = Duration::from_millis(50);

/// The kind of address of the robot.
pub(crate) enum Line {
    /// A port of this machine; 0 for any free port.
    Tcp(u16),
    /// A serial line.
    Terminal,
}

/// A served room.
pub(crate) struct ServedRoom {
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
    events: Arc<Mutex<Vec<Event>>>,
    /// The robot's true speeds: m/s and rad/s.
    motion: Arc<Mutex<[f64; 2]>>,
    address: FixedAddress,
    _watchdog: Watchdog,
}

/// The address of the robot, which stays the same when it returns.
struct FixedAddress {
    tcp: Option<std::net::SocketAddr>,
    /// A serial line gets a new path each time. This link stays the same.
    link: PathBuf,
    folder: TempDir,
}

/// A room that is not served until it returns.
pub(crate) struct StoppedRoom(FixedAddress);

impl ServedRoom {
    pub(crate) fn start(line: Line) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let tcp = match line {
            Line::Tcp(port) => Some(([127, 0, 0, 1], port).into()),
            Line::Terminal => None,
        };
        Self::at(FixedAddress {
            tcp,
            link: folder.path().join("pioneer"),
            folder,
        })
    }

    fn at(mut fixed: FixedAddress) -> Self {
        let world = World::parse(ROOM, "room.toml", 1).expect("a world");
        let options = Options {
            tcp: fixed.tcp,
            terminal: fixed.tcp.is_none(),
            ..Options::default()
        };
        let mut server = Server::open(world, &options).expect("the room can be served");
        let (_, endpoint) = server.addresses().next().expect("an endpoint");
        match endpoint {
            EndpointAddress::Tcp(address) => fixed.tcp = Some(address),
            EndpointAddress::Terminal(path) => {
                // An earlier server may have left its link.
                let _ = std::fs::remove_file(&fixed.link);
                symlink(path, &fixed.link).expect("a link");
            }
        }
        let stop = Arc::new(AtomicBool::new(false));
        let events: Arc<Mutex<Vec<Event>>> = Arc::default();
        let motion = Arc::new(Mutex::new([f64::NAN; 2]));
        let thread = std::thread::spawn({
            let (stop, events, motion) = (Arc::clone(&stop), Arc::clone(&events), Arc::clone(&motion));
            move || {
                while !stop.load(Ordering::Relaxed) {
                    let record = |event: &Event| events.lock().push(event.clone());
                    server.run(&stop, Some(STEP), record).expect("the server runs");
                    let (robot, _) = server.world().robots().next().expect("a robot");
                    let twist = server.world().truth(robot).twist;
                    *motion.lock() = [twist.linear, twist.angular];
                }
            }
        });
        Self {
            stop,
            thread: Some(thread),
            events,
            motion,
            address: fixed,
            _watchdog: Watchdog::for_test(),
        }
    }

    /// Returns the address for a driver.
    pub(crate) fn address(&self) -> String {
        self.address.address()
    }

    /// Waits until this event has occurred.
    pub(crate) fn until_event(&self, matches: impl Fn(&EventKind) -> bool) {
        while !self.events.lock().iter().any(|event| matches(&event.kind)) {
            std::thread::yield_now();
        }
    }

    /// Waits until the robot is at rest.
    pub(crate) fn until_standing(&self) {
        while *self.motion.lock() != [0.0; 2] {
            std::thread::yield_now();
        }
    }

    /// Ends without closing the session, like a robot that loses its power.
    pub(crate) fn stop(mut self) -> StoppedRoom {
        self.finish();
        let address = FixedAddress {
            tcp: self.address.tcp,
            link: self.address.link.clone(),
            folder: std::mem::replace(&mut self.address.folder, tempfile::tempdir().expect("a folder")),
        };
        StoppedRoom(address)
    }

    fn finish(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            thread.join().expect("the server has not panicked");
        }
    }
}

impl Drop for ServedRoom {
    fn drop(&mut self) {
        self.finish();
    }
}

impl StoppedRoom {
    pub(crate) fn restart(self) -> ServedRoom {
        ServedRoom::at(self.0)
    }
}

impl FixedAddress {
    fn address(&self) -> String {
        match self.tcp {
            Some(address) => format!("tcp:{address}"),
            None => format!("serial:{}@9600", self.link.display()),
        }
    }
}
