//! Sends values and panels to clients: one lane for each requested variable or panel and rate. A thread of
//! its own, so that clients that query without reading answers cannot delay it.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;
use std::time::{Duration, Instant};

use jde_board::{Board, Variable};
use zenoh::Session;

use super::inbox::{Demand, Inbox, Origin};
use super::panel_publisher::PanelPublisher;
use super::subject::Subject;
use super::value_publisher::ValuePublisher;
use crate::keys::{self, Keys, TokenTarget};

/// What lanes are made from.
pub(super) struct PublishContext<'a> {
    pub(super) subject: &'a dyn Subject,
    pub(super) inbox: &'a Arc<Inbox>,
    pub(super) sessions: &'a [(Origin, Session)],
    pub(super) keys: &'a Keys,
}

/// Serves all lanes until the link stops.
pub(super) fn run(yard: &PublishContext<'_>) {
    let mut lanes = Publications::default();
    while !yard.inbox.is_stopping() {
        let fresh = yard.inbox.take_fresh();
        if let Some(wants) = yard.inbox.take_demands() {
            lanes.update(&wants, yard);
        }
        match lanes.serve(yard.subject, fresh) {
            Some(due) => std::thread::park_timeout(due.saturating_duration_since(Instant::now())),
            None => std::thread::park(),
        }
    }
}

/// All lanes.
#[derive(Default)]
struct Publications {
    /// Each with the number of the last arrival for which it sent the newest value again.
    publications: BTreeMap<Demand, (u64, Publication)>,
    index: PublicationIndex,
}

/// The publication of one variable or panel at one rate.
enum Publication {
    Values(ValuePublisher),
    Panel(PanelPublisher),
}

/// The variables and panels by their paths in keys. Its size is bounded by the application, not by clients'
/// requests: an unknown path is rejected without a search of the board.
#[derive(Default)]
struct PublicationIndex {
    variables: HashMap<String, Arc<Variable>>,
    /// Names of the schemas with panels. Filled when a client first requests a panel.
    panels: Option<HashMap<String, String>>,
}

impl Publications {
    /// Opens and closes lanes, so that each want has one.
    fn update(&mut self, wants: &BTreeMap<Demand, u64>, yard: &PublishContext<'_>) {
        self.publications.retain(|want, _| wants.contains_key(want));
        self.index.update(yard.subject.board());
        for (want, joined) in wants {
            if let Some((known, lane)) = self.publications.get_mut(want) {
                if *known != *joined {
                    *known = *joined;
                    lane.resend();
                }
            } else if let Some(lane) = self.index.open(want, yard) {
                self.publications.insert(want.clone(), (*joined, lane));
            }
        }
    }

    /// Sends what is due; returns when the next is due.
    fn serve(&mut self, subject: &dyn Subject, fresh: bool) -> Option<Instant> {
        let now = Instant::now();
        let lanes = self.publications.values_mut();
        lanes
            .filter_map(|(_, lane)| match lane {
                Publication::Values(lane) => lane.serve(subject, now, fresh),
                Publication::Panel(lane) => lane.serve(subject, now, fresh),
            })
            .min()
    }
}

impl Publication {
    /// Sends the newest at once, whatever its age, for a client that joined late.
    fn resend(&mut self) {
        match self {
            Self::Values(lane) => lane.resend(),
            Self::Panel(lane) => lane.resend(),
        }
    }
}

impl PublicationIndex {
    /// Adds variables declared since the last call.
    fn update(&mut self, board: &Board) {
        for variable in board.list().skip(self.variables.len()) {
            let declared = variable.describe();
            let place = keys::variable_path(&declared.owner, &declared.name);
            self.variables.insert(place, variable);
        }
    }

    /// Opens a lane for an existing variable or panel.
    fn open(&mut self, want: &Demand, yard: &PublishContext<'_>) -> Option<Publication> {
        match &want.target {
            TokenTarget::Variable(place) => {
                let variable = self.variables.get(place)?;
                ValuePublisher::open(want, variable, yard).map(Publication::Values)
            }
            TokenTarget::Panel(place) => {
                let panels = self.panels.get_or_insert_with(|| panels(yard.subject));
                let schema = panels.get(place)?;
                PanelPublisher::open(want, schema, yard).map(Publication::Panel)
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

impl PublishContext<'_> {
    pub(super) fn session(&self, origin: Origin) -> Option<&Session> {
        let mut sessions = self.sessions.iter();
        sessions.find_map(|(of, session)| (*of == origin).then_some(session))
    }
}

/// The least time between two messages at a rate; none if there is no limit.
pub(super) fn period(want: &Demand) -> Option<Duration> {
    want.rate.period_ns().map(Duration::from_nanos)
}
