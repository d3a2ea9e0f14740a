//! A room that is served by a thread, and may go and come back at the same place.

use std::os::unix::fs::symlink;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use jde_driver_suite::ROOM;
use jde_p2os_server::{Event, Options, Place, Server, What};
use jde_sim::World;
use jde_watchdog::Watchdog;
use tempfile::TempDir;

/// Time of the machine between two looks at what is true.
const LOOK: Duration = Duration::from_millis(50);

/// Where the robot is.
pub(crate) enum Over {
    /// At a port of this machine; 0 for any.
    Tcp(u16),
    /// At a serial line.
    Terminal,
}

/// A served room.
pub(crate) struct Served {
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
    events: Arc<Mutex<Vec<Event>>>,
    /// How the robot truly moves: m/s and rad/s.
    motion: Arc<Mutex<[f64; 2]>>,
    place: Fixed,
    _watchdog: Watchdog,
}

/// Where the robot is found, now and when it has come back.
struct Fixed {
    tcp: Option<std::net::SocketAddr>,
    /// A serial line has another path each time; this link has not.
    link: PathBuf,
    folder: TempDir,
}

/// A room that nobody serves, until it comes back.
pub(crate) struct Gone(Fixed);

impl Served {
    pub(crate) fn start(over: Over) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let tcp = match over {
            Over::Tcp(port) => Some(([127, 0, 0, 1], port).into()),
            Over::Terminal => None,
        };
        Self::at(Fixed {
            tcp,
            link: folder.path().join("pioneer"),
            folder,
        })
    }

    fn at(mut fixed: Fixed) -> Self {
        let world = World::parse(ROOM, "room.toml", 1).expect("a world");
        let options = Options {
            tcp: fixed.tcp,
            terminal: fixed.tcp.is_none(),
            ..Options::default()
        };
        let mut server = Server::open(world, &options).expect("it can be served");
        let (_, place) = server.places().next().expect("a line");
        match place {
            Place::Tcp(address) => fixed.tcp = Some(address),
            Place::Terminal(path) => {
                // The one before may have left its own.
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
                    let hear = |event: &Event| lock(&events).push(event.clone());
                    server.run(&stop, Some(LOOK), hear).expect("it serves");
                    let (robot, _) = server.world().robots().next().expect("a robot");
                    let twist = server.world().truth(robot).twist;
                    *lock(&motion) = [twist.linear, twist.angular];
                }
            }
        });
        Self {
            stop,
            thread: Some(thread),
            events,
            motion,
            place: fixed,
            _watchdog: Watchdog::of_a_test(),
        }
    }

    /// How a driver calls it.
    pub(crate) fn address(&self) -> String {
        self.place.address()
    }

    /// Goes on once this has happened.
    pub(crate) fn until(&self, happened: impl Fn(&What) -> bool) {
        while !lock(&self.events).iter().any(|event| happened(&event.what)) {
            std::thread::yield_now();
        }
    }

    /// Goes on once the robot stands.
    pub(crate) fn until_it_stands(&self) {
        while *lock(&self.motion) != [0.0; 2] {
            std::thread::yield_now();
        }
    }

    /// Goes without a word, as a robot does whose plug is pulled.
    pub(crate) fn go(mut self) -> Gone {
        self.finish();
        let place = Fixed {
            tcp: self.place.tcp,
            link: self.place.link.clone(),
            folder: std::mem::replace(&mut self.place.folder, tempfile::tempdir().expect("a folder")),
        };
        Gone(place)
    }

    fn finish(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            thread.join().expect("it served to the end");
        }
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        self.finish();
    }
}

impl Gone {
    pub(crate) fn come_back(self) -> Served {
        Served::at(self.0)
    }
}

impl Fixed {
    fn address(&self) -> String {
        match self.tcp {
            Some(address) => format!("tcp:{address}"),
            None => format!("serial:{}@9600", self.link.display()),
        }
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
