//! The driver on the bench, with emulated scanners at a real pseudo-terminal and a real TCP connection.

use std::fs;
use std::io::{Read, Write};
use std::net::TcpListener;
use std::os::fd::AsFd;
use std::os::unix::fs::symlink;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::Instant;

use jde_port::Pty;
use jde_schema::bench::Bench;
use rustix::event::{PollFd, PollFlags, Timespec, poll};

use super::*;
use crate::emulator::Emulator;

/// A scanner at the end of a wire, until it is dropped.
struct Scanner {
    emulator: Arc<Mutex<Emulator>>,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Scanner {
    /// At a pseudo-terminal, which is gone with it; the path to it.
    fn at_line(emulator: Emulator) -> (Self, PathBuf) {
        let pty = Pty::open().expect("a pseudo-terminal");
        let path = pty.path().to_owned();
        let scanner = Self::run(emulator, move |emulator, stop| {
            serve(pty.master(), pty.master(), || pty.baud().ok(), emulator, stop);
        });
        (scanner, path)
    }

    /// Behind a serial server of 9600 baud, which takes one connection after another; its address.
    fn at_server(emulator: Emulator) -> (Self, String) {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
        let address = format!("tcp:{}", listener.local_addr().expect("it is bound"));
        let scanner = Self::run(emulator, move |emulator, stop| {
            while !stop.load(Ordering::Relaxed) {
                if ready(&listener)
                    && let Ok((stream, _)) = listener.accept()
                {
                    serve(&stream, &stream, || Some(9600), emulator, stop);
                }
            }
        });
        (scanner, address)
    }

    fn run(emulator: Emulator, serve: impl FnOnce(&Mutex<Emulator>, &AtomicBool) + Send + 'static) -> Self {
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

    fn set(&self, change: impl FnOnce(&mut Emulator)) {
        change(&mut self.emulator.lock().unwrap_or_else(PoisonError::into_inner));
    }
}

impl Drop for Scanner {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        let ended = self.thread.take().map(JoinHandle::join);
        assert!(
            thread::panicking() || matches!(ended, Some(Ok(()))),
            "the scanner found fault with the driver"
        );
    }
}

/// Whether something can be read, within some milliseconds.
fn ready(source: impl AsFd) -> bool {
    let soon = Timespec {
        tv_sec: 0,
        tv_nsec: 2_000_000,
    };
    poll(&mut [PollFd::new(&source, PollFlags::IN)], Some(&soon)).is_ok_and(|count| count > 0)
}

/// Plays the scanner until the other side is gone.
fn serve(
    mut source: impl Read + AsFd,
    mut sink: impl Write,
    baud: impl Fn() -> Option<u32>,
    emulator: &Mutex<Emulator>,
    stop: &AtomicBool,
) {
    let mut opened = false;
    while !stop.load(Ordering::Relaxed) {
        let mut room = [0; 256];
        let count = if ready(&source) {
            source.read(&mut room)
        } else {
            Ok(usize::MAX)
        };
        let answer = match count {
            // A terminal that nobody has open yet cannot be read.
            Err(_) if !opened => continue,
            Ok(0) | Err(_) => return,
            Ok(usize::MAX) => emulator.lock().unwrap_or_else(PoisonError::into_inner).turn(),
            Ok(count) => {
                opened = true;
                let baud = baud().expect("a line has a speed");
                emulator
                    .lock()
                    .unwrap_or_else(PoisonError::into_inner)
                    .hear(&room[..count], baud)
            }
        };
        if sink.write_all(&answer).is_err() {
            return;
        }
    }
}

/// The driver, and the time since it was made.
struct Driver {
    bench: Bench<Lms2xx>,
    start: Instant,
}

impl Driver {
    fn new(port: &str) -> Self {
        let mut bench = Bench::new();
        bench.set("port", Text::<256>::new(port));
        bench.set("baud", 9600_u32);
        bench.awake().expect("it is rightly configured");
        Self {
            bench,
            start: Instant::now(),
        }
    }

    /// Iterates until something is so; a driver that never gets there hangs, and the runner says so.
    fn until(&mut self, mut good: impl FnMut(&Bench<Lms2xx>) -> bool) {
        while !good(&self.bench) {
            self.bench.set_now(self.start.elapsed());
            self.bench
                .iterate()
                .expect("a driver whose device fails does not fail");
            thread::yield_now();
        }
    }

