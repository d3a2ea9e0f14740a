//! What waits for one client: answers in their order, the newest parameters, and the messages of each subscription. Nobody who
//! puts something in waits, and what a client does not read in time is left out: of a value, all but the newest; of
//! decisions, states and events, the oldest beyond a bound.

use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;
use std::time::{Duration, Instant};

use parking_lot::Mutex;
use serde_json::{Value, json};
use tokio::sync::Notify;

use super::frame::Opcode;

/// Values of a channel that wait, and their bytes. Beyond, only the newest is kept.
const MAX_VALUES: usize = 32;
/// Decisions, states or events that wait.
const MAX_RECORDS: usize = 1000;
/// Bytes of a channel that wait, beside a single message of any length.
const MAX_CHANNEL: usize = 1 << 20;
/// Bytes of all channels that wait, beside the newest message of each.
const MAX_BYTES: usize = 8 << 20;
/// Answers that wait, and their bytes. A client that reads no answers gets no more.
const MAX_ANSWERS: usize = 1000;
const MAX_ANSWER_BYTES: usize = 8 << 20;
/// Messages up to this length are small. Those of each channel have this many bytes between two large ones.
const SMALL: usize = 32 << 10;
/// How often a client learns what is left out.
const REPORTS: Duration = Duration::from_secs(5);
/// Topics that a report names.
const MAX_NAMED: usize = 8;

/// How severe a status message is, by the protocol.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Level {
    Info = 0,
    Warning = 1,
    Error = 2,
}

/// A message of a channel, which all clients share.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Message {
    /// ns since 1970.
    pub(super) log_time: u64,
    pub(super) data: Vec<u8>,
}

/// What is left out if a client reads too slowly.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Keep {
    /// All but the newest.
    Newest,
    /// The oldest beyond a bound.
    Records,
}

/// Something to send.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Item {
    Frame(Opcode, Arc<[u8]>),
    /// A message for a subscription.
    Message(u32, Arc<Message>),
}

/// What waits for a client.
#[derive(Default)]
pub(super) struct Outbox {
    state: Mutex<State>,
    changed: Notify,
}

#[derive(Default)]
struct State {
    answers: VecDeque<(Opcode, Arc<[u8]>)>,
    answer_bytes: usize,
    parameters: BTreeMap<String, Value>,
    /// By channel.
    queues: BTreeMap<u32, Queue>,
    bytes: usize,
    /// The channel whose large message was sent last.
    last_large: u32,
    left_out: BTreeMap<String, u64>,
    reported: Option<Instant>,
    /// The client gets what waits, and nothing more.
    is_closed: bool,
}

struct Queue {
    subscription: u32,
    topic: String,
    keep: Keep,
    messages: VecDeque<Arc<Message>>,
    bytes: usize,
    is_behind: bool,
}

impl Outbox {
    /// Waits until something is put in.
    pub(super) async fn changed(&self) {
        self.changed.notified().await;
    }

    /// Lets the writer look again.
    pub(super) fn again(&self) {
        self.changed.notify_one();
    }

    /// Puts in a message in JSON.
    pub(super) fn say(&self, message: &Value) {
        self.answer(Opcode::Text, message.to_string().into_bytes());
    }

    /// Puts in a status message for people. A newer one with the same id replaces it.
    pub(super) fn status(&self, level: Level, text: &str, id: Option<&str>) {
        let mut status = json!({ "op": "status", "level": level as u8, "message": text });
        if let Some(id) = id {
            status["id"] = json!(id);
        }
        self.say(&status);
    }

    pub(super) fn answer(&self, opcode: Opcode, bytes: impl Into<Arc<[u8]>>) {
        let bytes = bytes.into();
        let mut state = self.state.lock();
        // One that is larger than all, such as a list of thousands of channels, has the room for itself.
        let is_room = state.answers.is_empty()
            || state.answers.len() < MAX_ANSWERS && state.answer_bytes + bytes.len() <= MAX_ANSWER_BYTES;
        if is_room && !state.is_closed {
            state.answer_bytes += bytes.len();
            state.answers.push_back((opcode, bytes));
            self.changed.notify_one();
        }
    }

