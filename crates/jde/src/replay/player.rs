//! Plays a recording at its speed: publishes its values and lines, and obeys its controls. Draws nothing.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use jde_core::Nanos;
use jde_link::Events;
use jde_records::RunRecord;

use super::clock::PlaybackClock;
use super::hierarchy::Hierarchy;
use super::index::{Entries, Entry, Index};
use super::publisher::Publisher;
use super::state::PlaybackState;
use crate::failure::Failure;

/// The longest wait before the position is updated if there are no messages.
const TICK: Duration = Duration::from_millis(50);

/// The controls of the player.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Controls {
    pub(super) paused: bool,
    /// Seconds of the recording per second.
    pub(super) speed: f64,
    /// Start again at the end.
    pub(super) looping: bool,
    /// Continue from this place.
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
                seek: Some(from.clamp(index.begin, index.end)),
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
        lock(&self.controls).clone()
    }

    /// Returns the hierarchy at the position.
    pub(super) fn hierarchy(&self) -> Hierarchy {
        lock(&self.state).hierarchy().clone()
    }

    /// Returns the last lines before the position, newest first: at most `most` of those for which `words`
    /// returns a text.
    pub(super) fn recent(&self, most: usize, words: impl Fn(&RunRecord) -> Option<String>) -> Vec<String> {
        lock(&self.state).recent().filter_map(words).take(most).collect()
    }

    /// Pauses or continues. Continuing at the end starts again.
    pub(super) fn set_paused(&self, paused: bool) {
        self.update_controls(|wanted| {
            wanted.paused = paused;
            wanted.steps = 0;
            if !paused && self.at_end() {
                wanted.seek = Some(self.index.begin);
            }
        });
    }

    /// Continues at another speed, from 0.01 to 100.
    pub(super) fn set_speed(&self, speed: f64) {
        self.update_controls(|wanted| wanted.speed = speed.clamp(0.01, 100.0));
    }

    pub(super) fn set_looping(&self, looping: bool) {
        self.update_controls(|wanted| wanted.looping = looping);
    }

    /// Continues from another place.
    pub(super) fn seek(&self, place: Nanos) {
        self.update_controls(|wanted| wanted.seek = Some(place.clamp(self.index.begin, self.index.end)));
    }

    /// Continues to the next takeover, and pauses there.
    pub(super) fn step(&self) {
        self.update_controls(|wanted| {
            wanted.paused = true;
            wanted.steps += 1;
        });
    }

    pub(super) fn stop(&self) {
        self.update_controls(|wanted| wanted.stop = true);
    }

    /// Whether it was stopped.
    pub(super) fn is_stopped(&self) -> bool {
        lock(&self.controls).stop
    }

    /// Goes to the place where playing starts. Call it once, before anything asks for the position.
    pub(super) fn go_to_start(&self, stage: &mut Publisher, events: &Events) -> Result<(), Failure> {
        let place = lock(&self.controls).seek.take();
        let place = place.unwrap_or(self.index.begin);
        self.restore(place, stage, events).map(drop)
    }

    /// Plays until it is stopped. If `to_the_end` is set, also returns at the end.
    pub(super) fn play(
        &self,
        stage: &mut Publisher,
        events: &Events,
        to_the_end: bool,
    ) -> Result<(), Failure> {
        let mut coming = self.index.entries_from(self.position())?;
        let mut next: Option<Entry> = None;
        let mut pace = PlaybackClock::new(self.position(), Instant::now(), self.controls().speed);
        loop {
            let mut wanted = lock(&self.controls);
            if wanted.stop {
                return Ok(());
            }
            if let Some(place) = wanted.seek.take() {
                drop(wanted);
                coming = self.restore(place, stage, events)?;
                next = None;
                pace = PlaybackClock::new(place, Instant::now(), self.controls().speed);
                continue;
            }
            if wanted.paused && wanted.steps == 0 {
                let speed = self.wait(wanted, TICK).speed;
                pace = PlaybackClock::new(self.position(), Instant::now(), speed);
                continue;
            }
            let stepping = wanted.paused;
            let speed = wanted.speed;
            if next.is_none() {
                next = coming.next();
            }
            let Some(due) = next.as_ref().map(Entry::time) else {
                self.position.store(self.index.end, Ordering::Relaxed);
                wanted.steps = 0;
                if wanted.looping {
                    wanted.seek = Some(self.index.begin);
                    continue;
                }
                wanted.paused = true;
                self.at_end.store(true, Ordering::Relaxed);
                if to_the_end {
                    return Ok(());
                }
                continue;
            };
            if !stepping {
                let now = pace.advance(Instant::now(), speed);
                if due > now {
                    self.position.store(now, Ordering::Relaxed);
                    drop(self.wait(wanted, pace.time_until(now, due).min(TICK)));
                    continue;
                }
            }
            drop(wanted);
            self.position.store(due, Ordering::Relaxed);
            if let Some(next) = &next {
                lock(&self.state).apply(next);
            }
            match next.take() {
                Some(Entry::Value(value)) => stage.publish(&value),
                Some(Entry::Line(_, line)) => {
                    let takeover = matches!(&line, RunRecord::Decision(decision) if decision.changed);
                    events.push(line);
                    if stepping && takeover {
                        self.update_controls(|wanted| wanted.steps = wanted.steps.saturating_sub(1));
                    }
                }
                Some(Entry::Cycle(_)) | None => {}
            }
        }
    }

    /// Restores everything as it was at a place. Returns the entries from there on.
    fn restore(&self, place: Nanos, stage: &mut Publisher, events: &Events) -> Result<Entries, Failure> {
        self.at_end.store(false, Ordering::Relaxed);
        // Move a copy: holding the lock while reading would block viewers.
        let mut past = lock(&self.state).clone();
        // `jde why` needs the skipped lines too.
        for line in past.seek(&self.index, place, self.position())? {
            events.push(line);
        }
        *lock(&self.state) = past;
        stage.clear(place);
        for value in self.index.latest_values(place)? {
            stage.publish(&value);
        }
        self.position.store(place, Ordering::Relaxed);
        self.index.entries_from(place)
    }

    fn update_controls(&self, change: impl FnOnce(&mut Controls)) {
        change(&mut lock(&self.controls));
        self.changed.notify_all();
    }

    fn wait<'w>(&self, wanted: MutexGuard<'w, Controls>, time: Duration) -> MutexGuard<'w, Controls> {
        let waited = self.changed.wait_timeout(wanted, time);
        waited.map_or_else(|poisoned| poisoned.into_inner().0, |(wanted, _)| wanted)
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Stops the player when it is dropped, also by a panic of the viewer.
pub(super) struct StopPlayerOnDrop(pub(super) Arc<Player>);

impl Drop for StopPlayerOnDrop {
    fn drop(&mut self) {
        self.0.stop();
    }
}
