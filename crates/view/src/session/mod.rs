//! A running application as the windows see it: what came last over the link, and what is asked of it. Nothing here waits for the
//! network: questions and orders are carried out by threads of their own.
//!
//! A window asks each frame for what it shows; what nobody asks for any more is no longer listened to.

mod backlog;
mod client;
mod demand;
mod history;
mod inbox;
mod orders;
mod panels;
mod queue;
mod subscriptions;

use std::cell::RefCell;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use eframe::egui;
use jde_host::snapshot::{HoldKind, SchemaView, Snapshot};
use jde_host::story::Kind;
use jde_link::message::{About, Action, SchemaInfo, Schemas, VariableInfo};
use jde_link::{Error, Rate, Remote, Sample, Watching};
use jde_panel::Gesture;
use jde_types::Value;

pub(crate) use client::{Notice, Outcome};
pub(crate) use history::{History, Progress, StateInterval};
use inbox::Inbox;
use orders::Orders;
pub(crate) use panels::PanelContent;
use panels::Panels;
use subscriptions::Subscriptions;

use crate::window::Kind as Window;

/// The schema by which a recording that plays is steered.
pub(crate) const STEERING: &str = "replay";

/// How many lines of each kind are fetched of what happened before.
const EARLIER: usize = 2000;

/// An application that is looked into. Used by the window's thread alone.
pub(crate) struct Session {
    remote: Remote,
    schemas: Schemas,
    variables: Vec<VariableInfo>,
    inbox: Arc<Mutex<Inbox>>,
    snapshot: Arc<Snapshot>,
    /// When that came.
    progress: Instant,
    past: History,
    subscriptions: RefCell<Subscriptions>,
    panels: RefCell<Panels>,
    orders: Orders,
    openings: RefCell<Vec<Window>>,
    plots: RefCell<Vec<String>>,
    gone: bool,
    _watching: Vec<Watching>,
}

impl Session {
    /// Begins to look. Waits for answers of the application, up to 5 s each: not to be called from the window's thread.
    ///
    /// # Errors
    /// As [`Remote`]'s calls.
    pub(crate) fn open(remote: Remote, repaint: egui::Context) -> Result<Self, Error> {
        let schemas = remote.schemas()?;
        let variables = remote.variables(false)?;
        let snapshot = remote.hierarchy()?;
        let inbox = Arc::new(Mutex::new(Inbox::default()));
        let mut watching = Vec::new();
        watching.push({
            let (inbox, repaint) = (Arc::clone(&inbox), repaint.clone());
            remote.watch_hierarchy(move |snapshot| {
                lock(&inbox).snapshot = Some(snapshot);
                repaint.request_repaint();
            })?
        });
        watching.push({
            let inbox = Arc::clone(&inbox);
            remote.events(&Kind::ALL, EARLIER, move |happened| {
                lock(&inbox).push(happened.line, happened.missed);
            })?
        });
        {
            let repaint = repaint.clone();
            remote.on_gone(move || repaint.request_repaint());
        }
        Ok(Self {
            schemas,
            variables,
            inbox,
            past: History::new(),
            subscriptions: RefCell::new(Subscriptions::new(remote.clone(), repaint.clone())),
            panels: RefCell::new(Panels::new(remote.clone(), repaint.clone())),
            orders: Orders::new(remote.clone(), repaint),
            openings: RefCell::default(),
            plots: RefCell::default(),
            snapshot: Arc::new(snapshot),
            progress: Instant::now(),
            gone: false,
            remote,
            _watching: watching,
        })
    }

    /// Takes up what came since the last frame. To be called once at its beginning.
    pub(crate) fn begin_frame(&mut self) {
        let Inbox {
            snapshot,
            lines,
            dropped,
        } = std::mem::take(&mut *lock(&self.inbox));
        self.past.add_missed(dropped);
        for (line, missed) in lines {
            self.past.add_line(line, missed);
        }
        if let Some(snapshot) = snapshot {
            self.past.add_snapshot(&snapshot);
            self.snapshot = Arc::new(snapshot);
            self.progress = Instant::now();
        }
        self.gone = !self.remote.alive();
        self.subscriptions.get_mut().remove_unused();
        self.panels.get_mut().remove_unused();
    }

    /// What it is.
    pub(crate) fn about(&self) -> &About {
        self.remote.about()
    }

    /// Whether it is there no more; everything shown is then as it was last.
    pub(crate) fn is_gone(&self) -> bool {
        self.gone
    }

    /// For how long nothing was heard of it: an application tells twenty times a second how it is, so one that is silent for
    /// longer hangs, or the network to it is cut.
    pub(crate) fn silent(&self) -> Duration {
        self.progress.elapsed()
    }

    /// Whether it is a recording that plays.
    pub(crate) fn is_recording(&self) -> bool {
        self.about().executor == "replay"
    }

    /// Whether a modulation of a schema can be set: of a recording those that steer it.
    pub(crate) fn can_set(&self, schema: &str) -> bool {
        !self.gone && (!self.is_recording() || schema == STEERING)
    }

    /// Its schemas and groups, as declared.
    pub(crate) fn schemas(&self) -> &Schemas {
        &self.schemas
    }

    /// A schema by its name, as declared.
    pub(crate) fn schema(&self, name: &str) -> Option<&SchemaInfo> {
        self.schemas.schemas.iter().find(|schema| schema.name == name)
    }

    /// Its variables.
    pub(crate) fn variables(&self) -> &[VariableInfo] {
        &self.variables
    }

