//! The viewers of each schema's panel, the newest drawing of each panel, and the gestures that wait for
//! delivery. It draws nothing and calls no schema: the runner does both, in the schema's own turn.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use jde_core::Nanos;
use jde_panel::{Gesture, List, Touch};

/// The most drawings of a panel per second: more is not visible.
pub const MOST_RATE: f64 = 30.0;
/// The fewest drawings per second; a viewer that needs fewer registers for each.
const LEAST_RATE: f64 = 0.01;
/// Drawing takes at most one part in this many of a schema's time.
pub(crate) const SHARE: u32 = 20;
/// Shown in place of a panel without an instance to draw it.
const GONE: &str = "it is not there: it failed or was unloaded";
/// The most gestures that wait for one schema: several seconds of the fastest clicking.
const MOST_GESTURES: usize = 64;

/// What a panel showed at one instant.
#[derive(Clone, Debug, PartialEq)]
pub struct Drawn {
    /// Counts the drawings of this panel from 1.
    pub sequence: u64,
    /// When it was drawn, ns since the application's start.
    pub time: Nanos,
    /// How long the drawing took, in machine time.
    pub took: Duration,
    /// Failed drawings of this panel so far.
    pub failed: u64,
    /// The widgets, or why there is nothing to show.
    pub list: Result<List, String>,
}

/// Why a panel cannot be shown or touched.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Refusal {
    /// There is no such schema.
    #[error("there is no schema number {0}; the application has {1}")]
    Nobody(usize, usize),
    /// The schema has no panel.
    #[error("`{0}` has no panel of its own")]
    NoPanel(String),
    /// The panel takes no gestures.
    #[error("the panel of `{0}` only shows; nothing on it can be touched")]
    Untouchable(String),
    /// The schema has no instance at present.
    #[error("`{0}` is not there: it failed or was unloaded, and nobody has woken it since")]
    Gone(String),
    /// Too many earlier gestures still wait for the schema.
    #[error("`{0}` has {MOST_GESTURES} gestures to take up yet; try again")]
    Busy(String),
    /// The gesture is invalid.
    #[error("the gesture is wrong: {0}")]
    Wrong(jde_panel::Broken),
    /// The application replays recorded turns.
    #[error("a replay of decisions takes the turns of then again; nobody can look or act")]
    Past,
}

/// A registered viewer of a panel. Dropping it ends the registration.
pub struct Look {
    panels: Arc<Panels>,
    schema: usize,
    id: u64,
}

/// Called after a panel was drawn, on the thread of its schema. It must return at once.
pub(crate) type News = Arc<dyn Fn() + Send + Sync>;

/// All panels of an application.
pub(crate) struct Panels {
    easels: Vec<Easel>,
    /// Panels that have viewers.
    looked_at: AtomicUsize,
    /// Gestures delivered so far.
    handed: AtomicU64,
}

/// The panel of one schema.
#[derive(Default)]
struct Easel {
    exists: AtomicBool,
    touchable: AtomicBool,
    /// Time from one drawing to the next, ns; 0 without viewers.
    every: AtomicU64,
    lookers: Mutex<Lookers>,
    shown: Mutex<Shown>,
    hands: Mutex<Hands>,
}

/// Whether an instance receives gestures, and the gestures that wait for it.
#[derive(Default)]
struct Hands {
    there: bool,
    gestures: VecDeque<(String, Gesture)>,
}

/// The result of [`Panels::put`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Put {
    /// The gesture waits for the schema.
    Kept,
    /// There is no instance to receive it.
    Gone,
    /// Too many gestures wait already.
    Full,
}

#[derive(Default)]
struct Lookers {
    next: u64,
    all: Vec<(u64, Duration, News)>,
}

#[derive(Default)]
struct Shown {
    sequence: u64,
    failed: u64,
    newest: Option<Arc<Drawn>>,
}

impl Panels {
    /// Returns the panels of so many schemas, none of which has a panel yet.
    pub(crate) fn new(schemas: usize) -> Self {
        Self {
            easels: (0..schemas).map(|_| Easel::default()).collect(),
            looked_at: AtomicUsize::new(0),
            handed: AtomicU64::new(0),
        }
    }

    /// Declares whether a schema has a panel, and if so, whether it takes gestures.
    pub(crate) fn declare(&self, schema: usize, panel: Option<bool>) {
        let easel = &self.easels[schema];
        easel.exists.store(panel.is_some(), Ordering::Release);
        easel.touchable.store(panel == Some(true), Ordering::Release);
    }