    /// Puts in the last frame.
    pub(super) fn close(&self, code: u16) {
        self.answer(Opcode::Close, &code.to_be_bytes()[..]);
        self.state.lock().is_closed = true;
        self.changed.notify_one();
    }

    /// Puts in the newest value of a parameter.
    pub(super) fn parameter(&self, name: &str, value: &Value) {
        self.state
            .lock()
            .parameters
            .insert(name.to_owned(), value.clone());
    }

    /// Takes the parameters that changed.
    pub(super) fn take_parameters(&self) -> Vec<Value> {
        std::mem::take(&mut self.state.lock().parameters)
            .into_values()
            .collect()
    }

    /// Opens the queue of a channel.
    ///
    /// # Errors
    /// The channel or the number of the subscription has one, in words.
    pub(super) fn subscribe(
        &self,
        channel: u32,
        subscription: u32,
        topic: &str,
        keep: Keep,
    ) -> Result<(), String> {
        let mut state = self.state.lock();
        if state.queues.contains_key(&channel) {
            return Err(format!("{topic} has a subscription already"));
        }
        if state
            .queues
            .values()
            .any(|queue| queue.subscription == subscription)
        {
            return Err(format!("the subscription {subscription} exists already"));
        }
        let queue = Queue {
            subscription,
            topic: topic.to_owned(),
            keep,
            messages: VecDeque::new(),
            bytes: 0,
            is_behind: false,
        };
        state.queues.insert(channel, queue);
        Ok(())
    }

    /// Closes the queue of a subscription. Returns its channel.
    pub(super) fn unsubscribe(&self, subscription: u32) -> Option<u32> {
        let mut state = self.state.lock();
        let mut queues = state.queues.iter();
        let channel = *queues.find(|(_, queue)| queue.subscription == subscription)?.0;
        let bytes = state.queues.remove(&channel)?.bytes;
        state.bytes -= bytes;
        Some(channel)
    }

    /// Closes the queue of a channel that cannot be served, and says why.
    pub(super) fn refuse(&self, channel: u32, reason: &str) {
        let mut state = self.state.lock();
        if let Some(queue) = state.queues.remove(&channel) {
            state.bytes -= queue.bytes;
        }
        drop(state);
        self.status(Level::Error, reason, None);
    }

    /// Returns the channels that have subscriptions.
    pub(super) fn channels(&self) -> Vec<u32> {
        self.state.lock().queues.keys().copied().collect()
    }

    /// Puts in a message of a channel, if it has a subscription.
    pub(super) fn push(&self, channel: u32, message: &Arc<Message>) {
        let mut guard = self.state.lock();
        let state = &mut *guard;
        let Some(queue) = state.queues.get_mut(&channel) else {
            return;
        };
        let before = queue.bytes;
        let left_out = queue.push(message, state.bytes);
        state.bytes = state.bytes - before + queue.bytes;
        if left_out > 0 {
            *state.left_out.entry(queue.topic.clone()).or_default() += left_out;
        }
        self.changed.notify_one();
    }

    /// Whether the client has got all that it gets.
    pub(super) fn is_over(&self) -> bool {
        let state = self.state.lock();
        state.is_closed && state.answers.is_empty()
    }

    /// Takes what is to be sent next: answers, the small messages of each channel, and one large one. `None` at the end.
    pub(super) fn take(&self, now: Instant) -> Option<Vec<Item>> {
        let state = &mut *self.state.lock();
        let mut items: Vec<Item> = Vec::new();
        items.extend(
            state
                .answers
                .drain(..)
                .map(|(opcode, bytes)| Item::Frame(opcode, bytes)),
        );
        state.answer_bytes = 0;
        if state.is_closed {
            return (!items.is_empty()).then_some(items);
        }
        items.extend(state.report(now));
        for queue in state.queues.values_mut() {
            state.bytes -= queue.take(SMALL, &mut items);
        }
        let has_large = |(channel, queue): (&u32, &Queue)| (!queue.messages.is_empty()).then_some(*channel);
        let after = state.queues.range(state.last_large + 1..).find_map(has_large);
        let large = after.or_else(|| state.queues.iter().find_map(has_large));
        if let Some((channel, queue)) =
            large.and_then(|channel| Some((channel, state.queues.get_mut(&channel)?)))
        {
            state.last_large = channel;
            state.bytes -= queue.take_first(&mut items);
        }
        Some(items)
    }
}

