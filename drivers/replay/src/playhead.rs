//! The position in a recording, and its changes: pause, speed, jumps, steps, the end. It reads no messages.

use core::time::Duration;

/// The inputs of an iteration. Written values have sequence numbers, so that the same value can be written
/// twice.
pub(crate) struct PlaybackRequest {
    pub(crate) now: Duration,
    pub(crate) paused: bool,
    pub(crate) speed: f64,
    pub(crate) position: (u64, f64),
    pub(crate) step: (u64, u32),
    pub(crate) repeat: bool,
}

/// The actions of an iteration.
#[derive(Debug, Default, PartialEq, Eq)]
pub(crate) struct PlaybackStep {
    /// Continue from this position.
    pub(crate) seek: Option<Duration>,
    /// Play this many messages, whatever their times; `None` plays those that are due.
    pub(crate) messages: Option<u32>,
}

/// A moving position in a recording.
#[derive(Debug)]
pub(crate) struct Playhead {
    length: Duration,
    position: Duration,
    /// The application's time at that position.
    since: Duration,
    speed: f64,
    playing: bool,
    ended: bool,
    messages: u64,
    position_written: u64,
    step_written: u64,
    begun: bool,
}

impl Playhead {
    pub(crate) fn new(now: Duration, length: Duration) -> Self {
        Self {
            length,
            position: Duration::ZERO,
            since: now,
            speed: 1.0,
            playing: true,
            ended: false,
            messages: 0,
            position_written: 0,
            step_written: 0,
            begun: false,
        }
    }

    /// Excludes the time asleep, which ends now.
    pub(crate) fn wake(&mut self, now: Duration) {
        self.since = now;
    }

    /// Advances the position to this time, and returns the actions.
    pub(crate) fn advance(&mut self, request: &PlaybackRequest) -> PlaybackStep {
        let mut plan = PlaybackStep::default();
        let passed = request.now.saturating_sub(self.since);
        self.since = request.now;
        // The time before the first iteration does not count.
        let passed = if self.begun { passed } else { Duration::ZERO };
        self.speed = request.speed;
        self.playing = !request.paused;
        let (written, seconds) = request.position;
        if self.position_written != written || (!self.begun && seconds > 0.0) {
            self.position_written = written;
            let position = Duration::try_from_secs_f64(seconds).unwrap_or(self.length);
            plan.seek = Some(position.min(self.length));
        } else if self.ended && request.repeat && self.playing {
            plan.seek = Some(Duration::ZERO);
        }
        if let Some(position) = plan.seek {
            (self.position, self.ended) = (position, false);
        } else if self.playing {
            self.position = (self.position + passed.mul_f64(self.speed)).min(self.length);
        }
        let (written, count) = request.step;
        if self.step_written != written {
            self.step_written = written;
            plan.messages = (!self.playing).then_some(count);
        }
        if !self.playing {
            // A pause plays only the requested messages.
            plan.messages = plan.messages.or(Some(0));
        }
        self.begun = true;
        self.ended |= self.position >= self.length && self.playing;
        plan
    }

    /// Counts a message that was played. A step in a pause advances the position to it.
    pub(crate) fn played(&mut self, at: Duration, step: bool) {
        self.messages += 1;
        if step {
            self.position = self.position.max(at);
        }
    }

    /// Converts a position to the application's time.
    pub(crate) fn time_of(&self, at: Duration, now: Duration) -> Duration {
        let ago = self.position.saturating_sub(at);
        now.saturating_sub(ago.div_f64(self.speed))
    }

    pub(crate) fn position(&self) -> Duration {
        self.position
    }

    pub(crate) fn messages(&self) -> u64 {
        self.messages
    }

    pub(crate) fn is_playing(&self) -> bool {
        self.playing && !self.ended
    }

    pub(crate) fn has_ended(&self) -> bool {
        self.ended
    }
}
