//! A running application as the windows see it: the data last received over the link, and the requests to it.
//! No call waits for the network except [`WindowSession::open`]: separate threads subscribe and send orders.
//!
//! Each frame, a window requests the data that it shows. Subscriptions that no window requests any more are
//! ended.

mod backlog;
mod client;
mod demand;
mod inbox;
mod orders;
mod panels;
mod queue;
mod subscriptions;
mod watch_list;

use std::cell::RefCell;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use eframe::egui;
use jde_link::message::{About, Action, SchemaInfo, Schemas, VariableInfo};
use jde_link::{Error, Rate, Remote, Sample, Subscription};
use jde_panel::Gesture;
use jde_records::RecordKind;
use jde_records::snapshot::{SchemaView, Snapshot};
use jde_timeline::{Ending, Hierarchy, Keep, Timeline};
use jde_types::{Body, Value};
use parking_lot::Mutex;

pub(crate) use client::{Notice, OrderOutcome};
use inbox::Inbox;
use orders::Orders;
pub(crate) use panels::PanelContent;
use panels::Panels;
use subscriptions::Subscriptions;

use crate::recorded::Recorded;
use crate::stop::{StopRequest, StopTarget};
use crate::window::WindowKind as Window;

/// The schema that controls the playback of a recording.
pub(crate) const STEERING: &str = "replay";

/// Maximum number of earlier lines fetched of each kind: all that an application keeps.
const MAX_EARLIER_LINES: usize = 20_000;

/// How long after a switch a recording is shown, s. A position is before what happens at its time.
pub(crate) const AFTER_SWITCH_S: f64 = 0.002;

/// A connection to an application. Only the window's thread uses it, except [`WindowSession::open`].
pub(crate) struct WindowSession {
    remote: Remote,
    schemas: Schemas,
    variables: Vec<VariableInfo>,
    inbox: Arc<Mutex<Inbox>>,
    snapshot: Arc<Snapshot>,
    /// When the newest snapshot arrived.
    updated: Instant,
    timeline: Timeline,
    subscriptions: RefCell<Subscriptions>,
    panels: RefCell<Panels>,
    orders: Orders,
    openings: RefCell<Vec<Window>>,
    plots: RefCell<Vec<String>>,
    /// The schema whose events are to be shown; within, `None` for those of all.
    events_of: RefCell<Option<Option<String>>>,
    gone: bool,
    recorded: Option<Recorded>,
    _watching: Vec<Subscription>,
}

