//! The build that each instance runs, and the build to which it returns if the current one fails on trial.
//! Every new instance is created from the build in this registry, so it is of the right build whatever
//! happened to the previous instance. It creates no instance.

use std::sync::Arc;

use jde_core::{SchemaId, Table};
use jde_loader::build::SharedBuild;
use jde_records::reload::{BuildName, Replacement};
use jde_records::snapshot::ReloadView;
use parking_lot::Mutex;

use super::{Completion, Swap};

/// The error that a pending exchange receives at the end.
const APPLICATION_ENDED: &str = "the application has ended";

/// The builds of the instances of an application.
pub(crate) struct BuildRegistry {
    entries: Mutex<Table<SchemaId, RegistryEntry>>,
}

#[derive(Default)]
struct RegistryEntry {
    /// `None` before the instance is first created.
    current: Option<SharedBuild>,
    /// The previous build, while the current one is on trial.
    previous: Option<SharedBuild>,
    swap: SwapState,
    reloads: u32,
    /// Why the last new build was given up, if it was.
    rollback_reason: Option<String>,
}

/// The progress of an exchange of builds that was requested and is not completed yet.
#[derive(Default)]
enum SwapState {
    #[default]
    None,
    /// A build waits for its turn to take over.
    Pending(Swap),
    /// The build is taking over.
    InProgress {
        build: BuildName,
        completion: Arc<Completion>,
    },
    /// The build took over in the current turn.
    Done {
        replacement: Replacement,
        completion: Arc<Completion>,
    },
    /// The application has ended; further exchanges are refused.
    Closed,
}

impl BuildRegistry {
    pub(crate) fn new(instances: impl Iterator<Item = SchemaId>) -> Self {
        Self {
            entries: Mutex::new(instances.map(|_| RegistryEntry::default()).collect()),
        }
    }

    /// Sets the build with which an instance starts.
    pub(crate) fn set_initial(&self, instance: SchemaId, build: SharedBuild) {
        self.entries.lock()[instance].current = Some(build);
    }

    /// Returns the build of which an instance is to be created.
    pub(crate) fn current(&self, instance: SchemaId) -> SharedBuild {
        let current = self.entries.lock()[instance].current.clone();
        current.expect("an instance has a build before it has a runner")
    }

    /// Stores a build until its turn to take over. If a call hangs before that turn, the next runner takes
    /// it.
    ///
    /// # Errors
    /// Another build waits already, or the application has ended.
    pub(crate) fn enqueue(&self, instance: SchemaId, swap: Swap) -> Result<(), String> {
        let state = &mut self.entries.lock()[instance].swap;
        match state {
            SwapState::None => {
                *state = SwapState::Pending(swap);
                Ok(())
            }
            SwapState::Pending(_) | SwapState::InProgress { .. } | SwapState::Done { .. } => {
                Err("another build of it waits for the end of its iteration already".to_owned())
            }
            SwapState::Closed => Err(APPLICATION_ENDED.to_owned()),
        }
    }

    /// Refuses all further exchanges, because the application has ended. Pending exchanges fail.
    pub(crate) fn close(&self) {
        for entry in self.entries.lock().iter_mut() {
            match std::mem::replace(&mut entry.swap, SwapState::Closed) {
                SwapState::Pending(Swap { completion, .. })
                | SwapState::InProgress { completion, .. }
                | SwapState::Done { completion, .. } => {
                    completion.complete(Err(APPLICATION_ENDED.to_owned()))
                }
                SwapState::None | SwapState::Closed => {}
            }
        }
    }

    /// Whether a build waits for its turn.
    pub(crate) fn is_pending(&self, instance: SchemaId) -> bool {
        matches!(self.entries.lock()[instance].swap, SwapState::Pending(_))
    }

    /// Starts the exchange, if a build waits for it.
    pub(crate) fn start_swap(&self, instance: SchemaId) -> Option<Swap> {
        let state = &mut self.entries.lock()[instance].swap;
        match std::mem::take(state) {
            SwapState::Pending(swap) => {
                *state = SwapState::InProgress {
                    build: swap.build.name.clone(),
                    completion: Arc::clone(&swap.completion),
                };
                Some(swap)
            }
            other @ (SwapState::None
            | SwapState::InProgress { .. }
            | SwapState::Done { .. }
            | SwapState::Closed) => {
                *state = other;
                None
            }
        }
    }

    /// Records that the build took over. The exchange is completed at the end of the turn.
    pub(crate) fn mark_done(&self, instance: SchemaId, replacement: Replacement) {
        let state = &mut self.entries.lock()[instance].swap;
        *state = match std::mem::take(state) {
            SwapState::InProgress { completion, .. } => SwapState::Done {
                replacement,
                completion,
            },
            other
            @ (SwapState::None | SwapState::Pending(_) | SwapState::Done { .. } | SwapState::Closed) => other,
        };
    }

    /// Completes the current exchange. From now on another may be requested.
    pub(crate) fn finish_swap(&self, instance: SchemaId, outcome: Result<(), String>) {
        let state = &mut self.entries.lock()[instance].swap;
        match (std::mem::take(state), outcome) {
            (
                SwapState::Done {
                    replacement,
                    completion,
                },
                Ok(()),
            ) => completion.complete(Ok(replacement)),
            (SwapState::Done { completion, .. } | SwapState::InProgress { completion, .. }, Err(reason)) => {
                completion.complete(Err(reason));
            }
            (other, _) => *state = other,
        }
    }

    /// Returns the build that is taking over.
    pub(crate) fn incoming(&self, instance: SchemaId) -> Option<BuildName> {
        match &self.entries.lock()[instance].swap {
            SwapState::InProgress { build, .. } => Some(build.clone()),
            SwapState::None | SwapState::Pending(_) | SwapState::Done { .. } | SwapState::Closed => None,
        }
    }

    /// Records that a build took over. It is on trial if `previous` is given.
    pub(crate) fn record_replacement(
        &self,
        instance: SchemaId,
        build: SharedBuild,
        previous: Option<SharedBuild>,
    ) {
        let entry = &mut self.entries.lock()[instance];
        entry.current = Some(build);
        entry.previous = previous;
        entry.reloads += 1;
        entry.rollback_reason = None;
    }

    /// Ends the trial: the previous build is dropped.
    pub(crate) fn end_trial(&self, instance: SchemaId) {
        self.entries.lock()[instance].previous = None;
    }

    /// Returns to the previous build. The result is the name of the build given up; `None` if there is no
    /// previous build.
    pub(crate) fn roll_back(&self, instance: SchemaId, reason: &str) -> Option<BuildName> {
        let entry = &mut self.entries.lock()[instance];
        let previous = entry.previous.take()?;
        let given_up = entry.current.replace(previous);
        entry.rollback_reason = Some(reason.to_owned());
        given_up.map(|build| build.name.clone())
    }

    /// Records that a new build did not take over.
    pub(crate) fn record_failure(&self, instance: SchemaId, reason: &str) {
        self.entries.lock()[instance].rollback_reason = Some(reason.to_owned());
    }

    /// Returns the state of an instance's reloads; `None` if it runs the build with which it started and no
    /// reload failed.
    pub(crate) fn view(&self, instance: SchemaId) -> Option<ReloadView> {
        let entry = &self.entries.lock()[instance];
        if entry.reloads == 0 && entry.rollback_reason.is_none() {
            return None;
        }
        let name = entry.current.as_ref().map(|build| build.name.clone());
        Some(ReloadView {
            reloads: entry.reloads,
            build: name.unwrap_or_default(),
            on_trial: entry.previous.is_some(),
            undone: entry.rollback_reason.clone(),
        })
    }
}
