//! Which build each instance runs, and which it goes back to while the present one is on trial. Whoever makes an instance asks
//! here, so that one that is made anew is of the right build wherever the one before it was left.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::{BuildName, Shared};
use crate::reload::{Order, Swap, Takeover};
use crate::snapshot::ReloadView;

/// What whoever waits for an exchange at the end is told.
const OVER: &str = "the application has ended";

/// The builds of an application, by instance.
pub(crate) struct Register {
    entries: Mutex<Vec<Entry>>,
}

#[derive(Default)]
struct Entry {
    /// None before the instance is first made.
    present: Option<Shared>,
    /// The one before, while the present one is on trial.
    before: Option<Shared>,
    exchange: Exchange,
    reloads: u32,
    /// Why the last new build was given up, if it was.
    undone: Option<String>,
}

/// How far the exchange of builds is that somebody ordered and that is not answered yet.
#[derive(Default)]
enum Exchange {
    #[default]
    None,
    /// A build waits for its turn to take over.
    Awaited(Swap),
    /// It is taking over.
    UnderWay { build: BuildName, order: Arc<Order> },
    /// It took over in the present turn.
    Done { takeover: Takeover, order: Arc<Order> },
    /// The application has ended, and none is exchanged any more.
    Over,
}

impl Register {
    pub(crate) fn new(instances: usize) -> Self {
        Self {
            entries: Mutex::new((0..instances).map(|_| Entry::default()).collect()),
        }
    }

    /// The build that an instance starts with.
    pub(crate) fn begin(&self, instance: usize, build: Shared) {
        self.lock()[instance].present = Some(build);
    }

    /// The build that an instance is to be of.
    pub(crate) fn of(&self, instance: usize) -> Shared {
        let present = self.lock()[instance].present.clone();
        present.expect("an instance has a build before it has a runner")
    }

    /// A build is about to take over. It is kept here until it has its turn, so that a call that hangs before then leaves it to whoever
    /// takes the next.
    ///
    /// # Errors
    /// Another waits already, or the application has ended.
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

    /// The application has ended: whoever waits for a build to take over is answered, and no other takes over.
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

    /// It has its turn, if one waited for it.
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

    /// It took over; that is answered when its turn is over.
    pub(crate) fn announce(&self, instance: usize, takeover: Takeover) {
        let exchange = &mut self.lock()[instance].exchange;
        *exchange = match std::mem::take(exchange) {
            Exchange::UnderWay { order, .. } => Exchange::Done { takeover, order },
            other @ (Exchange::None | Exchange::Awaited(_) | Exchange::Done { .. } | Exchange::Over) => other,
        };
    }

    /// Answers whoever ordered the exchange whose turn it is. Another may be ordered from now on.
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

    /// The build that is taking over.
    pub(crate) fn coming(&self, instance: usize) -> Option<BuildName> {
        match &self.lock()[instance].exchange {
            Exchange::UnderWay { build, .. } => Some(build.clone()),
            Exchange::None | Exchange::Awaited(_) | Exchange::Done { .. } | Exchange::Over => None,
        }
    }

    /// A build took over, and is on trial if there is one to go back to.
    pub(crate) fn took_over(&self, instance: usize, build: Shared, before: Option<Shared>) {
        let entry = &mut self.lock()[instance];
        entry.present = Some(build);
        entry.before = before;
        entry.reloads += 1;
        entry.undone = None;
    }

    /// The trial is over: there is no going back.
    pub(crate) fn passed(&self, instance: usize) {
        self.lock()[instance].before = None;
    }

    /// Goes back to the build before; answers with the one given up, or nothing if there is none to go back to.
    pub(crate) fn go_back(&self, instance: usize, reason: &str) -> Option<BuildName> {
        let entry = &mut self.lock()[instance];
        let before = entry.before.take()?;
        let given_up = entry.present.replace(before);
        entry.undone = Some(reason.to_owned());
        given_up.map(|build| build.name.clone())
    }

    /// A new build never took over.
    pub(crate) fn never_was(&self, instance: usize, reason: &str) {
        self.lock()[instance].undone = Some(reason.to_owned());
    }

    /// What there is to see of it; nothing if the instance runs what it started with.
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
