//! Sends values and panels to clients, with one publisher for each requested variable or panel and rate. Runs
//! on a thread of its own, so that clients that query without reading replies cannot delay it.

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

/// What publishers are made from.
pub(super) struct PublishContext<'a> {
    pub(super) subject: &'a dyn Subject,
    pub(super) inbox: &'a Arc<Inbox>,
    pub(super) sessions: &'a [(Origin, Session)],
    pub(super) keys: &'a Keys,
}

/// Serves all publishers until the link stops.
pub(super) fn run(context: &PublishContext<'_>) {
    let mut publications = Publications::default();
    while !context.inbox.is_stopping() {
        let fresh = context.inbox.take_fresh();
        if let Some(demands) = context.inbox.take_demands() {
            publications.update(&demands, context);
        }
        match publications.serve(context.subject, fresh) {
            Some(due) => std::thread::park_timeout(due.saturating_duration_since(Instant::now())),
            None => std::thread::park(),
        }
    }
}

/// All publications.
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
    /// Opens and closes publications, so that each demand has one.
    fn update(&mut self, demands: &BTreeMap<Demand, u64>, context: &PublishContext<'_>) {
        self.publications.retain(|demand, _| demands.contains_key(demand));
        self.index.update(context.subject.board());
        for (demand, last_arrival) in demands {
            if let Some((served, publication)) = self.publications.get_mut(demand) {
                if *served != *last_arrival {
                    *served = *last_arrival;
                    publication.resend();
                }
            } else if let Some(publication) = self.index.open(demand, context) {
                self.publications
                    .insert(demand.clone(), (*last_arrival, publication));
            }
        }
    }

    /// Sends what is due; returns when the next is due.
    fn serve(&mut self, subject: &dyn Subject, fresh: bool) -> Option<Instant> {
        let now = Instant::now();
        let publications = self.publications.values_mut();
        publications
            .filter_map(|(_, publication)| match publication {
                Publication::Values(publisher) => publisher.serve(subject, now, fresh),
                Publication::Panel(publisher) => publisher.serve(subject, now, fresh),
            })
            .min()
    }
}

impl Publication {
    /// Sends the newest at once, whatever its age, for a client that joined late.
    fn resend(&mut self) {
        match self {
            Self::Values(publisher) => publisher.resend(),
            Self::Panel(publisher) => publisher.resend(),
        }
    }
}

impl PublicationIndex {
    /// Adds variables declared since the last call.
    fn update(&mut self, board: &Board) {
        for variable in board.list().skip(self.variables.len()) {
            let declared = variable.describe();
            let path = keys::variable_path(&declared.owner, &declared.name);
            self.variables.insert(path, variable);
        }
    }

    /// Opens a publication of an existing variable or panel.
    fn open(&mut self, demand: &Demand, context: &PublishContext<'_>) -> Option<Publication> {
        match &demand.target {
            TokenTarget::Variable(path) => {
                let variable = self.variables.get(path)?;
                ValuePublisher::open(demand, variable, context).map(Publication::Values)
            }
            TokenTarget::Panel(path) => {
                let panels = self.panels.get_or_insert_with(|| panels(context.subject));
                let schema = panels.get(path)?;
                PanelPublisher::open(demand, schema, context).map(Publication::Panel)
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

/// The least time between two messages of a publication; `None` if there is no limit.
pub(super) fn period(demand: &Demand) -> Option<Duration> {
    demand.rate.period_ns().map(Duration::from_nanos)
}