impl State {
    /// Says what was left out since the last report.
    fn report(&mut self, now: Instant) -> Option<Item> {
        let is_due = self
            .reported
            .is_none_or(|last| now.duration_since(last) >= REPORTS);
        if self.left_out.is_empty() || !is_due {
            return None;
        }
        self.reported = Some(now);
        let left_out = std::mem::take(&mut self.left_out);
        let total: u64 = left_out.values().sum();
        let mut topics: Vec<_> = left_out.iter().collect();
        topics.sort_by_key(|(_, count)| std::cmp::Reverse(**count));
        let named: Vec<_> = topics
            .iter()
            .take(MAX_NAMED)
            .map(|(topic, count)| format!("{count} of {topic}"))
            .collect();
        let more = if topics.len() > MAX_NAMED {
            ", and others"
        } else {
            ""
        };
        let text = format!(
            "{total} messages were left out, because this connection is too slow for them: {}{more}",
            named.join(", ")
        );
        let status =
            json!({ "op": "status", "level": Level::Warning as u8, "message": text, "id": "left-out" });
        Some(Item::Frame(Opcode::Text, status.to_string().into_bytes().into()))
    }
}

impl Queue {
    /// Adds a message. `all` are the bytes of all channels. Returns how many messages are left out by it.
    fn push(&mut self, message: &Arc<Message>, all: usize) -> u64 {
        let mut left_out = 0;
        let length = message.data.len();
        match self.keep {
            Keep::Newest => {
                let is_full = self.messages.len() >= MAX_VALUES
                    || self.bytes + length > MAX_CHANNEL
                    || all + length > MAX_BYTES;
                if self.is_behind || is_full {
                    left_out = self.messages.len() as u64;
                    self.messages.clear();
                    self.bytes = 0;
                    self.is_behind = true;
                }
            }
            Keep::Records => {
                while self.messages.len() >= MAX_RECORDS || self.bytes + length > MAX_CHANNEL {
                    let Some(oldest) = self.messages.pop_front() else {
                        break;
                    };
                    self.bytes -= oldest.data.len();
                    left_out += 1;
                }
            }
        }
        self.messages.push_back(Arc::clone(message));
        self.bytes += length;
        left_out
    }

    /// Takes small messages up to this many bytes. Returns their bytes.
    fn take(&mut self, most: usize, items: &mut Vec<Item>) -> usize {
        let mut taken = 0;
        while self
            .messages
            .front()
            .is_some_and(|first| taken + first.data.len() <= most)
        {
            taken += self.take_first(items);
        }
        taken
    }

