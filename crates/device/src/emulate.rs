//! For tests of drivers: an emulated device at a real pseudo-terminal or a real TCP connection, and a driver
//! on the bench that is iterated until something is so. It plays no device itself, and nothing here belongs
//! in a driver.

use std::io::{Read, Write};
use std::net::TcpListener;
use std::os::fd::AsFd;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::Instant;

use jde_port::Pty;
use jde_schema::bench::Bench;
use jde_schema::prelude::*;
use jde_watchdog::Watchdog;
use rustix::event::{PollFd, PollFlags, Timespec, poll};

/// A device in software. It does no I/O.
pub trait Emulator: Send + 'static {
    /// What it says to bytes at a speed of the line, bits per second.
    fn hear(&mut self, bytes: &[u8], baud: u32) -> Vec<u8>;

    /// What it says of itself when nobody has spoken to it for 2 ms.
    fn turn(&mut self) -> Vec<u8>;
}

/// A device at the end of a wire, on a thread of its own, until it is dropped.
#[derive(Debug)]
pub struct Emulated<E> {
    emulator: Arc<Mutex<E>>,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

/// A driver with a modulation `port` and an export `connection` on the bench, in time that passes.
pub struct Trial<S: Schema> {
    /// The bench, to set and to look.
    pub bench: Bench<S>,
    start: Instant,
    _watchdog: Watchdog,
}

impl<E: Emulator> Emulated<E> {
    /// At a pseudo-terminal, which is gone with it; the path to it.
    ///
    /// # Panics
    /// If the machine has no pseudo-terminal left.
    #[must_use]
    pub fn at_line(emulator: E) -> (Self, PathBuf) {
        let pty = Pty::open().expect("a pseudo-terminal");
        let path = pty.path().to_owned();
        let device = Self::run(emulator, move |emulator, stop| {
            serve(pty.master(), pty.master(), || pty.baud().ok(), emulator, stop);
        });
        (device, path)
    }

    /// Behind a server whose line has a speed, which takes one connection after another; its address.
    ///
    /// # Panics
    /// If the machine has no port left.
    #[must_use]
    pub fn at_server(emulator: E, baud: u32) -> (Self, String) {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
        let address = format!("tcp:{}", listener.local_addr().expect("it is bound"));
        let device = Self::run(emulator, move |emulator, stop| {
            while !stop.load(Ordering::Relaxed) {
                if ready(&listener)
                    && let Ok((stream, _)) = listener.accept()
                {
                    serve(&stream, &stream, || Some(baud), emulator, stop);
                }
            }
        });
        (device, address)
    }

    /// Looks at the device, or changes it, between two of its words.
    pub fn with<T>(&self, look: impl FnOnce(&mut E) -> T) -> T {
        look(&mut lock(&self.emulator))
    }

    fn run(emulator: E, serve: impl FnOnce(&Mutex<E>, &AtomicBool) + Send + 'static) -> Self {
        let emulator = Arc::new(Mutex::new(emulator));
        let stop = Arc::new(AtomicBool::new(false));
        let (shared, told) = (emulator.clone(), stop.clone());
        let thread = Some(thread::spawn(move || serve(&shared, &told)));
        Self {
            emulator,
            stop,
            thread,
        }
    }
}

/// A device that found fault with what was said to it fails the test.
impl<E> Drop for Emulated<E> {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        let ended = self.thread.take().map(JoinHandle::join);
        assert!(
            thread::panicking() || matches!(ended, Some(Ok(()))),
            "the device found fault with the driver"
        );
    }
}

impl<S: Schema> Trial<S> {
    /// A driver of the device at an address, asleep.
    #[must_use]
    pub fn at(port: &str) -> Self {
        let mut bench = Bench::new();
        bench.set("port", Text::<256>::new(port));
        Self {
            bench,
            start: Instant::now(),
            _watchdog: Watchdog::of_a_test(),
        }
    }

    /// Wakes it.
    ///
    /// # Panics
    /// If it does not awake.
    pub fn awake(&mut self) {
        self.bench.awake().expect("it is rightly configured");
    }

    /// Iterates until something is so.
    ///
    /// # Panics
    /// If an iteration fails.
    pub fn until(&mut self, mut good: impl FnMut(&Bench<S>) -> bool) {
        while !good(&self.bench) {
            self.step();
        }
    }

    /// Iterates once, at the present time.
    ///
    /// # Panics
    /// If the iteration fails.
    pub fn step(&mut self) {
        self.bench.set_now(self.start.elapsed());
        self.bench
            .iterate()
            .expect("a driver whose device fails does not fail");
        thread::yield_now();
    }

    /// Iterates until the connection is lost; why.
    pub fn lost(&mut self) -> String {
        self.until(|bench| connection(bench).state == Connection::LOST);
        self.connection().1
    }

    /// How the connection stands: its state and its note.
    #[must_use]
    pub fn connection(&self) -> (u8, String) {
        let connection = connection(&self.bench);
        (connection.state, connection.note.to_string())
    }

    /// Attempts since the device was last connected.
    #[must_use]
    pub fn attempts(&self) -> u32 {
        connection(&self.bench).attempts
    }
}

impl<S: Schema> core::fmt::Debug for Trial<S> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "Trial of {}", self.bench.description().name)
    }
}

fn connection<S>(bench: &Bench<S>) -> Connection {
    bench.exported("connection").unwrap_or_default()
}

fn lock<E>(emulator: &Mutex<E>) -> MutexGuard<'_, E> {
    emulator.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Whether something can be read, within some milliseconds.
fn ready(source: impl AsFd) -> bool {
    let soon = Timespec {
        tv_sec: 0,
        tv_nsec: 2_000_000,
    };
    poll(&mut [PollFd::new(&source, PollFlags::IN)], Some(&soon)).is_ok_and(|count| count > 0)
}

/// Plays the device until the other side is gone.
fn serve<E: Emulator>(
    mut source: impl Read + AsFd,
    mut sink: impl Write,
    baud: impl Fn() -> Option<u32>,
    emulator: &Mutex<E>,
    stop: &AtomicBool,
) {
    let mut opened = false;
    while !stop.load(Ordering::Relaxed) {
        let mut room = [0; 256];
        let answer = if ready(&source) {
            match source.read(&mut room) {
                // A terminal that nobody has open yet cannot be read.
                Err(_) if !opened => continue,
                Ok(0) | Err(_) => return,
                Ok(count) => {
                    opened = true;
                    let baud = baud().expect("a line has a speed");
                    lock(emulator).hear(&room[..count], baud)
                }
            }
        } else {
            lock(emulator).turn()
        };
        if sink.write_all(&answer).is_err() {
            return;
        }
    }
}
