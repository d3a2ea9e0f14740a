//! A running application as the subject of a link. `jde-link` itself has no runtime: its clients need none, and a
//! recording that is replayed is a subject too.

use std::sync::Arc;

use jde_abi::describe::{Kind, Port};
use jde_abi::raw;
use jde_app::{Binding, RemoteVariable, period};
use jde_board::value::{Value, decode};
use jde_board::{Board, Nanos, Stamp, Variable};
use jde_core::{Id, SchemaId};
use jde_host::reload::{ReloadOptions, Reloader};
use jde_host::{Handle, OperatorHandle, PanelViewGuard};
use jde_link::message::{Action, Refusal, Request, Schemas};
use jde_link::{OnDrawn, PanelViewer, Subject, SubjectInfo, schemas, value};
use jde_loader::Plugins;
use jde_panel::PanelFrame;
use jde_records::reload::ReloadReport;
use jde_records::snapshot::Snapshot;

/// The variable of a schema's period.
const PERIOD: &str = "period";

/// A running application as a subject.
pub struct Running {
    handle: Handle,
    info: SubjectInfo,
    reloader: Option<Reloader>,
}

impl Running {
    /// Creates the subject from a handle and the description of the application.
    #[must_use]
    pub fn new(handle: Handle, info: SubjectInfo) -> Self {
        Self {
            handle,
            info,
            reloader: None,
        }
    }

    /// Allows reloads from the files of these plugins. The application was checked against them.
    #[must_use]
    pub fn reloading(self, plugins: Arc<Plugins>) -> Self {
        let reloader = Some(Reloader::new(self.handle.clone(), plugins));
        Self { reloader, ..self }
    }

