//! From the names of an application to cells and ports: declares every variable on the board, and binds every
//! port to one.

use std::collections::BTreeMap;
use std::sync::Arc;

use jde_abi::describe::{Limits, Role};
use jde_abi::raw;
use jde_app::{Application, Binding, ChildTarget, ImportSource, InstanceConfig, InstancePort, period};
use jde_board::{Access, Board, Declaration, Error, LASTING, Variable, Watch};
use jde_core::{Nanos, SchemaId, Table};
use jde_loader::AlignedBytes;
use jde_types::Value;

use super::guard_wiring::{command_limits, guard_states, guarding, guards_of_command};
use super::rules::{Command, Commands};
use super::{Engine, Notifier, Signal};
use crate::instance::{
    AuthorityEnd, BoundPort, Chunks, ExportFaults, GuardState, MAX_INLINE_BYTES, PortGuard, Ports,
};

/// Simultaneous latches that a variable allows beyond its importers: for tools and the host itself.
const SPARE_READERS: usize = 8;
/// Writers that a modulation or command allows beyond the schemas bound to it: the operator's tools and the
/// host.
const SPARE_WRITERS: usize = 2;

/// The variables of every instance.
pub(crate) struct Variables {
    ports: Table<SchemaId, Vec<Option<Arc<Variable>>>>,
    periods: Table<SchemaId, Arc<Variable>>,
    remotes: Vec<Arc<Variable>>,
    faults: Table<SchemaId, Arc<ExportFaults>>,
    authority_ends: Table<SchemaId, Arc<AuthorityEnd>>,
    /// The exports whose values expire.
    expiring: Vec<Arc<Variable>>,
    /// The shortest validity of them, ns.
    shortest_validity: Nanos,
}

impl Variables {
    /// The variable of an instance's own export, modulation or command.
    pub(crate) fn of(&self, port: InstancePort) -> Option<&Arc<Variable>> {
        self.ports[port.instance].get(port.port)?.as_ref()
    }

    /// Ends the values of the exports of an instance that expire, because it sleeps (R19). Returns those whose readers
    /// lost a value, to be reported outside of the rules' lock.
    pub(crate) fn close_exports(&self, instance: SchemaId) -> impl Iterator<Item = Arc<Variable>> {
        let own = self.ports[instance].iter().flatten();
        own.filter(|variable| variable.close()).cloned()
    }

    /// Shows what an instance exports from now on, because it awakes.
    pub(crate) fn open_exports(&self, instance: SchemaId) {
        self.ports[instance]
            .iter()
            .flatten()
            .for_each(|variable| variable.open());
    }

    /// Ends the values of which the validity is over, and lets their readers know. Returns when the next one is over.
    pub(crate) fn expire(&self, now: Nanos) -> Option<Nanos> {
        self.expiring
            .iter()
            .filter_map(|variable| variable.expire(now))
            .min()
    }

    /// Returns when the value is over that ends next.
    pub(crate) fn next_end(&self) -> Option<Nanos> {
        let lasts = self
            .expiring
            .iter()
            .filter_map(|variable| variable.last_instant());
        lasts.min().map(|last| last.saturating_add(1))
    }

    /// The shortest validity of a value, ns.
    pub(crate) fn shortest_validity(&self) -> Nanos {
        self.shortest_validity
    }

    fn find_expiring(&mut self) {
        for variable in self.ports.iter().flatten().flatten().chain(&self.remotes) {
            if let Access::Export { validity } = variable.describe().access
                && validity != LASTING
            {
                self.expiring.push(Arc::clone(variable));
                self.shortest_validity = self.shortest_validity.min(validity);
            }
        }
    }

    /// Retracts the exports of an instance.
    pub(crate) fn retract_exports(&self, instance: SchemaId) {
        self.ports[instance]
            .iter()
            .flatten()
            .for_each(|variable| variable.retract());
    }

    /// The variable that an import reads.
    pub(crate) fn source(&self, source: ImportSource) -> &Arc<Variable> {
        match source {
            ImportSource::Local(port) => self.of(port).expect("imports are bound to variables"),
            ImportSource::Remote(remote) => &self.remotes[remote],
        }
    }

    /// The newest published period of an instance, ns; it counts from the next iteration. `None` if it is not
    /// valid: an invalid period from a father leaves the period as it was.
    pub(crate) fn newest_period(&self, instance: SchemaId) -> Option<Nanos> {
        let seconds = self.periods[instance]
            .reader("host")
            .latch(0)?
            .bytes
            .try_into()
            .ok()?;
        period::from_seconds(f64::from_ne_bytes(seconds)).ok()
    }