    pub(crate) fn has(&self, schema: usize) -> bool {
        self.easels[schema].exists.load(Ordering::Acquire)
    }

    pub(crate) fn is_touchable(&self, schema: usize) -> bool {
        self.easels[schema].touchable.load(Ordering::Acquire)
    }

    /// Records that a schema has an instance.
    pub(crate) fn came(&self, schema: usize) {
        lock(&self.easels[schema].hands).there = true;
    }

    /// Records that the instance of a schema has ended, and shows this to the viewers. Returns the number of
    /// waiting gestures, which are discarded.
    pub(crate) fn went(&self, schema: usize, time: Nanos) -> usize {
        let mut hands = lock(&self.easels[schema].hands);
        let was_there = std::mem::replace(&mut hands.there, false);
        let left = std::mem::take(&mut hands.gestures).len();
        drop(hands);
        if was_there && self.wanted(schema).is_some() {
            self.show_gone(schema, time);
        }
        left
    }

    pub(crate) fn is_there(&self, schema: usize) -> bool {
        lock(&self.easels[schema].hands).there
    }

    /// Shows a message in place of the panel: there is no instance to draw it.
    pub(crate) fn show_gone(&self, schema: usize, time: Nanos) {
        self.show(schema, time, Duration::ZERO, Err(GONE.to_owned()));
    }

    /// Whether any panel has a viewer.
    pub(crate) fn is_any_looked_at(&self) -> bool {
        self.looked_at.load(Ordering::Acquire) > 0
    }

    /// Registers a viewer, with the drawings per second that it requests.
    pub(crate) fn look(self: &Arc<Self>, schema: usize, rate: f64, news: News) -> Look {
        let rate = if rate.is_nan() { LEAST_RATE } else { rate };
        let every = Duration::from_secs_f64(1.0 / rate.clamp(LEAST_RATE, MOST_RATE));
        let easel = &self.easels[schema];
        let mut lookers = lock(&easel.lookers);
        let id = lookers.next;
        lookers.next += 1;
        lookers.all.push((id, every, news));
        if lookers.all.len() == 1 {
            self.looked_at.fetch_add(1, Ordering::AcqRel);
        }
        easel.settle(&lookers);
        drop(lookers);
        Look {
            panels: Arc::clone(self),
            schema,
            id,
        }
    }

    /// Returns the shortest time between drawings that a viewer requests; `None` without viewers.
    pub(crate) fn wanted(&self, schema: usize) -> Option<Duration> {
        let every = self.easels[schema].every.load(Ordering::Acquire);
        (every > 0).then(|| Duration::from_nanos(every))
    }

    /// Publishes a drawing and notifies the viewers.
    pub(crate) fn show(&self, schema: usize, time: Nanos, took: Duration, list: Result<List, String>) {
        let easel = &self.easels[schema];
        let lookers = lock(&easel.lookers);
        if lookers.all.is_empty() {
            return;
        }
        let mut shown = lock(&easel.shown);
        shown.sequence += 1;
        shown.failed += u64::from(list.is_err());
        shown.newest = Some(Arc::new(Drawn {
            sequence: shown.sequence,
            time,
            took,
            failed: shown.failed,
            list,
        }));
        drop(shown);
        let news: Vec<News> = lookers.all.iter().map(|(_, _, news)| Arc::clone(news)).collect();
        drop(lookers);
        news.iter().for_each(|news| news());
    }

    pub(crate) fn newest(&self, schema: usize) -> Option<Arc<Drawn>> {
        lock(&self.easels.get(schema)?.shown).newest.clone()
    }

    /// Queues a gesture for the schema. A movement of a drag or slider replaces the queued movements of the
    /// same operator on the same widget, as far as no other gesture follows them: a press takes effect with
    /// the values set before it.
    pub(crate) fn put(&self, schema: usize, by: &str, gesture: Gesture) -> Put {
        let mut hands = lock(&self.easels[schema].hands);
        if !hands.there {
            return Put::Gone;
        }
        let gestures = &mut hands.gestures;
        if moves(&gesture) {
            let last = gestures.iter().rposition(|(_, old)| !goes_on(old));
            let mut before = last.map_or(0, |last| last + 1);
            gestures.retain(|(whose, old)| {
                if before > 0 {
                    before -= 1;
                    return true;
                }
                whose != by || old.widget != gesture.widget
            });
        }
        if gestures.len() >= MOST_GESTURES {
            return Put::Full;
        }
        gestures.push_back((by.to_owned(), gesture));
        Put::Kept
    }

