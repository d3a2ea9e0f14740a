//! The protocol of the device. It does no I/O: bytes and time are arguments, and what is to be done is an event.

use core::time::Duration;

use jde_device::{Event, Protocol};

/// How long to wait for an answer.
const PATIENCE: Duration = Duration::from_secs(3);
/// The longest line that the device sends.
const LONGEST: usize = 64;

/// One connection to the device.
pub struct Session {
    line: Vec<u8>,
    asked: Duration,
    ready: bool,
}

impl Protocol for Session {
    const DEVICE: &'static str = "thermometer";
    type Config = ();
    /// Degrees Celsius.
    type Data = f64;

    fn start((): (), now: Duration, events: &mut Vec<Event<f64>>) -> Self {
        events.push(Event::Send(b"?".to_vec()));
        Self { line: Vec::new(), asked: now, ready: false }
    }

    /// Called in every iteration, often without a byte.
    fn receive(&mut self, bytes: &[u8], now: Duration, events: &mut Vec<Event<f64>>) {
        self.line.extend_from_slice(bytes);
        if let Some(end) = self.line.iter().position(|byte| *byte == b'\n') {
            let line: Vec<u8> = self.line.drain(..=end).collect();
            self.read(&String::from_utf8_lossy(&line), events);
            self.asked = now;
            events.push(Event::Send(b"?".to_vec()));
        } else if self.line.len() > LONGEST {
            events.push(Event::Disconnect("what came has no end of line".to_owned()));
        } else if now > self.asked + PATIENCE {
            events.push(Event::Disconnect(format!("no answer came for {PATIENCE:?}")));
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
            Err(error) => events.push(Event::Warn(format!("{line:?} is no temperature: {error}"))),
        }
    }
}
