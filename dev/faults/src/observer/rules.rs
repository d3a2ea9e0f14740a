//! Checks every transaction of the rules against the shadow model (R1, R5, R7, R9, R10).

use std::sync::Arc;

use jde_core::Effect;
use jde_host::transaction_observer::{ObservedTransaction, TransactionInput, TransactionObserver};
use jde_shadow::Shadow;
use parking_lot::Mutex;

use super::{ObserverState, Tamper};

/// The shadow model of one application.
pub(super) struct Rules {
    state: Arc<Mutex<ObserverState>>,
    shadow: Option<Shadow>,
}

impl Rules {
    pub(super) fn new(state: Arc<Mutex<ObserverState>>) -> Self {
        Self { state, shadow: None }
    }
}

impl TransactionObserver for Rules {
    fn on_transaction(&mut self, transaction: &ObservedTransaction<'_>) {
        let mut state = self.state.lock();
        let spec = transaction.hierarchy.spec();
        let shadow = self.shadow.get_or_insert_with(|| Shadow::new(spec));
        if !state.history.has_begun() {
            state.history.begin(spec);
        }
        match transaction.step {
            TransactionInput::IterationEnded(id) => shadow.end_iteration(id),
            TransactionInput::Shutdown => shadow.begin_shutdown(),
            TransactionInput::IterationBegan(_) | TransactionInput::Other => {}
        }
        let is_withdrawal = |effect: &Effect| matches!(effect, Effect::Withdrawn(_));
        let hides_withdrawal =
            transaction.effects.iter().any(is_withdrawal) && state.take_tamper(Tamper::Withdrawal);
        for effect in transaction.effects {
            if hides_withdrawal && is_withdrawal(effect) {
                continue;
            }
            if let Err(violation) = shadow.apply(spec, std::slice::from_ref(effect)) {
                state.report(format!("{violation}, at {:.6} s", transaction.began as f64 / 1e9));
            }
            let history = &mut state.history;
            match effect {
                Effect::Granted(id) => history.granted(*id, transaction.began),
                Effect::Withdrawn(id) => history.withdrawn(*id, transaction.done),
                Effect::Changed { id, to, .. } => history.changed(*id, *to),
                Effect::Hold { group, until } => history.holds(*group, *until),
                Effect::TakesOver { group, .. } => history.taken_over(*group, transaction.began),
                Effect::Woken(_)
                | Effect::Slept { .. }
                | Effect::Promoted(_)
                | Effect::Lapsed(_)
                | Effect::Refused(_)
                | Effect::Retries(_)
                | Effect::Demoted(_)
                | Effect::Arbitrate { .. }
                | Effect::Brake { .. }
                | Effect::Health { .. }
                | Effect::Decided(_)
                | Effect::TookOver { .. } => {}
            }
        }
        if let TransactionInput::IterationBegan(id) = transaction.step {
            shadow.begin_iteration(id);
        }
        // Without effects the states have not changed, so the shadow still agrees.
        if transaction.effects.is_empty() {
            return;
        }
        if let Err(violation) = shadow.check_against(transaction.hierarchy) {
            state.report(format!("{violation}, at {:.6} s", transaction.began as f64 / 1e9));
        }
    }
}
