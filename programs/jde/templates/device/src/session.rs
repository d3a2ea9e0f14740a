//! The protocol of the device. It does no I/O: bytes and time are arguments, and actions are events.

use core::time::Duration;

use jde_device::{Event, Protocol};

/// Longest wait for a reply.
const TIMEOUT: Duration = Duration::from_secs(3);
/// Longest line that the device sends, in bytes.
const MAX_LINE: usize = 64;

/// One connection to the device.
pub struct Session {
    line: Vec<u8>,
    requested: Duration,
    ready: bool,
}

impl Protocol for Session {
    const DEVICE: &'static str = "thermometer";
    type Config = ();
    /// Degrees Celsius.
    type Data = f64;

    fn start((): (), now: Duration, events: &mut Vec<Event<f64>>) -> Self {
        events.push(Event::Send(b"?".to_vec()));
        Self { line: Vec::new(), requested: now, ready: false }
    }

    /// Called in every iteration, often without bytes.
    fn receive(&mut self, bytes: &[u8], now: Duration, events: &mut Vec<Event<f64>>) {
        self.line.extend_from_slice(bytes);
        if let Some(end) = self.line.iter().position(|byte| *byte == b'\n') {
            let line: Vec<u8> = self.line.drain(..=end).collect();
            self.read(&String::from_utf8_lossy(&line), events);
            self.requested = now;
            events.push(Event::Send(b"?".to_vec()));
        } else if self.line.len() > MAX_LINE {
            events.push(Event::Disconnect("a line is too long".to_owned()));
        } else if now > self.requested + TIMEOUT {
            events.push(Event::Disconnect(format!("no reply for {TIMEOUT:?}")));
        }
    }

    fn is_ready(&self) -> bool {
        self.ready
    }

    fn closing_bytes() -> Vec<u8> {
        Vec::new()
    }
}

impl Session {
    fn read(&mut self, line: &str, events: &mut Vec<Event<f64>>) {
        match line.trim().parse() {
            Ok(celsius) => {
                if !self.ready {
                    self.ready = true;
                    events.push(Event::Ready("a thermometer".to_owned()));
                }
                events.push(Event::Data(celsius));
            }
            Err(error) => events.push(Event::Warn(format!("{line:?} is not a temperature: {error}"))),
        }
    }
}