    fn take_first(&mut self, items: &mut Vec<Item>) -> usize {
        let Some(first) = self.messages.pop_front() else {
            return 0;
        };
        let length = first.data.len();
        self.bytes -= length;
        self.is_behind = false;
        items.push(Item::Message(self.subscription, first));
        length
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(number: u64, length: usize) -> Arc<Message> {
        Arc::new(Message {
            log_time: number,
            data: vec![0; length],
        })
    }

    /// What is taken: the times of messages, and the texts of the rest.
    fn take(outbox: &Outbox) -> (Vec<(u32, u64)>, String) {
        let (mut messages, mut texts) = (Vec::new(), String::new());
        for item in outbox.take(Instant::now()).unwrap() {
            match item {
                Item::Message(subscription, message) => messages.push((subscription, message.log_time)),
                Item::Frame(_, bytes) => texts += &String::from_utf8_lossy(&bytes),
            }
        }
        (messages, texts)
    }

    #[test]
    fn after_a_gap_a_reader_gets_the_newest_value_and_learns_how_many_it_missed() {
        let outbox = Outbox::default();
        outbox.subscribe(3, 7, "/laser", Keep::Newest).unwrap();
        for number in 0..1000 {
            outbox.push(3, &message(number, 100));
        }
        let (messages, texts) = take(&outbox);
        assert_eq!(messages, [(7, 999)]);
        assert!(
            texts.contains("999 messages were left out") && texts.contains("999 of /laser"),
            "{texts}"
        );
        outbox.push(3, &message(1000, 100));
        outbox.push(3, &message(1001, 100));
        assert_eq!(take(&outbox).0, [(7, 1000), (7, 1001)], "it is no longer behind");
    }

    #[test]
    fn records_are_kept_up_to_a_bound() {
        let outbox = Outbox::default();
        outbox.subscribe(1, 1, "/jde/events", Keep::Records).unwrap();
        for number in 0..MAX_RECORDS as u64 + 5 {
            outbox.push(1, &message(number, 10));
        }
        let (messages, texts) = take(&outbox);
        assert_eq!((messages.len(), messages[0]), (MAX_RECORDS, (1, 5)));
        assert!(texts.contains("5 of /jde/events"), "{texts}");
    }

    #[test]
    fn small_messages_are_between_large_ones() {
        let outbox = Outbox::default();
        for channel in 0..3 {
            outbox.subscribe(channel, channel, "/any", Keep::Newest).unwrap();
        }
        for number in 0..3 {
            outbox.push(0, &message(number, 10 * SMALL));
            outbox.push(1, &message(number, 10));
            outbox.push(2, &message(number, 10 * SMALL));
        }
        assert_eq!(take(&outbox).0, [(1, 0), (1, 1), (1, 2), (2, 0)]);
        outbox.push(1, &message(3, 10));
        assert_eq!(take(&outbox).0, [(1, 3), (0, 0)]);
        assert_eq!(take(&outbox).0, [(2, 1)]);
    }

    #[test]
    fn what_waits_is_bounded_and_a_message_of_any_length_fits() {
        let outbox = Outbox::default();
        for channel in 0..100 {
            outbox.subscribe(channel, channel, "/any", Keep::Newest).unwrap();
            for number in 0..20 {
                outbox.push(channel, &message(number, MAX_CHANNEL / 20));
            }
        }
        let newest = 100 * MAX_CHANNEL / 20;
        assert!(outbox.state.lock().bytes <= MAX_BYTES + newest);
        outbox.push(0, &message(99, 2 * MAX_BYTES));
        assert!(
            outbox.state.lock().queues[&0]
                .messages
                .back()
                .is_some_and(|last| last.log_time == 99)
        );
        for channel in 0..100 {
            assert_eq!(outbox.unsubscribe(channel), Some(channel));
        }
        assert_eq!(outbox.state.lock().bytes, 0);
        for _ in 0..2 * MAX_ANSWERS {
            outbox.status(Level::Error, "no", None);
        }
        assert_eq!(outbox.state.lock().answers.len(), MAX_ANSWERS);
    }

    #[test]
    fn a_subscription_has_one_channel_and_ends_once() {
        let outbox = Outbox::default();
        outbox.subscribe(1, 5, "/a", Keep::Newest).unwrap();
        assert!(outbox.subscribe(1, 6, "/a", Keep::Newest).is_err());
        assert!(outbox.subscribe(2, 5, "/b", Keep::Newest).is_err());
        assert_eq!((outbox.unsubscribe(5), outbox.unsubscribe(5)), (Some(1), None));
        outbox.push(1, &message(1, 1));
        outbox.close(1000);
        assert_eq!(outbox.take(Instant::now()).map(|items| items.len()), Some(1));
        assert_eq!(outbox.take(Instant::now()), None);
    }
}
