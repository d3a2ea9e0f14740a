//! Waiting orders, and which one is next. A newer order replaces the ones that it makes obsolete, an order
//! that waited too long is given up, and a stop never waits. It sends nothing itself.

use std::collections::{HashMap, HashSet, VecDeque};
use std::sync::Arc;
use std::time::{Duration, Instant};

use jde_link::message::Action;
use jde_panel::Touch;
use serde_json::Value;

use super::client::OrderOutcome;
use super::orders::PATIENCE;
use crate::stop::StopRequest;

/// An order that waited this long is given up: it may no longer be what the user wants.
const GIVE_UP_AFTER: Duration = Duration::from_secs(3);
/// Minimum interval between two values for one modulation. An application accepts 100 orders a second from
/// all its windows together.
const VALUE_INTERVAL: Duration = Duration::from_millis(50);

/// An order to send.
#[derive(Debug)]
pub(super) enum Order {
    /// An action to send once.
    Act(Action, OrderOutcome),
    /// An action to hold for as long as it is ordered again.
    Hold(Action),
    /// Ends the hold on this schema.
    LetGo(String),
    /// Stops everything.
    StopEverything(Arc<StopRequest>),
}

/// A stop to send.
#[derive(Debug)]
pub(super) enum Stop {
    /// Of a schema.
    Schema(Action, OrderOutcome),
    /// Of everything, to be sent until it is acknowledged.
    Everything(Arc<StopRequest>),
}

impl Stop {
    fn action(&self) -> &Action {
        match self {
            Self::Schema(action, _) => action,
            Self::Everything(_) => &Action::StopAll,
        }
    }
}

/// What to do next.
#[derive(Debug)]
pub(super) enum Next {
    /// Send this order, which was added at this time.
    Send(Order, Instant),
    /// Give up this order: it waited too long.
    Stale(Action, OrderOutcome),
    /// Wait until this time, or until an order is added.
    Wait(Option<Instant>),
}

/// Orders in sequence.
#[derive(Debug, Default)]
pub(super) struct Queue {
    orders: VecDeque<(Order, Instant)>,
    /// Stops of a schema or of everything. Separate, because another thread sends them.
    stops: VecDeque<Stop>,
    /// The stop that is being sent.
    stopping: Option<Action>,
    /// When a modulation was last written, by schema and name.
    written: HashMap<(String, String), Instant>,
}

impl Queue {
    /// Adds an order, and removes those that it makes obsolete.
    pub(super) fn push(&mut self, order: Order, now: Instant) {
        match order {
            Order::StopEverything(request) => self.push_stop(Stop::Everything(request)),
            Order::Act(stop @ Action::Stop { .. }, outcome) => self.push_stop(Stop::Schema(stop, outcome)),
            Order::Act(action, outcome) => {
                self.remove_replaced(&action);
                self.orders.push_back((Order::Act(action, outcome), now));
            }
            Order::Hold(action) => {
                self.remove_waiting_hold(action.schema());
                self.orders.push_back((Order::Hold(action), now));
            }
            Order::LetGo(schema) => {
                self.remove_waiting_hold(&schema);
                self.orders.push_back((Order::LetGo(schema), now));
            }
        }
    }

    /// Adds a stop. It overrides waiting orders that would wake its schema.
    fn push_stop(&mut self, stop: Stop) {
        self.orders
            .retain(|(order, _)| !(wakes(order) && blocks(stop.action(), order)));
        match stop {
            Stop::Everything(_) => self.stops.push_front(stop),
            Stop::Schema(..) => self.stops.push_back(stop),
        }
    }

    /// The next order other than a stop.
    pub(super) fn next(&mut self, now: Instant) -> Next {
        self.written
            .retain(|_, written| now.saturating_duration_since(*written) < VALUE_INTERVAL);
        let (found, earliest) = self.first_free();
        let Some((order, given)) = found.and_then(|place| self.orders.remove(place)) else {
            return Next::Wait(earliest);
        };
        let waited = now.saturating_duration_since(given);
        match order {
            Order::Act(action, outcome) if waited >= GIVE_UP_AFTER => Next::Stale(action, outcome),
            // The hold has ended: it would have been renewed.
            Order::Hold(action) if waited >= PATIENCE => {
                Next::Send(Order::LetGo(action.schema().to_owned()), given)
            }
            order => {
                if let Some(which) = order.modulation() {
                    self.written.insert(which, now);
                }
                Next::Send(order, given)
            }
        }
    }

