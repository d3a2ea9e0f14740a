//! Which build each instance runs, and to which one it returns if the present one fails on trial. Every new
//! instance is created from the build registered here, so it is of the right build whatever happened to the
//! instance before. Creates no instance.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::{BuildName, Shared};
use crate::reload::{Order, Swap, Takeover};
use crate::snapshot::ReloadView;

/// The error that a pending exchange receives at the end.
const OVER: &str = "the application has ended";

/// The builds of an application, by instance.
pub(crate) struct Register {
    entries: Mutex<Vec<Entry>>,
}

#[derive(Default)]
struct Entry {
    /// `None` before the instance is first created.
    present: Option<Shared>,
    /// The build before, while the present one is on trial.
    before: Option<Shared>,
    exchange: Exchange,
    reloads: u32,
    /// Why the last new build was given up, if it was.
    undone: Option<String>,
}

/// The progress of an exchange of builds that was requested and not answered yet.
#[derive(Default)]
enum Exchange {
    #[default]
    None,
    /// A build waits for its turn to take over.
    Awaited(Swap),
    /// The build is taking over.
    UnderWay { build: BuildName, order: Arc<Order> },
    /// The build took over in the present turn.
    Done { takeover: Takeover, order: Arc<Order> },
    /// The application has ended; further exchanges are refused.
    Over,
}

impl Register {
    pub(crate) fn new(instances: usize) -> Self {
        Self {
            entries: Mutex::new((0..instances).map(|_| Entry::default()).collect()),
        }
    }

    /// Sets the build with which an instance starts.
    pub(crate) fn begin(&self, instance: usize, build: Shared) {
        self.lock()[instance].present = Some(build);
    }

    /// Returns the build of which an instance is to be created.
    pub(crate) fn of(&self, instance: usize) -> Shared {
        let present = self.lock()[instance].present.clone();
        present.expect("an instance has a build before it has a runner")
    }

    /// Stores a build until its turn to take over. If a call hangs before that turn, the next runner takes it
    /// from here.
    ///
    /// # Errors
    /// Another build waits already, or the application has ended.
    pub(crate) fn await_turn(&self, instance: usize, swap: Swap) -> Result<(), String> {
        let exchange = &mut self.lock()[instance].exchange;
        match exchange {
            Exchange::None => {
                *exchange = Exchange::Awaited(swap);
                Ok(())
            }
            Exchange::Awaited(_) | Exchange::UnderWay { .. } | Exchange::Done { .. } => {
                Err("another build of it waits for the end of its iteration already".to_owned())
            }
            Exchange::Over => Err(OVER.to_owned()),
        }
    }

    /// Refuses all further exchanges, because the application has ended. Pending exchanges are answered.
    pub(crate) fn close(&self) {
        for entry in &mut *self.lock() {
            match std::mem::replace(&mut entry.exchange, Exchange::Over) {
                Exchange::Awaited(Swap { order, .. })
                | Exchange::UnderWay { order, .. }
                | Exchange::Done { order, .. } => order.settle(Err(OVER.to_owned())),
                Exchange::None | Exchange::Over => {}
            }
        }
    }

    /// Whether a build waits for its turn.
    pub(crate) fn is_awaited(&self, instance: usize) -> bool {
        matches!(self.lock()[instance].exchange, Exchange::Awaited(_))
    }

    /// Starts the exchange, if a build waits for it.
    pub(crate) fn has_turn(&self, instance: usize) -> Option<Swap> {
        let exchange = &mut self.lock()[instance].exchange;
        match std::mem::take(exchange) {
            Exchange::Awaited(swap) => {
                *exchange = Exchange::UnderWay {
                    build: swap.build.name.clone(),
                    order: Arc::clone(&swap.order),
                };
                Some(swap)
            }
            other @ (Exchange::None | Exchange::UnderWay { .. } | Exchange::Done { .. } | Exchange::Over) => {
                *exchange = other;
                None
            }
        }
    }

    /// Records that the build took over. The answer is given at the end of the turn.
    pub(crate) fn announce(&self, instance: usize, takeover: Takeover) {
        let exchange = &mut self.lock()[instance].exchange;
        *exchange = match std::mem::take(exchange) {
            Exchange::UnderWay { order, .. } => Exchange::Done { takeover, order },
            other @ (Exchange::None | Exchange::Awaited(_) | Exchange::Done { .. } | Exchange::Over) => other,
        };
    }

    /// Answers the exchange that is under way. From now on another may be requested.
    pub(crate) fn settle(&self, instance: usize, outcome: Result<(), String>) {
        let exchange = &mut self.lock()[instance].exchange;
        match (std::mem::take(exchange), outcome) {
            (Exchange::Done { takeover, order }, Ok(())) => order.settle(Ok(takeover)),
            (Exchange::Done { order, .. } | Exchange::UnderWay { order, .. }, Err(reason)) => {
                order.settle(Err(reason));
            }
            (other, _) => *exchange = other,
        }
    }

    /// Returns the build that is taking over.
    pub(crate) fn coming(&self, instance: usize) -> Option<BuildName> {
        match &self.lock()[instance].exchange {
            Exchange::UnderWay { build, .. } => Some(build.clone()),
            Exchange::None | Exchange::Awaited(_) | Exchange::Done { .. } | Exchange::Over => None,
        }
    }

    /// Records that a build took over. It is on trial if there is a build before it.
    pub(crate) fn took_over(&self, instance: usize, build: Shared, before: Option<Shared>) {
        let entry = &mut self.lock()[instance];
        entry.present = Some(build);
        entry.before = before;
        entry.reloads += 1;
        entry.undone = None;
    }

    /// Ends the trial: the build before is dropped.
    pub(crate) fn passed(&self, instance: usize) {
        self.lock()[instance].before = None;
    }

    /// Returns to the build before. The result is the name of the build given up; `None` if there is none
    /// before.
    pub(crate) fn go_back(&self, instance: usize, reason: &str) -> Option<BuildName> {
        let entry = &mut self.lock()[instance];
        let before = entry.before.take()?;
        let given_up = entry.present.replace(before);
        entry.undone = Some(reason.to_owned());
        given_up.map(|build| build.name.clone())
    }

    /// Records that a new build did not take over.
    pub(crate) fn never_was(&self, instance: usize, reason: &str) {
        self.lock()[instance].undone = Some(reason.to_owned());
    }

    /// Returns the state of an instance's reloads; `None` if it runs the build with which it started and no
    /// reload failed.
    pub(crate) fn view(&self, instance: usize) -> Option<ReloadView> {
        let entry = &self.lock()[instance];
        if entry.reloads == 0 && entry.undone.is_none() {
            return None;
        }
        let name = entry.present.as_ref().map(|build| build.name.clone());
        Some(ReloadView {
            reloads: entry.reloads,
            build: name.unwrap_or_default(),
            on_trial: entry.before.is_some(),
            undone: entry.undone.clone(),
        })
    }

    fn lock(&self) -> MutexGuard<'_, Vec<Entry>> {
        self.entries.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
