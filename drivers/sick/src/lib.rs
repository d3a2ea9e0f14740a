//! Drives SICK LMS 200, 211, 220, 221 and 291 laser scanners. What goes over the wire is in modules that do no I/O; this file
//! holds them to a port, a clock and the exports.

#[cfg(test)]
mod emulator;
mod scan;
mod session;
mod telegram;

use core::time::Duration;

use jde_port::{Address, Backoff, Link, Port};
use jde_schema::prelude::*;

use scan::{Beams, Reach};
use session::{Event, Line, Scan, Session, Wanted};

/// One turn of the mirror, 75 times a second.
const TURN: f32 = 1.0 / 75.0;
/// How long the last words may take when it goes to sleep.
const FAREWELL: Duration = Duration::from_millis(100);

/// A SICK LMS 2xx laser scanner at a serial line, or behind a serial server.
///
/// It is found at whatever speed it has, configured and met again by itself after every loss.
#[derive(Describe)]
#[schema(driver, period = "10ms", budget = "20ms")]
pub struct Lms2xx {
    /// Where it is: "serial:/dev/ttyUSB0@9600", or "tcp:HOST:PORT" of a serial server.
    #[modulation(default = "", fixed)]
    port: Modulation<Text<256>>,
    /// Speed of the line while scans come, bits per second: 9600, 19200, 38400, or 500000 over RS-422.
    #[modulation(default = 38_400, fixed)]
    baud: Modulation<u32>,
    /// Beams of a scan: 181 or 361 over half a turn, 101, 201 or 401 over 100 degrees.
    #[modulation(default = 181, fixed)]
    beams: Modulation<u32>,
    /// How far it measures: 8, 16 or 32 in millimetres, 80 in centimetres.
    #[modulation(default = 8, unit = "m", fixed)]
    reach: Modulation<u32>,
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
    /// What was last told.
    told: Option<Connection>,
    /// What was last complained of; nothing once it was heard.
    trouble: Text<120>,
    name: String,
    last_scan: Option<Duration>,
    heard: Vec<u8>,
}

impl Schema for Lms2xx {
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
                Event::Ready(name) => {
                    info!(cx, "{name}");
                    device.name = name;
                }
                Event::Send(_) | Event::Baud(_) | Event::Lose(_) => {}
            }
        }
        if device.session.as_ref().is_none_or(|session| !session.is_ready())
            && device.last_scan.take().is_some()
        {
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
            if device.session.is_some() && device.port.write(&Session::farewell()) {
                device.port.flush(FAREWELL);
            }
            self.laser.retract(cx);
            self.connection.retract(cx);
        }
    }
}

impl Lms2xx {
    fn device(&self, cx: &Context) -> Result<Device> {
        let address = self.port.get(cx);
        if address.is_empty() {
            return Err(
                "it has no port; give it one in the application: port = \"serial:/dev/ttyUSB0@9600\"".into(),
            );
        }
        let address = Address::parse(address.as_str())?;
        let (baud, beams, reach) = (self.baud.get(cx), self.beams.get(cx), self.reach.get(cx));
        if ![9600, 19_200, 38_400, 500_000].contains(&baud) {
            return Err(format!("baud = {baud}: it can be 9600, 19200, 38400 or 500000").into());
        }
        let line = match address {
            Address::Serial { baud: first, .. } => Line::Serial { first, working: baud },
            Address::Tcp { .. } => Line::Fixed,
        };
        let wanted = Wanted {
            beams: Beams::so_many(beams)
                .ok_or_else(|| format!("beams = {beams}: it can be 101, 181, 201, 361 or 401"))?,
            reach: Reach::metres(reach)
                .ok_or_else(|| format!("reach = {reach}: it can be 8, 16, 32 or 80"))?,
            line,
        };
        Ok(Device {
            port: Port::new(address, Backoff::default()),
            wanted,
            session: None,
            told: None,
            trouble: Text::EMPTY,
            name: String::new(),
            last_scan: None,
            heard: Vec::new(),
        })
    }

    fn publish(&mut self, cx: &Context, device: &mut Device, scan: &Scan) -> Result {
        let beams = device.wanted.beams;
        // The first beam was measured before the rest of the turn, and all before they came over the wire.
        let turn = Duration::from_secs_f32(TURN * f32::from(beams.view) / 360.0);
        let time = cx.now().saturating_sub(scan.transfer + turn);
        let time = device.last_scan.map_or(time, |last| time.max(last));
        let mut laser = self.laser.loan(cx);
        laser.header = Header::new(time, "laser");
        laser.angle_min = beams.angle_min();
        laser.angle_increment = beams.increment();
        laser.angle_max = beams.angle_min() + beams.increment() * (beams.count() - 1) as f32;
        // Finer steps than a degree are put together from several turns, in no order that one number tells.
        laser.time_increment = if beams.step == 100 { TURN / 360.0 } else { 0.0 };
        laser.scan_time = device.last_scan.map_or(0.0, |last| (time - last).as_secs_f32());
        laser.range_min = 0.0;
        laser.range_max = device.wanted.reach.range_max();
        laser.intensities.clear();
        laser.ranges.clear();
        laser.ranges.extend_from_slice(&scan.ranges)?;
        laser.publish_at(time);
        device.last_scan = Some(time);
        Ok(())
    }
}

impl Device {
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
                Event::Ready(_) | Event::Scan(_) | Event::Warn(_) => {}
            }
        }
        if !self.port.link().is_connected() {
            self.session = None;
        }
        events
    }

    /// How the connection is, if that has not been told.
    fn news(&mut self, now: Duration) -> Option<Connection> {
        let ready = self.session.as_ref().is_some_and(Session::is_ready);
        let (state, note) = match self.port.link() {
            Link::Idle => (Connection::IDLE, ""),
            Link::Connecting { .. } => (Connection::CONNECTING, ""),
            Link::Connected { .. } if ready => (Connection::CONNECTED, &*self.name),
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

jde_schema::export!("sick", "Drives SICK LMS laser scanners.", [Lms2xx]);

#[cfg(test)]
mod tests;
