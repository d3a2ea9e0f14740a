//! An application as seen by tools. Callable from any thread; a clone refers to the same application.

use std::sync::Arc;
use std::time::{Duration, Instant};

use jde_abi::describe::Type;
use jde_panel::Gesture;
use jde_records::RecordKind;
use jde_records::reload::ReloadReport;
use jde_records::snapshot::Snapshot;
use parking_lot::Mutex;
use zenoh::Wait;
use zenoh::pubsub::Subscriber;
use zenoh::sample::SampleKind;

use super::connection::{Connection, QueryOutcome, Reply};
use super::liveliness::Liveliness;
use super::sample::ValueMemory;
use super::subscription::{Subscription, Tokens};
use super::{Hold, PanelSample, REPLY_TIMEOUT, ReceivedEvent, Sample, events, keys};
use crate::decode::{self, Refused};
use crate::folder::new_id;
use crate::keys::{self as key, Keys, Rate};
use crate::message::{About, Action, Network, OperateReply, Request, Schemas, VariableInfo};
use crate::server::no_panel;
use crate::{Error, client::complaint::Complaint};

/// How long an application may take to appear on a new connection.
const APPEAR_TIMEOUT: Duration = Duration::from_secs(3);
/// How often a query that the application had no room for is repeated, and the pause in between.
const QUERY_TRIES: usize = 5;
/// Longest reload: the application reads and loads a library of any size, and every schema finishes its
/// iteration.
const RELOAD_TIMEOUT: Duration = Duration::from_secs(30);
const QUERY_PAUSE: Duration = Duration::from_millis(50);

/// An application on this machine or on the network.
#[derive(Clone)]
pub struct Remote {
    inner: Arc<RemoteInner>,
}

struct RemoteInner {
    about: About,
    keys: Keys,
    liveliness: Arc<Liveliness>,
    tokens: Tokens,
    variables: Mutex<Option<Arc<Vec<VariableInfo>>>>,
    _subscriber: Subscriber<()>,
    // Dropped last.
    connection: Arc<Connection>,
}

impl Remote {
    pub(crate) fn new(connection: Arc<Connection>, about: About) -> Result<Self, Error> {
        let keys = keys(&about);
        let liveliness = Arc::new(Liveliness::default());
        let state = Arc::clone(&liveliness);
        let subscriber = connection
            .session()
            .liveliness()
            .declare_subscriber(keys.of(key::ALIVE))
            .history(true)
            .callback(move |token| state.set(token.kind() == SampleKind::Put))
            .wait()
            .map_err(|error| Error::Open(error.to_string()))?;
        if !liveliness.wait(true, APPEAR_TIMEOUT) {
            return Err(Error::Timeout {
                application: about.name,
                waited: APPEAR_TIMEOUT,
            });
        }
        let inner = RemoteInner {
            keys,
            liveliness,
            tokens: Tokens::new(new_id()?),
            variables: Mutex::new(None),
            connection,
            about,
            _subscriber: subscriber,
        };
        Ok(Self {
            inner: Arc::new(inner),
        })
    }

    /// The application's description.
    #[must_use]
    pub fn about(&self) -> &About {
        &self.inner.about
    }

    /// Whether the application lets this client operate: on its own machine always, across a network as it states.
    #[must_use]
    pub fn may_operate(&self) -> bool {
        self.is_local() || self.inner.about.network == Network::Operate
    }

    /// Whether the application was found on this machine, and not across a network.
    #[must_use]
    pub fn is_local(&self) -> bool {
        self.inner.connection.is_private()
    }

    /// Whether the application is reachable.
    #[must_use]
    pub fn is_alive(&self) -> bool {
        self.inner.liveliness.is_alive()
    }

    /// Waits until the application is gone, at most for `timeout`. Returns whether it is.
    #[must_use]
    pub fn wait_gone(&self, timeout: Duration) -> bool {
        self.inner.liveliness.wait(false, timeout)
    }

    /// Calls `call` once when the application is gone; at once if it already is.
    pub fn on_gone(&self, call: impl FnOnce() + Send + 'static) {
        self.inner.liveliness.on_gone(Box::new(call));
    }

    /// The application's schemas and groups.
    ///
    /// # Errors
    /// [`Error::Disconnected`], [`Error::Timeout`] after 5 s, [`Error::Garbled`]; likewise for all methods
    /// below.
    pub fn schemas(&self) -> Result<Schemas, Error> {
        self.ask(&self.inner.keys.of(key::SCHEMAS), decode::schemas)
    }

