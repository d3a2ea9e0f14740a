//! Plays a recording at its speed: publishes its values and lines, and obeys its controls. Draws nothing.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use jde_core::Nanos;
use jde_host::story::Line;
use jde_link::Events;

use super::cast::Hierarchy;
use super::index::{Coming, Index, Next};
use super::pace::Pace;
use super::past::Past;
use super::stage::Stage;
use crate::failure::Failure;

/// The longest wait before the position is updated if there are no messages.
const TICK: Duration = Duration::from_millis(50);

/// The controls of the player.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Wanted {
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
    wanted: Mutex<Wanted>,
    changed: Condvar,
    position: AtomicU64,
    at_end: AtomicBool,
    past: Mutex<Past>,
    pub(super) index: Index,
}

impl Player {
    pub(super) fn new(index: Index, paused: bool, speed: f64, looping: bool, from: Nanos) -> Self {
        Self {
            past: Mutex::new(Past::new(&index)),
            wanted: Mutex::new(Wanted {
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
    pub(super) fn wanted(&self) -> Wanted {
        lock(&self.wanted).clone()
    }

    /// Returns the hierarchy at the position.
    pub(super) fn hierarchy(&self) -> Hierarchy {
        lock(&self.past).hierarchy().clone()
    }

    /// Returns the last lines before the position, newest first: at most `most` of those for which `words`
    /// returns a text.
    pub(super) fn recent(&self, most: usize, words: impl Fn(&Line) -> Option<String>) -> Vec<String> {
        lock(&self.past).recent().filter_map(words).take(most).collect()
    }

    /// Pauses or continues. Continuing at the end starts again.
    pub(super) fn pause(&self, paused: bool) {
        self.want(|wanted| {
            wanted.paused = paused;
            wanted.steps = 0;
            if !paused && self.at_end() {
                wanted.seek = Some(self.index.begin);
            }
        });
    }

    /// Continues at another speed, from 0.01 to 100.
    pub(super) fn hurry(&self, speed: f64) {
        self.want(|wanted| wanted.speed = speed.clamp(0.01, 100.0));
    }

    pub(super) fn repeat(&self, looping: bool) {
        self.want(|wanted| wanted.looping = looping);
    }

    /// Continues from another place.
    pub(super) fn seek(&self, place: Nanos) {
        self.want(|wanted| wanted.seek = Some(place.clamp(self.index.begin, self.index.end)));
    }

    /// Continues to the next takeover, and pauses there.
    pub(super) fn step(&self) {
        self.want(|wanted| {
            wanted.paused = true;
            wanted.steps += 1;
        });
    }

    pub(super) fn stop(&self) {
        self.want(|wanted| wanted.stop = true);
    }

    /// Whether it was stopped.
    pub(super) fn is_stopped(&self) -> bool {
        lock(&self.wanted).stop
    }

    /// Goes to the place where playing starts. Call it once, before anything asks for the position.
    pub(super) fn begin(&self, stage: &mut Stage, events: &Events) -> Result<(), Failure> {
        let place = lock(&self.wanted).seek.take();
        let place = place.unwrap_or(self.index.begin);
        self.go_to(place, stage, events).map(drop)
    }

    /// Plays until it is stopped. If `to_the_end` is set, also returns at the end.
    pub(super) fn play(&self, stage: &mut Stage, events: &Events, to_the_end: bool) -> Result<(), Failure> {
        let mut coming = self.index.from(self.position())?;
        let mut next: Option<Next> = None;
        let mut pace = Pace::new(self.position(), Instant::now(), self.wanted().speed);
        loop {
            let mut wanted = lock(&self.wanted);
            if wanted.stop {
                return Ok(());
            }
            if let Some(place) = wanted.seek.take() {
                drop(wanted);
                coming = self.go_to(place, stage, events)?;
                next = None;
                pace = Pace::new(place, Instant::now(), self.wanted().speed);
                continue;
            }
            if wanted.paused && wanted.steps == 0 {
                let speed = self.wait(wanted, TICK).speed;
                pace = Pace::new(self.position(), Instant::now(), speed);
                continue;
            }
            let stepping = wanted.paused;
            let speed = wanted.speed;
            if next.is_none() {
                next = coming.next();
            }
            let Some(due) = next.as_ref().map(Next::time) else {
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
                let now = pace.place(Instant::now(), speed);
                if due > now {
                    self.position.store(now, Ordering::Relaxed);
                    drop(self.wait(wanted, pace.until(now, due).min(TICK)));
                    continue;
                }
            }
            drop(wanted);
            self.position.store(due, Ordering::Relaxed);
            if let Some(next) = &next {
                lock(&self.past).take_in(next);
            }
            match next.take() {
                Some(Next::Value(value)) => stage.publish(&value),
                Some(Next::Line(_, line)) => {
                    let takeover = matches!(&line, Line::Decision(decision) if decision.changed);
                    events.tell(line);
                    if stepping && takeover {
                        self.want(|wanted| wanted.steps = wanted.steps.saturating_sub(1));
                    }
                }
                Some(Next::Cycle(_)) | None => {}
            }
        }
    }

    /// Restores everything as it was at a place. Returns the entries from there on.
    fn go_to(&self, place: Nanos, stage: &mut Stage, events: &Events) -> Result<Coming, Failure> {
        self.at_end.store(false, Ordering::Relaxed);
        // Move a copy: holding the lock while reading would block viewers.
        let mut past = lock(&self.past).clone();
        // `jde why` needs the skipped lines too.
        for line in past.go_to(&self.index, place, self.position())? {
            events.tell(line);
        }
        *lock(&self.past) = past;
        stage.clear(place);
        for value in self.index.in_force(place)? {
            stage.publish(&value);
        }
        self.position.store(place, Ordering::Relaxed);
        self.index.from(place)
    }

    fn want(&self, change: impl FnOnce(&mut Wanted)) {
        change(&mut lock(&self.wanted));
        self.changed.notify_all();
    }

    fn wait<'w>(&self, wanted: MutexGuard<'w, Wanted>, time: Duration) -> MutexGuard<'w, Wanted> {
        let waited = self.changed.wait_timeout(wanted, time);
        waited.map_or_else(|poisoned| poisoned.into_inner().0, |(wanted, _)| wanted)
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Stops the player when it is dropped, also by a panic of the viewer.
pub(super) struct StopOnDrop(pub(super) Arc<Player>);

impl Drop for StopOnDrop {
    fn drop(&mut self) {
        self.0.stop();
    }
}
