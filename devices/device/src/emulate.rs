//! For tests of drivers: an emulated device at a real pseudo-terminal or a real TCP connection, and a driver
//! on the bench that iterates until a condition holds. It emulates no particular device. Drivers use
//! it only in their tests.

use std::io::{Read, Write};
use std::net::TcpListener;
use std::os::fd::AsFd;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::Instant;

use jde_schema::bench::Bench;
use jde_schema::prelude::*;
use jde_watchdog::Watchdog;
use parking_lot::Mutex;
use rustix::event::{PollFd, PollFlags, Timespec, poll};

use crate::port::Pty;

/// A device in software. It does no I/O.
pub trait Emulator: Send + 'static {
    /// Returns the first bytes of a new TCP connection. Most devices send none.
    fn connected(&mut self) -> Vec<u8> {
        Vec::new()
    }

    /// Returns the reply to bytes that arrived at this speed of the line, in bits per second.
    fn receive(&mut self, bytes: &[u8], baud: u32) -> Vec<u8>;

    /// Returns unsolicited bytes. It is called after 2 ms without input.
    fn poll_output(&mut self) -> Vec<u8>;
}

/// An emulated device on a thread of its own, until it is dropped.
#[derive(Debug)]
pub struct EmulatedDevice<E> {
    emulator: Arc<Mutex<E>>,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

/// A driver with a modulation `port` and an export `connection` on the bench, in real time.
pub struct DriverTest<S: Schema> {
    /// The bench, to set modulations and read exports.
    pub bench: Bench<S>,
    start: Instant,
    _watchdog: Watchdog,
}

impl<E: Emulator> EmulatedDevice<E> {
    /// Starts a device at a pseudo-terminal, and returns it with the path. The line ends with the device.
    ///
    /// # Panics
    /// If the machine has no pseudo-terminal left.
    #[must_use]
    pub fn at_pty(emulator: E) -> (Self, PathBuf) {
        let pty = Pty::open().expect("a pseudo-terminal");
        let path = pty.path().to_owned();
        let device = Self::run(emulator, move |emulator, stop| {
            serve(pty.master(), pty.master(), || pty.baud().ok(), emulator, stop);
        });
        (device, path)
    }

    /// Starts a device behind a TCP server whose line has speed `baud`, and returns it with its address. The
    /// server accepts one connection at a time.
    ///
    /// # Panics
    /// If the machine has no free port.
    #[must_use]
    pub fn at_tcp(emulator: E, baud: u32) -> (Self, String) {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
        let address = format!("tcp:{}", listener.local_addr().expect("a bound address"));
        let device = Self::run(emulator, move |emulator, stop| {
            while !stop.load(Ordering::Relaxed) {
                if is_readable(&listener)
                    && let Ok((stream, _)) = listener.accept()
                {
                    let greeting = emulator.lock().connected();
                    // If the client is gone already, serving it ends at once.
                    let _ = (&stream).write_all(&greeting);
                    serve(&stream, &stream, || Some(baud), emulator, stop);
                }
            }
        });
        (device, address)
    }

    /// Calls `access` with the emulator, between two of its replies.
    pub fn with<T>(&self, access: impl FnOnce(&mut E) -> T) -> T {
        access(&mut self.emulator.lock())
    }

    fn run(emulator: E, serve: impl FnOnce(&Mutex<E>, &AtomicBool) + Send + 'static) -> Self {
        let emulator = Arc::new(Mutex::new(emulator));
        let stop = Arc::new(AtomicBool::new(false));
        let (shared, stop_flag) = (emulator.clone(), stop.clone());
        let thread = Some(thread::spawn(move || serve(&shared, &stop_flag)));
        Self {
            emulator,
            stop,
            thread,
        }
    }
}

/// Fails the test if the emulator panicked.
impl<E> Drop for EmulatedDevice<E> {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        let ended = self.thread.take().map(JoinHandle::join);
        assert!(
            thread::panicking() || matches!(ended, Some(Ok(()))),
            "a check of the emulator failed"
        );
    }
}

