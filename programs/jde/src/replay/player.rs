//! Plays a recording at its speed: publishes its values and lines, and follows its controls. Draws nothing.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

use jde_core::Nanos;
use jde_link::Events;
use jde_records::RunRecord;
use jde_timeline::Timeline;
use parking_lot::{Condvar, Mutex};

use super::clock::PlaybackClock;
use super::index::{Entries, Index, IndexEntry};
use super::publisher::Publisher;
use super::state::PlaybackState;
use crate::failure::Failure;

/// The longest wait before the position is updated if there are no messages.
const POSITION_INTERVAL: Duration = Duration::from_millis(50);

/// The controls of the player.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Controls {
    pub(super) paused: bool,
    /// Seconds of the recording per second.
    pub(super) speed: f64,
    /// Start again at the end.
    pub(super) looping: bool,
    /// Continue from this position.
    seek: Option<Nanos>,
    /// Number of takeovers to play before pausing.
    steps: u32,
    stop: bool,
}

/// A recording that is being played. Any thread may call it.
pub(super) struct Player {
    controls: Mutex<Controls>,
    changed: Condvar,
    position: AtomicU64,
    at_end: AtomicBool,
    state: Mutex<PlaybackState>,
    pub(super) index: Index,
}

impl Player {
    pub(super) fn new(index: Index, paused: bool, speed: f64, looping: bool, from: Nanos) -> Self {
        Self {
            state: Mutex::new(PlaybackState::new(&index)),
            controls: Mutex::new(Controls {
                paused,
                speed,
                looping,
                // The last message is before the position after it.
                seek: Some(from.clamp(index.begin, index.end.saturating_add(1))),
                steps: 0,
                stop: false,
            }),
            changed: Condvar::new(),
            position: AtomicU64::new(0),
            at_end: AtomicBool::new(false),
            index,
        }
    }

    /// Returns the position, in ns since the application's start.
    pub(super) fn position(&self) -> Nanos {
        self.position.load(Ordering::Relaxed)
    }

    /// Whether it waits at the end.
    pub(super) fn at_end(&self) -> bool {
        self.at_end.load(Ordering::Relaxed)
    }

    /// Returns the current controls.
    pub(super) fn controls(&self) -> Controls {
        self.controls.lock().clone()
    }

    /// Returns what `read` finds in the run until the position.
    pub(super) fn timeline<T>(&self, read: impl FnOnce(&Timeline) -> T) -> T {
        read(self.state.lock().timeline())
    }

    /// Returns the last lines before the position, newest first: at most `count` of those for which `format`
    /// returns a text.
    pub(super) fn recent(&self, count: usize, format: impl Fn(&RunRecord) -> Option<String>) -> Vec<String> {
        self.state
            .lock()
            .recent()
            .filter_map(format)
            .take(count)
            .collect()
    }

    /// Pauses or continues. Continuing at the end starts again.
    pub(super) fn set_paused(&self, paused: bool) {
        self.update_controls(|controls| {
            controls.paused = paused;
            controls.steps = 0;
            if !paused && self.at_end() {
                controls.seek = Some(self.index.begin);
            }
        });
    }

    /// Continues at another speed, from 0.01 to 100.
    pub(super) fn set_speed(&self, speed: f64) {
        self.update_controls(|controls| controls.speed = speed.clamp(0.01, 100.0));
    }

    pub(super) fn set_looping(&self, looping: bool) {
        self.update_controls(|controls| controls.looping = looping);
    }

    /// Continues from another position.
    pub(super) fn seek(&self, position: Nanos) {
        self.update_controls(|controls| {
            controls.seek = Some(position.clamp(self.index.begin, self.index.end))
        });
    }

    /// Continues to the next takeover, and pauses there.
    pub(super) fn step(&self) {
        self.update_controls(|controls| {
            controls.paused = true;
            controls.steps += 1;
        });
    }

    pub(super) fn stop(&self) {
        self.update_controls(|controls| controls.stop = true);
    }

    /// Whether it was stopped.
    pub(super) fn is_stopped(&self) -> bool {
        self.controls.lock().stop
    }

    /// Goes to the position where playing starts. Call it once, before anything reads the position.
    pub(super) fn go_to_start(&self, publisher: &mut Publisher, events: &Events) -> Result<(), Failure> {
        let position = self.controls.lock().seek.take();
        let position = position.unwrap_or(self.index.begin);
        self.restore(position, publisher, events).map(drop)
    }

