//! The session with a unit that sends without being asked. It does no I/O and has no clock. It gives nothing that is of two
//! instants, at the limit of what the unit measures, or the same for too long.

use core::time::Duration;

use jde_device::{Event, Protocol};

use crate::frame::{Received, Receiver};
use crate::set::{ACCELERATION, ANGLES, QUATERNION, RATES, Set, Sets};

/// Time without a set after which a unit counts as lost.
pub(crate) const SILENCE: Duration = Duration::from_secs(1);
/// Time limit of the first set.
const START: Duration = Duration::from_secs(5);
/// Time without a reading after which nothing tells how old it is what has waited.
const BACKLOG: Duration = Duration::from_millis(500);
/// Bytes of a reading that has left others behind, as a port reads no more at once.
const FULL: usize = 64 << 10;
/// The rate is the mean of this time.
const RATE_TIME: Duration = Duration::from_secs(2);
/// The part of the rate that was asked for below which it is said.
const MIN_RATE: f64 = 0.8;
/// The last bits of what a unit measures are noise. One that sends the same for this time, so often, measures nothing.
const FROZEN_TIME: Duration = Duration::from_secs(5);
const FROZEN_SETS: u32 = 50;
/// Standard gravity, m/s².
const GRAVITY: f64 = 9.80665;

/// What is asked of the unit.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WitConfig {
    /// Sets in a second that it should send; 0 for any.
    pub(crate) rate: f64,
}

/// What the unit measured at an instant, in its own axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Reading {
    /// rad/s.
    pub(crate) rates: [f64; 3],
    /// The specific force, m/s².
    pub(crate) acceleration: Option<[f64; 3]>,
    /// x, y, z and w of a quaternion of length 1.
    pub(crate) orientation: Option<[f64; 4]>,
}

/// The session.
#[derive(Debug)]
pub(crate) struct WitSession {
    config: WitConfig,
    receiver: Receiver,
    sets: Sets,
    deadline: Duration,
    /// Time of the last reading.
    read: Duration,
    /// Time from which sets count.
    resume: Duration,
    is_ready: bool,
    /// What arrived since the last set that counts: bytes, good frames, corrupt ones, and why a set was refused.
    tally: (usize, usize, usize, Option<&'static str>),
    has_warned: bool,
    /// Since when sets are counted, and how many came.
    counted: (Duration, u32),
    /// The last set, since when it is the same, and how often it came.
    last: (Set, Duration, u32),
    /// The same of its turn rates.
    last_rates: ([i16; 3], Duration, u32),
}

impl Protocol for WitSession {
    const DEVICE: &'static str = "IMU";
    type Config = WitConfig;
    type Data = Reading;

    fn start(config: WitConfig, now: Duration, _: &mut Vec<Event<Reading>>) -> Self {
        Self {
            config,
            receiver: Receiver::default(),
            sets: Sets::default(),
            deadline: now + START,
            read: now,
            resume: now + BACKLOG,
            is_ready: false,
            tally: (0, 0, 0, None),
            has_warned: false,
            counted: (now + BACKLOG, 0),
            last: (Set::default(), now, 0),
            last_rates: ([0; 3], now, 0),
        }
    }

    fn is_ready(&self) -> bool {
        self.is_ready
    }

    fn receive(&mut self, bytes: &[u8], now: Duration, events: &mut Vec<Event<Reading>>) {
        let pause = now.saturating_sub(core::mem::replace(&mut self.read, now));
        if pause > BACKLOG || bytes.len() >= FULL {
            self.resume = now + BACKLOG;
            self.deadline = self.deadline.max(self.resume + SILENCE);
            (self.receiver, self.sets) = Default::default();
            self.counted = (self.resume, 0);
            return;
        }
        self.tally.0 += bytes.len();
        self.receiver.receive(bytes);
        let mut newest = None;
        while let Some(received) = self.receiver.next() {
            match received {
                Received::Frame(frame) => {
                    self.tally.1 += 1;
                    if let Some(set) = self.sets.add(&frame, now).filter(|_| now >= self.resume) {
                        self.counted.1 += 1;
                        newest = self.reading(&set, now).or(newest);
                    }
                }
                Received::Corrupt => self.tally.2 += 1,
            }
        }
        self.measure_rate(now, events);
        if let Some(reading) = newest {
            if !core::mem::replace(&mut self.is_ready, true) {
                events.push(Event::Ready("WIT-Motion".to_owned()));
            }
            if self.tally.2 > 0 && !core::mem::replace(&mut self.has_warned, true) {
                let words = "frames come with wrong checksums and are skipped: is the cable near a motor's?";
                events.push(Event::Warn(words.to_owned()));
            }
            (self.tally, self.deadline) = ((0, 0, 0, None), now + SILENCE);
            events.push(Event::Data(reading));
        }
        if now >= self.deadline {
            events.push(Event::Disconnect(self.reason().to_owned()));
        }
    }

