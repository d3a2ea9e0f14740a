//! One connection, from the first message to the end. Reading and writing are apart, so that a client that does not read still
//! stops the robot, and a client that floods delays itself alone.

use std::net::IpAddr;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use jde_link::TokenBucket;
use jde_link::message::Action;
use serde_json::{Value, json};
use tokio::io::{AsyncRead, AsyncWrite, AsyncWriteExt as _, BufWriter};
use tokio::sync::{Semaphore, mpsc};
use tokio::time::{MissedTickBehavior, interval, sleep, timeout};

use super::entry::Guest;
use super::frame::{self, Arrival, FrameReader, Opcode};
use super::outbox::{Item, Level, Outbox};
use super::parameters::Parameters;
use super::request::{Call, Request, Subscription};
use super::{server_info, services};
use crate::order;
use crate::server::Page;
use crate::settings::Right;

/// After this time without a frame that arrives or bytes that leave, a client is taken for gone.
const SILENCE: Duration = Duration::from_secs(60);
/// How often a client is asked whether it is there.
const PINGS: Duration = Duration::from_secs(10);
/// How often changed parameters and the time are sent.
const BEAT: Duration = Duration::from_millis(100);
/// What a client may ask for per second, and at once. Faster ones are read more slowly.
const REQUESTS: (f64, f64) = (200.0, 10_000.0);
const PAUSE: Duration = Duration::from_millis(20);
/// How long a request for parameters waits for the first values.
const ARRIVAL: Duration = Duration::from_secs(2);
/// Requests for parameters that wait.
const MAX_REQUESTS: usize = 16;
/// Parameters that one request sets.
const MAX_SET: usize = 256;
/// Calls that wait for the application, and stops beside them.
const MAX_CALLS: usize = 2;
/// How far the time goes back only if a recording is played from an earlier place, ns.
const REWOUND: u64 = 5_000_000_000;
/// Bytes that are written at a time.
const PIECE: usize = 64 << 10;
/// Codes of the end of a WebSocket.
const NORMAL: u16 = 1000;
const GOING_AWAY: u16 = 1001;
const BROKEN: u16 = 1002;
const TRY_LATER: u16 = 1013;

/// The answer to whoever may not operate.
const LOOKS_ONLY: &str = "this address only looks: it has no right to operate";
const WAITING: &str = "the ones before have no answer yet";

/// What reading and writing share.
struct Visit {
    page: Arc<Page>,
    right: Right,
    by: String,
    outbox: Arc<Outbox>,
    /// When the client was last seen to be there, in ms of the page.
    seen: AtomicU64,
    asked: mpsc::Sender<Request>,
    calls: Arc<Semaphore>,
    stops: Arc<Semaphore>,
}

/// Serves a client until it leaves.
pub(crate) async fn serve<S>(page: Arc<Page>, stream: S, from: IpAddr, guest: Guest)
where
    S: AsyncRead + AsyncWrite + Unpin,
{
    let (source, sink) = tokio::io::split(stream);
    let (asked, requests) = mpsc::channel(MAX_REQUESTS);
    let admission = page.admit(guest.right);
    let visit = Visit {
        right: guest.right,
        by: order::operator(&guest.name, &from.to_canonical().to_string()),
        outbox: Arc::default(),
        seen: AtomicU64::new(page.tick()),
        asked,
        calls: Arc::new(Semaphore::new(MAX_CALLS)),
        stops: Arc::new(Semaphore::new(MAX_CALLS)),
        page,
    };
    if admission.is_none() {
        visit.outbox.status(
            Level::Error,
            "too many pages and clients are open, and no more are served",
            None,
        );
        visit.outbox.close(TRY_LATER);
    } else {
        visit.greet();
    }
    let mut parameters = None;
    tokio::select! {
        () = visit.read(FrameReader::new(source)) => {}
        () = visit.write(sink) => {}
        () = visit.answer(requests, &mut parameters) => {}
        () = visit.silence() => {}
    }
    for channel in visit.outbox.channels() {
        visit.page.foxglove.feeds.leave(channel, &visit.outbox);
    }
    if let Some(parameters) = parameters {
        parameters.unwatch(&visit.outbox, &[]);
        // To end subscriptions waits for the link.
        tokio::task::spawn_blocking(move || drop(parameters));
    }
}