    /// The application's variables, with their status if requested.
    ///
    /// # Errors
    /// As above.
    pub fn variables(&self, with_status: bool) -> Result<Vec<VariableInfo>, Error> {
        let all = self.inner.keys.of(key::VARIABLES);
        if with_status {
            return self.ask(&format!("{all}?status"), decode::variables);
        }
        Ok(self.known_variables()?.to_vec())
    }

    /// A variable by its full name.
    ///
    /// # Errors
    /// [`Error::Refused`] with the most similar name; and as above.
    pub fn variable(&self, name: &str) -> Result<VariableInfo, Error> {
        let variables = self.known_variables()?;
        let found = variables.iter().find(|variable| variable.name == name);
        found.cloned().ok_or_else(|| {
            let names = variables.iter().map(|variable| variable.name.as_str());
            Error::Refused {
                text: format!("`{}` has no variable `{name}`", self.inner.about.name),
                nearest: jde_nearest::nearest(name, names).map(str::to_owned),
            }
        })
    }

    /// The newest value of a variable.
    ///
    /// # Errors
    /// As [`Self::variable`].
    pub fn get(&self, name: &str) -> Result<Sample, Error> {
        let (variable, value_type) = self.typed(name)?;
        let key = self.inner.keys.variable(&variable.owner, &variable.variable);
        let reply = self.query(&key, None)?;
        let (pieces, memory) = (&[&*reply.message], &mut ValueMemory::default());
        Sample::read(&value_type, pieces, reply.attachment.as_deref(), memory)
            .map_err(|reason| self.garbled(reason))
    }

    /// Calls `call` with the newest value at once and with each further value, on a thread of the link. While
    /// `call` runs, values may be skipped.
    ///
    /// # Errors
    /// As [`Self::variable`].
    pub fn watch(
        &self,
        name: &str,
        rate: Rate,
        call: impl FnMut(Sample) + Send + Sync + 'static,
    ) -> Result<Subscription, Error> {
        let (variable, value_type) = self.typed(name)?;
        self.watch_as(&variable, value_type, rate, call)
    }

    /// As [`Self::watch`], with values decoded by a type that is known to be the same.
    pub(crate) fn watch_as(
        &self,
        variable: &VariableInfo,
        value_type: Arc<Type>,
        rate: Rate,
        mut call: impl FnMut(Sample) + Send + Sync + 'static,
    ) -> Result<Subscription, Error> {
        let (owner, own, rate) = (&variable.owner, &variable.variable, rate.to_supported());
        let session = self.inner.connection.session();
        let complaint = Complaint::about(&self.inner.about.name);
        let (mut last, mut memory) = (None, ValueMemory::default());
        let deliver = move |sample: zenoh::sample::Sample| {
            let attachment = sample.attachment().map(|attachment| attachment.to_bytes());
            let pieces: Vec<_> = sample.payload().slices().collect();
            match Sample::read(&value_type, &pieces, attachment.as_deref(), &mut memory) {
                Ok(sample) => {
                    // The newest value is sent again when another client joins.
                    let current = (sample.sequence, sample.bytes.is_some());
                    if last.replace(current) != Some(current) {
                        call(sample);
                    }
                }
                Err(reason) => complaint.say(Refused::Unreadable(reason)),
            }
        };
        let subscriber = session
            .declare_subscriber(self.inner.keys.values(owner, own, rate))
            .callback_mut(deliver)
            .wait()
            .map_err(failed)?;
        let keys = &self.inner.keys;
        let token = self
            .inner
            .tokens
            .declare(session, |client| keys.value_token(owner, own, rate, client))?;
        Ok(Subscription::new(vec![subscriber], Some(token), self))
    }

    /// Calls `call` with the panel of a schema each time it is drawn, at most at this rate, on a thread of
    /// the link. A panel is drawn only while clients watch it, at most 30 times a second. A client that joins
    /// later receives the newest drawing at once.
    ///
    /// # Errors
    /// [`Error::Refused`] if the schema has no panel; and as above.
    pub fn watch_panel(
        &self,
        schema: &str,
        rate: Rate,
        mut call: impl FnMut(PanelSample) + Send + Sync + 'static,
    ) -> Result<Subscription, Error> {
        self.check_panel(schema)?;
        let rate = rate.to_supported();
        let complaint = Complaint::about(&self.inner.about.name);
        let mut last = None;
        let deliver = move |sample: zenoh::sample::Sample| {
            let attachment = sample.attachment().map(|attachment| attachment.to_bytes());
            match PanelSample::read(&sample.payload().to_bytes(), attachment.as_deref()) {
                // The newest drawing is sent again when another client joins.
                Ok(panel) if last.replace(panel.sequence) == Some(panel.sequence) => {}
                Ok(panel) => call(panel),
                Err(reason) => complaint.say(Refused::Unreadable(reason)),
            }
        };
        let (keys, session) = (&self.inner.keys, self.inner.connection.session());
        let subscriber = session
            .declare_subscriber(keys.panel(schema, rate))
            .callback_mut(deliver)
            .wait()
            .map_err(failed)?;
        let token = self
            .inner
            .tokens
            .declare(session, |client| keys.panel_token(schema, rate, client))?;
        Ok(Subscription::new(vec![subscriber], Some(token), self))
    }

