//! One page: its WebSocket, from the token to the end. The authority of a page is that of this socket, and ends with it.
//!
//! Reading and writing are apart, so that a page that does not read still stops the robot. What it does not read in time
//! is left out: it gets the newest state, and no older one.

use std::collections::{BTreeMap, BTreeSet};
use std::net::IpAddr;
use std::sync::Arc;
use std::time::{Duration, Instant};

use futures_util::stream::{SplitSink, SplitStream};
use futures_util::{SinkExt as _, StreamExt as _};
use jde_link::TokenBucket;
use jde_link::message::Action;
use parking_lot::Mutex;
use serde_json::json;
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::sync::{Semaphore, mpsc, watch};
use tokio::time::{MissedTickBehavior, interval, sleep, timeout, timeout_at};
use tokio_tungstenite::WebSocketStream;
use tokio_tungstenite::tungstenite::Message;
use tokio_tungstenite::tungstenite::protocol::{Role, WebSocketConfig};

use crate::feeds::Topic;
use crate::http::WRONG_TOKEN;
use crate::order::{self, DriveOrder, Order};
use crate::server::{Admission, MAX_PAGES, Page};
use crate::settings::Right;
use crate::{drive, floor};

/// The longest message of a page, bytes.
const MAX_MESSAGE: usize = 4096;
/// How long a page may take to show its token.
const ENTRY: Duration = Duration::from_secs(5);
/// A page says that it is there every 3 s while it can be seen. One that is silent for this long is taken for gone, although
/// its browser may still answer: it enters again when it is seen again.
const SILENCE: Duration = Duration::from_secs(15);
/// How long a message may take to a browser that does not read.
const UNREAD: Duration = Duration::from_secs(10);
/// How often a page gets something, if there is something.
const BEAT: Duration = Duration::from_millis(100);
/// The most that waits in memory for a browser that does not read, bytes. Its own pings are answered there.
const MAX_UNREAD: usize = 1 << 20;
/// Messages of a page per second, and at once after a pause. One that drives sends 14.
const MESSAGES: (f64, f64) = (50.0, 100.0);
/// Stops beside them, which no other messages keep out.
const STOPS: (f64, f64) = (5.0, 10.0);
/// Messages above that, or without a sense, after which a page is sent away.
const MAX_NONSENSE: u32 = 100;
/// Answers that wait for a page.
const MAX_ANSWERS: usize = 32;
/// Orders of a page that wait for the application, and stops beside them.
const MAX_ORDERS: usize = 2;
/// What a page looks at, at once.
const MAX_TOPICS: usize = 4;
/// Bytes of it per second, and at once: no part is longer.
const LOOKS: (f64, f64) = (400e3, 400e3);
/// Lines of the log in one message.
const MAX_LINES: usize = 50;

type Sink<S> = SplitSink<WebSocketStream<S>, Message>;
type Source<S> = SplitStream<WebSocketStream<S>>;

/// What reading and writing of a page share.
struct Visit {
    page: Arc<Page>,
    number: u64,
    right: Right,
    by: String,
    answers: mpsc::Sender<String>,
    drive: watch::Sender<Option<(DriveOrder, Instant)>>,
    looks: Mutex<Looks>,
    orders: Arc<Semaphore>,
    stops: Arc<Semaphore>,
}

/// A page that has shown a token.
pub(crate) struct Entered<S> {
    socket: (Sink<S>, Source<S>),
    right: Right,
    by: String,
    _admission: Admission,
}

/// Reads the token of a page; `None` if it has none, or if there is no seat.
pub(crate) async fn enter<S>(page: &Page, stream: S, from: IpAddr) -> Option<Entered<S>>
where
    S: AsyncRead + AsyncWrite + Unpin,
{
    let limits = WebSocketConfig::default()
        .max_message_size(Some(MAX_MESSAGE))
        .max_frame_size(Some(MAX_MESSAGE))
        .write_buffer_size(0)
        .max_write_buffer_size(MAX_UNREAD);
    let socket = WebSocketStream::from_raw_socket(stream, Role::Server, Some(limits)).await;
    let (mut sink, mut source) = socket.split();
    // What arrives late is no token, and its page tries again.
    let first = timeout(ENTRY, source.next()).await.ok()??.ok()?;
    let Some((right, by)) = identify(page, &first, from) else {
        sleep(WRONG_TOKEN).await;
        let text = "This address is not valid any more: the robot makes a new one at each start.";
        send_off(&mut sink, text, true).await;
        return None;
    };
    let Some(admission) = page.admit(right) else {
        let text = format!("{MAX_PAGES} pages are open, and no more are served.");
        send_off(&mut sink, &text, false).await;
        return None;
    };
    Some(Entered {
        socket: (sink, source),
        right,
        by,
        _admission: admission,
    })
}

