//! The wiring of guards and of the limits of commands: which guard judges which command, by which state, and what a driver
//! lets none exceed. It declares no variable.

use std::collections::BTreeMap;
use std::sync::Arc;

use jde_app::{Application, Binding, InstanceConfig, InstancePort};
use jde_core::SchemaId;

use super::wiring::Variables;
use crate::instance::{CommandLimits, GuardState, Guarding};

/// The state of each guard that a group names.
pub(super) fn guard_states(
    application: &Application,
    variables: &Variables,
) -> BTreeMap<SchemaId, Arc<GuardState>> {
    let named = application.groups.iter().filter_map(|group| group.guard);
    let states = named.map(|guard| {
        let port = guard_port(application, guard);
        let state = variables
            .of(InstancePort::new(guard, port))
            .expect("a guard's state is an export");
        let period = application.instances[guard].period_ns;
        (guard, GuardState::new(state.reader("host"), period))
    });
    states.collect()
}

/// What a guard judges beside what is commanded: the commands of drivers.
pub(super) fn guarding(
    application: &Application,
    variables: &Variables,
    guard: SchemaId,
    state: &Arc<GuardState>,
) -> Guarding {
    let mut commands = Vec::new();
    for (driver, instance) in application.instances.entries() {
        for place in 0..instance.schema.ports.len() {
            let command = InstancePort::new(driver, place);
            let mut guards = guards_of_command(application, command);
            if let Some((_, commanders)) = guards.find(|(other, _)| *other == guard)
                && let Some(variable) = variables.of(command)
            {
                commands.push((variable.reader("host"), commanders.into()));
            }
        }
    }
    Guarding {
        port: guard_port(application, guard),
        state: Arc::clone(state),
        commands,
        judged_by: 0,
    }
}

/// The limits of a driver's command: those that its modulation of this name and the command's type states at the start.
pub(super) fn command_limits(application: &Application, command: InstancePort) -> Option<CommandLimits> {
    let InstanceConfig {
        name,
        schema,
        bindings,
        ..
    } = &application.instances[command.instance];
    let command = &schema.ports[command.port];
    let limits = format!("{}_limits", command.name);
    let mut stated = schema.ports.iter().zip(bindings);
    stated.find_map(|(port, binding)| match binding {
        Binding::Modulation { initial, .. }
            if port.name == limits && port.value_type.same_as(&command.value_type) =>
        {
            let stated_by = format!("{name}.{limits}");
            Some(CommandLimits::new(stated_by, &command.value_type, initial))
        }
        _ => None,
    })
}

/// The guards of the schemas that command this command, each with these schemas.
pub(super) fn guards_of_command(
    application: &Application,
    command: InstancePort,
) -> impl Iterator<Item = (SchemaId, Vec<u32>)> {
    let target = Binding::Actuator {
        target: Some(command),
    };
    let mut guards: BTreeMap<SchemaId, Vec<u32>> = BTreeMap::new();
    for (commander, instance) in application.instances.entries() {
        if instance.bindings.contains(&target) {
            for guard in application.guards(commander, command) {
                guards.entry(guard).or_default().push(commander.0);
            }
        }
    }
    guards.into_iter()
}

/// The port that exports the state of a guard.
fn guard_port(application: &Application, guard: SchemaId) -> usize {
    let schema = &application.instances[guard].schema;
    schema.guard.as_ref().expect("a guard judges").state
}
