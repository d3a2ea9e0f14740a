//! The subscriptions to the application, one for each channel that any client wants, whatever the number of clients. A thread
//! of its own begins and ends them, as both wait for the link.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::io;
use std::sync::{Arc, mpsc};
use std::thread;
use std::time::Duration;

use jde_link::{Error, Rate, Remote, Subscription};
use jde_records::{RecordKind, RunRecord};
use parking_lot::Mutex;

use super::channel::{Channel, Encoder, Source};
use super::outbox::{Keep, Message, Outbox};
use crate::log::Log;

/// Earlier decisions, states and events that a client gets, of each kind.
const MAX_EARLIER: usize = 100;
/// How often a panel is drawn for clients.
const PANELS: Rate = Rate::Hz(5);
/// Panels at once, of all clients: the threads of their schemas draw them.
const MAX_PANELS: usize = 16;
/// How long the application is left alone between two changes of what is wanted.
const PAUSE: Duration = Duration::from_millis(100);

/// Begins and ends the subscriptions of clients.
pub(super) struct Feeds {
    orders: mpsc::Sender<Order>,
}

enum Order {
    Join(u32, Arc<Outbox>),
    Leave(u32, Arc<Outbox>),
}

/// A channel that somebody wants.
#[derive(Default)]
struct Feed {
    clients: Vec<Arc<Outbox>>,
    /// What a further client gets at once.
    newest: VecDeque<Arc<Message>>,
}

struct Worker {
    remote: Remote,
    channels: Arc<Vec<Channel>>,
    /// The channel of the events, by which clients learn that a value was taken back.
    events: u32,
    feeds: BTreeMap<u32, (Arc<Mutex<Feed>>, Subscription)>,
}

impl Feeds {
    /// Starts the thread.
    ///
    /// # Errors
    /// The system gives no thread.
    pub(super) fn start(remote: Remote, channels: Arc<Vec<Channel>>) -> io::Result<Self> {
        let (orders, queue) = mpsc::channel();
        let is_events = |channel: &Channel| channel.source == Source::Records(RecordKind::Event);
        let mut worker = Worker {
            remote,
            events: channels.iter().position(is_events).unwrap_or_default() as u32,
            channels,
            feeds: BTreeMap::new(),
        };
        thread::Builder::new()
            .name("foxglove".to_owned())
            .spawn(move || {
                while let Ok(first) = queue.recv() {
                    let orders = std::iter::once(first).chain(queue.try_iter()).collect();
                    last_ones(orders).into_iter().for_each(|order| worker.take(order));
                    thread::sleep(PAUSE);
                }
            })?;
        Ok(Self { orders })
    }

    /// Lets a client have the messages of a channel, beginning with the newest.
    pub(super) fn join(&self, channel: u32, client: &Arc<Outbox>) {
        // The thread ends with this object.
        let _ = self.orders.send(Order::Join(channel, Arc::clone(client)));
    }

    /// Ends that.
    pub(super) fn leave(&self, channel: u32, client: &Arc<Outbox>) {
        let _ = self.orders.send(Order::Leave(channel, Arc::clone(client)));
    }
}

/// Returns the last order of each client for each channel: who subscribes and unsubscribes again and again delays nobody.
fn last_ones(mut orders: Vec<Order>) -> Vec<Order> {
    let mut known = BTreeSet::new();
    orders.reverse();
    orders.retain(|order| {
        let (Order::Join(channel, client) | Order::Leave(channel, client)) = order;
        known.insert((*channel, Arc::as_ptr(client)))
    });
    orders.reverse();
    orders
}

impl Worker {
    fn take(&mut self, order: Order) {
        match order {
            Order::Join(channel, client) => {
                if let Some((feed, _)) = self.feeds.get(&channel) {
                    return feed.lock().join(channel, client);
                }
                if self.is_panel(channel)
                    && self.feeds.keys().filter(|open| self.is_panel(**open)).count() >= MAX_PANELS
                {
                    let text = format!(
                        "{MAX_PANELS} panels are shown at once; close one of any client, and subscribe again"
                    );
                    return client.refuse(channel, &text);
                }
                let feed = Arc::new(Mutex::new(Feed::default()));
                feed.lock().join(channel, Arc::clone(&client));
                match self.open(channel, Arc::clone(&feed)) {
                    Ok(subscription) => _ = self.feeds.insert(channel, (feed, subscription)),
                    Err(error) => client.refuse(channel, &error.to_string()),
                }
            }
            Order::Leave(channel, client) => {
                let Some((feed, _)) = self.feeds.get(&channel) else {
                    return;
                };
                if feed.lock().leave(&client) {
                    self.feeds.remove(&channel);
                }
            }
        }
    }