    fn find(&self, schema: &str) -> Result<SchemaId, Refusal> {
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
    fn info(&self) -> SubjectInfo {
        self.info.clone()
    }

    fn schemas(&self) -> Schemas {
        let mut schemas = schemas(self.handle.application());
        for schema in self.handle.panels() {
            schemas.schemas[schema.index()].panel = true;
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
            .map(|instance| &application.instances[instance].schema.ports);
        ports.is_some_and(|ports| {
            let fixed = |port: &&Port| port.has(raw::FIXED);
            ports.iter().filter(fixed).any(|port| port.name == declared.name)
        })
    }

    fn stated(&self, variable: &Variable) -> Option<Value> {
        let declared = variable.describe();
        let application = self.handle.application();
        let instance = &application.instances[application.instance(&declared.owner)?];
        let mut ports = instance.schema.ports.iter().zip(&instance.bindings);
        match ports.find(|(port, _)| port.name == declared.name) {
            Some((port, Binding::Modulation { stated, .. })) => Some(decode(&port.value_type, stated)),
            Some(_) => None,
            None if declared.name == PERIOD => Some(Value::Float(instance.stated_period_ns as f64 / 1e9)),
            None => None,
        }
    }

    fn writer(&self, number: u32) -> String {
        let application = self.handle.application();
        match application.instances.get(SchemaId(number)) {
            Some(instance) => instance.name.clone(),
            None if number == Stamp::NO_WRITER => String::new(),
            None if number == RemoteVariable::WRITER => "another application".to_owned(),
            None => "operator".to_owned(),
        }
    }

    fn now(&self) -> Nanos {
        self.handle.now()
    }

    fn snapshot(&self) -> Snapshot {
        self.handle.snapshot()
    }

    fn imports(&self) -> &[RemoteVariable] {
        &self.handle.application().remotes
    }

    fn view_panel(
        &self,
        schema: &str,
        rate: f64,
        on_drawn: OnDrawn,
    ) -> Result<Box<dyn PanelViewer>, Refusal> {
        let schema = self.find(schema)?;
        let view = self
            .handle
            .view_panel(schema, rate, move || on_drawn())
            .map_err(|refusal| Refusal::new(refusal.to_string()))?;
        Ok(Box::new(PanelView {
            handle: self.handle.clone(),
            schema,
            _view: view,
        }))
    }

    fn reload(&self, by: &str, action: &Action) -> Result<ReloadReport, Refusal> {
        let Action::Reload {
            schema,
            probation_s,
            fresh,
        } = action
        else {
            return Err(Refusal::new("the action is not a reload"));
        };
        let reloader = self
            .reloader
            .as_ref()
            .ok_or_else(|| Refusal::new("this application does not know the files of its plugins"))?;
        let mut options = ReloadOptions {
            fresh: *fresh,
            ..ReloadOptions::default()
        };
        if let Some(seconds) = probation_s {
            if !(0.0..=MAX_PROBATION_S).contains(seconds) {
                return Err(Refusal::new(format!(
                    "a probation of {seconds} s is not possible; request 0 to {MAX_PROBATION_S} s"
                )));
            }
            options.probation = (seconds * 1e9) as Nanos;
        }
        reloader.reload(by, schema, options).map_err(|refusal| Refusal {
            nearest: refusal.nearest().map(str::to_owned),
            error: refusal.to_string(),
        })
    }

    fn act(&self, by: &str, action: &Action) -> Result<(), Refusal> {
        self.act_as(&self.handle.operator(by), action).map(drop)
    }

    fn operate(&self, request: &Request) -> Result<String, Refusal> {
        let operator = self.handle.operator(&request.by);
        match request.lease_ms {
            Some(_) => self.act_as(&operator.under_lease(), &request.action),
            None => self.act_as(&operator, &request.action),
        }
    }
}

/// An action on one schema. Returns what awake schemas lose by it.
type SchemaAction = fn(&OperatorHandle, SchemaId) -> Result<String, String>;

/// The longest probation of a new build, s: an hour.
const MAX_PROBATION_S: f64 = 3600.0;

/// The panel of a running schema.
struct PanelView {
    handle: Handle,
    schema: SchemaId,
    _view: PanelViewGuard,
}

impl PanelViewer for PanelView {
    fn newest(&self) -> Option<Arc<PanelFrame>> {
        self.handle.panel(self.schema)
    }
}

impl Running {
    /// Carries out an action. Returns what awake schemas lose by it, in words.
    fn act_as(&self, operator: &OperatorHandle, action: &Action) -> Result<String, Refusal> {
        match action {
            Action::Reload { .. } => {
                return self.reload(operator.name(), action).map(|_| String::new());
            }
            Action::Unload { schema } | Action::Load { schema } | Action::LetGo { schema } => {
                let schemas = self.handle.schemas_named(schema);
                if schemas.len() > 1 {
                    return self.act_on_all(operator, action, schemas);
                }
            }
            _ => {}
        }
        let schema = || self.find(action.schema());
        let done = match action {
            Action::Stop { .. } => return operator.stop(schema()?, false).map_err(Refusal::new),
            Action::Unload { .. } => return operator.stop(schema()?, true).map_err(Refusal::new),
            Action::StopAll => operator.stop_all(),
            Action::ReleaseAll => operator.release_all(),
            Action::Continue => operator.continue_time(),
            Action::Step => operator.step_time(),
            Action::Play { .. } => operator.play(schema()?),
            Action::Force { .. } => operator.force(schema()?),
            Action::Release { .. } => operator.release(schema()?),
            Action::LetGo { .. } => operator.release_own(schema()?),
            Action::Period { period_s, .. } => match period::from_seconds(*period_s) {
                Ok(period) => operator.set_period(schema()?, period),
                Err(error) => Err(error.to_string()),
            },
            Action::Modulate {
                schema: owner,
                variable,
                value,
            } => {
                let modulated = self.modulate(operator, schema()?, owner, variable, value);
                return modulated.map(|()| String::new());
            }
            Action::Load { .. } => operator.load(schema()?),
            Action::Reload { .. } => unreachable!("reloads are carried out above"),
            Action::Touch { gesture, .. } => self
                .handle
                .touch(operator.name(), schema()?, gesture.clone())
                .map_err(|refusal| refusal.to_string()),
            Action::Renew { .. } => schema().map(drop).map_err(|refusal| refusal.error),
        };
        done.map(|()| String::new()).map_err(Refusal::new)
    }

    /// Unloads, loads or lets go of all schemas of a plugin. Unloads motor schemas first and drivers last, since the
    /// former depend on the latter; loads in the reverse order. If one is refused, the others are restored. Returns
    /// what other schemas lose by it.
    fn act_on_all(
        &self,
        operator: &OperatorHandle,
        action: &Action,
        mut schemas: Vec<SchemaId>,
    ) -> Result<String, Refusal> {
        let unloads = matches!(action, Action::Unload { .. });
        let unload: SchemaAction = |operator, schema| operator.stop(schema, true);
        let load: SchemaAction = |operator, schema| operator.load(schema).map(|()| String::new());
        let let_go: SchemaAction = |operator, schema| operator.release_own(schema).map(|()| String::new());
        let (act, undo) = match action {
            Action::Unload { .. } => (unload, load),
            Action::Load { .. } => (load, unload),
            _ => (let_go, let_go),
        };
        let instances = &self.handle.application().instances;
        let rank = |schema: &SchemaId| match instances[*schema].schema.kind {
            Kind::Motor => 0,
            Kind::Perceptive => 1,
            Kind::Driver => 2,
        };
        schemas.sort_by_key(rank);
        if !unloads {
            schemas.reverse();
        }
        let mut losses = Vec::new();
        for (place, schema) in schemas.iter().enumerate() {
            let result = act(operator, *schema);
            if let Ok(lost) = &result {
                losses.extend((!lost.is_empty()).then(|| lost.clone()));
            }
            if let Err(reason) = result {
                for done in schemas[..place].iter().rev() {
                    // A recent action can be undone, unless the schema is not yet at rest. Then it remains,
                    // and its state shows it.
                    let _ = undo(operator, *done);
                }
                return Err(Refusal::new(reason));
            }
        }
        Ok(losses.join(", "))
    }

    /// Finds the variable and converts its new value.
    fn modulate(
        &self,
        operator: &OperatorHandle,
        schema: SchemaId,
        owner: &str,
        variable: &str,
        json: &serde_json::Value,
    ) -> Result<(), Refusal> {
        let full = format!("{owner}.{variable}");
        if self.board().find(&full).is_none() {
            let mut ports = self.handle.application().instances[schema].schema.ports.iter();
            if let Some(port) = ports.find(|port| port.former_name.as_deref() == Some(variable)) {
                let error = format!("`{variable}` of `{owner}` is called `{}` now", port.name);
                return Err(Refusal::new(error));
            }
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
