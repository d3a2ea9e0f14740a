//! The subscriptions to the application, one for each channel that any client wants, whatever the number of clients. A thread
//! of its own begins and ends them, as both wait for the link.

use std::collections::{BTreeMap, VecDeque};
use std::io;
use std::sync::{Arc, mpsc};
use std::thread;

use jde_link::{Error, Rate, Remote, Subscription};
use jde_records::{RecordKind, RunRecord};
use parking_lot::Mutex;

use super::channel::{Channel, Encoder, Source};
use super::outbox::{Keep, Level, Message, Outbox};
use crate::log::Log;

/// Earlier decisions, states and events that a client gets, of each kind.
const MAX_EARLIER: usize = 100;
/// How often a panel is drawn for clients.
const PANELS: Rate = Rate::Hz(5);

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
            .spawn(move || queue.iter().for_each(|order| worker.take(order)))?;
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

impl Worker {
    fn take(&mut self, order: Order) {
        match order {
            Order::Join(channel, client) => {
                if let Some((feed, _)) = self.feeds.get(&channel) {
                    return feed.lock().join(channel, client);
                }
                let feed = Arc::new(Mutex::new(Feed::default()));
                feed.lock().join(channel, Arc::clone(&client));
                match self.open(channel, Arc::clone(&feed)) {
                    Ok(subscription) => _ = self.feeds.insert(channel, (feed, subscription)),
                    Err(error) => client.status(Level::Error, &error.to_string(), None),
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
        self.clients.push(client);
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
