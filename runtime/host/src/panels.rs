//! The viewers of each schema's panel, the newest drawing of each panel, and the gestures that wait for
//! delivery. It draws nothing and calls no schema: the runner does both, in the schema's own turn.

use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use jde_core::{Nanos, SchemaId, Table};
use jde_panel::{Gesture, List, MAX_RATE, PanelFrame, Touch};
use parking_lot::Mutex;

/// The least number of drawings per second. A viewer that needs fewer registers for each drawing.
const MIN_PANEL_RATE: f64 = 0.01;
/// The share of a schema's time that drawing may take, as a divisor.
pub(crate) const DRAWING_SHARE: u32 = 20;
/// Shown in place of a panel without an instance to draw it.
const ABSENT_MESSAGE: &str = "there is no instance: it failed or was unloaded";
/// The most gestures that wait for one schema: several seconds of the fastest clicking.
const MAX_GESTURES: usize = 64;

/// Why a panel cannot be shown or touched.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PanelError {
    /// There is no such schema.
    #[error("there is no schema number {}; the application has {count}", schema.0)]
    NoSuchSchema {
        /// The number.
        schema: SchemaId,
        /// How many there are.
        count: usize,
    },
    /// The schema has no panel.
    #[error("`{0}` has no panel of its own")]
    NoPanel(String),
    /// The panel takes no gestures.
    #[error("the panel of `{0}` is read-only; it cannot be touched")]
    ReadOnly(String),
    /// The schema has no instance.
    #[error("`{0}` has no instance: it failed or was unloaded, and has not been woken since")]
    NoInstance(String),
    /// Too many earlier gestures still wait for the schema.
    #[error("`{0}` has {MAX_GESTURES} gestures waiting; try again later")]
    QueueFull(String),
    /// The gesture is invalid.
    #[error("the gesture is invalid: {0}")]
    InvalidGesture(jde_panel::Broken),
    /// The application replays recorded turns.
    #[error("a replay of decisions repeats recorded turns; panels can be neither viewed nor touched")]
    InReplay,
}

/// A registered viewer of a panel. Dropping it ends the registration.
pub struct PanelViewGuard {
    panels: Arc<Panels>,
    schema: SchemaId,
    id: u64,
}

/// Called after a panel was drawn, on the thread of its schema. It must return at once.
pub(crate) type DrawingCallback = Arc<dyn Fn() + Send + Sync>;

/// All panels of an application.
pub(crate) struct Panels {
    panels: Table<SchemaId, PanelState>,
    /// Panels that have viewers.
    viewed_count: AtomicUsize,
    /// Gestures delivered so far.
    delivered_count: AtomicU64,
}

/// The panel of one schema.
#[derive(Default)]
struct PanelState {
    exists: AtomicBool,
    touchable: AtomicBool,
    /// Time from one drawing to the next, ns; 0 without viewers.
    interval: AtomicU64,
    viewers: Mutex<Viewers>,
    drawing: Mutex<DrawingState>,
    gesture_queue: Mutex<GestureQueue>,
}

/// Whether an instance receives gestures, and the gestures that wait for it.
#[derive(Default)]
struct GestureQueue {
    has_instance: bool,
    gestures: VecDeque<(String, Gesture)>,
}

/// The result of [`Panels::push_gesture`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum GestureOutcome {
    /// The gesture waits for the schema.
    Queued,
    /// There is no instance to receive it.
    NoInstance,
    /// Too many gestures wait already.
    Full,
}

#[derive(Default)]
struct Viewers {
    next: u64,
    all: Vec<(u64, Duration, DrawingCallback)>,
}

#[derive(Default)]
struct DrawingState {
    sequence: u64,
    failed: u64,
    newest: Option<Arc<PanelFrame>>,
}

impl Panels {
    /// Returns the state of the panels of these schemas, none of which has a panel yet.
    pub(crate) fn new(schemas: impl Iterator<Item = SchemaId>) -> Self {
        Self {
            panels: schemas.map(|_| PanelState::default()).collect(),
            viewed_count: AtomicUsize::new(0),
            delivered_count: AtomicU64::new(0),
        }
    }

    /// Declares whether a schema has a panel, and if so, whether it takes gestures.
    pub(crate) fn declare(&self, schema: SchemaId, panel: Option<bool>) {
        let panel_state = &self.panels[schema];
        panel_state.exists.store(panel.is_some(), Ordering::Release);
        panel_state
            .touchable
            .store(panel == Some(true), Ordering::Release);
    }

    pub(crate) fn has_panel(&self, schema: SchemaId) -> bool {
        self.panels[schema].exists.load(Ordering::Acquire)
    }

