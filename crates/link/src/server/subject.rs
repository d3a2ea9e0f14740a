//! What is looked into and steered: a running application, or a recording that plays. Tools see both alike.

use std::sync::Arc;

use jde_abi::describe::{Kind, Port, Role};
use jde_board::{Board, Nanos, Stamp, Variable};
use jde_host::app::{Application, Executor, Remote};
use jde_host::plugin::Plugins;
use jde_host::reload::{How, Reloaded, Reloader};
use jde_host::snapshot::Snapshot;
use jde_host::{Drawn, Handle, Look, Operating, period};

use super::described::schemas;
use crate::message::{Action, Range, Refusal, Schemas};
use crate::value;

/// What is looked into and steered. Called from threads of the link only, at bounded rates.
pub trait Subject: Send + Sync + 'static {
    /// What it is.
    fn title(&self) -> Title;
    /// Its schemas and groups.
    fn schemas(&self) -> Schemas;
    /// Its variables.
    fn board(&self) -> &Board;
    /// Whether a modulation is taken on awakening alone.
    fn is_fixed(&self, variable: &Variable) -> bool {
        let _ = variable;
        false
    }
    /// What a variable takes.
    fn range(&self, variable: &Variable) -> Range {
        (&variable.describe().limits).into()
    }
    /// Who a writer of variables is; empty for nobody.
    fn writer(&self, number: u32) -> String;
    /// ns since its start.
    fn now(&self) -> Nanos;
    /// What every schema and group is doing.
    fn snapshot(&self) -> Snapshot;
    /// Carries out what an operator wants (R14); leases are the link's business.
    ///
    /// # Errors
    /// Why not.
    fn act(&self, by: &str, action: &Action) -> Result<(), Refusal>;
    /// Carries out an [`Action::Reload`]: it waits for turns of schemas, on a thread of its own.
    ///
    /// # Errors
    /// Why nothing was reloaded.
    fn reload(&self, by: &str, action: &Action) -> Result<Reloaded, Refusal> {
        self.act(by, action)?;
        Err(Refusal::new("nothing here can be reloaded"))
    }
    /// Has the panel of a schema be drawn, at most so often a second, until the answer is dropped; `news` is called after each
    /// drawing, and must return at once. [`SchemaInfo::panel`](crate::message::SchemaInfo::panel) says which schemas have one.
    ///
    /// # Errors
    /// Why not.
    fn look(&self, schema: &str, rate: f64, news: News) -> Result<Box<dyn Looking>, Refusal> {
        let _ = (rate, news);
        Err(no_panel(schema))
    }
    /// What it imports from other applications.
    fn imports(&self) -> &[Remote] {
        &[]
    }
}

/// Is called when a panel was drawn.
pub type News = Arc<dyn Fn() + Send + Sync>;

/// Somebody who looks at a panel, until it is dropped.
pub trait Looking: Send {
    /// What it shows now, or why it shows nothing; none before it was drawn.
    fn newest(&self) -> Option<Arc<Drawn>>;
}

/// That a schema has no panel.
pub(crate) fn no_panel(schema: &str) -> Refusal {
    Refusal::new(format!("`{schema}` has no panel of its own"))
}

/// What a subject is.
#[derive(Clone, Debug, PartialEq)]
pub struct Title {
    /// The name of the application.
    pub application: String,
    /// The file it was read from.
    pub file: String,
    /// `threads`, `pool`, `lockstep` or `replay`.
    pub executor: String,
    /// Seconds of the application in a second of the machine.
    pub speed: f64,
}

impl Title {
    /// Of an application at a speed.
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

/// A running application as a subject.
pub struct Running {
    handle: Handle,
    title: Title,
    reloader: Option<Reloader>,
}

impl Running {
    /// Of a handle; the title says how it runs.
    #[must_use]
    pub fn new(handle: Handle, title: Title) -> Self {
        Self {
            handle,
            title,
            reloader: None,
        }
    }

