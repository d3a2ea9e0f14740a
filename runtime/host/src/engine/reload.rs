//! Other builds of schemas (R14): whether a build fits, and the events of a reload. The exchange itself is
//! the runner's.

use std::sync::Arc;

use jde_core::SchemaId;
use jde_loader::LoadedPlugin;
use jde_loader::build::{self, Build, map_build};
use jde_records::event::{OperatorAction, What};
use jde_records::reload::{BuildName, Replacement};

use super::{Engine, Signal};
use crate::reload::{Completion, PendingReload, ReloadOptions, Swap};

impl Engine {
    /// Orders another build of a schema's type, which takes over at the schema's next turn.
    ///
    /// # Errors
    /// All reasons against it.
    pub(crate) fn replace(
        &self,
        by: &str,
        instance: SchemaId,
        with: &LoadedPlugin,
        how: ReloadOptions,
    ) -> Result<PendingReload, Vec<String>> {
        let (build, notes) = self.check_build(instance, with)?;
        let action = OperatorAction::Reload {
            schema: instance,
            build: build.name.clone(),
        };
        let order = Arc::new(Completion::default());
        let swap = Swap {
            build: Arc::new(build),
            options: how,
            notes,
            completion: Arc::clone(&order),
        };
        self.builds
            .enqueue(instance, swap)
            .map_err(|reason| vec![reason])?;
        self.rules.report_operation(by, action);
        self.rules.signals.send(instance, Signal::BuildPending);
        Ok(PendingReload::new(&order))
    }

    /// Checks that a build fits in place of the present one. Returns it with notes on what of it is not in
    /// force.
    ///
    /// # Errors
    /// All reasons why it does not fit.
    pub(crate) fn check_build(
        &self,
        instance: SchemaId,
        with: &LoadedPlugin,
    ) -> Result<(Build, Vec<String>), Vec<String>> {
        self.operators
            .check_schema(instance)
            .map_err(|error| vec![error])?;
        if self.clock.is_replayed() {
            return Err(vec![
                "a replay of decisions has the builds of today from the start".to_owned(),
            ]);
        }
        let present = &self.application.instances[instance];
        if self.mocks.contains_key(&instance) {
            return Err(vec![format!("`{}` is replaced by a mock", present.name)]);
        }
        let mut wrong = Vec::new();
        let plugin = &self.application.plugins[present.plugin].name;
        if *plugin != with.description.name {
            wrong.push(format!(
                "it comes from the plugin `{plugin}`, and this is `{}`",
                with.description.name
            ));
        }
        let Some(number) = build::schema_index(&with.description, &present.schema.name) else {
            let types: Vec<_> = with
                .description
                .schemas
                .iter()
                .map(|schema| schema.name.as_str())
                .collect();
            wrong.push(format!(
                "the plugin has no type `{}` any more, only {}",
                present.schema.name,
                types.join(", ")
            ));
            return Err(wrong);
        };
        let table = with.schema(number);
        let state = jde_loader::instance::memory_of(&table).unwrap_or_else(|error| {
            wrong.push(error);
            None
        });
        match map_build(&self.application, instance, &with.description.schemas[number]) {
            Ok(mut fit) if wrong.is_empty() => {
                let notes = std::mem::take(&mut fit.notes);
                Ok((Build::new(with.clone(), number, state, fit), notes))
            }
            Ok(_) => Err(wrong),
            Err(others) => {
                wrong.extend(others);
                Err(wrong)
            }
        }
    }

    /// Whether an instance runs exactly this library, or is about to.
    pub(crate) fn is_running_build(&self, instance: SchemaId, plugin: &LoadedPlugin) -> bool {
        self.builds.current(instance).plugin.is_same_library(plugin)
    }

    /// Reports that a build took over.
    pub(crate) fn report_reload(&self, instance: SchemaId, takeover: &Replacement) {
        tracing::info!(target: "jde::event", schema = self.name(instance), "runs {} now", takeover.build);
        self.rules.report_now(What::Reloaded {
            schema: instance,
            takeover: takeover.clone(),
        });
    }

    /// Reports that a build could not take over. The build before continues.
    pub(crate) fn report_reload_failure(&self, instance: SchemaId, build: &BuildName, reason: &str) {
        self.builds.record_failure(instance, reason);
        self.report_rollback(instance, build.clone(), reason);
    }

    /// Goes back to the build before if the present one is on trial. Returns whether it was.
    pub(crate) fn roll_back_build(&self, instance: SchemaId, reason: &str) -> bool {
        let given_up = self.builds.roll_back(instance, reason);
        let was = given_up.is_some();
        if let Some(build) = given_up {
            self.report_rollback(instance, build, reason);
        }
        was
    }

    /// Undoes a reload after a call was given up: the build before replaces a build that was taking over in
    /// that call or is on trial.
    pub(super) fn interrupt_reload(&self, instance: SchemaId, reason: &str) {
        let outcome = if let Some(coming) = self.builds.incoming(instance) {
            self.report_reload_failure(instance, &coming, reason);
            Err(reason.to_owned())
        } else if self.roll_back_build(instance, reason) {
            Err(reason.to_owned())
        } else {
            Ok(())
        };
        self.builds.finish_swap(instance, outcome);
    }

    fn report_rollback(&self, instance: SchemaId, build: BuildName, reason: &str) {
        tracing::warn!(
            target: "jde::event",
            schema = self.name(instance),
            "goes on with the build before {build}: {reason}"
        );
        self.rules.report_now(What::ReloadRolledBack {
            schema: instance,
            build,
            reason: reason.to_owned(),
        });
    }
}
