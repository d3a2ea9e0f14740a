//! Plays a recording at its pace: publishes its values, tells its lines, and does what it is told meanwhile. Draws nothing.

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

/// Longest wait before the position is shown anew where nothing comes.
const TICK: Duration = Duration::from_millis(50);

/// What is wanted of the player.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Wanted {
    pub(super) paused: bool,
    /// Seconds of the recording in a second.
    pub(super) speed: f64,
    /// Begin again at the end.
    pub(super) looping: bool,
    /// Go on from there.
    seek: Option<Nanos>,
    /// Takeovers to go on to, one after another, and then pause.
    steps: u32,
    stop: bool,
}

/// A recording under way. Any thread may call it.
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

    /// Where it is, ns since the application's start.
    pub(super) fn position(&self) -> Nanos {
        self.position.load(Ordering::Relaxed)
    }

    /// Whether it has come to the end and stands there.
    pub(super) fn at_end(&self) -> bool {
        self.at_end.load(Ordering::Relaxed)
    }

    /// What is wanted of it.
    pub(super) fn wanted(&self) -> Wanted {
        lock(&self.wanted).clone()
    }

    /// The hierarchy where it is.
    pub(super) fn hierarchy(&self) -> Hierarchy {
        lock(&self.past).hierarchy().clone()
    }

    /// What was told last where it is, the newest first: so many of those that have words.
    pub(super) fn recent(&self, most: usize, words: impl Fn(&Line) -> Option<String>) -> Vec<String> {
        lock(&self.past).recent().filter_map(words).take(most).collect()
    }

    /// Pauses or goes on; at the end it begins again.
    pub(super) fn pause(&self, paused: bool) {
        self.want(|wanted| {
            wanted.paused = paused;
            wanted.steps = 0;
            if !paused && self.at_end() {
                wanted.seek = Some(self.index.begin);
            }
        });
    }

    /// Goes on at another speed.
    pub(super) fn hurry(&self, speed: f64) {
        self.want(|wanted| wanted.speed = speed.clamp(0.01, 100.0));
    }

    pub(super) fn repeat(&self, looping: bool) {
        self.want(|wanted| wanted.looping = looping);
    }

    /// Goes on from another place.
    pub(super) fn seek(&self, place: Nanos) {
        self.want(|wanted| wanted.seek = Some(place.clamp(self.index.begin, self.index.end)));
    }

    /// Goes on to the next takeover, and pauses there.
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

    /// Plays until it is stopped; or, if it is to end by itself, to the end.
    pub(super) fn play(&self, stage: &mut Stage, events: &Events, to_the_end: bool) -> Result<(), Failure> {
        let mut coming = self.index.from(0)?;
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

    /// Shows everything as it was at a place; answers with what comes from there on.
    fn go_to(&self, place: Nanos, stage: &mut Stage, events: &Events) -> Result<Coming, Failure> {
        self.at_end.store(false, Ordering::Relaxed);
        // Not under its lock: that would keep those waiting who look on.
        let mut past = lock(&self.past).clone();
        // Whoever asks why hears of what was passed over too.
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

/// Stops the player when whoever looks on is done, panics included.
pub(super) struct StopOnDrop(pub(super) Arc<Player>);

impl Drop for StopOnDrop {
    fn drop(&mut self) {
        self.0.stop();
    }
}
