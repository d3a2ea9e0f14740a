//! An application of another process as a source of the oscilloscope: the newest data from the link. No call
//! waits for the network, except that an action waits for its answer.

use std::sync::{Arc, Mutex, PoisonError};

use jde_host::event::Outcome;
use jde_host::snapshot::Snapshot;
use jde_host::story::{Kind, Line};
use jde_link::message::{Action as Deed, Request, VariableInfo};
use jde_link::{Rate, Remote, Watching};
use jde_types::{Mission, Odometry, Pose2D, Value as _};

use crate::failure::Failure;
use crate::session::{self, Mission as Progress, Read};
use crate::top::{Action, Application, RobotView};

/// The rate at which the robot's pose is requested.
const PLACES: Rate = Rate::Hz(10);

/// An application of another process.
pub(crate) struct Live {
    remote: Remote,
    seen: Arc<Mutex<Seen>>,
    _watching: Vec<Watching>,
}

/// The newest data.
struct Seen {
    snapshot: Snapshot,
    odometry: Option<Pose2D>,
    mission: Option<Progress>,
    outcome: Option<Outcome>,
    notes: Vec<String>,
}

/// Number of notes that are kept below the picture.
const NOTES: usize = 50;

impl Live {
    /// Subscribes to the application.
    ///
    /// # Errors
    /// The application does not answer.
    pub(crate) fn new(remote: Remote) -> Result<Self, Failure> {
        let seen = Arc::new(Mutex::new(Seen {
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
            remote.events(&[Kind::Happening], 0, move |happened| {
                lock(&seen).happened(&happened.line)
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
            watching.push(remote.watch(&odometry, PLACES, move |sample| {
                lock(&seen).odometry = sample.bytes.as_deref().and_then(|bytes| {
                    let value_type = &*sample.value_type;
                    Read { value_type, bytes }.odometry()
                });
            })?);
        }
        if let Some(mission) = of_type(&Mission::describe().name) {
            let seen = Arc::clone(&seen);
            watching.push(remote.watch(&mission, PLACES, move |sample| {
                let read = sample.bytes.as_deref().and_then(|bytes| {
                    let value_type = &*sample.value_type;
                    Progress::read(Read { value_type, bytes })
                });
                let mut seen = lock(&seen);
                // Once a target was a place, `of_places` stays set, also after the last target.
                let places = seen.mission.as_ref().is_some_and(|mission| mission.of_places);
                seen.mission = read.map(|mission| Progress {
                    of_places: mission.of_places || places,
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
            seen,
            _watching: watching,
        })
    }

    /// Returns a function that makes the oscilloscope leave. Any thread may call it.
    pub(crate) fn leaving(&self) -> impl Fn() + Send + use<> {
        let seen = Arc::clone(&self.seen);
        move || lock(&seen).outcome = Some(Outcome::Stopped)
    }
}

impl Application for Live {
    fn snapshot(&self) -> Snapshot {
        lock(&self.seen).snapshot.clone()
    }

    fn robot(&self) -> Option<RobotView> {
        let seen = lock(&self.seen);
        Some(session::robot(seen.odometry?, seen.mission.as_ref()))
    }

    fn act(&self, action: Action) -> Result<(), String> {
        let name = |place: usize| lock(&self.seen).snapshot.schemas[place].name.clone();
        let action = match action {
            Action::Play(place) => Deed::Play { schema: name(place) },
            Action::Stop(place) => Deed::Stop { schema: name(place) },
            Action::Force(place) => Deed::Force { schema: name(place) },
            Action::Release(place) => Deed::Release { schema: name(place) },
            Action::Period(place, period) => Deed::Period {
                schema: name(place),
                period_s: period as f64 / 1e9,
            },
            Action::StopAll => Deed::StopAll,
            Action::ReleaseAll => Deed::ReleaseAll,
        };
        let request = Request {
            by: jde_link::operator(),
            action,
            lease_ms: None,
        };
        self.remote.operate(&request).map_err(|error| error.to_string())
    }

    fn outcome(&self) -> Option<Outcome> {
        lock(&self.seen).outcome.clone()
    }

    fn log_lines(&self) -> Vec<String> {
        lock(&self.seen).notes.clone()
    }
}

impl Seen {
    fn happened(&mut self, line: &Line) {
        let Line::Happening(line) = line else { return };
        if line.kind == "ended" {
            self.outcome = Some(Outcome::read(&line.text));
        }
        if self.notes.len() == NOTES {
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

fn lock(seen: &Mutex<Seen>) -> std::sync::MutexGuard<'_, Seen> {
    seen.lock().unwrap_or_else(PoisonError::into_inner)
}