    /// The same, whose schemas can be reloaded from the files of these plugins: those that the application was checked against.
    #[must_use]
    pub fn reloading(self, plugins: Arc<Plugins>) -> Self {
        let reloader = Some(Reloader::new(self.handle.clone(), plugins));
        Self { reloader, ..self }
    }

    fn place(&self, schema: &str) -> Result<usize, Refusal> {
        let application = self.handle.application();
        application.instance(schema).ok_or_else(|| {
            let names = application
                .instances
                .iter()
                .map(|instance| instance.name.as_str());
            Refusal::unknown("schema", schema, names)
        })
    }
}

impl Subject for Running {
    fn title(&self) -> Title {
        self.title.clone()
    }

    fn schemas(&self) -> Schemas {
        let mut schemas = schemas(self.handle.application());
        for place in self.handle.panels() {
            schemas.schemas[place].panel = true;
        }
        schemas
    }

    fn board(&self) -> &Board {
        self.handle.board()
    }

    fn is_fixed(&self, variable: &Variable) -> bool {
        let declared = variable.describe();
        let application = self.handle.application();
        let ports = application
            .instance(&declared.owner)
            .map(|place| &application.instances[place].schema.ports);
        ports.is_some_and(|ports| {
            let fixed = |port: &&Port| matches!(port.role, Role::Modulation { fixed: true, .. });
            ports.iter().filter(fixed).any(|port| port.name == declared.name)
        })
    }

    fn writer(&self, number: u32) -> String {
        let application = self.handle.application();
        match application.instances.get(number as usize) {
            Some(instance) => instance.name.clone(),
            None if number == Stamp::NOBODY => String::new(),
            None if number == Remote::WRITER => "another application".to_owned(),
            None => "operator".to_owned(),
        }
    }

    fn now(&self) -> Nanos {
        self.handle.now()
    }

    fn snapshot(&self) -> Snapshot {
        self.handle.snapshot()
    }

    fn imports(&self) -> &[Remote] {
        &self.handle.application().remotes
    }

    fn look(&self, schema: &str, rate: f64, news: News) -> Result<Box<dyn Looking>, Refusal> {
        let schema = self.place(schema)?;
        let look = self
            .handle
            .look(schema, rate, move || news())
            .map_err(|refusal| Refusal::new(refusal.to_string()))?;
        Ok(Box::new(Watched {
            handle: self.handle.clone(),
            schema,
            _look: look,
        }))
    }

    fn reload(&self, by: &str, action: &Action) -> Result<Reloaded, Refusal> {
        let Action::Reload {
            schema,
            probation_s,
            fresh,
        } = action
        else {
            return Err(Refusal::new("this is no reload"));
        };
        let reloader = self
            .reloader
            .as_ref()
            .ok_or_else(|| Refusal::new("this application does not know the files of its plugins"))?;
        let mut how = How {
            fresh: *fresh,
            ..How::default()
        };
        if let Some(seconds) = probation_s {
            if !(0.0..=LONGEST_PROBATION).contains(seconds) {
                return Err(Refusal::new(format!(
                    "a probation of {seconds} s is not given; ask for 0 to {LONGEST_PROBATION}"
                )));
            }
            how.probation = (seconds * 1e9) as Nanos;
        }
        reloader.reload(by, schema, how).map_err(|refused| Refusal {
            nearest: refused.nearest().map(str::to_owned),
            error: refused.to_string(),
        })
    }