/// What a page looks at.
#[derive(Default)]
struct Looks {
    /// Each with the newest version that was sent.
    topics: BTreeMap<Topic, u64>,
    /// When the last message was sent, until the page says that it has taken it: no answer waits behind more than one.
    sent: Option<Instant>,
    /// When there may be another one: a network that is slow is used half of the time.
    next: Option<Instant>,
}

impl Looks {
    /// The page has taken the last message.
    fn take(&mut self, now: Instant) {
        if let Some(sent) = self.sent.take() {
            self.next = Some(now + now.saturating_duration_since(sent));
        }
    }
}

/// Serves a page until it leaves.
pub(crate) async fn serve<S>(page: Arc<Page>, entered: Entered<S>)
where
    S: AsyncRead + AsyncWrite + Unpin,
{
    let Entered {
        socket: (mut sink, mut source),
        right,
        by,
        _admission,
    } = entered;
    let number = page.next_socket();
    let (answers, waiting) = mpsc::channel(MAX_ANSWERS);
    let (drive, wanted) = watch::channel(None);
    // No other page has this name, also of another process that serves the same application.
    let driver = (number, format!("{by} (page {}-{number})", std::process::id()));
    tokio::spawn(drive::run(Arc::clone(&page), driver, wanted, answers.clone()));
    let welcome = welcome(&page, right, &by);
    let visit = Visit {
        number,
        right,
        by,
        answers,
        drive,
        looks: Mutex::default(),
        orders: Arc::new(Semaphore::new(MAX_ORDERS)),
        stops: Arc::new(Semaphore::new(MAX_ORDERS)),
        page,
    };
    // Whichever ends first ends the visit, and with it what the page holds.
    tokio::select! {
        () = read(&visit, &mut source) => {}
        () = write(&visit, &mut sink, welcome, waiting) => {}
    }
    visit.page.feeds.want(number, right, BTreeSet::new());
    let _ = timeout(BEAT, sink.close()).await;
}

/// Reads the token. Returns the right that it gives, and the name of the person.
fn identify(page: &Page, first: &Message, from: IpAddr) -> Option<(Right, String)> {
    let Ok(Order::Enter { token, name }) = Order::read(first.to_text().ok()?) else {
        return None;
    };
    let right = page.tokens.right(&token)?;
    Some((right, order::operator(&name, &from.to_canonical().to_string())))
}

/// Says why a page is not served. Only a wrong token is of no further use to it.
async fn send_off<S>(sink: &mut Sink<S>, text: &str, is_token: bool)
where
    S: AsyncRead + AsyncWrite + Unpin,
{
    let message = json!({ "t": "refused", "text": text, "is_token": is_token }).to_string();
    // It may be gone already.
    let _ = timeout(ENTRY, async {
        sink.send(Message::text(message)).await?;
        sink.close().await
    })
    .await;
}

fn welcome(page: &Page, right: Right, by: &str) -> String {
    let about = page.model.remote.about();
    let teleoperators = page
        .model
        .teleoperators()
        .map(|schema| json!({ "schema": schema }));
    let may_operate = right == Right::Operate;
    json!({
        "t": "welcome",
        "right": right,
        "by": by,
        "name": about.name,
        "application": about.application,
        "host": about.host,
        "replay": about.executor == "replay",
        "floor": floor::exists(&page.model),
        "panels": page.model.panels(),
        "drive": if may_operate { teleoperators.collect() } else { Vec::new() },
        "looks_only": match (may_operate, page.is_link_read_only) {
            (true, _) => "",
            (false, true) => LINK_LOOKS_ONLY,
            (false, false) => LOOKS_ONLY,
        },
        "share": may_operate.then_some(&page.addresses.read),
    })
    .to_string()
}