    /// The next stop. Until [`Self::stopped`] is called, [`Self::next`] holds back the orders that concern
    /// what is stopped.
    pub(super) fn next_stop(&mut self) -> Option<Stop> {
        let stop = self.stops.pop_front()?;
        self.stopping = Some(stop.action().clone());
        Some(stop)
    }

    /// Ends the stop that [`Self::next_stop`] returned.
    pub(super) fn stopped(&mut self) {
        self.stopping = None;
    }

    /// Whether no order waits and no stop is being sent.
    pub(super) fn is_empty(&self) -> bool {
        self.orders.is_empty() && self.stops.is_empty() && self.stopping.is_none()
    }

    /// The position of the first order that can be sent now. If none can, the earliest time at which one can.
    fn first_free(&self) -> (Option<usize>, Option<Instant>) {
        let mut earliest: Option<Instant> = None;
        let stops = || self.stops.iter().map(Stop::action).chain(&self.stopping);
        // A later order for a schema must not overtake an earlier one that waits.
        let mut later = HashSet::new();
        for (place, (order, _)) in self.orders.iter().enumerate() {
            if later.contains(order.schema()) || stops().any(|stop| blocks(stop, order)) {
                continue;
            }
            match order.modulation().and_then(|which| self.written.get(&which)) {
                None => return (Some(place), None),
                Some(written) => {
                    later.insert(order.schema());
                    let end = *written + VALUE_INTERVAL;
                    earliest = Some(earliest.map_or(end, |earliest| earliest.min(end)));
                }
            }
        }
        (None, earliest)
    }

    /// Removes a waiting hold on a schema: a newer hold or release replaces it.
    fn remove_waiting_hold(&mut self, schema: &str) {
        self.orders
            .retain(|(order, _)| !matches!(order, Order::Hold(action) if action.schema() == schema));
    }

    /// Removes the latest waiting order on the same modulation or widget, if an action replaces it.
    fn remove_replaced(&mut self, newer: &Action) {
        let about = |order: &Order| match order {
            Order::Act(older, _) => is_same(older, newer).then(|| replaces(newer, older)),
            Order::Hold(_) | Order::LetGo(_) | Order::StopEverything(_) => None,
        };
        let mut latest = self.orders.iter().enumerate().rev();
        let last = latest.find_map(|(place, (order, _))| Some((place, about(order)?)));
        if let Some((place, true)) = last {
            self.orders.remove(place);
        }
    }
}

impl Order {
    fn schema(&self) -> &str {
        match self {
            Self::Act(action, _) | Self::Hold(action) => action.schema(),
            Self::LetGo(schema) => schema,
            Self::StopEverything(_) => "",
        }
    }

    /// The modulation that the order writes once, as from a slider. Holds have their own interval of renewal.
    fn modulation(&self) -> Option<(String, String)> {
        match self {
            Self::Act(Action::Modulate { schema, variable, .. }, _) => {
                Some((schema.clone(), variable.clone()))
            }
            Self::Act(..) | Self::Hold(_) | Self::LetGo(_) | Self::StopEverything(_) => None,
        }
    }
}

/// Whether an order could wake a schema, or release one that is stopped.
fn wakes(order: &Order) -> bool {
    match order {
        Order::Act(action, _) => matches!(
            action,
            Action::Play { .. }
                | Action::Force { .. }
                | Action::Release { .. }
                | Action::ReleaseAll
                | Action::LetGo { .. }
                | Action::Load { .. }
        ),
        Order::Hold(_) => true,
        Order::LetGo(_) | Order::StopEverything(_) => false,
    }
}

/// Whether an order must wait for a stop, because it concerns what is stopped.
fn blocks(stop: &Action, order: &Order) -> bool {
    match (stop, order) {
        (Action::StopAll, _) | (_, Order::Act(Action::ReleaseAll, _)) => true,
        _ => stop.schema() == order.schema(),
    }
}

/// Whether two actions concern the same modulation or widget.
fn is_same(a: &Action, b: &Action) -> bool {
    match (a, b) {
        (
            Action::Modulate { schema, variable, .. },
            Action::Modulate {
                schema: schema_b,
                variable: which,
                ..
            },
        ) => schema == schema_b && variable == which,
        (
            Action::Touch { schema, gesture },
            Action::Touch {
                schema: schema_b,
                gesture: which,
            },
        ) => schema == schema_b && gesture.widget == which.widget,
        _ => false,
    }
}

