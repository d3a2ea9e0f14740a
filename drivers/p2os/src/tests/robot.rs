//! A scripted robot on a thread of its own, which uses the protocol with the driver.

use std::fs::File;
use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::os::fd::AsFd;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::Instant;

use jde_device::port::Pty;
use jde_p2os::*;
use parking_lot::Mutex;
use rustix::event::{PollFd, PollFlags, Timespec, poll};

/// The reports that the robot sends, and the commands that it received.
pub(super) struct Script {
    pub(super) names: Names,
    pub(super) sip: Sip,
    pub(super) received: Vec<Command>,
    pub(super) laser: bool,
    pub(super) mute: bool,
    pub(super) hang_up: bool,
    /// Number of reports sent.
    pub(super) reports: u32,
}

/// A robot on a thread of its own. Dropping it stops the thread.
pub(super) struct Robot {
    pub(super) script: Arc<Mutex<Script>>,
    pub(super) stop: Arc<AtomicBool>,
    pub(super) thread: Option<JoinHandle<()>>,
}

impl Robot {
    pub(super) fn script(subclass: &str) -> Arc<Mutex<Script>> {
        let names = Names {
            name: "AMRISim".into(),
            class: "Pioneer".into(),
            subclass: subclass.into(),
        };
        let sip = Sip {
            battery_tenths: Some(124),
            gripper: Some(0),
            analog_port: Some(0),
            analog: Some(0),
            digital_in: Some(0),
            digital_out: Some(0),
            ..Sip::default()
        };
        Arc::new(Mutex::new(Script {
            names,
            sip,
            received: Vec::new(),
            laser: false,
            mute: false,
            hang_up: false,
            reports: 0,
        }))
    }

    /// A robot behind TCP, which serves one client after another, and its address.
    pub(super) fn at_tcp(subclass: &str) -> (Self, String) {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
        let address = format!("tcp:{}", listener.local_addr().expect("it is bound"));
        let robot = Self::run(Self::script(subclass), move |script, stop| {
            while !stop.load(Ordering::Relaxed) {
                if ready(&listener)
                    && let Ok((stream, _)) = listener.accept()
                {
                    let halves: (&TcpStream, &TcpStream) = (&stream, &stream);
                    serve(halves.0, halves.1, script, stop);
                }
            }
        });
        (robot, address)
    }

    /// A robot at a serial line, and its address.
    pub(super) fn at_line(subclass: &str) -> (Self, String) {
        let pty = Pty::open().expect("a pseudo-terminal");
        let address = format!("serial:{}@9600", pty.path().display());
        let robot = Self::run(Self::script(subclass), move |script, stop| {
            while !stop.load(Ordering::Relaxed) {
                let halves: (&File, &File) = (pty.master(), pty.master());
                serve(halves.0, halves.1, script, stop);
            }
        });
        (robot, address)
    }

    pub(super) fn run(
        script: Arc<Mutex<Script>>,
        serve: impl FnOnce(&Mutex<Script>, &AtomicBool) + Send + 'static,
    ) -> Self {
        let stop = Arc::new(AtomicBool::new(false));
        let (shared, is_stopped) = (script.clone(), stop.clone());
        let thread = Some(thread::spawn(move || serve(&shared, &is_stopped)));
        Self { script, stop, thread }
    }

    pub(super) fn with<T>(&self, access: impl FnOnce(&mut Script) -> T) -> T {
        access(&mut self.script.lock())
    }
}

impl Drop for Robot {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        let ended = self.thread.take().map(JoinHandle::join);
        assert!(thread::panicking() || matches!(ended, Some(Ok(()))));
    }
}

/// Whether the source becomes readable within 5 ms.
fn ready(source: impl AsFd) -> bool {
    let soon = Timespec {
        tv_sec: 0,
        tv_nsec: 5_000_000,
    };
    poll(&mut [PollFd::new(&source, PollFlags::IN)], Some(&soon)).is_ok_and(|count| count > 0)
}

/// Plays the robot until the client disconnects.
fn serve(mut source: impl Read + AsFd, mut sink: impl Write, script: &Mutex<Script>, stop: &AtomicBool) {
    let (mut receiver, start) = (Receiver::new(), Instant::now());
    let (mut open, mut last_report) = (false, start);
    while !stop.load(Ordering::Relaxed) {
        let mut room = [0; 512];
        let count = if ready(&source) {
            source.read(&mut room)
        } else {
            Ok(usize::MAX)
        };
        let bytes = match count {
            Ok(usize::MAX) => &[],
            Ok(0) | Err(_) => return,
            Ok(count) => &room[..count],
        };
        let mut script = script.lock();
        if core::mem::take(&mut script.hang_up) {
            return;
        }
        let mut packets = Vec::new();
        receiver.receive(bytes, start.elapsed(), |packet| packets.push(packet));
        let mut replies = Vec::new();
        for packet in packets {
            let command = Command::from_packet(&packet);
            match (&command, SyncStep::from_packet(&packet)) {
                (_, Some(SyncStep::Two)) => replies.push(script.names.to_packet().unwrap()),
                (_, Some(sync)) => replies.push(sync.to_packet()),
                (Command::Open(_), _) => open = true,
                (Command::Close(_), _) => open = false,
                (Command::Config(_), _) => {
                    let config = Config {
                        trans_acc: 300,
                        trans_dec: 600,
                        ..Config::default()
                    };
                    replies.push(config.to_packet().unwrap());
                }
                (Command::Enable(on), _) => script.sip.flags = u16::from(*on),
                (Command::LaserOn35(_), _) => script.laser = true,
                _ => {}
            }
            script.received.push(command);
        }
        if open && !script.mute && last_report.elapsed().as_millis() >= 20 {
            last_report = Instant::now();
            script.reports += 1;
            replies.push(script.sip.to_packet().unwrap());
            replies.push(Encoders { left: 5, right: -7 }.to_packet());
            if script.laser {
                let form = LaserForm::Extended { device: 0, flags: 0 };
                let reading = |beam: u16| Reading {
                    range: 1000 + 50 * beam,
                    reflectance: 0,
                };
                let sweep: Vec<_> = (0..180).map(reading).collect();
                replies.extend(LaserPacket::sweep(form, &sweep).map(|part| part.to_packet().unwrap()));
            }
        }
        drop(script);
        let bytes: Vec<u8> = replies.iter().flat_map(Packet::to_bytes).collect();
        if sink.write_all(&bytes).is_err() {
            return;
        }
    }
}