    /// The driver sends nothing: the unit measures as long as it has power.
    fn closing_bytes() -> Vec<u8> {
        Vec::new()
    }
}

impl WitSession {
    /// What a set says, if it is to be used.
    fn reading(&mut self, set: &Set, now: Duration) -> Option<Reading> {
        if is_frozen(&mut self.last, set, now) {
            return self.refuse("it sends the same numbers again and again: unplug it and plug it in again");
        }
        let scaled = |kind, range: f64| {
            let [x, y, z, _] = set.get(kind)?;
            Some([x, y, z].map(|number| f64::from(number) / 32768.0 * range))
        };
        let Some(rates) = scaled(RATES, 2000_f64.to_radians()) else {
            return self.refuse(
                "it sends no turn rates: switch on \"angular velocity\" in the program of its maker",
            );
        };
        // A gyro may be stuck while the rest goes on. Zeros may be a unit that stands.
        let [x, y, z, _] = set.get(RATES).unwrap_or_default();
        if is_frozen(&mut self.last_rates, &[x, y, z], now) && [x, y, z] != [0; 3] {
            return self
                .refuse("it sends the same turn rates again and again: unplug it and plug it in again");
        }
        let is_saturated = |kind| {
            let numbers = set.get(kind).unwrap_or_default();
            numbers[..3].iter().any(|number| number.unsigned_abs() >= 32767)
        };
        if is_saturated(RATES) || is_saturated(ACCELERATION) {
            return self.refuse("it is at the limit of what it measures, 2000 degrees/s or 16 g");
        }
        Some(Reading {
            rates,
            acceleration: scaled(ACCELERATION, 16.0 * GRAVITY),
            orientation: set.get(QUATERNION).and_then(quaternion).or_else(|| {
                let [roll, pitch, yaw] = scaled(ANGLES, 180_f64.to_radians())?;
                Some(of_angles(roll, pitch, yaw))
            }),
        })
    }

    fn refuse(&mut self, why: &'static str) -> Option<Reading> {
        self.tally.3 = Some(why);
        None
    }

    fn measure_rate(&mut self, now: Duration, events: &mut Vec<Event<Reading>>) {
        let (since, sets) = self.counted;
        let time = now.saturating_sub(since);
        if time < RATE_TIME {
            return;
        }
        self.sets.count(sets, time.as_secs_f64());
        self.counted = (now, 0);
        let rate = f64::from(sets) / time.as_secs_f64();
        let asked = self.config.rate;
        if self.is_ready && sets > 0 && rate < MIN_RATE * asked {
            // Said once in a connection.
            self.config.rate = 0.0;
            events.push(Event::Warn(format!(
                "it sends {rate:.0} times a second, and `rate` asks for {asked:.0}: set its output rate, and a speed of the line that carries it"
            )));
        }
    }

    /// Why no set comes.
    fn reason(&self) -> &'static str {
        let (bytes, good, corrupt, problem) = self.tally;
        match problem {
            _ if bytes == 0 => "nothing comes from it: has it power, and is its TX wired to RX?",
            // By chance, a checksum is right.
            _ if good <= bytes / 500 => {
                "bytes come, but no frames of a WIT-Motion unit: is the speed of the line its own, 9600 or 115200 baud?"
            }
            _ if corrupt > good => {
                "most frames come with wrong checksums: is the cable near a motor's, or its ground missing?"
            }
            Some(problem) => problem,
            None => "its frames make no whole set: too many are missing",
        }
    }
}

/// Whether something has been the same for so long and so often that it measures nothing.
fn is_frozen<T: Copy + PartialEq>(
    (last, since, count): &mut (T, Duration, u32),
    new: &T,
    now: Duration,
) -> bool {
    if last != new {
        (*last, *since, *count) = (*new, now, 0);
    }
    *count += 1;
    *count >= FROZEN_SETS && now.saturating_sub(*since) >= FROZEN_TIME
}

/// The quaternion of the unit, x, y, z and w; `None` if it has another length than 1.
fn quaternion(numbers: [i16; 4]) -> Option<[f64; 4]> {
    let [w, x, y, z] = numbers.map(|number| f64::from(number) / 32768.0);
    let length = libm::hypot(libm::hypot(x, y), libm::hypot(z, w));
    (0.98..1.02)
        .contains(&length)
        .then(|| [x, y, z, w].map(|part| part / length))
}

/// Roll about x after pitch about y after yaw about z.
fn of_angles(roll: f64, pitch: f64, yaw: f64) -> [f64; 4] {
    let [(a, b), (c, d), (e, f)] = [roll, pitch, yaw].map(|angle| libm::sincos(angle / 2.0));
    [
        a * d * f - b * c * e,
        b * c * f + a * d * e,
        b * d * e - a * c * f,
        b * d * f + a * c * e,
    ]
}

#[cfg(test)]
mod tests;