    /// The exports of an instance that fail.
    pub(crate) fn faults(&self, instance: SchemaId) -> &Arc<ExportFaults> {
        &self.faults[instance]
    }

    /// When the authority of an instance ended last.
    pub(crate) fn authority_end(&self, instance: SchemaId) -> &Arc<AuthorityEnd> {
        &self.authority_ends[instance]
    }

    /// The period of an instance, seconds.
    pub(crate) fn period(&self, instance: SchemaId) -> &Arc<Variable> {
        &self.periods[instance]
    }
}

/// Declares all variables, then creates all ports.
pub(super) fn wire(
    application: &Application,
    board: &Board,
) -> Result<(Variables, Table<SchemaId, Ports>, Commands), Error> {
    let uses = Uses::count(application);
    let mut variables = Variables {
        ports: Table::default(),
        periods: Table::default(),
        remotes: Vec::new(),
        faults: application.instances.map_ids(|_| Arc::default()),
        authority_ends: application.instances.map_ids(|_| Arc::default()),
        expiring: Vec::new(),
        shortest_validity: LASTING,
    };
    for (number, instance) in application.instances.entries() {
        let mut own = Vec::new();
        for (place, port) in instance.schema.ports.iter().enumerate() {
            let usage = &uses.ports[number][place];
            let (access, initial, writers) = match (&port.role, &instance.bindings[place]) {
                (Role::Export { .. }, _) => {
                    let validity = instance.validity_ns(place);
                    (Access::Export { validity }, None, 1)
                }
                (Role::Modulation { .. }, Binding::Modulation { initial, .. }) => (
                    Access::Modulation,
                    Some(initial.clone()),
                    usage.writers + SPARE_WRITERS,
                ),
                (Role::Command { validity_ns, neutral }, _) => (
                    Access::Command {
                        validity: *validity_ns,
                    },
                    Some(neutral.clone()),
                    usage.writers + SPARE_WRITERS,
                ),
                _ => {
                    own.push(None);
                    continue;
                }
            };
            let declare = if usage.is_isolated && port.value_type.bytes > MAX_INLINE_BYTES {
                Board::declare_shared
            } else {
                Board::declare
            };
            let declared = declare(
                board,
                Declaration {
                    owner: instance.name.clone(),
                    name: port.name.clone(),
                    doc: port.doc.clone(),
                    unit: port.unit.clone(),
                    value_type: Arc::clone(&port.value_type),
                    access,
                    limits: match &port.role {
                        Role::Modulation { limits, .. } => limits.clone(),
                        _ => Limits::default(),
                    },
                    initial,
                    writers,
                    readers: usage.readers + SPARE_READERS,
                },
            );
            own.push(Some(declared?));
        }
        variables.ports.push(own);
        variables.periods.push(board.declare(Declaration {
            owner: instance.name.clone(),
            name: String::from("period"),
            doc: String::from("Time from one iteration to the next; takes effect at the next."),
            unit: String::from("s"),
            value_type: Arc::new(f64::describe()),
            access: Access::Modulation,
            limits: Limits {
                least: Some(period::SHORTEST as f64 / 1e9),
                greatest: Some(period::LONGEST as f64 / 1e9),
                ..Limits::default()
            },
            initial: Some((instance.period_ns as f64 / 1e9).to_ne_bytes().to_vec()),
            writers: uses.period_writers[number] + SPARE_WRITERS,
            readers: SPARE_READERS,
        })?);
    }
    for (remote, usage) in application.remotes.iter().zip(&uses.remotes) {
        let (owner, name) = remote.parts();
        let declare = if usage.is_isolated && remote.value_type.bytes > MAX_INLINE_BYTES {
            Board::declare_shared
        } else {
            Board::declare
        };
        let declared = declare(
            board,
            Declaration {
                owner: owner.to_owned(),
                name: name.to_owned(),
                doc: format!("`{}` of the application `{}`.", remote.variable, remote.peer),
                unit: remote.unit.clone(),
                value_type: Arc::clone(&remote.value_type),
                access: Access::Export {
                    validity: remote.stale_ns,
                },
                limits: Limits::default(),
                initial: None,
                writers: 1,
                readers: usage.readers + SPARE_READERS,
            },
        );
        variables.remotes.push(declared?);
    }
    variables.find_expiring();
    let states = guard_states(application, &variables);
    let ports = application.instances.ids();
    let ports = ports
        .map(|instance| ports_of(application, &variables, &states, instance))
        .collect::<Result<_, _>>()?;
    let commands = commands(application, &variables);
    Ok((variables, ports, commands))
}