    fn scan(&mut self) -> Box<LaserScan> {
        self.until(|bench| bench.exported::<LaserScan>("laser").is_some());
        Box::new(self.bench.exported("laser").expect("just seen"))
    }
}

fn state(bench: &Bench<Lms2xx>) -> (u8, String) {
    let connection: Connection = bench.exported("connection").unwrap_or_default();
    (connection.state, connection.note.to_string())
}

#[test]
fn a_scanner_at_a_serial_line_is_seen() {
    let (_scanner, path) = Scanner::at_line(Emulator::new());
    let mut driver = Driver::new(&format!("serial:{}@9600", path.display()));
    let scan = driver.scan();
    assert_eq!(scan.ranges.as_slice(), [1.5; 181]);
    assert!((scan.angle(0) + core::f64::consts::FRAC_PI_2).abs() < 1e-6);
    assert!((scan.angle(180) - core::f64::consts::FRAC_PI_2).abs() < 1e-5);
    assert_eq!(scan.range_max, 8.182);
    assert_eq!(
        state(&driver.bench),
        (Connection::CONNECTED, "LMS200;30106;V02.10, 9600 baud".to_owned())
    );
    let first = driver.bench.exported_at("laser");
    driver.until(|bench| bench.exported_at("laser") > first);
}

#[test]
fn a_scanner_behind_a_serial_server_is_met_again_after_silence_noise_and_a_restart() {
    let (scanner, address) = Scanner::at_server(Emulator {
        noisy: true,
        ..Emulator::new()
    });
    let mut driver = Driver::new(&address);
    driver.scan();
    scanner.set(|scanner| scanner.silent = true);
    driver.until(|bench| state(bench).0 == Connection::LOST);
    assert!(state(&driver.bench).1.contains("no scan came for 3 s"));
    assert_eq!(
        driver.bench.exported::<LaserScan>("laser"),
        None,
        "what is not heard is taken back"
    );
    scanner.set(|scanner| {
        scanner.silent = false;
        scanner.value = 2500;
        scanner.restart();
    });
    assert_eq!(driver.scan().ranges[90], 2.5);
}

#[test]
fn a_plug_that_is_pulled_and_put_back_is_survived() {
    let name = std::env::temp_dir().join(format!("jde-sick-{}", std::process::id()));
    let mut driver = Driver::new(&format!("serial:{}@9600", name.display()));
    driver.until(|bench| state(bench).0 == Connection::LOST);
    assert!(state(&driver.bench).1.contains("there is no such device"));
    for _ in 0..2 {
        let (scanner, path) = Scanner::at_line(Emulator::new());
        symlink(path, &name).expect("a name");
        driver.scan();
        fs::remove_file(&name).expect("it is there");
        drop(scanner);
        driver.until(|bench| state(bench).0 == Connection::LOST);
        assert_eq!(driver.bench.exported::<LaserScan>("laser"), None);
    }
}

#[test]
fn the_same_trouble_is_said_once_however_often_it_is_tried_again() {
    let mut driver = Driver::new("serial:/dev/no-such-line@9600");
    let attempts = |bench: &Bench<Lms2xx>| {
        bench
            .exported("connection")
            .map_or(0, |connection: Connection| connection.attempts)
    };
    driver.until(|bench| attempts(bench) >= 3);
    let said = driver.bench.log();
    assert_eq!(said.len(), 1, "{said:?}");
}

#[test]
fn asleep_it_tells_the_scanner_to_rest() {
    let (scanner, path) = Scanner::at_line(Emulator::new());
    let mut driver = Driver::new(&format!("serial:{}@9600", path.display()));
    driver.scan();
    driver.bench.sleep().expect("it sleeps");
    assert_eq!(driver.bench.exported::<LaserScan>("laser"), None);
    let streams = || {
        scanner
            .emulator
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .streaming
    };
    while streams() {
        thread::yield_now();
    }
}

#[test]
fn what_cannot_be_is_refused_before_anything_is_opened() {
    let refused = |set: fn(&mut Bench<Lms2xx>)| {
        let mut bench = Bench::<Lms2xx>::new();
        bench.set("port", Text::<256>::new("serial:/dev/no-such-line@9600"));
        set(&mut bench);
        bench.awake().expect_err("it cannot be").reason
    };
    assert!(refused(|bench| bench.set("port", Text::<256>::EMPTY)).contains("give it one"));
    assert!(
        refused(|bench| bench.set("port", Text::<256>::new("/dev/ttyUSB0"))).contains("serial:PATH@BAUD")
    );
    assert_eq!(
        refused(|bench| bench.set("baud", 57_600_u32)),
        "baud = 57600: it can be 9600, 19200, 38400 or 500000"
    );
    assert_eq!(
        refused(|bench| bench.set("beams", 180_u32)),
        "beams = 180: it can be 101, 181, 201, 361 or 401"
    );
    assert_eq!(
        refused(|bench| bench.set("reach", 10_u32)),
        "reach = 10: it can be 8, 16, 32 or 80"
    );
    assert!(refused(|bench| bench.set_real_time(false)).contains("--lockstep"));
}
