//! From an application and its options to an engine and the runners of all instances, created and asleep.

use std::collections::BTreeMap;
use std::sync::Arc;

use jde_app::{Application, InstanceConfig};
use jde_core::{SchemaId, Table};
use jde_loader::Plugins;
use jde_loader::build::Build;

use crate::clock::Clock;
use crate::engine::Engine;
use crate::runner::Runner;
use crate::running::{Options, StartError};

/// Takes what the engine needs out of the options.
pub(crate) fn prepare(
    mut application: Application,
    plugins: &Plugins,
    clock: Clock,
    options: &mut Options,
) -> Result<(Arc<Engine>, Table<SchemaId, Runner>), StartError> {
    let mut mocks = BTreeMap::new();
    for (schema, mock) in std::mem::take(&mut options.mocks) {
        let (id, mock) = mock.resolve(&application, &schema)?;
        mocks.insert(id, Arc::new(mock));
        // A mock needs no process.
        application.instances[id].isolate = None;
    }
    let isolation_program = options.isolation_program.take();
    let instances = application.instances.iter();
    if isolation_program.is_none()
        && let Some(isolated) = instances
            .clone()
            .find(|instance| instance.isolate.is_some() && !application.plugins[instance.plugin].isolated)
    {
        return Err(StartError::NoProgram(isolated.name.clone()));
    }
    let builds = instances
        .map(|instance| original_build(&application, plugins, instance))
        .collect::<Result<Vec<_>, StartError>>()?;
    let (engine, ports) = Engine::new(
        application,
        clock,
        std::mem::take(&mut options.observers),
        options.on_turn.take(),
        options.transaction_observer.take(),
        isolation_program,
        mocks,
    )
    .map_err(StartError::Wiring)?;
    let mut runners = Table::default();
    let instances = engine.application.instances.ids();
    for (id, (build, ports)) in instances.zip(builds.into_iter().zip(ports)) {
        let mut runner = Runner::new(&engine, id, build, ports);
        if let Err(error) = runner.create_for_start() {
            runners.iter_mut().rev().for_each(Runner::destroy);
            return Err(error);
        }
        runners.push(runner);
    }
    Ok((engine, runners))
}

/// Returns the build of an instance's type against which the application was checked.
pub(crate) fn original_build(
    application: &Application,
    plugins: &Plugins,
    instance: &InstanceConfig,
) -> Result<Build, StartError> {
    let plugin = &application.plugins[instance.plugin];
    let loaded = plugins
        .loaded(plugin)
        .ok_or_else(|| StartError::MissingPlugin(plugin.name.clone()))?;
    Ok(Build::original(loaded, instance.number, &instance.schema))
}