impl Visit {
    fn greet(&self) {
        let (hub, about) = (&self.page.foxglove, self.page.model.remote.about());
        self.outbox.say(&server_info(about, self.right));
        self.outbox.say(&hub.advertisement());
        if self.right == Right::Operate {
            self.outbox.say(&services::advertisement());
        }
    }

    fn refuse(&self, text: &str) {
        self.outbox.status(Level::Error, text, None);
    }

    fn is_seen(&self) {
        self.seen.store(self.page.tick(), Ordering::Relaxed);
    }

    /// Waits until the client is silent for too long.
    async fn silence(&self) {
        let limit = SILENCE.as_millis() as u64;
        loop {
            let silent = self.page.tick().saturating_sub(self.seen.load(Ordering::Relaxed));
            if silent >= limit {
                return;
            }
            sleep(Duration::from_millis(limit - silent)).await;
        }
    }

    /// Reads what the client sends, until it is gone.
    async fn read<R: AsyncRead + Unpin>(&self, mut frames: FrameReader<R>) {
        let mut limit = TokenBucket::with_burst(REQUESTS.0, REQUESTS.1, Instant::now());
        loop {
            let arrival = match frames.next().await {
                Ok(arrival) => arrival,
                Err(error) if error.kind() == std::io::ErrorKind::InvalidData => {
                    self.outbox.close(BROKEN);
                    return std::future::pending().await;
                }
                Err(_) => return,
            };
            self.is_seen();
            let cost = match arrival {
                Arrival::Text(text) => match Request::read(&text) {
                    Ok(request) => {
                        let cost = request.cost();
                        self.take(request);
                        cost
                    }
                    Err(reason) => {
                        self.refuse(&reason);
                        1
                    }
                },
                Arrival::Binary(bytes) => {
                    match Call::read(&bytes) {
                        Ok(call) => self.call(call),
                        Err(reason) => self.refuse(&reason),
                    }
                    1
                }
                Arrival::Ping(bytes) => {
                    self.outbox.answer(Opcode::Pong, bytes);
                    1
                }
                Arrival::Pong => 1,
                Arrival::Broken(reason) => {
                    self.refuse(&reason);
                    1
                }
                Arrival::Close => {
                    self.outbox.close(NORMAL);
                    return std::future::pending().await;
                }
            };
            while !limit.try_take_all(cost.min(REQUESTS.1 as usize), Instant::now()) {
                sleep(PAUSE).await;
            }
        }
    }

    /// Takes a request. Nothing here waits.
    fn take(&self, request: Request) {
        match request {
            Request::Subscribe { subscriptions } => {
                for subscription in subscriptions {
                    if let Err(reason) = self.subscribe(&subscription) {
                        self.refuse(&reason);
                    }
                }
            }
            Request::Unsubscribe { subscription_ids } => {
                for id in subscription_ids {
                    match self.outbox.unsubscribe(id) {
                        Some(channel) => self.page.foxglove.feeds.leave(channel, &self.outbox),
                        None => self.refuse(&format!("there is no subscription {id}")),
                    }
                }
            }
            Request::GetParameters { .. }
            | Request::SetParameters { .. }
            | Request::SubscribeParameterUpdates { .. }
            | Request::UnsubscribeParameterUpdates { .. } => {
                if self.asked.try_send(request).is_err() {
                    self.refuse(&format!("the request for parameters is left out: {WAITING}"));
                }
            }
        }
    }

    fn subscribe(&self, wanted: &Subscription) -> Result<(), String> {
        let hub = &self.page.foxglove;
        let channel = hub.channels.get(wanted.channel_id as usize);
        let channel = channel.ok_or_else(|| format!("there is no channel {}", wanted.channel_id))?;
        self.outbox
            .subscribe(wanted.channel_id, wanted.id, &channel.topic, channel.keep())?;
        hub.feeds.join(wanted.channel_id, &self.outbox);
        Ok(())
    }