    /// Performs a gesture on a widget of a schema's panel as the operator `by`, such as `ana@laptop`. The
    /// schema receives it between two iterations.
    ///
    /// # Errors
    /// [`Error::Refused`] with the reason; and as above.
    pub fn touch(&self, by: &str, schema: &str, gesture: Gesture) -> Result<(), Error> {
        self.operate(&Request {
            by: by.to_owned(),
            action: Action::Touch {
                schema: schema.to_owned(),
                gesture,
            },
            lease_ms: None,
        })
    }

    /// The state of every schema and group, at most 50 ms old.
    ///
    /// # Errors
    /// As above.
    pub fn hierarchy(&self) -> Result<Snapshot, Error> {
        self.ask(&self.inner.keys.of(key::HIERARCHY), decode::snapshot)
    }

    /// Calls `call` with the state of every schema and group 20 times a second, on a thread of the link.
    ///
    /// # Errors
    /// As above.
    pub fn watch_hierarchy(
        &self,
        mut call: impl FnMut(Snapshot) + Send + Sync + 'static,
    ) -> Result<Subscription, Error> {
        let complaint = Complaint::about(&self.inner.about.name);
        let subscriber = self
            .inner
            .connection
            .session()
            .declare_subscriber(self.inner.keys.of(key::HIERARCHY))
            .callback_mut(
                move |sample| match decode::snapshot(&sample.payload().to_bytes()) {
                    Ok(snapshot) => call(snapshot),
                    Err(refused) => complaint.say(refused),
                },
            )
            .wait()
            .map_err(failed)?;
        Ok(Subscription::new(vec![subscriber], None, self))
    }

    /// Calls `call` with the last `last` events of each kind and then with each new one, in the order of each
    /// kind, on a thread of the link.
    ///
    /// # Errors
    /// As above.
    pub fn events(
        &self,
        kinds: &[RecordKind],
        last: usize,
        call: impl FnMut(ReceivedEvent) + Send + 'static,
    ) -> Result<Subscription, Error> {
        let merger = events::EventMerger::new(Box::new(call));
        let mut subscribers = Vec::new();
        for kind in kinds {
            let (merger, kind) = (Arc::clone(&merger), *kind);
            let complaint = Complaint::about(&self.inner.about.name);
            let subscriber = self
                .inner
                .connection
                .session()
                .declare_subscriber(self.inner.keys.of(key::events(kind)))
                .callback(move |sample| {
                    let attachment = sample.attachment().map(|attachment| attachment.to_bytes());
                    let pushed = merger.push(kind, &sample.payload().to_bytes(), attachment.as_deref());
                    if let Err(refused) = pushed {
                        complaint.say(refused);
                    }
                })
                .wait()
                .map_err(failed)?;
            subscribers.push(subscriber);
        }
        let mut past = Vec::new();
        if last > 0 {
            for kind in kinds {
                let key = self.inner.keys.of(key::events(*kind));
                past.extend(self.ask(&format!("{key}?last={last}"), |message| {
                    decode::records(*kind, message)
                })?);
            }
        }
        merger.begin(past);
        Ok(Subscription::new(subscribers, None, self))
    }

    /// Sends an operator's request to the application (R14).
    ///
    /// # Errors
    /// [`Error::Refused`] with the reason; and as above.
    pub fn operate(&self, request: &Request) -> Result<(), Error> {
        self.operate_reporting(request).map(drop)
    }

    /// As [`Self::operate`]. Returns what awake schemas lose by a stop or an unload: "goon loses its laser"; empty if
    /// nothing.
    ///
    /// # Errors
    /// As [`Self::operate`].
    pub fn operate_reporting(&self, request: &Request) -> Result<String, Error> {
        let json = serde_json::to_vec(request).map_err(|error| self.garbled(error.to_string()))?;
        let reply = self.query(&self.inner.keys.of(key::OPERATE), Some(json))?;
        Ok(self.operated(&reply)?.losses)
    }