    /// The exports of a standard type, in the application's order.
    pub(crate) fn exports<T: Value>(&self) -> impl Iterator<Item = &VariableInfo> {
        let name = T::describe().name;
        let fits = move |variable: &&VariableInfo| variable.access == "export" && variable.type_name == name;
        self.variables.iter().filter(fits)
    }

    /// What every schema and group is doing.
    pub(crate) fn snapshot(&self) -> &Arc<Snapshot> {
        &self.snapshot
    }

    /// What a schema is doing.
    pub(crate) fn view(&self, schema: &str) -> Option<&SchemaView> {
        self.snapshot.schemas.iter().find(|view| view.name == schema)
    }

    /// What has happened as far as it is kept.
    pub(crate) fn past(&self) -> &History {
        &self.past
    }

    /// The schemas that have a panel of their own.
    pub(crate) fn panels(&self) -> impl Iterator<Item = &str> {
        let schemas = self.snapshot.schemas.iter();
        schemas
            .filter(|schema| schema.panel)
            .map(|schema| schema.name.as_str())
    }

    /// The schemas at the top.
    pub(crate) fn roots(&self) -> impl Iterator<Item = &str> {
        let tops = self.schemas.groups.iter().filter(|group| group.father.is_none());
        tops.flat_map(|group| group.members.iter().map(String::as_str))
    }

    /// Whether an operator keeps a schema asleep.
    pub(crate) fn is_stopped(&self, schema: &str) -> bool {
        let hold = self.view(schema).and_then(|view| view.operator.as_ref());
        hold.is_some_and(|hold| matches!(hold.kind, HoldKind::Stopped | HoldKind::Unloaded))
    }

    /// Whether everything was stopped at once, and a root is not let go on since.
    pub(crate) fn is_everything_stopped(&self) -> bool {
        let mut holds = self.roots().filter_map(|root| self.view(root)?.operator.as_ref());
        holds.any(|hold| hold.with_everything)
    }

    /// s since the application's start, as of the newest snapshot.
    pub(crate) fn now(&self) -> f64 {
        self.snapshot.time as f64 / 1e9
    }

    /// The newest value of a variable. Asked for in every frame in which it is shown: the first times there is none yet, and
    /// what is no longer asked for is no longer sent.
    pub(crate) fn value(&self, name: &str, rate: Rate) -> Option<Arc<Sample>> {
        self.subscriptions.borrow_mut().newest(name, rate)
    }

    /// As [`Self::value`], as a standard type; none if it is of another.
    pub(crate) fn read<T: Value>(&self, name: &str, rate: Rate) -> Option<(T, Arc<Sample>)> {
        let sample = self.value(name, rate)?;
        let value = T::from_bytes(sample.bytes.as_deref()?)?;
        (sample.value_type.name == T::describe().name).then_some((value, sample))
    }

    /// The values of a variable that came since the call before with the same `reader`, oldest first; for traces. To be asked
    /// for in every frame, as [`Self::value`].
    pub(crate) fn values(&self, name: &str, rate: Rate, reader: &str) -> Vec<Arc<Sample>> {
        self.subscriptions.borrow_mut().since(name, rate, reader)
    }

    /// Why a variable cannot be listened to, if so.
    pub(crate) fn trouble(&self, name: &str) -> Option<String> {
        self.subscriptions.borrow().trouble(name)
    }

    /// The newest list of a schema's own panel, or why it has none to show; nothing while none came yet. To be asked for in every
    /// frame, as [`Self::value`].
    pub(crate) fn panel(&self, schema: &str, rate: Rate) -> Option<PanelContent> {
        self.panels.borrow_mut().newest(schema, rate)
    }

    /// Hands a schema what a person did to its panel. A slider or drag under way that a newer one overtakes is left out.
    pub(crate) fn touch(&self, schema: &str, gesture: Gesture) -> Outcome {
        let schema = schema.to_owned();
        self.order(Action::Touch { schema, gesture })
    }

    /// Asks for something as an operator (R14). What comes of it is among [`Self::notices`].
    pub(crate) fn act(&self, action: Action) {
        self.orders.act(action);
    }

    /// As [`Self::act`], for those who want to know what came of just this.
    pub(crate) fn order(&self, action: Action) -> Outcome {
        self.orders.order(action)
    }

    /// As [`Self::act`], held by a lease for as long as it is asked for again at least every half second: what a person lets go
    /// of, or a viewer that dies, is undone by the application itself.
    pub(crate) fn hold(&self, action: Action) {
        self.orders.hold(action);
    }

    /// Ends what [`Self::hold`] holds at a schema, at once.
    pub(crate) fn let_go(&self, schema: &str) {
        self.orders.let_go(schema);
    }

    /// What came of orders lately, newest last.
    pub(crate) fn notices(&self) -> Vec<Notice> {
        self.orders.notices()
    }

    /// Asks for a window of a kind: brought to the front, or opened if there is none.
    pub(crate) fn open_window(&self, kind: Window) {
        self.openings.borrow_mut().push(kind);
    }

    /// The windows that were asked for since the call before.
    pub(crate) fn openings(&self) -> Vec<Window> {
        self.openings.take()
    }

    /// Asks for a number over time, by the name of its variable and its path in it: the oscilloscope shows it.
    pub(crate) fn plot(&self, name: String) {
        self.plots.borrow_mut().push(name);
        self.open_window(Window::Oscilloscope);
    }

    /// The numbers that were asked for since the call before.
    pub(crate) fn plots(&self) -> Vec<String> {
        self.plots.take()
    }

    /// The way to the application. Its calls wait: not for the window's thread.
    #[cfg(test)]
    pub(crate) fn remote(&self) -> &Remote {
        &self.remote
    }
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