    /// Sends the action of a call to the application, and its answer to the client.
    fn call(&self, call: Call) {
        let outbox = Arc::clone(&self.outbox);
        let action = match services::action(&call) {
            Ok(action) if self.right == Right::Operate => action,
            Ok(_) => return outbox.say(&services::failure(&call, LOOKS_ONLY)),
            Err(reason) => return outbox.say(&services::failure(&call, &reason)),
        };
        let limit = if action == Action::StopAll {
            &self.stops
        } else {
            &self.calls
        };
        let Ok(permit) = Arc::clone(limit).try_acquire_owned() else {
            return outbox.say(&services::failure(&call, WAITING));
        };
        let (page, by) = (Arc::clone(&self.page), self.by.clone());
        tokio::spawn(async move {
            match page.operate(&by, action, None).await {
                Ok(losses) => outbox.answer(Opcode::Binary, services::response(&call, &losses)),
                Err(reason) => outbox.say(&services::failure(&call, &reason)),
            }
            drop(permit);
        });
    }

    /// Answers requests for parameters in their order.
    async fn answer(&self, mut requests: mpsc::Receiver<Request>, opened: &mut Option<Arc<Parameters>>) {
        while let Some(request) = requests.recv().await {
            let parameters = match opened {
                Some(parameters) => Arc::clone(parameters),
                None => match self.page.foxglove.parameters(&self.page.model).await {
                    Ok(parameters) => Arc::clone(opened.insert(parameters)),
                    Err(reason) => {
                        self.refuse(&reason);
                        continue;
                    }
                },
            };
            // A busy link repeats what it left out; the others are not kept waiting for it.
            let _ = timeout(ARRIVAL, parameters.arrived()).await;
            match request {
                Request::GetParameters { parameter_names, id } => {
                    self.values(&parameters.get(&parameter_names), id);
                }
                Request::SetParameters {
                    parameters: wanted,
                    id,
                } => {
                    let names: Vec<String> = wanted
                        .iter()
                        .map(|wanted| wanted.name.clone())
                        .take(MAX_SET)
                        .collect();
                    if wanted.len() > MAX_SET {
                        self.refuse(&format!(
                            "a request sets at most {MAX_SET} parameters; the others are left out"
                        ));
                    }
                    for wanted in wanted.into_iter().take(MAX_SET) {
                        if let Err(reason) = self.set(&parameters, &wanted.name, wanted.value).await {
                            self.refuse(&format!("{} is not set: {reason}", wanted.name));
                        }
                    }
                    self.values(&parameters.get(&names), id);
                }
                Request::SubscribeParameterUpdates { parameter_names } => {
                    parameters.watch(&self.outbox, parameter_names);
                }
                Request::UnsubscribeParameterUpdates { parameter_names } => {
                    parameters.unwatch(&self.outbox, &parameter_names);
                }
                Request::Subscribe { .. } | Request::Unsubscribe { .. } => {}
            }
        }
    }

    /// Sets a parameter, and asks for the value that is in force then.
    async fn set(&self, parameters: &Arc<Parameters>, name: &str, value: Value) -> Result<(), String> {
        let action = parameters.action(name, value)?;
        if self.right != Right::Operate {
            return Err(LOOKS_ONLY.to_owned());
        }
        let outcome = self.page.operate(&self.by, action, None).await;
        let (page, parameters, name) = (Arc::clone(&self.page), Arc::clone(parameters), name.to_owned());
        let read = tokio::task::spawn_blocking(move || match page.model.remote.get(&name) {
            Ok(sample) => {
                parameters.update(&name, &sample);
                Ok(())
            }
            Err(error) => Err(error.to_string()),
        })
        .await;
        outcome?;
        read.map_err(|error| error.to_string())?
    }

    fn values(&self, parameters: &[Value], id: Option<String>) {
        let mut message = json!({ "op": "parameterValues", "parameters": parameters });
        if let Some(id) = id {
            message["id"] = json!(id);
        }
        self.outbox.say(&message);
    }

