//! Helpers of the server's tests: a served world, and a client that uses only the protocol. The client waits
//! for the robot's packets, never for fixed times.

#![allow(dead_code, reason = "each test file uses only some of the helpers")]

use std::fs::{File, OpenOptions};
use std::io::{ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use jde_p2os::{Command, Form, Names, Packet, Receiver, Sip, SyncStep};
use jde_p2os_server::{EndpointAddress, Event, EventKind, Options, RobotStats, Server};
use jde_sim::World;
use jde_watchdog::Watchdog;
use parking_lot::Mutex;

/// A room of 10 x 8 m with two robots.
pub(crate) const ROOM: &str = r#"
    walls  = [{ name = "room", points = [[0, 0], [10, 0], [10, 8], [0, 8]], closed = true }]
    [robots.pioneer]
    start = { x = 2, y = 3 }
    [robots.second]
    start = { x = 2, y = 6, heading_deg = 90 }
"#;

/// A world served by a thread.
pub(crate) struct RunningServer {
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<Vec<RobotStats>>>,
    events: Arc<Mutex<Vec<Event>>>,
    pub(crate) addresses: Vec<SocketAddr>,
    pub(crate) terminals: Vec<PathBuf>,
    _watchdog: Watchdog,
}

impl RunningServer {
    pub(crate) fn start(world: &str, mut options: Options) -> Self {
        if !options.terminal {
            options.tcp = Some("127.0.0.1:0".parse().expect("an address"));
        }
        let world = World::parse(world, "room.toml", 1).expect("a world");
        let mut server = Server::open(world, &options).expect("a server");
        let addresses: Vec<EndpointAddress> = server.addresses().map(|(_, address)| address).collect();
        let stop = Arc::new(AtomicBool::new(false));
        let events: Arc<Mutex<Vec<Event>>> = Arc::default();
        let thread = std::thread::spawn({
            let (stop, events) = (Arc::clone(&stop), Arc::clone(&events));
            move || {
                let record = |event: &Event| events.lock().push(event.clone());
                server.run(&stop, None, record).expect("the server runs");
                server.stats()
            }
        });
        let mut server = Self {
            stop,
            thread: Some(thread),
            events,
            addresses: Vec::new(),
            terminals: Vec::new(),
            _watchdog: Watchdog::for_test(),
        };
        for address in addresses {
            match address {
                EndpointAddress::Tcp(address) => server.addresses.push(address),
                EndpointAddress::Terminal(path) => server.terminals.push(path),
            }
        }
        server
    }

    /// Stops the server, and returns the totals of the robots.
    pub(crate) fn end(mut self) -> Vec<RobotStats> {
        self.stop.store(true, Ordering::Relaxed);
        let thread = self.thread.take().expect("the server ends once");
        thread.join().expect("the server thread ends")
    }

    /// Waits until this event of that robot has occurred.
    pub(crate) fn until(&self, robot: &str, matches: impl Fn(&EventKind) -> bool) {
        let has_occurred = |events: &[Event]| {
            events
                .iter()
                .any(|event| event.robot == robot && matches(&event.kind))
        };
        while !has_occurred(&self.events.lock()) {
            std::thread::yield_now();
        }
    }

    pub(crate) fn count(&self, matches: impl Fn(&EventKind) -> bool) -> usize {
        let events = self.events.lock();
        events.iter().filter(|event| matches(&event.kind)).count()
    }
}

impl Drop for RunningServer {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
    }
}

/// The stream of a client.
pub(crate) trait Stream: Read + Write {}
impl<T: Read + Write> Stream for T {}

/// A client of the protocol.
pub(crate) struct Client {
    stream: Box<dyn Stream>,
    receiver: Receiver,
    packets: std::collections::VecDeque<Packet>,
    start: Instant,
}

impl Client {
    pub(crate) fn tcp(address: SocketAddr) -> Self {
        let stream = TcpStream::connect(address).expect("the server listens");
        stream.set_nodelay(true).expect("an option of TCP");
        Self::on(stream)
    }