    /// Goes to the position where playing starts, and reads nothing: the caller [applies](Self::apply) what it needs.
    pub(super) fn stand(&self) {
        let position = self.controls.lock().seek.take();
        let position = position.unwrap_or(self.index.begin);
        self.position.store(position, Ordering::Relaxed);
    }

    /// Adds an entry to the state.
    pub(super) fn apply(&self, next: &IndexEntry) {
        self.state.lock().apply(next);
    }

    /// Plays until it is stopped. If `to_the_end` is set, also returns at the end.
    pub(super) fn play(
        &self,
        publisher: &mut Publisher,
        events: &Events,
        to_the_end: bool,
    ) -> Result<(), Failure> {
        let mut entries = self.index.entries_from(self.position())?;
        let mut next: Option<IndexEntry> = None;
        let mut clock = PlaybackClock::new(self.position(), Instant::now(), self.controls().speed);
        loop {
            let mut controls = self.controls.lock();
            if controls.stop {
                return Ok(());
            }
            if let Some(position) = controls.seek.take() {
                drop(controls);
                entries = self.restore(position, publisher, events)?;
                next = None;
                clock = PlaybackClock::new(position, Instant::now(), self.controls().speed);
                continue;
            }
            if controls.paused && controls.steps == 0 {
                self.changed.wait_for(&mut controls, POSITION_INTERVAL);
                let speed = controls.speed;
                clock = PlaybackClock::new(self.position(), Instant::now(), speed);
                continue;
            }
            let stepping = controls.paused;
            let speed = controls.speed;
            if next.is_none() {
                next = entries.next();
            }
            let Some(due) = next.as_ref().map(IndexEntry::time) else {
                self.position.store(self.index.end, Ordering::Relaxed);
                controls.steps = 0;
                if controls.looping {
                    controls.seek = Some(self.index.begin);
                    continue;
                }
                controls.paused = true;
                self.at_end.store(true, Ordering::Relaxed);
                if to_the_end {
                    return Ok(());
                }
                continue;
            };
            if !stepping {
                let now = clock.advance(Instant::now(), speed);
                if due > now {
                    self.position.store(now, Ordering::Relaxed);
                    self.changed
                        .wait_for(&mut controls, clock.time_until(now, due).min(POSITION_INTERVAL));
                    continue;
                }
            }
            drop(controls);
            self.position.store(due, Ordering::Relaxed);
            if let Some(next) = &next {
                self.state.lock().apply(next);
            }
            match next.take() {
                Some(IndexEntry::Value(value)) => publisher.publish(&value),
                Some(IndexEntry::Line(time, line)) => {
                    if let Some(topic) = self.index.retracted_topic(&line) {
                        publisher.end(topic, time);
                    }
                    let takeover = matches!(&line, RunRecord::Decision(decision) if decision.changed);
                    events.push(line);
                    if stepping && takeover {
                        self.update_controls(|controls| controls.steps = controls.steps.saturating_sub(1));
                    }
                }
                Some(IndexEntry::Cycle(_)) | None => {}
            }
        }
    }

    /// Restores everything as it was at a position. Returns the entries from there on.
    fn restore(
        &self,
        position: Nanos,
        publisher: &mut Publisher,
        events: &Events,
    ) -> Result<Entries, Failure> {
        self.at_end.store(false, Ordering::Relaxed);
        // Move a copy: holding the lock while reading would block viewers.
        let mut state = self.state.lock().clone();
        // `jde why` needs the skipped lines too.
        for line in state.seek(&self.index, position, self.position())? {
            events.push(line);
        }
        *self.state.lock() = state;
        publisher.clear(position);
        for value in self.index.latest_values(position)? {
            publisher.publish(&value);
            if let Some(ended) = value.ended {
                publisher.end(&value.topic, ended);
            }
        }
        self.position.store(position, Ordering::Relaxed);
        self.index.entries_from(position)
    }

    fn update_controls(&self, change: impl FnOnce(&mut Controls)) {
        change(&mut self.controls.lock());
        self.changed.notify_all();
    }
}

/// Stops the player when it is dropped, also by a panic of the viewer.
pub(super) struct StopPlayerOnDrop(pub(super) Arc<Player>);

impl Drop for StopPlayerOnDrop {
    fn drop(&mut self) {
        self.0.stop();
    }
}
