//! An application of another process as a source of the oscilloscope: the newest data from the link. No call
//! waits for the network, except that an action waits for its answer.

use std::sync::Arc;
use std::time::{Duration, Instant};

use jde_core::Nanos;
use jde_link::message::{Action as OperatorAction, VariableInfo};
use jde_link::{Rate, Remote, Subscription};
use jde_records::event::{Outcome, What};
use jde_records::snapshot::Snapshot;
use jde_records::{RecordKind, RunRecord};
use jde_session::log::Log;
use jde_session::run as session;
use jde_session::top::{ObservedApplication, RobotView, ScreenAction};
use jde_timeline::{Ending, MissionTimeline};
use jde_types::{Mission, Odometry, Pose2D, Value as _};
use parking_lot::Mutex;

use super::request;
use crate::failure::Failure;

/// The rate at which the robot's pose is requested.
const POSE_RATE: Rate = Rate::Hz(10);

/// An application of another process.
pub(crate) struct RemoteApplication {
    remote: Remote,
    state: Arc<Mutex<RemoteState>>,
    log: Option<Log>,
    _subscriptions: Vec<Subscription>,
}

/// The newest data.
struct RemoteState {
    snapshot: Snapshot,
    /// When it arrived.
    updated: Instant,
    odometry: Option<Pose2D>,
    mission: MissionTimeline,
    ending: Option<Ending>,
    /// When it ended, ns.
    ended: Option<Nanos>,
    notes: Vec<String>,
}

/// Number of notes that are kept below the picture.
const MAX_NOTES: usize = 50;

impl RemoteApplication {
    /// Subscribes to the application. Lines that `log` keeps are shown below its events.
    ///
    /// # Errors
    /// The application does not answer.
    pub(crate) fn new(remote: Remote, log: Option<Log>) -> Result<Self, Failure> {
        let state = Arc::new(Mutex::new(RemoteState {
            snapshot: remote.hierarchy()?,
            updated: Instant::now(),
            odometry: None,
            mission: MissionTimeline::default(),
            ending: None,
            ended: None,
            notes: Vec::new(),
        }));
        let mut subscriptions = Vec::new();
        subscriptions.push({
            let state = Arc::clone(&state);
            remote.watch_hierarchy(move |snapshot| {
                let mut state = state.lock();
                state.snapshot = snapshot;
                state.updated = Instant::now();
            })?
        });
        subscriptions.push({
            let state = Arc::clone(&state);
            remote.events(&[RecordKind::Event], MAX_NOTES, move |event| {
                state.lock().on_event(&event.record)
            })?
        });
        let variables = remote.variables(false)?;
        let of_type = |name: &str| {
            let export = |variable: &&VariableInfo| variable.access == "export" && variable.type_name == name;
            variables
                .iter()
                .find(export)
                .map(|variable| variable.name.clone())
        };
        if let Some(odometry) = of_type(&Odometry::describe().name) {
            let state = Arc::clone(&state);
            subscriptions.push(remote.watch(&odometry, POSE_RATE, move |sample| {
                let odometry = sample.bytes.as_deref().and_then(Odometry::from_bytes);
                state.lock().odometry = odometry.map(|odometry| odometry.pose2d());
            })?);
        }
        if let Some(mission) = of_type(&Mission::describe().name) {
            let state = Arc::clone(&state);
            subscriptions.push(remote.watch(&mission, POSE_RATE, move |sample| {
                let mission = sample.bytes.as_deref().and_then(Mission::from_bytes);
                state.lock().mission.add(mission);
            })?);
        }
        {
            let state = Arc::clone(&state);
            remote.on_gone(move || {
                state.lock().ending.get_or_insert(Ending::Lost);
            });
        }
        Ok(Self {
            remote,
            state,
            log,
            _subscriptions: subscriptions,
        })
    }

    /// Returns a function that makes the oscilloscope leave. Any thread may call it.
    pub(crate) fn stop_callback(&self) -> impl Fn() + Send + use<> {
        let state = Arc::clone(&self.state);
        move || state.lock().ending = Some(Ending::Known(Outcome::Stopped))
    }
}

impl ObservedApplication for RemoteApplication {
    fn snapshot(&self) -> Snapshot {
        let state = self.state.lock();
        let mut snapshot = state.snapshot.clone();
        snapshot.time = state.ended.unwrap_or(snapshot.time);
        snapshot
    }

    fn robot(&self) -> Option<RobotView> {
        let state = self.state.lock();
        Some(session::robot_view(state.odometry?, &state.mission))
    }

    fn act(&self, action: ScreenAction) -> Result<(), String> {
        // The newest snapshot may have fewer schemas than the one on the screen.
        let name = |schema: usize| {
            let state = self.state.lock();
            let schema = state.snapshot.schemas.get(schema);
            schema.map_or_else(String::new, |schema| schema.name.clone())
        };
        let action = match action {
            ScreenAction::Play(schema) => OperatorAction::Play { schema: name(schema) },
            ScreenAction::Stop(schema) => OperatorAction::Stop { schema: name(schema) },
            ScreenAction::Force(schema) => OperatorAction::Force { schema: name(schema) },
            ScreenAction::Release(schema) => OperatorAction::Release { schema: name(schema) },
            ScreenAction::Period(schema, period) => OperatorAction::Period {
                schema: name(schema),
                period_s: period as f64 / 1e9,
            },
            ScreenAction::StopAll => OperatorAction::StopAll,
            ScreenAction::ReleaseAll => OperatorAction::ReleaseAll,
            ScreenAction::Continue => OperatorAction::Continue,
            ScreenAction::Step => OperatorAction::Step,
        };
        self.remote
            .operate(&request(action))
            .map_err(|error| error.to_string())
    }

    fn ending(&self) -> Option<Ending> {
        self.state.lock().ending.clone()
    }

    fn silent(&self) -> Duration {
        self.state.lock().updated.elapsed()
    }

    fn log_lines(&self) -> Vec<String> {
        let mut lines = self.state.lock().notes.clone();
        lines.extend(self.log.iter().flat_map(Log::buffered_lines));
        lines
    }
}

impl RemoteState {
    fn on_event(&mut self, record: &RunRecord) {
        let RunRecord::Other(event) = record else { return };
        if let What::Ended { outcome } = &event.what {
            self.ending = Some(Ending::Known(outcome.clone()));
            self.ended = Some(event.time);
        }
        if self.notes.len() == MAX_NOTES {
            self.notes.remove(0);
        }
        self.notes.push(format!("{:.2} s  {event}", event.time_s()));
    }
}