async fn read<S>(visit: &Visit, source: &mut Source<S>)
where
    S: AsyncRead + AsyncWrite + Unpin,
{
    let mut limit = TokenBucket::with_burst(MESSAGES.0, MESSAGES.1, Instant::now());
    let mut stops = TokenBucket::with_burst(STOPS.0, STOPS.1, Instant::now());
    let mut nonsense = 0;
    let mut silent_at = tokio::time::Instant::now() + SILENCE;
    while nonsense < MAX_NONSENSE {
        let Ok(Some(Ok(message))) = timeout_at(silent_at, source.next()).await else {
            return;
        };
        // What the browser sends by itself, such as the answer to a ping, is no sign of the page.
        let Message::Text(text) = message else {
            nonsense += u32::from(!limit.try_take(Instant::now()));
            continue;
        };
        silent_at = tokio::time::Instant::now() + SILENCE;
        let order = Order::read(&text);
        let is_stop = visit.right == Right::Operate && matches!(order, Ok(Order::StopAll { .. }));
        // What costs the application nothing is not left out: pictures and the pad depend on it.
        let is_free = matches!(order, Ok(Order::Taken {} | Order::LetGo {} | Order::Alive {}));
        let limit = if is_stop { &mut stops } else { &mut limit };
        if !limit.try_take(Instant::now()) {
            nonsense += 1;
            if let Some(id) = order.as_ref().ok().and_then(Order::id) {
                let text = "too many messages at once";
                visit.say(&json!({ "t": "answer", "id": id, "ok": false, "text": text }));
            }
            if !is_free {
                continue;
            }
        }
        match order {
            Ok(order) => visit.take(order),
            Err(reason) => {
                nonsense += 1;
                visit.say(&json!({ "t": "refused", "text": reason }));
            }
        }
    }
}

/// Sends what there is to send: answers at once, and the rest at a low rate.
async fn write<S>(visit: &Visit, sink: &mut Sink<S>, welcome: String, mut answers: mpsc::Receiver<String>)
where
    S: AsyncRead + AsyncWrite + Unpin,
{
    let mut state = visit.page.state.clone();
    // The present one may be that of the last visitor. The next is made soon, as somebody looks now.
    state.mark_unchanged();
    let mut ticks = interval(BEAT);
    ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
    let (mut line, mut is_ending, mut first) = (0, false, Some(welcome));
    let mut budget = TokenBucket::with_burst(LOOKS.0, LOOKS.1, Instant::now());
    while !is_ending {
        let mut messages: Vec<String> = first.take().into_iter().collect();
        tokio::select! {
            answer = answers.recv() => messages.extend(answer),
            changed = state.changed() => {
                is_ending = changed.is_err();
                messages.extend(visit.tick());
                messages.push(state.borrow_and_update().clone());
                let lines = visit.page.model.present().log.after(line, MAX_LINES);
                if let Some(last) = lines.last() {
                    let missed = lines[0].number - line - 1;
                    line = last.number;
                    messages.push(json!({ "t": "log", "missed": missed, "lines": lines }).to_string());
                }
            }
            _ = ticks.tick() => {
                if visit.drive.borrow().is_some() {
                    messages.extend(visit.tick());
                }
                messages.extend(visit.look(&mut budget));
            }
        }
        for message in messages {
            if !matches!(
                timeout(UNREAD, sink.send(Message::text(message))).await,
                Ok(Ok(()))
            ) {
                return;
            }
        }
    }
}

impl Visit {
    /// Takes a message. Nothing here waits.
    fn take(&self, order: Order) {
        match order {
            Order::Enter { .. } | Order::Alive {} => {}
            Order::Touch { id, schema, gesture } => {
                self.order(id, Action::Touch { schema, gesture }, &self.orders);
            }
            Order::Look { at } => self.look_at(at),
            Order::Taken {} => self.looks.lock().take(Instant::now()),
            Order::StopAll { id } => self.order(id, Action::StopAll, &self.stops),
            Order::ReleaseAll { id } => self.order(id, Action::ReleaseAll, &self.orders),
            Order::Play { id, schema } => self.order(id, Action::Play { schema }, &self.orders),
            Order::Stop { id, schema } => self.order(id, Action::Stop { schema }, &self.orders),
            Order::Release { id, schema } => self.order(id, Action::Release { schema }, &self.orders),
            Order::LetGo {} => self.want(None),
            Order::Drive(order) => {
                if self.right != Right::Operate {
                    self.say(&json!({ "t": "drive", "held": false, "text": LOOKS_ONLY }));
                } else if self.is_fresh(order.tick) {
                    self.want(Some((order, Instant::now())));
                } else {
                    self.want(None);
                    let text = "released: the connection is too slow to drive by";
                    self.say(&json!({ "t": "drive", "held": false, "text": text }));
                }
            }
        }
    }

