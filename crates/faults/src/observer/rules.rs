//! Checks every transaction of the rules against the shadow model (R1, R5, R7, R9, R10).

use std::sync::{Arc, Mutex};

use jde_core::Effect;
use jde_host::transaction_observer::{Transaction, TransactionInput, TransactionObserver};
use jde_shadow::Shadow;

use super::{ObserverState, Tamper, lock};

/// The shadow model of one application.
pub(super) struct Rules {
    known: Arc<Mutex<ObserverState>>,
    shadow: Option<Shadow>,
}

impl Rules {
    pub(super) fn new(known: Arc<Mutex<ObserverState>>) -> Self {
        Self { known, shadow: None }
    }
}

impl TransactionObserver for Rules {
    fn on_transaction(&mut self, seen: &Transaction<'_>) {
        let mut known = lock(&self.known);
        let spec = seen.hierarchy.spec();
        let shadow = self.shadow.get_or_insert_with(|| Shadow::new(spec));
        if !known.history.knows() {
            known.history.begin(spec);
        }
        match seen.step {
            TransactionInput::IterationEnded(id) => shadow.end_iteration(id),
            TransactionInput::Shutdown => shadow.begin_shutdown(),
            TransactionInput::IterationBegan(_) | TransactionInput::Other => {}
        }
        let lost = |effect: &Effect| matches!(effect, Effect::Withdrawn(_));
        let hides = seen.effects.iter().any(lost) && known.take_tamper(Tamper::Withdrawal);
        for effect in seen.effects {
            if hides && lost(effect) {
                continue;
            }
            if let Err(broken) = shadow.apply(spec, std::slice::from_ref(effect)) {
                known.report(format!("{broken}, at {:.6} s", seen.began as f64 / 1e9));
            }
            let history = &mut known.history;
            match effect {
                Effect::Granted(id) => history.granted(*id, seen.began),
                Effect::Withdrawn(id) => history.withdrawn(*id, seen.done),
                Effect::Changed { id, to, .. } => history.changed(*id, *to),
                Effect::Hold { group, until } => history.holds(*group, *until),
                Effect::TakesOver { group, .. } => history.taken_over(*group, seen.began),
                Effect::Woken(_)
                | Effect::Slept { .. }
                | Effect::Promoted(_)
                | Effect::Lapsed(_)
                | Effect::Demoted(_)
                | Effect::Arbitrate { .. }
                | Effect::Brake { .. }
                | Effect::Health { .. }
                | Effect::Decided(_)
                | Effect::TookOver { .. } => {}
            }
        }
        if let TransactionInput::IterationBegan(id) = seen.step {
            shadow.begin_iteration(id);
        }
        // Without effects the states have not changed, and the shadow cannot disagree.
        if seen.effects.is_empty() {
            return;
        }
        if let Err(broken) = shadow.check_against(seen.hierarchy) {
            known.report(format!("{broken}, at {:.6} s", seen.began as f64 / 1e9));
        }
    }
}