    fn operated(&self, reply: &Reply) -> Result<OperateReply, Error> {
        decode::operate_reply(&reply.message).map_err(|refused| self.refused(refused))
    }

    /// Replaces a plugin's build by the one that is now in its file, by an [`Action::Reload`].
    ///
    /// # Errors
    /// [`Error::Refused`] with all reasons, if nothing was replaced; and as above.
    pub fn reload(&self, request: &Request) -> Result<ReloadReport, Error> {
        let json = serde_json::to_vec(request).map_err(|error| self.garbled(error.to_string()))?;
        let reply = self.query_within(&self.inner.keys.of(key::OPERATE), Some(json), RELOAD_TIMEOUT)?;
        self.operated(&reply)?
            .reloaded
            .ok_or_else(|| self.garbled("the outcome of the reload is missing"))
    }

    /// As [`Self::operate`], until the returned hold is dropped, this process dies or the network is cut.
    /// Then the operator's hold on the schema ends within `lease`.
    ///
    /// # Errors
    /// As [`Self::operate`].
    pub fn hold(&self, request: &Request, lease: Duration) -> Result<Hold, Error> {
        Hold::begin(self.clone(), request, lease)
    }

    /// Refuses a schema without a panel.
    fn check_panel(&self, schema: &str) -> Result<(), Error> {
        let schemas = self.schemas()?.schemas;
        let names = schemas.iter().map(|schema| schema.name.as_str());
        match schemas.iter().find(|known| known.name == schema) {
            Some(known) if known.panel => Ok(()),
            Some(_) => Err(Error::Refused {
                text: no_panel(schema).error,
                nearest: None,
            }),
            None => Err(Error::Refused {
                text: format!("`{}` has no schema `{schema}`", self.inner.about.name),
                nearest: jde_nearest::nearest(schema, names).map(str::to_owned),
            }),
        }
    }

    fn known_variables(&self) -> Result<Arc<Vec<VariableInfo>>, Error> {
        let mut known = self.inner.variables.lock();
        if let Some(known) = &*known {
            return Ok(Arc::clone(known));
        }
        let variables = self.ask(&self.inner.keys.of(key::VARIABLES), decode::variables)?;
        Ok(Arc::clone(known.insert(Arc::new(variables))))
    }

    /// A variable and its type.
    fn typed(&self, name: &str) -> Result<(VariableInfo, Arc<Type>), Error> {
        let variable = self.variable(name)?;
        let value_type = variable
            .value_type()
            .map_err(|error| self.garbled(format!("the type of `{name}`: {error}")))?;
        Ok((variable, Arc::new(value_type)))
    }

    /// Sends a query, and reads its answer.
    fn ask<T>(&self, selector: &str, read: impl Fn(&[u8]) -> Result<T, Refused>) -> Result<T, Error> {
        read(&self.query(selector, None)?.message).map_err(|refused| self.refused(refused))
    }

    fn query(&self, selector: &str, payload: Option<Vec<u8>>) -> Result<Reply, Error> {
        self.query_within(selector, payload, REPLY_TIMEOUT)
    }

    fn query_within(
        &self,
        selector: &str,
        payload: Option<Vec<u8>>,
        timeout: Duration,
    ) -> Result<Reply, Error> {
        let name = || self.inner.about.name.clone();
        let start = Instant::now();
        for _ in 0..QUERY_TRIES {
            if !self.is_alive() {
                return Err(Error::Disconnected(name()));
            }
            match self
                .inner
                .connection
                .query_one(selector, payload.clone(), timeout)?
            {
                QueryOutcome::Reply(reply) => return Ok(reply),
                QueryOutcome::Refused(refusal) => return Err(refusal.into()),
                QueryOutcome::Unanswered => {
                    if self.wait_gone(QUERY_PAUSE) {
                        return Err(Error::Disconnected(name()));
                    }
                }
                QueryOutcome::TimedOut => break,
            }
        }
        if !self.is_alive() {
            return Err(Error::Disconnected(name()));
        }
        Err(Error::Timeout {
            application: name(),
            waited: start.elapsed(),
        })
    }

    fn refused(&self, refused: Refused) -> Error {
        Error::refused(&self.inner.about.name, refused)
    }

    fn garbled(&self, reason: impl Into<String>) -> Error {
        Error::Garbled {
            application: self.inner.about.name.clone(),
            reason: reason.into(),
        }
    }
}

fn failed(error: zenoh::Error) -> Error {
    Error::Open(error.to_string())
}
