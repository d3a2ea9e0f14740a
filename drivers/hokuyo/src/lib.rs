//! Drives Hokuyo laser scanners that speak SCIP 2. What goes over the wire is in modules that do no I/O; this file holds them to a
//! port, a clock and the exports.

mod clock;
#[cfg(test)]
mod emulator;
mod message;
mod scan;
mod session;

use core::f64::consts::TAU;
use core::time::Duration;

use jde_port::{Address, Backoff, Link, Port};
use jde_schema::prelude::*;

use clock::Clock;
use scan::{Beams, Letters, Scan};
use session::{Event, Session, Wanted};

/// How long the last words may take when it goes to sleep.
const FAREWELL: Duration = Duration::from_millis(100);

/// A Hokuyo laser scanner (URG, UBG, UTM, UST, UXM) at a serial line, over USB or over Ethernet.
///
/// It is asked what it measures, started, and met again by itself after every loss.
#[derive(Describe)]
#[schema(driver, period = "10ms", budget = "20ms")]
pub struct Scip2 {
    /// Where it is: "tcp:192.168.0.10:10940", or "serial:/dev/ttyACM0@115200".
    #[modulation(default = "", fixed)]
    port: Modulation<Text<256>>,
    /// The angle it shall cover, centred ahead; it covers what it can of it.
    #[modulation(default = TAU, unit = "rad", min = 0.0, max = TAU, fixed)]
    view: Modulation<f64>,
    /// Turns that are left out between two scans.
    #[modulation(default = 0, max = 9, fixed)]
    skip: Modulation<u32>,
    /// Letters of a distance: 3, or 2 for distances up to 4.094 m over slow lines.
    #[modulation(default = 3, min = 2, max = 3, fixed)]
    letters: Modulation<u32>,
    /// What it sees, from right to left.
    #[export]
    laser: Export<LaserScan>,
    /// Whether it is heard.
    #[export]
    connection: Export<Connection>,
    device: Option<Device>,
}

/// A scanner that is looked for, or found.
struct Device {
    port: Port,
    wanted: Wanted,
    session: Option<Session>,
    clock: Clock,
    beams: Option<Beams>,
    name: String,
    /// What was last told.
    told: Option<Connection>,
    /// What was last complained of; nothing once it was heard.
    trouble: Text<120>,
    /// Whether a scan stands.
    seen: bool,
    heard: Vec<u8>,
}

impl Schema for Scip2 {
    fn awake(&mut self, cx: &Context) -> Result {
        cx.require_real_time()?;
        if self.device.is_none() {
            self.device = Some(self.device(cx)?);
        }
        Ok(())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let Some(mut device) = self.device.take() else {
            return Err("it is not awake".into());
        };
        for event in device.step(cx.now()) {
            match event {
                Event::Scan(scan) => self.publish(cx, &mut device, &scan)?,
                Event::Warn(words) => warn!(cx, "{words}"),
                Event::Ready(beams, name) => {
                    info!(cx, "{name}: {} beams", beams.count());
                    device.clock = Clock::default();
                    device.beams = Some(beams);
                    device.name = name;
                }
                Event::Send(_) | Event::Baud(_) | Event::Lose(_) => {}
            }
        }
        if !device.is_ready() && device.seen {
            device.seen = false;
            self.laser.retract(cx);
        }
        if let Some(connection) = device.news(cx.now()) {
            if device.is_new_trouble(&connection) {
                warn!(cx, "{}", connection.note);
            }
            self.connection.write(cx, connection);
        }
        self.device = Some(device);
        Ok(())
    }

    fn sleep(&mut self, cx: &Context) {
        if let Some(mut device) = self.device.take() {
            if device.session.is_some() && device.port.write(Session::farewell()) {
                device.port.flush(FAREWELL);
            }
            self.laser.retract(cx);
            self.connection.retract(cx);
        }
    }
}

