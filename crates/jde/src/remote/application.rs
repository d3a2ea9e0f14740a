//! An application of another process as a source of the oscilloscope: the newest data from the link. No call
//! waits for the network, except that an action waits for its answer.

use std::sync::{Arc, Mutex, PoisonError};

use jde_link::message::{Action as OperatorAction, Request, VariableInfo};
use jde_link::{Rate, Remote, Subscription};
use jde_records::event::Outcome;
use jde_records::snapshot::Snapshot;
use jde_records::{RecordKind, RunRecord};
use jde_types::{Mission, Odometry, Pose2D, Value as _};

use crate::failure::Failure;
use crate::session::{self, MissionProgress, ValueView};
use crate::top::{Action, ObservedApplication, RobotView};

/// The rate at which the robot's pose is requested.
const POSE_RATE: Rate = Rate::Hz(10);

/// An application of another process.
pub(crate) struct RemoteApplication {
    remote: Remote,
    state: Arc<Mutex<RemoteState>>,
    _subscriptions: Vec<Subscription>,
}

/// The newest data.
struct RemoteState {
    snapshot: Snapshot,
    odometry: Option<Pose2D>,
    mission: Option<MissionProgress>,
    outcome: Option<Outcome>,
    notes: Vec<String>,
}

/// Number of notes that are kept below the picture.
const MAX_NOTES: usize = 50;

impl RemoteApplication {
    /// Subscribes to the application.
    ///
    /// # Errors
    /// The application does not answer.
    pub(crate) fn new(remote: Remote) -> Result<Self, Failure> {
        let seen = Arc::new(Mutex::new(RemoteState {
            snapshot: remote.hierarchy()?,
            odometry: None,
            mission: None,
            outcome: None,
            notes: Vec::new(),
        }));
        let mut watching = Vec::new();
        watching.push({
            let seen = Arc::clone(&seen);
            remote.watch_hierarchy(move |snapshot| lock(&seen).snapshot = snapshot)?
        });
        watching.push({
            let seen = Arc::clone(&seen);
            remote.events(&[RecordKind::Event], 0, move |happened| {
                lock(&seen).on_event(&happened.record)
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
            let seen = Arc::clone(&seen);
            watching.push(remote.watch(&odometry, POSE_RATE, move |sample| {
                lock(&seen).odometry = sample.bytes.as_deref().and_then(|bytes| {
                    let value_type = &*sample.value_type;
                    ValueView { value_type, bytes }.odometry()
                });
            })?);
        }
        if let Some(mission) = of_type(&Mission::describe().name) {
            let seen = Arc::clone(&seen);
            watching.push(remote.watch(&mission, POSE_RATE, move |sample| {
                let read = sample.bytes.as_deref().and_then(|bytes| {
                    let value_type = &*sample.value_type;
                    MissionProgress::read(ValueView { value_type, bytes })
                });
                let mut seen = lock(&seen);
                // Once a target was a place, `counts_positions` stays set, also after the last target.
                let places = seen
                    .mission
                    .as_ref()
                    .is_some_and(|mission| mission.counts_positions);
                seen.mission = read.map(|mission| MissionProgress {
                    counts_positions: mission.counts_positions || places,
                    ..mission
                });
            })?);
        }
        {
            let (seen, name) = (Arc::clone(&seen), remote.about().name.clone());
            remote.on_gone(move || {
                let mut seen = lock(&seen);
                if seen.outcome.is_none() {
                    let text = format!("{name} is gone: it ended, was killed, or the network to it is cut");
                    seen.outcome = Some(Outcome::Broken(text));
                }
            });
        }
        Ok(Self {
            remote,
            state: seen,
            _subscriptions: watching,
        })
    }

    /// Returns a function that makes the oscilloscope leave. Any thread may call it.
    pub(crate) fn stop_callback(&self) -> impl Fn() + Send + use<> {
        let seen = Arc::clone(&self.state);
        move || lock(&seen).outcome = Some(Outcome::Stopped)
    }
}

impl ObservedApplication for RemoteApplication {
    fn snapshot(&self) -> Snapshot {
        lock(&self.state).snapshot.clone()
    }

    fn robot(&self) -> Option<RobotView> {
        let seen = lock(&self.state);
        Some(session::robot_view(seen.odometry?, seen.mission.as_ref()))
    }

    fn act(&self, action: Action) -> Result<(), String> {
        let name = |place: usize| lock(&self.state).snapshot.schemas[place].name.clone();
        let action = match action {
            Action::Play(place) => OperatorAction::Play { schema: name(place) },
            Action::Stop(place) => OperatorAction::Stop { schema: name(place) },
            Action::Force(place) => OperatorAction::Force { schema: name(place) },
            Action::Release(place) => OperatorAction::Release { schema: name(place) },
            Action::Period(place, period) => OperatorAction::Period {
                schema: name(place),
                period_s: period as f64 / 1e9,
            },
            Action::StopAll => OperatorAction::StopAll,
            Action::ReleaseAll => OperatorAction::ReleaseAll,
        };
        let request = Request {
            by: jde_link::operator(),
            action,
            lease_ms: None,
        };
        self.remote.operate(&request).map_err(|error| error.to_string())
    }

    fn outcome(&self) -> Option<Outcome> {
        lock(&self.state).outcome.clone()
    }

    fn log_lines(&self) -> Vec<String> {
        lock(&self.state).notes.clone()
    }
}

impl RemoteState {
    fn on_event(&mut self, line: &RunRecord) {
        let RunRecord::Event(line) = line else { return };
        if line.kind == "ended" {
            self.outcome = Some(Outcome::parse(&line.text));
        }
        if self.notes.len() == MAX_NOTES {
            self.notes.remove(0);
        }
        let schema = line
            .schema
            .as_ref()
            .map_or(String::new(), |name| format!("{name} "));
        self.notes.push(format!(
            "{:.2} s  {schema}{}: {}",
            line.time_s, line.kind, line.text
        ));
    }
}

fn lock(seen: &Mutex<RemoteState>) -> std::sync::MutexGuard<'_, RemoteState> {
    seen.lock().unwrap_or_else(PoisonError::into_inner)
}