    /// Takes the oldest gesture of a schema's queue. Also returns whether more are queued.
    pub(crate) fn take(&self, schema: usize) -> Option<((String, Gesture), bool)> {
        let gestures = &mut lock(&self.easels[schema].hands).gestures;
        let first = gestures.pop_front()?;
        Some((first, !gestures.is_empty()))
    }

    /// Returns the number of the next delivered gesture, from 1.
    pub(crate) fn next_handed(&self) -> u64 {
        self.handed.fetch_add(1, Ordering::AcqRel) + 1
    }
}

impl Easel {
    /// Sets the drawing interval to the shortest that a viewer requests.
    fn settle(&self, lookers: &Lookers) {
        let least = lookers
            .all
            .iter()
            .map(|(_, every, _)| every.as_nanos() as u64)
            .min();
        self.every.store(least.unwrap_or(0), Ordering::Release);
    }
}

impl Drop for Look {
    fn drop(&mut self) {
        let easel = &self.panels.easels[self.schema];
        let mut lookers = lock(&easel.lookers);
        lookers.all.retain(|(id, ..)| *id != self.id);
        easel.settle(&lookers);
        if lookers.all.is_empty() {
            self.panels.looked_at.fetch_sub(1, Ordering::AcqRel);
            // A later viewer must not see an old drawing as if it were live.
            lock(&easel.shown).newest = None;
        }
    }
}

/// When a panel may be drawn again.
#[derive(Default)]
pub(crate) struct Pace {
    next: Option<Instant>,
}

impl Pace {
    /// Returns how long to wait before the next drawing; `None` if it may be drawn at once.
    pub(crate) fn wait(&self, now: Instant) -> Option<Duration> {
        let next = self.next?;
        next.checked_duration_since(now).filter(|wait| !wait.is_zero())
    }

    /// Records a drawing that began at `start` and lasted `took`, at the requested interval `every`. The next
    /// drawing is on the grid of that interval, so that a schema whose period does not divide it is drawn as
    /// often as it can be. Drawing never takes more than its [`SHARE`] of the time.
    pub(crate) fn drew(&mut self, start: Instant, took: Duration, every: Duration) {
        let grid = self.next.map_or(start + every, |due| due + every);
        let soonest = start + (every / 2).max(took * SHARE);
        self.next = Some(grid.max(soonest));
    }
}

fn moves(gesture: &Gesture) -> bool {
    matches!(gesture.touch, Touch::Moved(_) | Touch::Dragged { .. })
}

/// Whether the next gesture of this kind on the same widget supersedes it.
fn goes_on(gesture: &Gesture) -> bool {
    gesture.goes_on() || matches!(gesture.touch, Touch::Moved(_))
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: Duration = Duration::from_millis(1);

    #[test]
    fn a_panel_is_drawn_on_the_grid_of_its_rate() {
        let (start, every) = (Instant::now(), 100 * MS);
        let mut pace = Pace::default();
        assert_eq!(pace.wait(start), None, "at once, the first time");
        pace.drew(start, MS, every);
        assert_eq!(pace.wait(start + 30 * MS), Some(70 * MS));
        // The period is 75 ms: the drawing due at 100 occurs late, at 150, and the one at 225 is on time
        // again.
        assert_eq!(pace.wait(start + 150 * MS), None);
        pace.drew(start + 150 * MS, MS, every);
        assert_eq!(pace.wait(start + 225 * MS), None);
        pace.drew(start + 225 * MS, MS, every);
        assert_eq!(pace.wait(start + 225 * MS), Some(75 * MS));
    }

    #[test]
    fn who_was_held_up_is_not_drawn_twice_in_a_row() {
        let (start, every) = (Instant::now(), 100 * MS);
        let mut pace = Pace::default();
        pace.drew(start, MS, every);
        let late = start + 1000 * MS;
        pace.drew(late, MS, every);
        assert_eq!(pace.wait(late), Some(50 * MS));
    }

    #[test]
    fn a_drawing_has_a_twentieth_of_the_time() {
        let (start, every) = (Instant::now(), 100 * MS);
        let mut pace = Pace::default();
        pace.drew(start, 50 * MS, every);
        assert_eq!(pace.wait(start), Some(1000 * MS));
    }
}