    pub(crate) fn serial(path: &Path) -> Self {
        let file: File = OpenOptions::new()
            .read(true)
            .write(true)
            .custom_flags(rustix::fs::OFlags::NOCTTY.bits().cast_signed())
            .open(path)
            .expect("a serial line");
        Self::on(file)
    }

    fn on(stream: impl Read + Write + 'static) -> Self {
        Self {
            stream: Box::new(stream),
            receiver: Receiver::new(),
            packets: std::collections::VecDeque::new(),
            start: Instant::now(),
        }
    }

    /// Returns the stream alone.
    pub(crate) fn into_stream(self) -> Box<dyn Stream> {
        self.stream
    }

    /// Completes the handshake, opens the robot's servers and switches the motors on.
    pub(crate) fn open(&mut self) -> Names {
        let names = self.handshake();
        self.send_command(&Command::Open(Form::One));
        self.send_command(&Command::Enable(true));
        self.sip_with(|sip| sip.motors());
        names
    }

    pub(crate) fn handshake(&mut self) -> Names {
        for sync in [SyncStep::Zero, SyncStep::One] {
            self.send(&sync.to_packet().to_bytes());
            let echo = self.packet_with(|packet| SyncStep::from_packet(packet) == Some(sync));
            assert_eq!(echo, sync.to_packet());
        }
        self.send(&SyncStep::Two.to_packet().to_bytes());
        let packet = self.packet_with(|packet| packet.id() == 2);
        Names::from_packet(&packet).expect("names")
    }

    pub(crate) fn send_command(&mut self, command: &Command) {
        self.send(
            &command
                .to_packet()
                .expect("the command fits into a packet")
                .to_bytes(),
        );
    }

    pub(crate) fn send(&mut self, bytes: &[u8]) {
        self.stream.write_all(bytes).expect("the connection is open");
    }

    /// Returns the next packet.
    pub(crate) fn packet(&mut self) -> Packet {
        self.try_packet().expect("the connection is open")
    }

    /// Returns the next packet; `None` if the robot has closed the connection.
    pub(crate) fn try_packet(&mut self) -> Option<Packet> {
        while self.packets.is_empty() {
            let mut buffer = [0; 512];
            let count = match self.stream.read(&mut buffer) {
                Ok(0) => return None,
                Ok(count) => count,
                Err(error) if error.kind() == ErrorKind::Interrupted => continue,
                Err(_) => return None,
            };
            let Self {
                receiver, packets, ..
            } = self;
            receiver.receive(&buffer[..count], self.start.elapsed(), |packet| {
                packets.push_back(packet);
            });
        }
        self.packets.pop_front()
    }

    /// Returns the next packet for which `is_wanted` is true.
    pub(crate) fn packet_with(&mut self, is_wanted: impl Fn(&Packet) -> bool) -> Packet {
        loop {
            let packet = self.packet();
            if is_wanted(&packet) {
                return packet;
            }
        }
    }

    /// Returns the next server information packet.
    pub(crate) fn sip(&mut self) -> Sip {
        let packet = self.packet_with(|packet| matches!(packet.id(), 0x32 | 0x33));
        Sip::from_packet(&packet).expect("a valid SIP")
    }

    /// Returns the next server information packet for which `is_wanted` is true, and sends PULSE meanwhile.
    pub(crate) fn sip_with(&mut self, is_wanted: impl Fn(&Sip) -> bool) -> Sip {
        loop {
            let sip = self.sip();
            if is_wanted(&sip) {
                return sip;
            }
            self.send_command(&Command::Pulse);
        }
    }
}

/// Returns the pose of a P3-DX: metres ahead and to the left, and radians.
pub(crate) fn pose(sip: &Sip) -> [f64; 3] {
    let metres = |count: u16| f64::from(count.cast_signed()) * 0.000_485;
    let turn = f64::from(sip.th) * core::f64::consts::TAU / 4096.0;
    [metres(sip.x), metres(sip.y), turn]
}

/// Checks a value within a tolerance.
#[track_caller]
pub(crate) fn assert_near(actual: f64, expected: f64, tolerance: f64) {
    assert!(
        (actual - expected).abs() <= tolerance,
        "{actual} is not {expected} ± {tolerance}"
    );
}

pub(crate) const SECOND: Duration = Duration::from_secs(1);
