//! Observes every command to a driver: its writer, whether the writer had authority (R7), and whether the
//! command may still be in force (R9).

use std::collections::BTreeMap;
use std::sync::Arc;

use jde_abi::describe::{Kind, Role};
use jde_app::{Binding, InstanceConfig, InstancePort};
use jde_board::{Access, Reader, Variable, Watch};
use jde_core::{Nanos, SchemaId, Table};
use jde_host::Handle;
use parking_lot::Mutex;

use super::history::AuthorityStatus;
use super::{ObserverState, Tamper};
use crate::case::RunMode;

/// Longest time until a group's brake is visible under load, ns: a patience and scheduling delays.
const BRAKE_SLACK: Nanos = 250_000_000;

/// All commands of an application.
#[derive(Default)]
pub(crate) struct Commands {
    ports: BTreeMap<String, CommandPort>,
    motors: Table<SchemaId, bool>,
    issued: Vec<IssuedCommand>,
    closed: bool,
    /// Hides brakes, to test the observer.
    hides_brakes: bool,
}

/// A command of a driver.
struct CommandPort {
    neutral: Vec<u8>,
    /// The schemas bound to it.
    commanders: Vec<SchemaId>,
    newest: Option<IssuedCommand>,
    /// The time since which the newest command is in force although its schema does not hold authority and no
    /// winner commands the same.
    orphan: Option<Nanos>,
    reader: Reader,
}

#[derive(Clone, Debug)]
struct IssuedCommand {
    port: String,
    writer: SchemaId,
    sequence: u64,
    time: Nanos,
    observed_at: Nanos,
    valid_until: Nanos,
    neutral: bool,
}

impl Commands {
    /// Watches the commands of an application from the first one on.
    pub(super) fn watch(shared: &Arc<Mutex<Self>>, handle: &Handle, tamper: Option<Tamper>) -> Vec<Watch> {
        let application = handle.application();
        let mut commands = shared.lock();
        commands.hides_brakes = tamper == Some(Tamper::Brake);
        commands.motors = application
            .instances
            .iter()
            .map(|instance| instance.schema.kind == Kind::Motor)
            .collect();
        let all = handle.board().list();
        let all = all.filter(|variable| matches!(variable.describe().access, Access::Command { .. }));
        let mut watches = Vec::new();
        for variable in all {
            let name = variable.describe().full_name();
            commands.ports.insert(
                name.clone(),
                CommandPort {
                    neutral: neutral_of(handle, &variable),
                    commanders: commanders_of(handle, &variable),
                    newest: None,
                    orphan: None,
                    reader: variable.reader("faults"),
                },
            );
            let (shared, handle) = (Arc::downgrade(shared), handle.clone());
            watches.push(variable.watch(move || {
                if let Some(shared) = shared.upgrade() {
                    shared.lock().record(&name, handle.now());
                }
            }));
        }
        watches
    }

    /// Ignores all later commands.
    pub(super) fn close(&mut self) {
        self.closed = true;
        // Otherwise these readers would count as leaked after the application's end.
        self.ports.clear();
    }