    /// Whether the page saw a tick lately. An order that was under way for long is not carried out late.
    fn is_fresh(&self, tick: u64) -> bool {
        let age = self.page.tick().checked_sub(tick);
        age.is_some_and(|age| u128::from(age) <= drive::MAX_AGE.as_millis())
    }

    /// Returns the message of the present tick, unless the application itself has been silent: what the page shows is old
    /// then, however quick its connection is.
    fn tick(&self) -> Option<String> {
        let is_new = self.page.model.present().updated.elapsed() <= drive::MAX_AGE;
        is_new.then(|| json!({ "t": "tick", "n": self.page.tick() }).to_string())
    }

    fn want(&self, order: Option<(DriveOrder, Instant)>) {
        self.drive.send_if_modified(|wanted| {
            let is_new = wanted.is_some() || order.is_some();
            *wanted = order;
            is_new
        });
    }

    /// Sends an order of this operator to the application, and its answer to the page.
    fn order(&self, id: u64, action: Action, limit: &Arc<Semaphore>) {
        let answers = self.answers.clone();
        let answer = move |ok: bool, text: &str| {
            // A page that does not read sees the outcome in its next state.
            let _ = answers.try_send(json!({ "t": "answer", "id": id, "ok": ok, "text": text }).to_string());
        };
        if self.right != Right::Operate {
            return answer(false, LOOKS_ONLY);
        }
        let Ok(permit) = Arc::clone(limit).try_acquire_owned() else {
            return answer(false, "the orders before have no answer yet");
        };
        let (page, by) = (Arc::clone(&self.page), self.by.clone());
        tokio::spawn(async move {
            match page.operate(&by, action, None).await {
                Ok(losses) => answer(true, &losses),
                Err(reason) => answer(false, &reason),
            }
            drop(permit);
        });
    }

    fn look_at(&self, topics: Vec<Topic>) {
        let topics: BTreeSet<_> = topics.into_iter().take(MAX_TOPICS).collect();
        let mut looks = self.looks.lock();
        looks.topics = topics.iter().map(|topic| (topic.clone(), 0)).collect();
        drop(looks);
        self.page.feeds.want(self.number, self.right, topics);
    }

    /// Returns the message of what is new of all that the page looks at, as far as its budget of bytes allows.
    fn look(&self, budget: &mut TokenBucket) -> Option<String> {
        let mut looks = self.looks.lock();
        if looks.sent.is_some() || looks.next.is_some_and(|next| Instant::now() < next) {
            return None;
        }
        let mut news = Vec::new();
        for (topic, seen) in &mut looks.topics {
            let newer = self.page.feeds.get(topic).and_then(|feed| feed.after(*seen));
            if let Some((version, parts)) = newer
                && budget.try_take_all(parts.len(), Instant::now())
            {
                *seen = version;
                let topic = serde_json::to_string(topic).unwrap_or_default();
                news.push(format!(r#"{{"topic":{topic},"parts":{parts}}}"#));
            }
        }
        looks.sent = (!news.is_empty()).then(Instant::now);
        looks
            .sent
            .map(|_| format!(r#"{{"t":"looks","news":[{}]}}"#, news.join(",")))
    }

    fn say(&self, message: &serde_json::Value) {
        let _ = self.answers.try_send(message.to_string());
    }
}

/// Why a page may not operate.
const LOOKS_ONLY: &str = "this address only looks: it has no right to operate";
const LINK_LOOKS_ONLY: &str = "the application lets clients from the network only read; to operate, serve the page on the robot itself, or set access = \"operate\" in its [link]";
