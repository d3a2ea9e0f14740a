//! The common part of the server's tests: a served world, and a client that knows only the protocol. It waits
//! for the robot's packets, never for fixed times.

#![allow(dead_code, reason = "each test file uses its part")]

use std::fs::{File, OpenOptions};
use std::io::{ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use jde_p2os::{Command, Form, Names, Packet, Receiver, Sip, SyncStep};
use jde_p2os_server::{EndpointAddress, Event, EventKind, Options, RobotStats, Server};
use jde_sim::World;
use jde_watchdog::Watchdog;

/// A room of 10 x 8 m with two robots.
pub(crate) const ROOM: &str = r#"
    walls  = [{ name = "room", points = [[0, 0], [10, 0], [10, 8], [0, 8]], closed = true }]
    [robots.pioneer]
    start = { x = 2, y = 3 }
    [robots.second]
    start = { x = 2, y = 6, heading_deg = 90 }
"#;

/// A world served by a thread.
pub(crate) struct Served {
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<Vec<RobotStats>>>,
    events: Arc<Mutex<Vec<Event>>>,
    pub(crate) addresses: Vec<SocketAddr>,
    pub(crate) terminals: Vec<PathBuf>,
    _watchdog: Watchdog,
}

impl Served {
    pub(crate) fn start(world: &str, mut options: Options) -> Self {
        if !options.terminal {
            options.tcp = Some("127.0.0.1:0".parse().expect("an address"));
        }
        let world = World::parse(world, "room.toml", 1).expect("a world");
        let mut server = Server::open(world, &options).expect("it can be served");
        let places: Vec<EndpointAddress> = server.addresses().map(|(_, place)| place).collect();
        let stop = Arc::new(AtomicBool::new(false));
        let events: Arc<Mutex<Vec<Event>>> = Arc::default();
        let thread = std::thread::spawn({
            let (stop, events) = (Arc::clone(&stop), Arc::clone(&events));
            move || {
                let hear = |event: &Event| lock(&events).push(event.clone());
                server.run(&stop, None, hear).expect("it serves");
                server.stats()
            }
        });
        let mut served = Self {
            stop,
            thread: Some(thread),
            events,
            addresses: Vec::new(),
            terminals: Vec::new(),
            _watchdog: Watchdog::for_test(),
        };
        for place in places {
            match place {
                EndpointAddress::Tcp(address) => served.addresses.push(address),
                EndpointAddress::Terminal(path) => served.terminals.push(path),
            }
        }
        served
    }

    /// Stops the server, and returns the totals of the robots.
    pub(crate) fn end(mut self) -> Vec<RobotStats> {
        self.stop.store(true, Ordering::Relaxed);
        let thread = self.thread.take().expect("it ends once");
        thread.join().expect("it served to the end")
    }

    /// Waits until this event of that robot has occurred.
    pub(crate) fn until(&self, robot: &str, happened: impl Fn(&EventKind) -> bool) {
        let found = |events: &[Event]| {
            events
                .iter()
                .any(|event| event.robot == robot && happened(&event.kind))
        };
        while !found(&lock(&self.events)) {
            std::thread::yield_now();
        }
    }

    pub(crate) fn count(&self, happened: impl Fn(&EventKind) -> bool) -> usize {
        let events = lock(&self.events);
        events.iter().filter(|event| happened(&event.kind)).count()
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
    }
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().expect("nobody panicked")
}

/// The stream of a client.
pub(crate) trait Wire: Read + Write {}
impl<T: Read + Write> Wire for T {}

/// A client of the protocol.
pub(crate) struct Client {
    wire: Box<dyn Wire>,
    receiver: Receiver,
    waiting: std::collections::VecDeque<Packet>,
    begun: Instant,
}

impl Client {
    pub(crate) fn tcp(address: SocketAddr) -> Self {
        let stream = TcpStream::connect(address).expect("somebody listens");
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

    fn on(wire: impl Read + Write + 'static) -> Self {
        Self {
            wire: Box::new(wire),
            receiver: Receiver::new(),
            waiting: std::collections::VecDeque::new(),
            begun: Instant::now(),
        }
    }

    /// Returns the stream alone.
    pub(crate) fn into_wire(self) -> Box<dyn Wire> {
        self.wire
    }

    /// Does the handshake, opens the servers and switches the motors on.
    pub(crate) fn open(&mut self) -> Names {
        let names = self.shake_hands();
        self.say(&Command::Open(Form::One));
        self.say(&Command::Enable(true));
        self.sip_with(|sip| sip.motors());
        names
    }

    pub(crate) fn shake_hands(&mut self) -> Names {
        for sync in [SyncStep::Zero, SyncStep::One] {
            self.send(&sync.to_packet().to_bytes());
            let echo = self.packet_with(|packet| SyncStep::from_packet(packet) == Some(sync));
            assert_eq!(echo, sync.to_packet());
        }
        self.send(&SyncStep::Two.to_packet().to_bytes());
        let packet = self.packet_with(|packet| packet.id() == 2);
        Names::from_packet(&packet).expect("its names")
    }

    pub(crate) fn say(&mut self, command: &Command) {
        self.send(&command.to_packet().expect("it fits").to_bytes());
    }

    pub(crate) fn send(&mut self, bytes: &[u8]) {
        self.wire.write_all(bytes).expect("the robot is there");
    }

    /// Returns the next packet.
    pub(crate) fn packet(&mut self) -> Packet {
        self.try_packet().expect("the robot is there")
    }

    /// Returns the next packet; `None` if the robot has closed the connection.
    pub(crate) fn try_packet(&mut self) -> Option<Packet> {
        while self.waiting.is_empty() {
            let mut room = [0; 512];
            let count = match self.wire.read(&mut room) {
                Ok(0) => return None,
                Ok(count) => count,
                Err(error) if error.kind() == ErrorKind::Interrupted => continue,
                Err(_) => return None,
            };
            let Self {
                receiver, waiting, ..
            } = self;
            receiver.receive(&room[..count], self.begun.elapsed(), |packet| {
                waiting.push_back(packet);
            });
        }
        self.waiting.pop_front()
    }

    /// Returns the next packet for which `wanted` is true.
    pub(crate) fn packet_with(&mut self, wanted: impl Fn(&Packet) -> bool) -> Packet {
        loop {
            let packet = self.packet();
            if wanted(&packet) {
                return packet;
            }
        }
    }

    /// Returns the next server information packet.
    pub(crate) fn sip(&mut self) -> Sip {
        let packet = self.packet_with(|packet| matches!(packet.id(), 0x32 | 0x33));
        Sip::from_packet(&packet).expect("a good one")
    }

    /// Returns the next server information packet for which `wanted` is true, and sends PULSE meanwhile.
    pub(crate) fn sip_with(&mut self, wanted: impl Fn(&Sip) -> bool) -> Sip {
        loop {
            let sip = self.sip();
            if wanted(&sip) {
                return sip;
            }
            self.say(&Command::Pulse);
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
pub(crate) fn near(is: f64, wanted: f64, tolerance: f64) {
    assert!(
        (is - wanted).abs() <= tolerance,
        "{is} is not {wanted} ± {tolerance}"
    );
}

pub(crate) const SECOND: Duration = Duration::from_secs(1);
