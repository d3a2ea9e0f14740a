//! Who looks at which schema's panel, what each shows, and what people did to them and is not handed in yet. It draws nothing and
//! calls no schema: the runner does, on the schema's own turn.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use jde_core::Nanos;
use jde_panel::{Gesture, List, Touch};

/// Most drawings of a panel in a second: what eyes can use.
pub const MOST_RATE: f64 = 30.0;
/// Fewest: whoever wants less looks now and then.
const LEAST_RATE: f64 = 0.01;
/// Drawing takes at most one part in so many of a schema's time.
pub(crate) const SHARE: u32 = 20;
/// What is shown in place of a panel that nobody can draw.
const GONE: &str = "it is not there: it failed or was unloaded";
/// Most gestures that await a schema: some seconds of somebody who clicks as fast as people can.
const MOST_GESTURES: usize = 64;

/// What a panel showed at one instant.
#[derive(Clone, Debug, PartialEq)]
pub struct Drawn {
    /// Counts the drawings of this panel from 1.
    pub sequence: u64,
    /// When it was drawn, ns since the application's start.
    pub time: Nanos,
    /// How long that took, of the machine's time.
    pub took: Duration,
    /// How many drawings of it went wrong so far.
    pub failed: u64,
    /// What it shows, or why there is nothing to show.
    pub list: Result<List, String>,
}

/// Why nobody can look at a panel, or touch it.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Refusal {
    /// No such schema.
    #[error("there is no schema number {0}; the application has {1}")]
    Nobody(usize, usize),
    /// It has no panel.
    #[error("`{0}` has no panel of its own")]
    NoPanel(String),
    /// It takes no gestures.
    #[error("the panel of `{0}` only shows; nothing on it can be touched")]
    Untouchable(String),
    /// Its instance is gone.
    #[error("`{0}` is not there: it failed or was unloaded, and nobody has woken it since")]
    Gone(String),
    /// It has not taken up what was done before.
    #[error("`{0}` has {MOST_GESTURES} gestures to take up yet; try again")]
    Busy(String),
    /// A gesture that cannot be.
    #[error("the gesture is wrong: {0}")]
    Wrong(jde_panel::Broken),
    /// The turns of then are taken again.
    #[error("a replay of decisions takes the turns of then again; nobody can look or act")]
    Past,
}

/// Somebody who looks at a panel; dropping it ends that.
pub struct Look {
    panels: Arc<Panels>,
    schema: usize,
    id: u64,
}

/// Is called after a panel was drawn, on the thread of its schema: it must return at once.
pub(crate) type News = Arc<dyn Fn() + Send + Sync>;

/// All panels of an application.
pub(crate) struct Panels {
    easels: Vec<Easel>,
    /// Panels that somebody looks at.
    looked_at: AtomicUsize,
    /// Gestures handed in so far.
    handed: AtomicU64,
}

/// The panel of one schema.
#[derive(Default)]
struct Easel {
    exists: AtomicBool,
    touchable: AtomicBool,
    /// How long from one drawing to the next, ns; 0 while nobody looks.
    every: AtomicU64,
    lookers: Mutex<Lookers>,
    shown: Mutex<Shown>,
    hands: Mutex<Hands>,
}

/// Who takes gestures up, and those that await it.
#[derive(Default)]
struct Hands {
    there: bool,
    gestures: VecDeque<(String, Gesture)>,
}

/// What became of a gesture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Put {
    /// It awaits the schema.
    Kept,
    /// There is no instance to take it up.
    Gone,
    /// Too many await it already.
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
    /// Of so many schemas, none of which has one yet.
    pub(crate) fn new(schemas: usize) -> Self {
        Self {
            easels: (0..schemas).map(|_| Easel::default()).collect(),
            looked_at: AtomicUsize::new(0),
            handed: AtomicU64::new(0),
        }
    }

    /// Whether a schema has a panel, and one that can be touched.
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

    /// A schema has an instance now.
    pub(crate) fn came(&self, schema: usize) {
        lock(&self.easels[schema].hands).there = true;
    }

    /// Its instance is gone; whoever looks is told so. Answers how many gestures it had not taken up: nobody will.
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

    /// Says in place of the panel that there is no instance to draw it.
    pub(crate) fn show_gone(&self, schema: usize, time: Nanos) {
        self.show(schema, time, Duration::ZERO, Err(GONE.to_owned()));
    }

    /// Whether anybody looks at any panel.
    pub(crate) fn is_any_looked_at(&self) -> bool {
        self.looked_at.load(Ordering::Acquire) > 0
    }

    /// Somebody looks, so often a second.
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

    /// How long from one drawing to the next, as whoever wants most wants it; nothing while nobody looks.
    pub(crate) fn wanted(&self, schema: usize) -> Option<Duration> {
        let every = self.easels[schema].every.load(Ordering::Acquire);
        (every > 0).then(|| Duration::from_nanos(every))
    }

    /// Shows what was drawn, and tells those who look.
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

    /// Keeps a gesture until the schema takes it up. The newest place of a drag or slider is all there is to tell of it, as long as
    /// nothing else was done in between: what is pressed then counts with what was set before.
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

    /// The gesture that has awaited a schema longest, and whether there are more.
    pub(crate) fn take(&self, schema: usize) -> Option<((String, Gesture), bool)> {
        let gestures = &mut lock(&self.easels[schema].hands).gestures;
        let first = gestures.pop_front()?;
        Some((first, !gestures.is_empty()))
    }

    /// The number of the next gesture that is handed in, from 1.
    pub(crate) fn next_handed(&self) -> u64 {
        self.handed.fetch_add(1, Ordering::AcqRel) + 1
    }
}

impl Easel {
    /// Draws as often as whoever wants most.
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
            // What nobody saw come is not shown later as if it were live.
            lock(&easel.shown).newest = None;
        }
    }
}

/// When a panel was drawn, and when it may be again.
#[derive(Default)]
pub(crate) struct Pace {
    next: Option<Instant>,
}

impl Pace {
    /// When it may be drawn; nothing: at once.
    pub(crate) fn wait(&self, now: Instant) -> Option<Duration> {
        let next = self.next?;
        next.checked_duration_since(now).filter(|wait| !wait.is_zero())
    }

    /// It was drawn at `start`, which took so long, and is wanted that often: on the grid of its rate, so that schemas whose
    /// periods do not divide it are drawn as often as they can be; and never for more than its share of time.
    pub(crate) fn drew(&mut self, start: Instant, took: Duration, every: Duration) {
        let grid = self.next.map_or(start + every, |due| due + every);
        let soonest = start + (every / 2).max(took * SHARE);
        self.next = Some(grid.max(soonest));
    }
}

fn moves(gesture: &Gesture) -> bool {
    matches!(gesture.touch, Touch::Moved(_) | Touch::Dragged { .. })
}

/// Whether the next of its kind on its widget tells all that it does.
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
        // A turn of 75 ms each: the one at 150 comes late, and the one at 225 is on time again.
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