impl WindowSession {
    /// Opens a session and subscribes to the application. Waits up to 5 s for each reply: not to be called
    /// from the window's thread.
    ///
    /// # Errors
    /// Those of [`Remote`]'s calls.
    pub(crate) fn open(remote: Remote, repaint: egui::Context) -> Result<Self, Error> {
        let schemas = remote.schemas()?;
        let variables = remote.variables(false)?;
        let snapshot = remote.hierarchy()?;
        let inbox = Arc::new(Mutex::new(Inbox::default()));
        let mut watching = Vec::new();
        watching.push({
            let (inbox, repaint) = (Arc::clone(&inbox), repaint.clone());
            remote.watch_hierarchy(move |snapshot| {
                inbox.lock().snapshot = Some(snapshot);
                repaint.request_repaint();
            })?
        });
        watching.push({
            let inbox = Arc::clone(&inbox);
            remote.events(&RecordKind::ALL, MAX_EARLIER_LINES, move |event| {
                inbox.lock().push(event.record, event.missed);
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
            timeline: Timeline::new(Hierarchy::of_snapshot(&snapshot), Keep::LIVE),
            subscriptions: RefCell::new(Subscriptions::new(remote.clone(), repaint.clone())),
            panels: RefCell::new(Panels::new(remote.clone(), repaint.clone())),
            orders: Orders::new(remote.clone(), repaint),
            openings: RefCell::default(),
            plots: RefCell::default(),
            events_of: RefCell::default(),
            snapshot: Arc::new(snapshot),
            updated: Instant::now(),
            gone: false,
            recorded: None,
            remote,
            _watching: watching,
        })
    }

    /// Reads the file of the recording that plays, too.
    pub(crate) fn with_file(self, file: PathBuf, repaint: egui::Context) -> Self {
        let recorded = Some(Recorded::open(file, repaint));
        Self { recorded, ..self }
    }

    /// The whole recording, if its file can be read on this machine.
    pub(crate) fn recorded(&self) -> Option<&Recorded> {
        self.recorded.as_ref()
    }

    /// Requests that the recording goes on from just after a switch at a time, s, so that it is in force.
    pub(crate) fn seek_switch(&self, time_s: f64) -> OrderOutcome {
        self.seek(time_s + AFTER_SWITCH_S)
    }

    /// Requests that the recording goes on from a time, s, or from its end if that is before.
    pub(crate) fn seek(&self, time_s: f64) -> OrderOutcome {
        let position = format!("{STEERING}.position");
        let position = self.variables.iter().find(|variable| variable.name == position);
        let end = position.and_then(|variable| variable.range.greatest);
        let time_s = end.map_or(time_s, |end| time_s.min(end));
        self.order(Action::Modulate {
            schema: STEERING.to_owned(),
            variable: "position".to_owned(),
            value: time_s.into(),
        })
    }

    /// Takes in the data received since the last frame. Call once at the beginning of each frame.
    pub(crate) fn begin_frame(&mut self) {
        let Inbox {
            snapshot,
            mut lines,
            dropped,
        } = std::mem::take(&mut *self.inbox.lock());
        self.timeline.add_missed(dropped);
        // Each kind of earlier lines arrives by itself.
        lines.make_contiguous().sort_by_key(|(line, _)| line.time());
        for (line, missed) in lines {
            self.timeline.add_missed(missed);
            self.timeline.add(&line);
        }
        if let Some(mut snapshot) = snapshot {
            self.timeline.add_snapshot(&snapshot);
            if self.timeline.ending().is_some() {
                // The clock of an application that stays to be looked at goes on.
                snapshot.time = snapshot.time.min(self.timeline.now());
            }
            self.snapshot = Arc::new(snapshot);
            self.updated = Instant::now();
        }
        self.gone = !self.remote.is_alive();
        self.subscriptions.get_mut().remove_unused();
        self.panels.get_mut().remove_unused();
    }

    /// The application's name, process and file.
    pub(crate) fn about(&self) -> &About {
        self.remote.about()
    }

    /// Whether the application is gone. Everything shown is then its last state.
    pub(crate) fn is_gone(&self) -> bool {
        self.gone
    }

    /// How the application ended; `None` while it runs. In a recording, as of its position.
    pub(crate) fn ending(&self) -> Option<Ending> {
        let known = self.timeline.ending().cloned();
        known.or_else(|| self.gone.then_some(Ending::Lost))
    }

    /// Whether nothing changes any more: the application has ended or is gone.
    pub(crate) fn is_over(&self) -> bool {
        self.gone || !self.is_recording() && self.timeline.ending().is_some()
    }

    /// Time since the newest snapshot. An application sends 20 snapshots a second. A longer silence means
    /// that it hangs, or that its network connection is cut.
    pub(crate) fn silent(&self) -> Duration {
        self.updated.elapsed()
    }

    /// Whether the application is a recording that plays.
    pub(crate) fn is_recording(&self) -> bool {
        self.about().executor == "replay"
    }

    /// Whether a modulation of a schema can be set. In a recording, only those of the schema [`STEERING`]
    /// can.
    pub(crate) fn can_set(&self, schema: &str) -> bool {
        !self.is_over() && (!self.is_recording() || schema == STEERING)
    }

    /// The application's schemas and groups, as declared.
    pub(crate) fn schemas(&self) -> &Schemas {
        &self.schemas
    }

    /// The declaration of a schema, by its name.
    pub(crate) fn schema(&self, name: &str) -> Option<&SchemaInfo> {
        self.schemas.schemas.iter().find(|schema| schema.name == name)
    }

    /// The application's variables.
    pub(crate) fn variables(&self) -> &[VariableInfo] {
        &self.variables
    }

    /// The exports of a standard type, in the application's order.
    pub(crate) fn exports<T: Value>(&self) -> impl Iterator<Item = &VariableInfo> {
        let name = T::describe().name;
        let fits = move |variable: &&VariableInfo| variable.access == "export" && variable.type_name == name;
        self.variables.iter().filter(fits)
    }

    /// The body that this driver exports, or that of the robot to which this schema is bound; the first body for a
    /// schema that is bound to no robot. `None` until it is published. Call in each frame, as [`Self::value`].
    pub(crate) fn body(&self, schema: &str) -> Option<Body> {
        let info = self.schema(schema)?;
        let is_bound = |robot: &str| {
            let mut variables = info.ports.iter().filter_map(|port| port.variable.as_deref());
            schema == robot
                || variables.any(|name| name.rsplit_once('.').is_some_and(|(owner, _)| owner == robot))
        };
        let bound = self.exports::<Body>().find(|body| is_bound(&body.owner));
        let first = || self.exports::<Body>().next().filter(|_| info.kind != "driver");
        let body = bound.or_else(first)?;
        Some(self.read::<Body>(&body.name, Rate::Hz(1))?.0)
    }

    /// The newest states of all schemas and groups.
    pub(crate) fn snapshot(&self) -> &Arc<Snapshot> {
        &self.snapshot
    }

    /// The newest state of a schema.
    pub(crate) fn view(&self, schema: &str) -> Option<&SchemaView> {
        self.snapshot.schemas.iter().find(|view| view.name == schema)
    }

    /// What happened, as far as it is kept; in a recording, until its position.
    pub(crate) fn timeline(&self) -> &Timeline {
        &self.timeline
    }

    /// The names of the schemas that have a panel.
    pub(crate) fn panels(&self) -> impl Iterator<Item = &str> {
        let schemas = self.snapshot.schemas.iter();
        schemas
            .filter(|schema| schema.panel)
            .map(|schema| schema.name.as_str())
    }

    /// The names of the schemas of the top level.
    pub(crate) fn roots(&self) -> impl Iterator<Item = &str> {
        let tops = self.schemas.groups.iter().filter(|group| group.father.is_none());
        tops.flat_map(|group| group.members.iter().map(String::as_str))
    }

    /// Whether an operator keeps a schema stopped or unloaded.
    pub(crate) fn is_stopped(&self, schema: &str) -> bool {
        self.view(schema).is_some_and(|view| view.stop().is_some())
    }

    /// Who stopped everything, as far as that still holds, and the roots that no operator keeps stopped.
    pub(crate) fn stopped_by(&self) -> Option<(&str, Vec<&str>)> {
        let mut holds = self
            .roots()
            .filter_map(|root| self.view(root))
            .flat_map(SchemaView::holds);
        let by = holds.find(|hold| hold.with_everything)?.by.as_str();
        Some((by, self.roots().filter(|root| !self.is_stopped(root)).collect()))
    }

    /// What a stop of everything in these windows concerns. A recording has nothing to stop.
    pub(crate) fn stop_target(&self) -> Option<StopTarget> {
        let about = self.about();
        (!self.is_recording()).then(|| StopTarget::One(format!("{}@{}", about.name, about.id)))
    }

    /// Why time stands still; `None` while it passes.
    pub(crate) fn standstill(&self) -> Option<&str> {
        self.snapshot.standstill.as_deref()
    }

    /// The time of the newest snapshot, in s since the application's start.
    pub(crate) fn now(&self) -> f64 {
        self.snapshot.time as f64 / 1e9
    }

    /// The newest value of a variable. Call in each frame that shows it: a variable that is not requested is
    /// no longer sent. Returns `None` until the first value arrives.
    pub(crate) fn value(&self, name: &str, rate: Rate) -> Option<Arc<Sample>> {
        self.subscriptions.borrow_mut().newest(name, rate)
    }

    /// As [`Self::value`], decoded as a standard type. `None` if the variable has another type.
    pub(crate) fn read<T: Value>(&self, name: &str, rate: Rate) -> Option<(T, Arc<Sample>)> {
        let sample = self.value(name, rate)?;
        let value = T::from_bytes(sample.bytes.as_deref()?)?;
        (sample.value_type.name == T::describe().name).then_some((value, sample))
    }

    /// The values of a variable that arrived since the last call with the same `reader`, oldest first; for
    /// traces. Call in each frame, as [`Self::value`].
    pub(crate) fn values(&self, name: &str, rate: Rate, reader: &str) -> Vec<Arc<Sample>> {
        self.subscriptions.borrow_mut().since(name, rate, reader)
    }

    /// Why subscribing to a variable failed, if so.
    pub(crate) fn trouble(&self, name: &str) -> Option<String> {
        self.subscriptions.borrow().trouble(name)
    }

    /// The newest list of a schema's panel, or why there is none. `None` until the first arrives. Call in
    /// each frame, as [`Self::value`].
    pub(crate) fn panel(&self, schema: &str, rate: Rate) -> Option<PanelContent> {
        self.panels.borrow_mut().newest(schema, rate)
    }

    /// Sends a gesture on a schema's panel to the schema. A newer gesture replaces a waiting slider move or
    /// unfinished drag.
    pub(crate) fn touch(&self, schema: &str, gesture: Gesture) -> OrderOutcome {
        let schema = schema.to_owned();
        self.order(Action::Touch { schema, gesture })
    }

    /// Requests an action as an operator (R14). A failure is added to [`Self::notices`].
    pub(crate) fn act(&self, action: Action) {
        self.orders.act(action);
    }

    /// Sends an order to stop everything until it is acknowledged or withdrawn, also after this session was dropped.
    pub(crate) fn stop_everything(&self, request: Arc<StopRequest>) {
        self.orders.stop_everything(request);
    }

    /// As [`Self::act`], and returns the outcome of this order.
    pub(crate) fn order(&self, action: Action) -> OrderOutcome {
        self.orders.order(action)
    }

    /// As [`Self::act`], held by a lease that must be renewed by a call at least every half second. When the
    /// user releases the control, or the viewer dies, the application undoes the action.
    pub(crate) fn hold(&self, action: Action) {
        self.orders.hold(action);
    }

    /// Ends an action of [`Self::hold`] on a schema at once.
    pub(crate) fn let_go(&self, schema: &str) {
        self.orders.let_go(schema);
    }

    /// The notices of failed orders, newest last.
    pub(crate) fn notices(&self) -> Vec<Notice> {
        self.orders.notices()
    }

    /// Requests a window of a kind: an open one is brought to the front, or else one is opened.
    pub(crate) fn open_window(&self, kind: Window) {
        self.openings.borrow_mut().push(kind);
    }

    /// Removes and returns the requested windows.
    pub(crate) fn openings(&self) -> Vec<Window> {
        self.openings.take()
    }

    /// Requests a trace of a number in the oscilloscope, by the variable's name and the path in it.
    pub(crate) fn plot(&self, name: String) {
        self.plots.borrow_mut().push(name);
        self.open_window(Window::Oscilloscope);
    }

    /// Requests the events that deserve a look, of a schema or of all.
    pub(crate) fn show_events(&self, schema: Option<String>) {
        self.events_of.replace(Some(schema));
        self.open_window(Window::Events);
    }

    /// Removes and returns whose events are requested; within, `None` for those of all.
    pub(crate) fn requested_events(&self) -> Option<Option<String>> {
        self.events_of.take()
    }

    /// Removes and returns the requested traces.
    pub(crate) fn plots(&self) -> Vec<String> {
        self.plots.take()
    }

    /// The link to the application. Its calls wait: not for the window's thread.
    pub(crate) fn remote(&self) -> &Remote {
        &self.remote
    }
}
