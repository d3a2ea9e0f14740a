//! The subject that clients inspect and control: a running application, or a recording that is replayed.
//! Tools see both alike.

use std::sync::Arc;

use jde_app::{Application, Executor, RemoteVariable};
use jde_board::value::Value;
use jde_board::{Board, Nanos, Variable};
use jde_panel::PanelFrame;
use jde_records::reload::ReloadReport;
use jde_records::snapshot::Snapshot;

use crate::message::{Action, Range, Refusal, Request, Schemas};

/// The subject of a link. Called only from threads of the link, at bounded rates.
pub trait Subject: Send + Sync + 'static {
    /// The description of the subject.
    fn info(&self) -> SubjectInfo;
    /// The schemas and groups.
    fn schemas(&self) -> Schemas;
    /// The variables.
    fn board(&self) -> &Board;
    /// Whether a modulation is read only at the awakening of its schema.
    fn is_fixed(&self, variable: &Variable) -> bool {
        let _ = variable;
        false
    }
    /// What the application's file states of a modulation, or else the default of its type; `None` of other variables.
    fn stated(&self, variable: &Variable) -> Option<Value> {
        let _ = variable;
        None
    }
    /// The allowed values of a variable.
    fn range(&self, variable: &Variable) -> Range {
        (&variable.describe().limits).into()
    }
    /// The name of a writer of variables; empty for none.
    fn writer(&self, number: u32) -> String;
    /// Time since the subject's start, ns.
    fn now(&self) -> Nanos;
    /// The state of every schema and group.
    fn snapshot(&self) -> Snapshot;
    /// Carries out an operator's action (R14). The link manages leases.
    ///
    /// # Errors
    /// The reason for a refusal.
    fn act(&self, by: &str, action: &Action) -> Result<(), Refusal>;
    /// Carries out a request, under its lease if it has one: then a [`Action::LetGo`] ends what that lease holds. Returns
    /// in words what awake schemas lose by it; empty if nothing.
    ///
    /// # Errors
    /// The reason for a refusal.
    fn operate(&self, request: &Request) -> Result<String, Refusal> {
        self.act(&request.by, &request.action)?;
        Ok(String::new())
    }
    /// Carries out an [`Action::Reload`]. It waits for schemas, so it runs on a thread of its own.
    ///
    /// # Errors
    /// The reason why nothing was reloaded.
    fn reload(&self, by: &str, action: &Action) -> Result<ReloadReport, Refusal> {
        self.act(by, action)?;
        Err(Refusal::new("this application cannot reload plugins"))
    }
    /// Has the panel of a schema drawn at most `rate` times a second until the result is dropped. `on_drawn`
    /// is called after each drawing and must return at once.
    /// [`SchemaInfo::panel`](crate::message::SchemaInfo::panel) shows which schemas have a panel.
    ///
    /// # Errors
    /// The reason for a refusal.
    fn view_panel(
        &self,
        schema: &str,
        rate: f64,
        on_drawn: OnDrawn,
    ) -> Result<Box<dyn PanelViewer>, Refusal> {
        let _ = (rate, on_drawn);
        Err(no_panel(schema))
    }
    /// The imports from other applications.
    fn imports(&self) -> &[RemoteVariable] {
        &[]
    }
}

/// Called when a panel was drawn.
pub type OnDrawn = Arc<dyn Fn() + Send + Sync>;

/// A viewer of a panel, until dropped.
pub trait PanelViewer: Send {
    /// The newest drawing, or the reason why there is none; `None` before the first.
    fn newest(&self) -> Option<Arc<PanelFrame>>;
}

/// Refuses a schema without a panel.
pub(crate) fn no_panel(schema: &str) -> Refusal {
    Refusal::new(format!("`{schema}` has no panel of its own"))
}

/// The description of a subject.
#[derive(Clone, Debug, PartialEq)]
pub struct SubjectInfo {
    /// The name of the application.
    pub application: String,
    /// The file that it was loaded from.
    pub file: String,
    /// `threads`, `pool`, `lockstep` or `replay`.
    pub executor: String,
    /// Seconds of application time per second of real time.
    pub speed: f64,
}

impl SubjectInfo {
    /// The description of an application that runs at this speed.
    #[must_use]
    pub fn new(application: &Application, speed: f64) -> Self {
        Self {
            application: application.name.clone(),
            file: application.path.display().to_string(),
            executor: match application.executor {
                Executor::Threads => "threads",
                Executor::Pool => "pool",
            }
            .to_owned(),
            speed,
        }
    }
}