/// Whether a newer value of a modulation, slider or drag replaces an older one.
fn replaces(newer: &Action, older: &Action) -> bool {
    match (newer, older) {
        (Action::Modulate { value: newer, .. }, Action::Modulate { value: older, .. }) => {
            covers(newer, older)
        }
        (Action::Touch { gesture: newer, .. }, Action::Touch { gesture: older, .. }) => {
            match (&newer.touch, &older.touch) {
                (Touch::Moved(_), Touch::Moved(_)) => true,
                (
                    Touch::Dragged { from: same, .. },
                    Touch::Dragged {
                        from, ended: false, ..
                    },
                ) => from == same,
                _ => false,
            }
        }
        _ => false,
    }
}

/// Whether a value writes everything that another does: omitted fields keep their values.
fn covers(newer: &Value, older: &Value) -> bool {
    match (newer, older) {
        (Value::Object(newer), Value::Object(older)) => older
            .iter()
            .all(|(name, older)| newer.get(name).is_some_and(|newer| covers(newer, older))),
        (Value::Object(_), _) | (_, Value::Object(_)) => false,
        _ => true,
    }
}

#[cfg(test)]
mod tests {
    use jde_link::{Folders, Reach};
    use jde_panel::Gesture;
    use serde_json::json;

    use super::*;
    use crate::stop::StopTarget;

    fn name(schema: &str) -> String {
        schema.to_owned()
    }

    fn act(action: Action) -> Order {
        Order::Act(action, OrderOutcome::default())
    }

    fn play(schema: &str) -> Order {
        act(Action::Play { schema: name(schema) })
    }

    fn stop(schema: &str) -> Order {
        act(Action::Stop { schema: name(schema) })
    }

    fn modulate(schema: &str, variable: &str, value: Value) -> Action {
        Action::Modulate {
            schema: name(schema),
            variable: name(variable),
            value,
        }
    }

    fn hold(schema: &str, value: f64) -> Order {
        Order::Hold(modulate(schema, "want", value.into()))
    }

    fn description(order: &Order) -> String {
        match order {
            Order::Act(Action::Modulate { schema, value, .. }, _) => format!("set {schema} {value}"),
            Order::Act(Action::Touch { gesture, .. }, _) => format!("touch {:?}", gesture.touch),
            Order::Act(action, _) => format!("act {}", action.schema()),
            Order::Hold(Action::Modulate { schema, value, .. }) => format!("hold {schema} {value}"),
            Order::Hold(action) => format!("hold {}", action.schema()),
            Order::LetGo(schema) => format!("let go {schema}"),
            Order::StopEverything(_) => "stop everything".to_owned(),
        }
    }

    fn queue(orders: impl IntoIterator<Item = Order>, now: Instant) -> Queue {
        let mut queue = Queue::default();
        orders.into_iter().for_each(|order| queue.push(order, now));
        queue
    }

    /// All orders that can be sent now.
    fn sent(queue: &mut Queue, now: Instant) -> Vec<String> {
        let mut sent = Vec::new();
        loop {
            match queue.next(now) {
                Next::Send(order, _) => sent.push(description(&order)),
                Next::Stale(action, _) => sent.push(format!("stale {}", action.schema())),
                Next::Wait(_) => return sent,
            }
        }
    }

    #[test]
    fn of_waiting_holds_the_last_of_each_schema_is_sent() {
        let now = Instant::now();
        let orders = [
            hold("base", 1.0),
            hold("base", 2.0),
            hold("head", 1.0),
            play("goon"),
            hold("base", 3.0),
            hold("head", 2.0),
            Order::LetGo(name("head")),
        ];
        let sent = sent(&mut queue(orders, now), now);
        assert_eq!(sent, ["act goon", "hold base 3.0", "let go head"]);
    }

    #[test]
    fn a_hold_after_a_release_is_sent_too() {
        let now = Instant::now();
        let orders = [hold("base", 1.0), Order::LetGo(name("base")), hold("base", 2.0)];
        let sent = sent(&mut queue(orders, now), now);
        assert_eq!(sent, ["let go base", "hold base 2.0"]);
    }