    pub(crate) fn is_touchable(&self, schema: SchemaId) -> bool {
        self.panels[schema].touchable.load(Ordering::Acquire)
    }

    /// Records that a schema has an instance.
    pub(crate) fn add_instance(&self, schema: SchemaId) {
        self.panels[schema].gesture_queue.lock().has_instance = true;
    }

    /// Records that the instance of a schema has ended, and shows this to the viewers. Returns the number of
    /// waiting gestures, which are discarded.
    pub(crate) fn remove_instance(&self, schema: SchemaId, time: Nanos) -> usize {
        let mut queue = self.panels[schema].gesture_queue.lock();
        let had_instance = std::mem::replace(&mut queue.has_instance, false);
        let discarded = std::mem::take(&mut queue.gestures).len();
        drop(queue);
        if had_instance && self.requested_interval(schema).is_some() {
            self.publish_absence(schema, time);
        }
        discarded
    }

    pub(crate) fn has_instance(&self, schema: SchemaId) -> bool {
        self.panels[schema].gesture_queue.lock().has_instance
    }

    /// Shows a message in place of the panel: there is no instance to draw it.
    pub(crate) fn publish_absence(&self, schema: SchemaId, time: Nanos) {
        self.publish(schema, time, Duration::ZERO, Err(ABSENT_MESSAGE.to_owned()));
    }

    /// Whether any panel has a viewer.
    pub(crate) fn has_viewers(&self) -> bool {
        self.viewed_count.load(Ordering::Acquire) > 0
    }

    /// Registers a viewer, with the drawings per second that it requests.
    pub(crate) fn add_viewer(
        self: &Arc<Self>,
        schema: SchemaId,
        rate: f64,
        callback: DrawingCallback,
    ) -> PanelViewGuard {
        let rate = if rate.is_nan() { MIN_PANEL_RATE } else { rate };
        let every = Duration::from_secs_f64(1.0 / rate.clamp(MIN_PANEL_RATE, MAX_RATE));
        let panel_state = &self.panels[schema];
        let mut viewers = panel_state.viewers.lock();
        let id = viewers.next;
        viewers.next += 1;
        viewers.all.push((id, every, callback));
        if viewers.all.len() == 1 {
            self.viewed_count.fetch_add(1, Ordering::AcqRel);
        }
        panel_state.update_interval(&viewers);
        drop(viewers);
        PanelViewGuard {
            panels: Arc::clone(self),
            schema,
            id,
        }
    }

    /// Returns the shortest time between drawings that a viewer requests; `None` without viewers.
    pub(crate) fn requested_interval(&self, schema: SchemaId) -> Option<Duration> {
        let every = self.panels[schema].interval.load(Ordering::Acquire);
        (every > 0).then(|| Duration::from_nanos(every))
    }

    /// Publishes a drawing and notifies the viewers.
    pub(crate) fn publish(&self, schema: SchemaId, time: Nanos, took: Duration, list: Result<List, String>) {
        let panel_state = &self.panels[schema];
        let viewers = panel_state.viewers.lock();
        if viewers.all.is_empty() {
            return;
        }
        let mut drawing = panel_state.drawing.lock();
        drawing.sequence += 1;
        drawing.failed += u64::from(list.is_err());
        drawing.newest = Some(Arc::new(PanelFrame {
            sequence: drawing.sequence,
            time,
            took,
            failed: drawing.failed,
            list,
        }));
        drop(drawing);
        let callbacks: Vec<DrawingCallback> = viewers
            .all
            .iter()
            .map(|(_, _, callback)| Arc::clone(callback))
            .collect();
        drop(viewers);
        callbacks.iter().for_each(|callback| callback());
    }

    pub(crate) fn newest(&self, schema: SchemaId) -> Option<Arc<PanelFrame>> {
        self.panels.get(schema)?.drawing.lock().newest.clone()
    }

    /// Queues a gesture for the schema. A movement of a drag or slider replaces the queued movements of the
    /// same operator on the same widget, as far as no other gesture follows them: a press takes effect with
    /// the values set before it.
    pub(crate) fn push_gesture(&self, schema: SchemaId, by: &str, gesture: Gesture) -> GestureOutcome {
        let mut queue = self.panels[schema].gesture_queue.lock();
        if !queue.has_instance {
            return GestureOutcome::NoInstance;
        }
        let gestures = &mut queue.gestures;
        if is_movement(&gesture) {
            let last = gestures.iter().rposition(|(_, queued)| !is_supersedable(queued));
            let mut kept = last.map_or(0, |last| last + 1);
            gestures.retain(|(operator, queued)| {
                if kept > 0 {
                    kept -= 1;
                    return true;
                }
                operator != by || queued.widget != gesture.widget
            });
        }
        if gestures.len() >= MAX_GESTURES {
            return GestureOutcome::Full;
        }
        gestures.push_back((by.to_owned(), gesture));
        GestureOutcome::Queued
    }