/// Signals an instance for each import and each command that triggers it (R12), and for its period.
pub(super) fn watch_triggers(engine: &Engine, notifier: &Arc<dyn Notifier>) -> Vec<Watch> {
    let mut watches = Vec::new();
    for (number, instance) in engine.application.instances.entries() {
        let notify = |signal: fn() -> Signal| {
            let notifier = Arc::downgrade(notifier);
            move || {
                if let Some(notifier) = notifier.upgrade() {
                    let signal = signal();
                    if notifier.post(number, signal) {
                        notifier.notify(number);
                    }
                }
            }
        };
        for binding in &instance.bindings {
            if let Binding::Import {
                source: Some(source),
                trigger,
                ..
            } = binding
            {
                let variable = engine.variables.source(*source);
                // The end of a value triggers every reader (R19).
                watches.push(if *trigger {
                    variable.watch(notify(|| Signal::Triggered))
                } else {
                    variable.watch_end(notify(|| Signal::Triggered))
                });
            }
        }
        for (place, port) in instance.schema.ports.iter().enumerate() {
            if matches!(port.role, Role::Command { .. })
                && port.has(raw::TRIGGER)
                && let Some(variable) = engine.variables.of(InstancePort::new(number, place))
            {
                watches.push(variable.watch(notify(|| Signal::Triggered)));
            }
        }
        let period = engine.variables.period(number);
        watches.push(period.watch(notify(|| Signal::PeriodChanged)));
    }
    watches
}

fn ports_of(
    application: &Application,
    variables: &Variables,
    states: &BTreeMap<SchemaId, Arc<GuardState>>,
    number: SchemaId,
) -> Result<Ports, Error> {
    let instance = &application.instances[number];
    let id = number.0;
    let variable = |port| variables.of(port).expect("bindings name variables");
    let own = |port| InstancePort::new(number, port);
    let foreign = |variable: &Arc<Variable>, guards: Arc<[PortGuard]>| -> Result<BoundPort, Error> {
        Ok(BoundPort::ForeignOutput {
            writer: variable.writer(id, &instance.name)?,
            refused: None,
            guards,
            limits: None,
            limited_at: None,
        })
    };
    let guard = |guard: SchemaId, commanders: Vec<u32>| PortGuard::new(guard, &states[&guard], commanders);
    let mut ports = Vec::new();
    for (place, binding) in instance.bindings.iter().enumerate() {
        ports.push(match binding {
            Binding::Import { source: None, .. }
            | Binding::Actuator { target: None }
            | Binding::ChildModulation { target: None } => BoundPort::Unbound,
            Binding::Import {
                source: Some(source),
                stale_ns,
                ..
            } => {
                let reader = variables.source(*source).reader(&instance.name);
                BoundPort::Input(reader.with_stale(stale_ns.unwrap_or(Nanos::MAX)))
            }
            Binding::Modulation { .. } => {
                let reader = variable(own(place)).reader(&instance.name);
                match instance.schema.ports[place].has(raw::FIXED) {
                    true => BoundPort::Fixed(reader),
                    false => BoundPort::Input(reader),
                }
            }
            Binding::Command => {
                let Role::Command { neutral, .. } = &instance.schema.ports[place].role else {
                    unreachable!("a command is bound as one")
                };
                let reader = variable(own(place)).reader(&instance.name);
                BoundPort::Command {
                    reader,
                    neutral: AlignedBytes::new(neutral),
                    in_force: None,
                    driver: id,
                    guards: guards_of_command(application, own(place))
                        .map(|(number, commanders)| guard(number, commanders))
                        .collect(),
                }
            }
            Binding::Export => BoundPort::Output(variable(own(place)).writer(id, &instance.name)?),
            Binding::Actuator { target: Some(target) } => {
                let guards = application.guards(number, *target).into_iter();
                let mut port = foreign(
                    variable(*target),
                    guards.map(|number| guard(number, vec![id])).collect(),
                )?;
                if let BoundPort::ForeignOutput { limits, .. } = &mut port {
                    *limits = command_limits(application, *target).map(Arc::new);
                }
                port
            }
            Binding::ChildModulation {
                target: Some(ChildTarget::Port(port)),
            } => foreign(variable(*port), Arc::default())?,
            Binding::ChildModulation {
                target: Some(ChildTarget::Period(child)),
            } => foreign(variables.period(*child), Arc::default())?,
        });
    }
    let mut ports = Ports::new(ports, Arc::clone(variables.faults(number)));
    ports.chunks = Chunks::of(&instance.schema, variables.authority_end(number));
    let odometry = application.odometry_of(number).map(variable);
    for (place, port) in instance.schema.ports.iter().enumerate() {
        if matches!(port.role, Role::Export { .. }) {
            // What plays a recording takes commands, too, and does not follow them.
            let commands = instance.bindings.iter().enumerate();
            let commands = commands
                .map(|(command, binding)| (own(command), binding))
                .filter(|(command, binding)| {
                    matches!(binding, Binding::Command) && command_limits(application, *command).is_some()
                })
                .map(|(command, _)| variable(command));
            ports
                .measurements
                .add(place, variable(own(place)), odometry, commands);
        }
    }
    if let Some(state) = states.get(&number) {
        ports.guard(guarding(application, variables, number, state));
    }
    Ok(ports)
}

