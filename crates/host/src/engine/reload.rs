//! Other builds of schemas (R14): whether a build fits, and the events of a reload. The exchange itself is
//! the runner's.

use std::sync::Arc;

use super::{Engine, Signal, schema};
use crate::build::{self, Build, BuildName, fit};
use crate::event::{Event, OperatorAction};
use crate::plugin::Loaded;
use crate::reload::{How, Order, Reload, Swap, Takeover};

impl Engine {
    /// Orders another build of a schema's type, which takes over at the schema's next turn.
    ///
    /// # Errors
    /// All reasons against it.
    pub(crate) fn replace(
        &self,
        by: &str,
        instance: usize,
        with: &Loaded,
        how: How,
    ) -> Result<Reload, Vec<String>> {
        let (build, notes) = self.fitting(instance, with)?;
        let action = OperatorAction::Reload {
            schema: instance,
            build: build.name.clone(),
        };
        let order = Arc::new(Order::default());
        let swap = Swap {
            build: Arc::new(build),
            how,
            notes,
            order: Arc::clone(&order),
        };
        self.builds
            .await_turn(instance, swap)
            .map_err(|reason| vec![reason])?;
        self.operated(by, action);
        self.ring(instance, Signal::Swapped);
        Ok(Reload::new(&order))
    }

    /// Checks that a build fits in place of the present one. Returns it with notes on what of it is not in
    /// force.
    ///
    /// # Errors
    /// All reasons why it does not fit.
    pub(crate) fn fitting(
        &self,
        instance: usize,
        with: &Loaded,
    ) -> Result<(Build, Vec<String>), Vec<String>> {
        self.known(instance).map_err(|error| vec![error])?;
        if self.clock.is_past() {
            return Err(vec![
                "a replay of decisions has the builds of today from the start".to_owned(),
            ]);
        }
        let present = &self.application.instances[instance];
        let mut wrong = Vec::new();
        let plugin = &self.application.plugins[present.plugin].name;
        if *plugin != with.description.name {
            wrong.push(format!(
                "it comes from the plugin `{plugin}`, and this is `{}`",
                with.description.name
            ));
        }
        let Some(number) = build::place(&with.description, &present.schema.name) else {
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
        let state = crate::instance::memory_of(&table).unwrap_or_else(|error| {
            wrong.push(error);
            None
        });
        match fit(&self.application, instance, &with.description.schemas[number]) {
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
    pub(crate) fn runs(&self, instance: usize, plugin: &Loaded) -> bool {
        self.builds.of(instance).plugin.is_one_with(plugin)
    }

    /// Reports that a build took over.
    pub(crate) fn reloaded(&self, instance: usize, takeover: &Takeover) {
        tracing::info!(schema = self.name(instance), "runs {} now", takeover.build);
        self.report(&Event::Reloaded {
            time: self.clock.now(),
            schema: instance,
            takeover: takeover.clone(),
        });
    }

    /// Reports that a build could not take over. The build before continues.
    pub(crate) fn not_reloaded(&self, instance: usize, build: &BuildName, reason: &str) {
        self.builds.never_was(instance, reason);
        self.undone(instance, build.clone(), reason);
    }

    /// Goes back to the build before if the present one is on trial. Returns whether it was.
    pub(crate) fn give_up_build(&self, instance: usize, reason: &str) -> bool {
        let given_up = self.builds.go_back(instance, reason);
        let was = given_up.is_some();
        if let Some(build) = given_up {
            self.undone(instance, build, reason);
        }
        was
    }

    /// Undoes a reload after a call was given up: the build before replaces a build that was taking over in
    /// that call or is on trial.
    pub(super) fn interrupted(&self, instance: usize, reason: &str) {
        let outcome = if let Some(coming) = self.builds.coming(instance) {
            self.not_reloaded(instance, &coming, reason);
            Err(reason.to_owned())
        } else if self.give_up_build(instance, reason) {
            Err(reason.to_owned())
        } else {
            Ok(())
        };
        self.builds.settle(instance, outcome);
    }

    /// Reports that a faulted schema has new code. It wakes up if it is requested.
    pub(crate) fn restored(&self, instance: usize) {
        self.transact(|hierarchy, now, out| hierarchy.restored(now, schema(instance), out));
    }

    fn undone(&self, instance: usize, build: BuildName, reason: &str) {
        tracing::warn!(
            schema = self.name(instance),
            "goes on with the build before {build}: {reason}"
        );
        self.report(&Event::ReloadUndone {
            time: self.clock.now(),
            schema: instance,
            build,
            reason: reason.to_owned(),
        });
    }
}