    #[test]
    fn a_later_value_of_a_modulation_replaces_those_that_it_covers() {
        let now = Instant::now();
        let set = |value: Value| act(modulate("goon", "speed", value));
        let mut both = queue([set(json!(1)), play("stop"), set(json!(2))], now);
        assert_eq!(sent(&mut both, now), ["act stop", "set goon 2"]);
        let partial = [
            set(json!({"x": 1})),
            set(json!({"y": 2})),
            set(json!({"x": 3, "y": 4})),
        ];
        let mut partial = queue(partial, now);
        assert_eq!(partial.orders.len(), 2, "x is not covered by y alone");
        assert_eq!(sent(&mut partial, now), [r#"set goon {"x":1}"#]);
    }

    #[test]
    fn values_of_one_modulation_are_sent_at_intervals_and_no_order_of_its_schema_overtakes_them() {
        let start = Instant::now();
        let set = |value: f64| act(modulate("goon", "speed", value.into()));
        let mut queue = queue([set(1.0)], start);
        assert_eq!(sent(&mut queue, start), ["set goon 1.0"]);
        queue.push(set(2.0), start);
        let release = Action::Release { schema: name("goon") };
        queue.push(act(release), start);
        queue.push(play("vff"), start);
        assert_eq!(sent(&mut queue, start), ["act vff"]);
        assert!(matches!(queue.next(start), Next::Wait(Some(then)) if then == start + VALUE_INTERVAL));
        assert_eq!(
            sent(&mut queue, start + VALUE_INTERVAL),
            ["set goon 2.0", "act goon"]
        );
        assert!(queue.is_empty());
    }

    #[test]
    fn a_stop_does_not_wait_and_removes_orders_that_would_wake_its_schema() {
        let now = Instant::now();
        let mut queue = queue([play("goon"), play("vff"), hold("goon", 1.0), stop("goon")], now);
        let stop = queue.next_stop().expect("a stop is waiting");
        assert_eq!(stop.action().schema(), "goon");
        queue.push(play("goon"), now);
        assert_eq!(sent(&mut queue, now), ["act vff"], "other orders for goon wait");
        queue.stopped();
        assert_eq!(sent(&mut queue, now), ["act goon"]);
    }

    #[test]
    fn stopping_everything_precedes_other_stops_and_blocks_all_other_orders() {
        let now = Instant::now();
        let set = act(modulate("vff", "speed", json!(1)));
        let orders = [
            play("goon"),
            hold("base", 1.0),
            set,
            stop("goon"),
            Order::StopEverything(StopRequest::new(
                StopTarget::All,
                Reach::Local(Folders::at("/nowhere")),
                now,
                Vec::new(),
            )),
        ];
        let mut queue = queue(orders, now);
        assert!(matches!(queue.next_stop(), Some(Stop::Everything(_))));
        queue.push(act(Action::ReleaseAll), now);
        assert_eq!(sent(&mut queue, now), Vec::<String>::new());
        queue.stopped();
        assert_eq!(
            sent(&mut queue, now),
            ["set vff 1"],
            "the stop of goon is still waiting"
        );
        assert!(matches!(queue.next_stop(), Some(Stop::Schema(..))));
        queue.stopped();
        assert_eq!(sent(&mut queue, now), ["act "], "then everything is released");
    }

    #[test]
    fn orders_that_waited_too_long_are_discarded_and_stale_holds_are_released() {
        let start = Instant::now();
        let mut queue = queue([play("goon"), hold("base", 1.0), stop("vff")], start);
        assert_eq!(
            sent(&mut queue, start + GIVE_UP_AFTER),
            ["stale goon", "let go base"]
        );
        assert!(queue.next_stop().is_some(), "a stop is never discarded");
    }

    #[test]
    fn only_the_newest_slider_move_is_sent_unless_a_press_is_between() {
        let now = Instant::now();
        let touch = |touch: Touch| {
            act(Action::Touch {
                schema: name("goon"),
                gesture: Gesture {
                    widget: name("map"),
                    touch,
                },
            })
        };
        let moved = |to: f64| touch(Touch::Moved(to));
        let mut drag = queue([moved(1.0), moved(2.0)], now);
        assert_eq!(sent(&mut drag, now), ["touch Moved(2.0)"]);
        let mut pressed = queue([moved(1.0), touch(Touch::Pressed), moved(2.0)], now);
        assert_eq!(sent(&mut pressed, now).len(), 3);
    }
}