fn commands(application: &Application, variables: &Variables) -> Commands {
    let mut commands = Vec::new();
    for (driver, instance) in application.instances.entries() {
        for (place, port) in instance.schema.ports.iter().enumerate() {
            let Role::Command { neutral, .. } = &port.role else {
                continue;
            };
            let command = InstancePort::new(driver, place);
            let variable = Arc::clone(variables.of(command).expect("commands are variables"));
            let target = Binding::Actuator {
                target: Some(command),
            };
            let commanders = application.instances.entries();
            commands.push(Command {
                driver,
                newest: variable.reader("host"),
                variable,
                neutral: neutral.clone(),
                held_sequence: 0,
                holders: Vec::new(),
                commanders: commanders
                    .filter(|(_, other)| other.bindings.contains(&target))
                    .map(|(i, _)| i)
                    .collect(),
            });
        }
    }
    Commands::new(commands)
}

/// How many read and write a variable, and whether one of them has a process of its own.
#[derive(Clone, Default)]
struct Usage {
    readers: usize,
    writers: usize,
    is_isolated: bool,
}

/// The use of each variable.
struct Uses {
    ports: Table<SchemaId, Vec<Usage>>,
    period_writers: Table<SchemaId, usize>,
    remotes: Vec<Usage>,
}

impl Uses {
    fn count(application: &Application) -> Self {
        let unused = |instance: &InstanceConfig| {
            let usage = Usage {
                is_isolated: instance.isolate.is_some(),
                ..Usage::default()
            };
            vec![usage; instance.bindings.len()]
        };
        let mut uses = Self {
            ports: application.instances.iter().map(unused).collect(),
            period_writers: application.instances.map_ids(|_| 0),
            remotes: vec![Usage::default(); application.remotes.len()],
        };
        for (number, instance) in application.instances.entries() {
            let is_isolated = instance.isolate.is_some();
            for (place, binding) in instance.bindings.iter().enumerate() {
                match binding {
                    Binding::Import {
                        source: Some(source), ..
                    } => {
                        let usage = match *source {
                            ImportSource::Local(port) => &mut uses.ports[port.instance][port.port],
                            ImportSource::Remote(remote) => &mut uses.remotes[remote],
                        };
                        usage.readers += 1;
                        usage.is_isolated |= is_isolated;
                    }
                    Binding::Modulation { .. } | Binding::Command => uses.ports[number][place].readers += 1,
                    Binding::Actuator { target: Some(port) }
                    | Binding::ChildModulation {
                        target: Some(ChildTarget::Port(port)),
                    } => {
                        let usage = &mut uses.ports[port.instance][port.port];
                        usage.writers += 1;
                        usage.is_isolated |= is_isolated;
                    }
                    Binding::ChildModulation {
                        target: Some(ChildTarget::Period(child)),
                    } => uses.period_writers[*child] += 1,
                    Binding::Import { source: None, .. }
                    | Binding::Export
                    | Binding::Actuator { target: None }
                    | Binding::ChildModulation { target: None } => {}
                }
            }
        }
        uses
    }
}