    /// Takes the oldest gesture of a schema's queue. Also returns whether more are queued.
    pub(crate) fn pop_gesture(&self, schema: SchemaId) -> Option<((String, Gesture), bool)> {
        let gestures = &mut self.panels[schema].gesture_queue.lock().gestures;
        let first = gestures.pop_front()?;
        Some((first, !gestures.is_empty()))
    }

    /// Returns the number of the next delivered gesture, from 1.
    pub(crate) fn next_delivery_number(&self) -> u64 {
        self.delivered_count.fetch_add(1, Ordering::AcqRel) + 1
    }
}

impl PanelState {
    /// Sets the drawing interval to the shortest that a viewer requests.
    fn update_interval(&self, viewers: &Viewers) {
        let shortest = viewers
            .all
            .iter()
            .map(|(_, every, _)| every.as_nanos() as u64)
            .min();
        self.interval.store(shortest.unwrap_or(0), Ordering::Release);
    }
}

impl Drop for PanelViewGuard {
    fn drop(&mut self) {
        let panel_state = &self.panels.panels[self.schema];
        let mut viewers = panel_state.viewers.lock();
        viewers.all.retain(|(id, ..)| *id != self.id);
        panel_state.update_interval(&viewers);
        if viewers.all.is_empty() {
            self.panels.viewed_count.fetch_sub(1, Ordering::AcqRel);
            // A later viewer must not see an old drawing as if it were live.
            panel_state.drawing.lock().newest = None;
        }
    }
}

/// The earliest time of the next drawing of a panel.
#[derive(Default)]
pub(crate) struct DrawingPace {
    next: Option<Instant>,
}

impl DrawingPace {
    /// Returns how long to wait before the next drawing; `None` if it may be drawn at once.
    pub(crate) fn wait(&self, now: Instant) -> Option<Duration> {
        let next = self.next?;
        next.checked_duration_since(now).filter(|wait| !wait.is_zero())
    }

    /// Records a drawing that began at `start` and lasted `took`, at the requested interval `every`. The next
    /// drawing is on the grid of that interval, so that the mean rate is kept even if the schema's period
    /// does not divide it. Drawing never takes more than its [`DRAWING_SHARE`] of the time.
    pub(crate) fn record_drawing(&mut self, start: Instant, took: Duration, every: Duration) {
        let grid = self.next.map_or(start + every, |due| due + every);
        let soonest = start + (every / 2).max(took * DRAWING_SHARE);
        self.next = Some(grid.max(soonest));
    }
}

fn is_movement(gesture: &Gesture) -> bool {
    matches!(gesture.touch, Touch::Moved(_) | Touch::Dragged { .. })
}

/// Whether the next gesture of this kind on the same widget supersedes it.
fn is_supersedable(gesture: &Gesture) -> bool {
    gesture.goes_on() || matches!(gesture.touch, Touch::Moved(_))
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: Duration = Duration::from_millis(1);

    #[test]
    fn a_panel_is_drawn_on_the_grid_of_its_rate() {
        let (start, every) = (Instant::now(), 100 * MS);
        let mut pace = DrawingPace::default();
        assert_eq!(pace.wait(start), None, "the first drawing is not delayed");
        pace.record_drawing(start, MS, every);
        assert_eq!(pace.wait(start + 30 * MS), Some(70 * MS));
        // The period is 75 ms: the drawing due at 100 occurs late, at 150, and the one at 225 is on time
        // again.
        assert_eq!(pace.wait(start + 150 * MS), None);
        pace.record_drawing(start + 150 * MS, MS, every);
        assert_eq!(pace.wait(start + 225 * MS), None);
        pace.record_drawing(start + 225 * MS, MS, every);
        assert_eq!(pace.wait(start + 225 * MS), Some(75 * MS));
    }

    #[test]
    fn a_late_drawing_is_not_followed_by_another_at_once() {
        let (start, every) = (Instant::now(), 100 * MS);
        let mut pace = DrawingPace::default();
        pace.record_drawing(start, MS, every);
        let late = start + 1000 * MS;
        pace.record_drawing(late, MS, every);
        assert_eq!(pace.wait(late), Some(50 * MS));
    }

    #[test]
    fn drawing_takes_at_most_a_twentieth_of_the_time() {
        let (start, every) = (Instant::now(), 100 * MS);
        let mut pace = DrawingPace::default();
        pace.record_drawing(start, 50 * MS, every);
        assert_eq!(pace.wait(start), Some(1000 * MS));
    }
}
