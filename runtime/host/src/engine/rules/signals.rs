//! Signals to the runners of instances, and the notification of their threads.

use std::sync::{Arc, OnceLock, Weak};

use jde_board::Variable;
use jde_core::{GroupId, Level, Nanos, SchemaId};

use super::messages::Message;

/// Delivers signals to the runners of instances and sets the rules' timer.
///
/// [`Notifier::post`] and [`Notifier::set_timer`] take effect at once, in the order of the transactions that cause
/// them. They also run under the engine's lock, so they must not call the engine. The threads that wait are
/// notified once the lock is free: a notified thread may run before the notifier continues, and would
/// otherwise block on the rules' lock.
pub(crate) trait Notifier: Send + Sync {
    /// Leaves a signal for an instance. Returns whether a thread must be notified.
    fn post(&self, instance: SchemaId, signal: Signal) -> bool;
    /// Notifies the thread that takes the instance's turns.
    fn notify(&self, instance: SchemaId);
    /// Sets the next time at which the rules need [`Engine::tick`](super::Engine::tick). Returns whether a thread must be
    /// notified.
    fn set_timer(&self, next: Option<Nanos>) -> bool;
    /// Notifies the thread that waits for that time.
    fn notify_timer(&self);
}

/// A signal to an instance.
#[derive(Debug)]
pub(crate) enum Signal {
    /// The instance is awake since that time.
    Awake(Nanos),
    /// The instance is asleep.
    Asleep,
    /// A call of the instance hung, or its process died. The instance ends once no call of it runs; the next
    /// awakening creates a new one.
    Replaced,
    /// The instance was unloaded: it ends as soon as it sleeps.
    Unloaded,
    /// The instance became WINNER: iterate at once.
    Promoted,
    /// A value that triggers the instance was published (R12), or a driver received a command that cannot
    /// wait.
    Triggered,
    /// The instance requests a turn (R12).
    TurnRequested,
    /// The instance must arbitrate (R4).
    ArbitrationRequested {
        group: GroupId,
        ticket: u64,
        level: Level,
    },
    /// The period was written.
    PeriodChanged,
    /// A viewer opened the instance's panel.
    PanelOpened,
    /// A gesture on the panel is waiting.
    GestureQueued,
    /// Another build is waiting to take over at the instance's next turn.
    BuildPending,
}

/// The way to the runners.
#[derive(Default)]
pub(crate) struct Signals {
    notifier: OnceLock<Weak<dyn Notifier>>,
}

/// What to notify, and then to log, once the rules' lock is free.
#[derive(Default)]
pub(super) struct PendingNotifications {
    pub(super) messages: Vec<Message>,
    instances: Vec<SchemaId>,
    timer: bool,
    /// The variables that have lost their value.
    ended: Vec<Arc<Variable>>,
}

impl Signals {
    /// Connects the executor. Called once.
    pub(crate) fn attach(&self, notifier: &Arc<dyn Notifier>) {
        assert!(
            self.notifier.set(Arc::downgrade(notifier)).is_ok(),
            "an engine has one executor"
        );
    }

    /// Signals an instance outside of the rules' lock.
    pub(crate) fn send(&self, instance: SchemaId, signal: Signal) {
        if self.post(instance, signal) {
            self.notify(instance);
        }
    }

    /// Leaves a signal for an instance. Returns whether to notify its thread, outside of the lock.
    pub(crate) fn post(&self, instance: SchemaId, signal: Signal) -> bool {
        self.notifier()
            .is_some_and(|notifier| notifier.post(instance, signal))
    }

    pub(crate) fn notify(&self, instance: SchemaId) {
        if let Some(notifier) = self.notifier() {
            notifier.notify(instance);
        }
    }

    /// Leaves a signal within a transaction.
    pub(super) fn post_within(&self, pending: &mut PendingNotifications, instance: SchemaId, signal: Signal) {
        if self.post(instance, signal) {
            pending.instances.push(instance);
        }
    }

    /// Sets the timer within a transaction. Returns whether there is an executor.
    pub(super) fn set_timer_within(&self, pending: &mut PendingNotifications, next: Option<Nanos>) -> bool {
        let notifier = self.notifier();
        pending.timer |= notifier.as_ref().is_some_and(|notifier| notifier.set_timer(next));
        notifier.is_some()
    }

    /// Notifies the threads that a transaction concerns, and the watches of variables that lost their value in it.
    pub(super) fn notify_all(&self, pending: &PendingNotifications) {
        pending.ended.iter().for_each(|variable| variable.report_end());
        let Some(notifier) = self.notifier() else {
            return;
        };
        for instance in &pending.instances {
            notifier.notify(*instance);
        }
        if pending.timer {
            notifier.notify_timer();
        }
    }

    fn notifier(&self) -> Option<Arc<dyn Notifier>> {
        self.notifier.get().and_then(Weak::upgrade)
    }
}

impl PendingNotifications {
    /// Adds variables that have lost their value.
    pub(super) fn add_ended(&mut self, variables: impl Iterator<Item = Arc<Variable>>) {
        self.ended.extend(variables);
    }

    pub(super) fn is_empty(&self) -> bool {
        self.instances.is_empty() && !self.timer && self.ended.is_empty() && self.messages.is_empty()
    }
}