impl<S: Schema> DriverTest<S> {
    /// Creates a driver of the device at an address, SLEPT.
    #[must_use]
    pub fn with_port(port: &str) -> Self {
        let mut bench = Bench::new();
        bench.set("port", Text::<256>::new(port));
        Self {
            bench,
            start: Instant::now(),
            _watchdog: Watchdog::for_test(),
        }
    }

    /// Wakes the driver.
    ///
    /// # Panics
    /// If it fails to wake.
    pub fn awake(&mut self) {
        self.bench.awake().expect("a valid configuration");
    }

    /// Iterates until a condition holds.
    ///
    /// # Panics
    /// If an iteration fails.
    pub fn run_until(&mut self, mut condition: impl FnMut(&Bench<S>) -> bool) {
        while !condition(&self.bench) {
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
            .expect("an iteration does not fail, even if the device does");
        thread::yield_now();
    }

    /// Iterates until the connection is lost, and returns the reason.
    pub fn wait_lost(&mut self) -> String {
        self.run_until(|bench| connection(bench).state == Connection::LOST);
        self.connection().1
    }

    /// Returns the state and the note of the connection.
    #[must_use]
    pub fn connection(&self) -> (u8, String) {
        let connection = connection(&self.bench);
        (connection.state, connection.note.to_string())
    }

    /// Returns the number of attempts to connect since the last byte arrived.
    #[must_use]
    pub fn attempts(&self) -> u32 {
        connection(&self.bench).attempts
    }
}

/// Sets modulations of a driver that is not awake, and returns why it refuses to awake. The check before the start must say
/// the same.
///
/// # Panics
/// If it awakes, or the check says something else.
#[must_use]
pub fn refusal<S: Schema>(set: impl FnOnce(&mut Bench<S>)) -> String {
    let mut bench = Bench::new();
    set(&mut bench);
    let problems = bench.inspect().expect("it inspects");
    let reason = bench.awake().expect_err("the setting is invalid").reason;
    let errors = problems.iter().filter(|problem| !problem.unavailable);
    let errors: Vec<_> = errors.map(|problem| &*problem.words).collect();
    assert_eq!(errors, [&*reason], "the check before the start says the same");
    reason
}

impl<S: Schema> core::fmt::Debug for DriverTest<S> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "DriverTest of {}", self.bench.description().name)
    }
}

fn connection<S>(bench: &Bench<S>) -> Connection {
    bench.exported("connection").unwrap_or_default()
}

/// Returns whether bytes can be read, after waiting at most 2 ms.
fn is_readable(source: impl AsFd) -> bool {
    let timeout = Timespec {
        tv_sec: 0,
        tv_nsec: 2_000_000,
    };
    poll(&mut [PollFd::new(&source, PollFlags::IN)], Some(&timeout)).is_ok_and(|count| count > 0)
}

/// Runs the emulator until the peer is gone.
fn serve<E: Emulator>(
    mut source: impl Read + AsFd,
    mut sink: impl Write,
    baud: impl Fn() -> Option<u32>,
    emulator: &Mutex<E>,
    stop: &AtomicBool,
) {
    let mut opened = false;
    while !stop.load(Ordering::Relaxed) {
        let mut buffer = [0; 256];
        let reply = if is_readable(&source) {
            match source.read(&mut buffer) {
                // A terminal that no program has opened yet cannot be read.
                Err(_) if !opened => continue,
                Ok(0) | Err(_) => return,
                Ok(count) => {
                    opened = true;
                    let baud = baud().expect("a line has a speed");
                    emulator.lock().receive(&buffer[..count], baud)
                }
            }
        } else {
            emulator.lock().poll_output()
        };
        if sink.write_all(&reply).is_err() {
            return;
        }
    }
}