    fn act(&self, by: &str, action: &Action) -> Result<(), Refusal> {
        match action {
            Action::Reload { .. } => return self.reload(by, action).map(drop),
            Action::Unload { schema } | Action::Load { schema } => {
                let of_plugin = self.handle.places(schema);
                if of_plugin.len() > 1 {
                    return self.act_on_all(by, action, of_plugin);
                }
            }
            _ => {}
        }
        let operator = self.handle.operator(by);
        let schema = || self.place(action.schema());
        match action {
            Action::StopAll => operator.stop_all(),
            Action::ReleaseAll => operator.release_all(),
            Action::Play { .. } => operator.play(schema()?),
            Action::Stop { .. } => operator.hold_asleep(schema()?),
            Action::Force { .. } => operator.force(schema()?),
            Action::Release { .. } => operator.release(schema()?),
            Action::LetGo { .. } => operator.let_go(schema()?),
            Action::Period { period_s, .. } => match period::of_seconds(*period_s) {
                Ok(period) => operator.set_period(schema()?, period),
                Err(error) => Err(error.to_string()),
            },
            Action::Modulate {
                schema: owner,
                variable,
                value,
            } => return self.modulate(&operator, schema()?, owner, variable, value),
            Action::Unload { .. } => operator.unload(schema()?),
            Action::Load { .. } => operator.load(schema()?),
            Action::Reload { .. } => unreachable!("it was carried out above"),
            Action::Touch { gesture, .. } => self
                .handle
                .touch(by, schema()?, gesture.clone())
                .map_err(|refusal| refusal.to_string()),
            Action::Renew { .. } => schema().map(drop).map_err(|refusal| refusal.error),
        }
        .map_err(Refusal::new)
    }
}

/// What an operator does to one schema.
type Act = fn(&Operating, usize) -> Result<(), String>;

/// The longest trial of a new build, s: an hour.
const LONGEST_PROBATION: f64 = 3600.0;

/// The panel of a running schema.
struct Watched {
    handle: Handle,
    schema: usize,
    _look: Look,
}

impl Looking for Watched {
    fn newest(&self) -> Option<Arc<Drawn>> {
        self.handle.panel(self.schema)
    }
}

impl Running {
    /// Unloads or loads all schemas of a plugin: those that act before those that they need, and the other way round. If one is
    /// refused, the others are as before.
    fn act_on_all(&self, by: &str, action: &Action, mut schemas: Vec<usize>) -> Result<(), Refusal> {
        let operator = self.handle.operator(by);
        let unloads = matches!(action, Action::Unload { .. });
        let (act, undo): (Act, Act) = if unloads {
            (Operating::unload, Operating::load)
        } else {
            (Operating::load, Operating::unload)
        };
        let instances = &self.handle.application().instances;
        let rank = |schema: &usize| match instances[*schema].schema.kind {
            Kind::Motor => 0,
            Kind::Perceptive => 1,
            Kind::Driver => 2,
        };
        schemas.sort_by_key(rank);
        if !unloads {
            schemas.reverse();
        }
        for (place, schema) in schemas.iter().enumerate() {
            if let Err(reason) = act(&operator, *schema) {
                for done in schemas[..place].iter().rev() {
                    // What was done a moment ago can be undone, unless it has not come to rest yet; then it stands and is shown.
                    let _ = undo(&operator, *done);
                }
                return Err(Refusal::new(reason));
            }
        }
        Ok(())
    }

    /// Finds who means that variable, and what it is to be.
    fn modulate(
        &self,
        operator: &jde_host::Operating,
        schema: usize,
        owner: &str,
        variable: &str,
        json: &serde_json::Value,
    ) -> Result<(), Refusal> {
        let full = format!("{owner}.{variable}");
        if self.board().find(&full).is_none() {
            let known: Vec<_> = self
                .board()
                .list()
                .filter(|variable| variable.describe().owner == owner)
                .map(|variable| variable.describe().name.clone())
                .collect();
            let mut refusal = Refusal::unknown("modulation", variable, known.iter().map(String::as_str));
            refusal.error = format!("`{owner}` has no modulation `{variable}`");
            return Err(refusal);
        }
        let new = value::from_json(json).map_err(|error| Refusal::new(format!("`{full}`: {error}")))?;
        operator.modulate(schema, variable, &new).map_err(Refusal::new)
    }
}
