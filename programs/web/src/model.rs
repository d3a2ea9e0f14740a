//! The application as the pages see it: the timeline of its records and snapshots, its missions, and the limits of those
//! who drive by hand. It is fed by the link's threads.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Instant;

use jde_link::message::{Action, Request, SchemaInfo, Schemas, VariableInfo};
use jde_link::{Error, Rate, Remote, Subscription};
use jde_records::RecordKind;
use jde_records::snapshot::Snapshot;
use jde_timeline::{Hierarchy, Keep, LogLimits, Timeline};
use jde_types::{Mission, Value};
use parking_lot::{Mutex, MutexGuard};

use crate::log::Log;

/// The type of schemas that drive a base by hand.
const TELEOPERATOR: &str = "teleop/base";
/// Earlier records of each kind that are asked for.
const MAX_EARLIER: usize = 1000;
/// How often slow values are read.
const SLOW: Rate = Rate::Hz(2);

/// What is kept: what the page shows, which is the present and the reasons of the last switches.
const KEEP: Keep = Keep {
    intervals: 16,
    marks: 0,
    switches: 64,
    records: LogLimits {
        records: 1000,
        candidates: 20_000,
        switches: 200,
    },
    ended: false,
};

/// An application.
pub(crate) struct Model {
    pub(crate) remote: Remote,
    pub(crate) schemas: Schemas,
    pub(crate) variables: Vec<VariableInfo>,
    present: Arc<Mutex<Present>>,
    _subscriptions: Vec<Subscription>,
}

/// What is known of an application now.
pub(crate) struct Present {
    pub(crate) timeline: Timeline,
    pub(crate) snapshot: Snapshot,
    /// When the newest snapshot arrived.
    pub(crate) updated: Instant,
    pub(crate) log: Log,
    /// By the names of their variables.
    pub(crate) missions: BTreeMap<String, Mission>,
    /// By the names of their variables: `teleop.fast`.
    limits: BTreeMap<String, f64>,
}

/// The greatest speeds of somebody who drives by hand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MaxSpeeds {
    /// m/s.
    pub(crate) fast: f64,
    /// rad/s.
    pub(crate) turn: f64,
}

impl Present {
    /// Returns the greatest speeds of somebody who drives by hand; `None` until they are known.
    pub(crate) fn max_speeds(&self, schema: &str) -> Option<MaxSpeeds> {
        let limit = |name: &str| self.limits.get(&format!("{schema}.{name}")).copied();
        Some(MaxSpeeds {
            fast: limit("fast")?,
            turn: limit("turn")?.max(0.0),
        })
    }
}

impl Model {
    /// Subscribes to an application.
    ///
    /// # Errors
    /// It gives no answer.
    pub(crate) fn open(remote: Remote) -> Result<Self, Error> {
        let schemas = remote.schemas()?;
        let variables = remote.variables(false)?;
        let snapshot = remote.hierarchy()?;
        let present = Arc::new(Mutex::new(Present {
            timeline: Timeline::new(Hierarchy::of_snapshot(&snapshot), KEEP),
            snapshot,
            updated: Instant::now(),
            log: Log::default(),
            missions: BTreeMap::new(),
            limits: BTreeMap::new(),
        }));
        let mut subscriptions = Vec::new();
        let sink = Arc::clone(&present);
        subscriptions.push(remote.events(&RecordKind::ALL, MAX_EARLIER, move |event| {
            let mut present = sink.lock();
            present.timeline.add_missed(event.missed);
            present.timeline.add(&event.record);
            present.log.add(&event.record);
        })?);
        let sink = Arc::clone(&present);
        subscriptions.push(remote.watch_hierarchy(move |snapshot| {
            let mut present = sink.lock();
            present.timeline.add_snapshot(&snapshot);
            (present.snapshot, present.updated) = (snapshot, Instant::now());
        })?);
        let mission = Mission::describe().name;
        let missions = variables
            .iter()
            .filter(|variable| variable.access == "export" && variable.type_name == mission);
        for variable in missions {
            let (sink, name) = (Arc::clone(&present), variable.name.clone());
            subscriptions.push(remote.watch(&variable.name, SLOW, move |sample| {
                let missions = &mut sink.lock().missions;
                match sample.bytes.as_deref().and_then(Mission::from_bytes) {
                    Some(mission) => _ = missions.insert(name.clone(), mission),
                    None => _ = missions.remove(&name),
                }
            })?);
        }
        for schema in teleoperators(&schemas) {
            for limit in ["fast", "turn"] {
                let name = format!("{}.{limit}", schema.name);
                if !variables.iter().any(|variable| variable.name == name) {
                    continue;
                }
                let (sink, known) = (Arc::clone(&present), name.clone());
                subscriptions.push(remote.watch(&name, SLOW, move |sample| {
                    let number = sample
                        .value()
                        .and_then(|value| value.into_only_field().as_number());
                    if let Some(number) = number {
                        sink.lock().limits.insert(known.clone(), number);
                    }
                })?);
            }
        }
        Ok(Self {
            remote,
            schemas,
            variables,
            present,
            _subscriptions: subscriptions,
        })
    }

    /// Returns what is known now. Held for a moment only: the link's threads wait for it.
    pub(crate) fn present(&self) -> MutexGuard<'_, Present> {
        self.present.lock()
    }

    /// Returns the names of those who drive by hand.
    pub(crate) fn teleoperators(&self) -> impl Iterator<Item = &str> {
        teleoperators(&self.schemas).map(|schema| schema.name.as_str())
    }

    /// Returns the names of the schemas with panels.
    pub(crate) fn panels(&self) -> Vec<&str> {
        let with_panel = self.schemas.schemas.iter().filter(|schema| schema.panel);
        with_panel.map(|schema| schema.name.as_str()).collect()
    }

    /// Returns the greatest speeds of somebody who drives by hand; `None` until they are known.
    pub(crate) fn max_speeds(&self, schema: &str) -> Option<MaxSpeeds> {
        self.present().max_speeds(schema)
    }

    /// Sends an order to the application, and waits for the answer: not for a thread that serves pages. Returns what others
    /// lose by it.
    ///
    /// # Errors
    /// The reason in words.
    pub(crate) fn operate(&self, by: &str, action: Action, lease_ms: Option<u64>) -> Result<String, String> {
        let request = Request {
            by: by.to_owned(),
            action,
            lease_ms,
        };
        let answer = self.remote.operate_reporting(&request);
        answer.map_err(|error| error.to_string())
    }
}

fn teleoperators(schemas: &Schemas) -> impl Iterator<Item = &SchemaInfo> {
    schemas
        .schemas
        .iter()
        .filter(|schema| schema.type_name == TELEOPERATOR)
}