impl Scip2 {
    fn device(&self, cx: &Context) -> Result<Device> {
        let address = self.port.get(cx);
        if address.is_empty() {
            return Err(
                "it has no port; give it one in the application: port = \"tcp:192.168.0.10:10940\", \
                 or port = \"serial:/dev/ttyACM0@115200\""
                    .into(),
            );
        }
        let address = Address::parse(address.as_str())?;
        let baud = match address {
            Address::Serial { baud, .. } if baud > 999_999 => {
                return Err(format!("{address}: a scanner's line goes at 750000 baud at most").into());
            }
            Address::Serial { baud, .. } => Some(baud),
            Address::Tcp { .. } => None,
        };
        let wanted = Wanted {
            view: self.view.get(cx),
            skip: self.skip.get(cx),
            letters: match self.letters.get(cx) {
                2 => Letters::Two,
                _ => Letters::Three,
            },
            baud,
        };
        Ok(Device {
            port: Port::new(address, Backoff::default()),
            wanted,
            session: None,
            clock: Clock::default(),
            beams: None,
            name: String::new(),
            told: None,
            trouble: Text::EMPTY,
            seen: false,
            heard: Vec::new(),
        })
    }

    fn publish(&mut self, cx: &Context, device: &mut Device, scan: &Scan) -> Result {
        let Some(beams) = device.beams else {
            return Ok(());
        };
        let time = device.clock.measured(scan.stamp, cx.now());
        let mut laser = self.laser.loan(cx);
        laser.header = Header::new(time, "laser");
        laser.angle_min = beams.angle_min();
        laser.angle_increment = beams.increment();
        laser.angle_max = beams.angle_min() + beams.increment() * (beams.count() - 1) as f32;
        laser.time_increment = beams.time_increment();
        laser.scan_time = beams.scan_time();
        laser.range_min = beams.range_min();
        laser.range_max = beams.range_max();
        laser.intensities.clear();
        laser.ranges.clear();
        laser.ranges.extend_from_slice(&scan.ranges)?;
        laser.publish_at(time);
        device.seen = true;
        Ok(())
    }
}

impl Device {
    fn is_ready(&self) -> bool {
        self.session.as_ref().is_some_and(Session::is_ready)
    }

    /// Hears and speaks; what the schema should know of it.
    fn step(&mut self, now: Duration) -> Vec<Event> {
        if !self.port.poll(now).is_connected() {
            self.session = None;
            return Vec::new();
        }
        self.heard.clear();
        self.port.read(&mut self.heard);
        let mut events = Vec::new();
        let session = match &mut self.session {
            Some(session) => session,
            none => none.insert(Session::begin(self.wanted, now, &mut events)),
        };
        session.hear(&self.heard, now, &mut events);
        for event in &events {
            match event {
                Event::Send(bytes) => drop(self.port.write(bytes)),
                Event::Baud(baud) => self.port.set_baud(*baud),
                Event::Lose(reason) => self.port.lose(reason),
                Event::Ready(..) | Event::Scan(_) | Event::Warn(_) => {}
            }
        }
        if !self.port.link().is_connected() {
            self.session = None;
        }
        events
    }

    /// How the connection is, if that has not been told.
    fn news(&mut self, now: Duration) -> Option<Connection> {
        let (state, note) = match self.port.link() {
            Link::Idle => (Connection::IDLE, ""),
            Link::Connecting { .. } => (Connection::CONNECTING, ""),
            Link::Connected { .. } if self.is_ready() => (Connection::CONNECTED, &*self.name),
            Link::Connected { .. } => (
                Connection::CONNECTING,
                "the line is open; looking for the scanner",
            ),
            Link::Lost { reason, .. } => (Connection::LOST, &**reason),
        };
        let connection = Connection {
            header: Header::new(now, ""),
            state,
            attempts: self.port.attempts(),
            note: Text::truncated(note),
            ..Connection::default()
        };
        let said = |told: Connection| (told.state, told.attempts, told.note);
        if self.told.map(said) == Some(said(connection)) {
            return None;
        }
        self.told = Some(connection);
        Some(connection)
    }

    /// Whether there is a trouble to complain of: the same is said once, however often it is tried again.
    fn is_new_trouble(&mut self, connection: &Connection) -> bool {
        let trouble = match connection.state {
            Connection::LOST => connection.note,
            Connection::CONNECTED => Text::EMPTY,
            _ => return false,
        };
        let new = trouble != self.trouble && !trouble.is_empty();
        self.trouble = trouble;
        new
    }
}

jde_schema::export!(
    "hokuyo",
    "Drives Hokuyo laser scanners that speak SCIP 2.",
    [Scip2]
);

#[cfg(test)]
mod tests;