    /// Judges all commands since the last call, and those in force.
    pub(super) fn judge(&mut self, state: &mut ObserverState, now: Nanos) {
        for mut command in std::mem::take(&mut self.issued) {
            if command.neutral || !self.is_motor(command.writer) {
                continue;
            }
            if state.take_tamper(Tamper::Stranger) {
                let mut others = self.motors.ids();
                command.writer = others
                    .find(|other| self.is_motor(*other) && !state.history.held_authority(*other, 0, now))
                    .unwrap_or(command.writer);
            }
            let writer = command.writer;
            let had_authority = state
                .history
                .held_authority(writer, command.time, command.observed_at);
            if !had_authority && !state.history.is_held(writer, command.time) {
                let (port, at) = (&command.port, command.time as f64 / 1e9);
                let name = state.name(writer);
                let violation =
                    format!("R7: `{port}` took a command of `{name}`, which had no authority, at {at:.6} s");
                state.report(violation);
            }
        }
        let motors = &self.motors;
        let is_motor = |writer: SchemaId| motors.get(writer).copied().unwrap_or(false);
        for (name, port) in &mut self.ports {
            let in_force = port
                .newest
                .as_ref()
                .filter(|newest| is_motor(newest.writer) && !newest.neutral && newest.valid_until >= now);
            let Some(newest) = in_force else {
                port.orphan = None;
                continue;
            };
            let status = state.history.status(newest.writer, newest.time, now);
            let reason = match status {
                AuthorityStatus::Orphan(group) => format!("R9: group {} has no winner", group.0),
                AuthorityStatus::TakenOver(winner) => {
                    let mut commanders = port.commanders.iter();
                    if commanders.any(|commander| state.history.is_of(*commander, winner)) {
                        port.orphan = None;
                        continue;
                    }
                    format!("R7: `{}` won and does not command it", state.name(winner))
                }
                AuthorityStatus::Holds | AuthorityStatus::HeldByPolicy => {
                    port.orphan = None;
                    continue;
                }
            };
            let since = *port.orphan.get_or_insert(now);
            if state.clock == RunMode::Lockstep || now.saturating_sub(since) > BRAKE_SLACK {
                let writer = state.name(newest.writer).to_owned();
                state.report(format!(
                    "{reason}, and a command of `{writer}` to `{name}` is in force, at {:.6} s",
                    now as f64 / 1e9
                ));
                // Reported once.
                port.newest = None;
            }
        }
    }

    /// Whether a non-neutral command of this driver is in force, from a schema or from an absence policy.
    pub(super) fn is_driven(&self, driver: &str, now: Nanos) -> bool {
        let is_of_driver = |name: &str| name.split_once('.').is_some_and(|(owner, _)| owner == driver);
        let ports = self.ports.iter().filter(|(name, _)| is_of_driver(name));
        ports
            .filter_map(|(_, port)| port.newest.as_ref())
            .any(|newest| !newest.neutral && newest.valid_until >= now)
    }

    fn is_motor(&self, writer: SchemaId) -> bool {
        self.motors.get(writer).copied().unwrap_or(false)
    }

    fn record(&mut self, name: &str, observed_at: Nanos) {
        if self.closed {
            return;
        }
        let Some(port) = self.ports.get_mut(name) else {
            return;
        };
        let command = port.reader.latch(observed_at).map(|latched| IssuedCommand {
            port: name.to_owned(),
            writer: SchemaId(latched.stamp.writer),
            sequence: latched.stamp.sequence,
            time: latched.stamp.time,
            observed_at,
            valid_until: latched.stamp.valid_until,
            neutral: latched.bytes == port.neutral,
        });
        port.reader.release();
        let Some(command) = command else {
            return;
        };
        if self.hides_brakes && command.neutral {
            return;
        }
        let newer = port
            .newest
            .as_ref()
            .is_none_or(|newest| newest.sequence < command.sequence);
        if newer {
            port.newest = Some(command.clone());
            self.issued.push(command);
        }
    }
}

/// The schemas that are bound to a command.
fn commanders_of(handle: &Handle, variable: &Variable) -> Vec<SchemaId> {
    let declared = variable.describe();
    let application = handle.application();
    let target = application.instance(&declared.owner).and_then(|owner| {
        let mut ports = application.instances[owner].schema.ports.iter();
        let port = ports.position(|port| port.name == declared.name)?;
        Some(InstancePort::new(owner, port))
    });
    let bound = |(_, instance): &(SchemaId, &InstanceConfig)| {
        let actuator = |binding: &Binding| matches!(binding, Binding::Actuator { target: bound_to } if *bound_to == target);
        target.is_some() && instance.bindings.iter().any(actuator)
    };
    let instances = application.instances.entries().filter(bound);
    instances.map(|(index, _)| index).collect()
}

/// The neutral value of a command, as its driver declares it.
fn neutral_of(handle: &Handle, variable: &Variable) -> Vec<u8> {
    let declared = variable.describe();
    let application = handle.application();
    let owner = application
        .instance(&declared.owner)
        .map(|index| &application.instances[index]);
    let port = owner.and_then(|owner| owner.schema.ports.iter().find(|port| port.name == declared.name));
    match port.map(|port| &port.role) {
        Some(Role::Command { neutral, .. }) => neutral.clone(),
        _ => Vec::new(),
    }
}
