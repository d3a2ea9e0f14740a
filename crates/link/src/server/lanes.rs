//! Sends values and panels to clients: one lane for each requested variable or panel and rate. A thread of
//! its own, so that clients that query without reading answers cannot delay it.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;
use std::time::{Duration, Instant};

use jde_board::{Board, Variable};
use zenoh::Session;

use super::inbox::{Inbox, Origin, Want};
use super::panel_lane::PanelLane;
use super::subject::Subject;
use super::value_lane::ValueLane;
use crate::keys::{self, Keys, Wanted};

/// What lanes are made from.
pub(super) struct Yard<'a> {
    pub(super) subject: &'a dyn Subject,
    pub(super) inbox: &'a Arc<Inbox>,
    pub(super) sessions: &'a [(Origin, Session)],
    pub(super) keys: &'a Keys,
}

/// Serves all lanes until the link stops.
pub(super) fn run(yard: &Yard<'_>) {
    let mut lanes = Lanes::default();
    while !yard.inbox.stopping() {
        let fresh = yard.inbox.take_fresh();
        if let Some(wants) = yard.inbox.wants() {
            lanes.follow(&wants, yard);
        }
        match lanes.serve(yard.subject, fresh) {
            Some(due) => std::thread::park_timeout(due.saturating_duration_since(Instant::now())),
            None => std::thread::park(),
        }
    }
}

/// All lanes.
#[derive(Default)]
struct Lanes {
    /// Each with the number of the last arrival for which it sent the newest value again.
    lanes: BTreeMap<Want, (u64, Lane)>,
    places: Places,
}

/// The publication of one variable or panel at one rate.
enum Lane {
    Values(ValueLane),
    Panel(PanelLane),
}

/// The variables and panels by their paths in keys. Its size is bounded by the application, not by clients'
/// requests: an unknown path is rejected without a search of the board.
#[derive(Default)]
struct Places {
    variables: HashMap<String, Arc<Variable>>,
    /// Names of the schemas with panels. Filled when a client first requests a panel.
    panels: Option<HashMap<String, String>>,
}

impl Lanes {
    /// Opens and closes lanes, so that each want has one.
    fn follow(&mut self, wants: &BTreeMap<Want, u64>, yard: &Yard<'_>) {
        self.lanes.retain(|want, _| wants.contains_key(want));
        self.places.follow(yard.subject.board());
        for (want, joined) in wants {
            if let Some((known, lane)) = self.lanes.get_mut(want) {
                if *known != *joined {
                    *known = *joined;
                    lane.begin_again();
                }
            } else if let Some(lane) = self.places.open(want, yard) {
                self.lanes.insert(want.clone(), (*joined, lane));
            }
        }
    }

    /// Sends what is due; returns when the next is due.
    fn serve(&mut self, subject: &dyn Subject, fresh: bool) -> Option<Instant> {
        let now = Instant::now();
        let lanes = self.lanes.values_mut();
        lanes
            .filter_map(|(_, lane)| match lane {
                Lane::Values(lane) => lane.serve(subject, now, fresh),
                Lane::Panel(lane) => lane.serve(subject, now, fresh),
            })
            .min()
    }
}

impl Lane {
    /// Sends the newest at once, whatever its age, for a client that joined late.
    fn begin_again(&mut self) {
        match self {
            Self::Values(lane) => lane.begin_again(),
            Self::Panel(lane) => lane.begin_again(),
        }
    }
}

impl Places {
    /// Adds variables declared since the last call.
    fn follow(&mut self, board: &Board) {
        for variable in board.list().skip(self.variables.len()) {
            let declared = variable.describe();
            let place = keys::place(&declared.owner, &declared.name);
            self.variables.insert(place, variable);
        }
    }

    /// Opens a lane for an existing variable or panel.
    fn open(&mut self, want: &Want, yard: &Yard<'_>) -> Option<Lane> {
        match &want.what {
            Wanted::Variable(place) => {
                let variable = self.variables.get(place)?;
                ValueLane::open(want, variable, yard).map(Lane::Values)
            }
            Wanted::Panel(place) => {
                let panels = self.panels.get_or_insert_with(|| panels(yard.subject));
                let schema = panels.get(place)?;
                PanelLane::open(want, schema, yard).map(Lane::Panel)
            }
        }
    }
}

fn panels(subject: &dyn Subject) -> HashMap<String, String> {
    let schemas = subject.schemas().schemas.into_iter();
    schemas
        .filter(|schema| schema.panel)
        .map(|schema| (keys::chunk(&schema.name), schema.name))
        .collect()
}

impl Yard<'_> {
    pub(super) fn session(&self, origin: Origin) -> Option<&Session> {
        let mut sessions = self.sessions.iter();
        sessions.find_map(|(of, session)| (*of == origin).then_some(session))
    }
}

/// The least time between two messages at a rate; none if there is no limit.
pub(super) fn period(want: &Want) -> Option<Duration> {
    want.rate.period_ns().map(Duration::from_nanos)
}