    fn is_panel(&self, channel: u32) -> bool {
        matches!(self.channels[channel as usize].source, Source::Panel(_))
    }

    fn open(&self, number: u32, feed: Arc<Mutex<Feed>>) -> Result<Subscription, Error> {
        let channel = &self.channels[number as usize];
        let (remote, keep, events) = (&self.remote, channel.keep(), self.events);
        let encoder = Encoder {
            started: remote.about().started_ns,
        };
        match &channel.source {
            Source::Variable(name) => {
                let (variable, mut has_value) = (name.clone(), false);
                remote.watch(name, Rate::Full, move |sample| {
                    match encoder.value(&sample) {
                        Some(message) => feed.lock().deliver(number, message, keep),
                        // As in a recording, an event says that the value was taken back.
                        None if has_value => {
                            let record =
                                RunRecord::retracted(sample.time.saturating_add(sample.age), &variable);
                            feed.lock().retract(events, &encoder.record(&record));
                        }
                        None => {}
                    }
                    has_value = sample.bytes.is_some();
                })
            }
            Source::Records(kind) => remote.events(&[*kind], MAX_EARLIER, move |event| {
                feed.lock().deliver(number, encoder.record(&event.record), keep);
            }),
            Source::Panel(schema) => remote.watch_panel(schema, PANELS, move |sample| {
                feed.lock().deliver(number, encoder.panel(&sample), keep);
            }),
            Source::Lines => {
                let mut log = Log::default();
                remote.events(&RecordKind::ALL, MAX_EARLIER, move |event| {
                    for line in encoder.lines(&mut log, &event.record) {
                        feed.lock().deliver(number, line, keep);
                    }
                })
            }
        }
    }
}

impl Feed {
    fn join(&mut self, channel: u32, client: Arc<Outbox>) {
        for message in &self.newest {
            client.push(channel, message);
        }
        if !self.clients.iter().any(|other| Arc::ptr_eq(other, &client)) {
            self.clients.push(client);
        }
    }

    /// Returns whether nobody is left.
    fn leave(&mut self, client: &Arc<Outbox>) -> bool {
        self.clients.retain(|other| !Arc::ptr_eq(other, client));
        self.clients.is_empty()
    }

    fn deliver(&mut self, channel: u32, message: Arc<Message>, keep: Keep) {
        for client in &self.clients {
            client.push(channel, &message);
        }
        let most = match keep {
            Keep::Newest => 1,
            Keep::Records => MAX_EARLIER,
        };
        if self.newest.len() == most {
            self.newest.pop_front();
        }
        self.newest.push_back(message);
    }

    /// Says that the value was taken back, to those who get the events, too.
    fn retract(&mut self, events: u32, message: &Arc<Message>) {
        self.newest.clear();
        for client in &self.clients {
            client.push(events, message);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_many_orders_of_a_client_the_last_one_counts() {
        let [one, other] = [Arc::new(Outbox::default()), Arc::new(Outbox::default())];
        let mut orders = Vec::new();
        for _ in 0..1000 {
            orders.push(Order::Join(3, Arc::clone(&one)));
            orders.push(Order::Leave(3, Arc::clone(&one)));
        }
        orders.push(Order::Join(3, Arc::clone(&other)));
        orders.push(Order::Join(4, Arc::clone(&one)));
        let left = last_ones(orders);
        assert!(matches!(
            &left[..],
            [Order::Leave(3, _), Order::Join(3, _), Order::Join(4, _)]
        ));
    }

    #[test]
    fn a_client_that_joins_again_is_served_once() {
        let client = Arc::new(Outbox::default());
        let mut feed = Feed::default();
        feed.join(3, Arc::clone(&client));
        feed.join(3, Arc::clone(&client));
        assert!(feed.leave(&client), "nobody is left");
    }
}
