//! The session with a lidar that sends frames without being asked. It does no I/O and has no clock. It gives no turn
//! whose angles, speed and times contradict each other.

use core::time::Duration;

use jde_device::{Event, Protocol};

use super::frame::{Frame, POINTS, Received, Receiver, WRAP};
use crate::scanner::{Scan, range};
use crate::turn::{Point, Turn, Turns};
use crate::watch::{Watch, Words};

/// The distances that the lidars measure, m, by their data sheets.
const LIMITS: [f32; 2] = [0.02, 12.0];
/// Turns per second that the lidars can have: 5 to 13 by their data sheets, with a margin.
const SPEEDS: core::ops::RangeInclusive<f64> = 4.0..=16.0;
/// What it says when no turns come.
const WORDS: Words = Words {
    silent: "nothing comes from it: is it switched on, and is its TX wired to RX?",
    foreign: "bytes come, but no frames of an LD06, LD19 or STL-19P: do you use 230400 baud, and is it that model?",
    corrupt: "most frames come with wrong checksums: is the cable near a motor's, or its ground missing?",
    incomplete: "its frames make no whole turn: too many are missing",
};
/// How much the duration of a turn may differ from that of the speed.
const TOLERANCE: f64 = 0.25;
/// Greatest time between two frames of a connection that is not lost, s.
const MAX_STEP: f64 = 1.0;
/// How much the clocks of the lidar and of this machine may differ.
const DRIFT: f64 = 0.01;

/// The configuration of the driver. The lidar has none.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LdConfig {
    pub(crate) beams: usize,
    pub(crate) inverted: bool,
}

/// The session.
#[derive(Debug)]
pub(crate) struct LdSession {
    receiver: Receiver,
    turns: Turns,
    /// The lidar's clock: its last stamp, and the time without wraps, s.
    clock: Option<(u16, f64)>,
    /// The time at which the lidar's was 0, s: by the frame that came soonest, because frames wait for each other where
    /// they are late. Infinite before the first.
    origin: f64,
    watch: Watch,
}

impl Protocol for LdSession {
    const DEVICE: &'static str = "lidar";
    type Config = LdConfig;
    type Data = Scan;

    fn start(config: LdConfig, now: Duration, _: &mut Vec<Event<Scan>>) -> Self {
        Self {
            receiver: Receiver::default(),
            turns: Turns::new(config.beams, config.inverted),
            clock: None,
            origin: f64::INFINITY,
            watch: Watch::new(now),
        }
    }

    fn is_ready(&self) -> bool {
        self.watch.is_ready()
    }

    fn receive(&mut self, bytes: &[u8], now: Duration, events: &mut Vec<Event<Scan>>) {
        if !self.watch.receive(bytes.len(), now) {
            self.receiver = Receiver::default();
            self.turns.clear();
            (self.clock, self.origin) = (None, f64::INFINITY);
            return;
        }
        self.receiver.receive(bytes);
        let mut turns = Vec::new();
        while let Some(received) = self.receiver.next() {
            match received {
                Received::Frame(frame) => turns.extend(self.frame(&frame, now)),
                Received::Corrupt => self.watch.corrupt(1),
            }
        }
        if self.watch.warns() {
            events.push(Event::Warn(
                "frames come with wrong checksums and are skipped: is the cable near a motor's?".to_owned(),
            ));
        }
        if let Some((_, time)) = self.clock {
            self.origin = self.origin.min(now.as_secs_f64() - time);
        }
        for turn in turns {
            if !self.watch.is_ready() {
                events.push(Event::Ready("LD06, LD19 or STL-19P".to_owned()));
            }
            self.watch.accept(now);
            events.push(Event::Data(Scan {
                age: Duration::try_from_secs_f64(now.as_secs_f64() - self.origin - turn.end)
                    .unwrap_or_default(),
                turn,
                limits: LIMITS,
                has_intensities: true,
            }));
        }
        if let Some(reason) = self.watch.lost(now, &WORDS) {
            events.push(Event::Disconnect(reason));
        }
    }

    /// The lidar has no commands: it measures as long as it has power.
    fn closing_bytes() -> Vec<u8> {
        Vec::new()
    }
}

impl LdSession {
    /// Adds the points of a frame. Returns the turn that ends in it.
    fn frame(&mut self, frame: &Frame, now: Duration) -> Option<Turn> {
        self.watch.good(1);
        let (last, time) = self.clock.unwrap_or((frame.stamp, 0.0));
        let passed = (u32::from(frame.stamp) + u32::from(WRAP) - u32::from(last)) % u32::from(WRAP);
        let passed = f64::from(passed) / 1000.0;
        let time = time + passed;
        self.clock = Some((frame.stamp, time));
        self.origin += passed * DRIFT;
        if passed > MAX_STEP {
            // The frames may be old ones, which the line repeats.
            self.turns.clear();
            self.watch.distrust(now);
            self.contradict(&format!("its time leaps by {passed:.1} s"));
        }
        let speed = f64::from(frame.speed);
        let hertz = speed / 360.0;
        if !SPEEDS.contains(&hertz) {
            self.turns.clear();
            self.watch.refuse(format!(
                "it turns {hertz:.1} times a second instead of 5 to 13: is its head blocked, or its PWM wire open?"
            ));
            return None;
        }
        let step = frame.span / (POINTS - 1) as f64;
        let mut turn = None;
        for (index, (millimetres, intensity)) in frame.points.into_iter().enumerate() {
            let ended = self.turns.add(&Point {
                angle: frame.start + step * index as f64,
                range: range(f32::from(millimetres) / 1000.0, LIMITS),
                intensity: f32::from(intensity),
                time: time - step * (POINTS - 1 - index) as f64 / speed,
            });
            turn = turn.or(ended);
        }
        turn.filter(|turn| self.is_consistent(turn, hertz, now))
    }

    /// Whether to give a turn that has ended.
    fn is_consistent(&mut self, turn: &Turn, hertz: f64, now: Duration) -> bool {
        if !self.watch.end_turn(now) {
            return false;
        }
        if (turn.duration * hertz - 1.0).abs() > TOLERANCE {
            let duration = turn.duration;
            self.contradict(&format!(
                "{duration:.3} s for a turn, at {hertz:.1} turns a second"
            ));
            return false;
        }
        true
    }

    /// Refuses a turn, and relates the lidar's clock to this machine's anew.
    fn contradict(&mut self, how: &str) {
        self.origin = f64::INFINITY;
        self.watch
            .refuse(format!("its clock and its speed contradict each other: {how}"));
    }
}

#[cfg(test)]
mod tests;