    /// Writes what there is, until the application or the client is gone.
    async fn write<W: AsyncWrite + Unpin>(&self, sink: W) {
        let mut sink = BufWriter::with_capacity(PIECE, sink);
        let mut state = self.page.state.clone();
        let (mut ticks, mut pings) = (interval(BEAT), interval(PINGS));
        ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
        pings.set_missed_tick_behavior(MissedTickBehavior::Delay);
        let (mut time, mut is_over) = (0, false);
        loop {
            let mut now = 0;
            tokio::select! {
                () = self.outbox.changed() => {}
                _ = ticks.tick() => {
                    now = self.now();
                    let changed = self.outbox.take_parameters();
                    if !changed.is_empty() {
                        self.values(&changed, None);
                    }
                }
                _ = pings.tick() => self.outbox.answer(Opcode::Ping, &b""[..]),
                changed = state.changed(), if !is_over => if changed.is_err() {
                    is_over = true;
                    self.end();
                }
            }
            // One batch: the time, parameters, pings and the end have their turn beside a client that reads slowly.
            if let Some(items) = self.outbox.take(Instant::now()) {
                if self.send(&mut sink, &items, &mut time, now).await.is_err() {
                    return;
                }
                if !items.is_empty() {
                    self.outbox.again();
                }
            }
            if self.outbox.is_over() {
                // The client may be gone already.
                let _ = sink.shutdown().await;
                return;
            }
        }
    }

    /// Returns the application's time, ns since 1970.
    fn now(&self) -> u64 {
        let started = self.page.model.remote.about().started_ns;
        started.saturating_add(self.page.model.present().snapshot.time)
    }

    /// Says that the application is gone.
    fn end(&self) {
        let channels: Vec<usize> = (0..self.page.foxglove.channels.len()).collect();
        self.outbox
            .say(&json!({ "op": "unadvertise", "channelIds": channels }));
        let ending = self.page.model.present().timeline.ending().cloned();
        let ending = ending.map_or_else(
            || "it is gone".to_owned(),
            |ending| format!("it {}: {}", ending.word(), ending.reason()),
        );
        self.outbox.status(
            Level::Info,
            &format!("this application is not served any more: {ending}"),
            None,
        );
        self.outbox.close(GOING_AWAY);
    }

    /// Writes items. Before them is the time of the newest, or `now` if that is later.
    async fn send<W: AsyncWrite + Unpin>(
        &self,
        sink: &mut BufWriter<W>,
        items: &[Item],
        time: &mut u64,
        now: u64,
    ) -> std::io::Result<()> {
        let times = items.iter().map(|item| match item {
            Item::Message(_, message) => message.log_time,
            Item::Frame(..) => 0,
        });
        let newest = times.max().unwrap_or_default().max(now);
        // A recording is played again from an earlier place.
        if now > 0 && now.saturating_add(REWOUND) < *time {
            *time = 0;
        }
        if newest > *time {
            *time = newest;
            let time = [&[2][..], &newest.to_le_bytes()].concat();
            self.put(sink, Opcode::Binary, &time, &[]).await?;
        }
        for item in items {
            match item {
                Item::Frame(opcode, bytes) => self.put(sink, *opcode, bytes, &[]).await?,
                Item::Message(subscription, message) => {
                    let mut head = vec![1];
                    head.extend(subscription.to_le_bytes());
                    head.extend(message.log_time.to_le_bytes());
                    self.put(sink, Opcode::Binary, &head, &message.data).await?;
                }
            }
        }
        sink.flush().await
    }

    /// Writes a message of two parts.
    async fn put<W: AsyncWrite + Unpin>(
        &self,
        sink: &mut BufWriter<W>,
        opcode: Opcode,
        first: &[u8],
        second: &[u8],
    ) -> std::io::Result<()> {
        sink.write_all(&frame::head(opcode, first.len() + second.len()))
            .await?;
        sink.write_all(first).await?;
        for piece in second.chunks(PIECE) {
            sink.write_all(piece).await?;
            // Less than this fits into the system's buffer for a client that is gone.
            if second.len() > PIECE {
                self.is_seen();
            }
        }
        Ok(())
    }
}
