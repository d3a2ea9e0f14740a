//! Checks every transaction of the rules against the shadow model (R1, R5, R7, R9, R10).

use std::sync::{Arc, Mutex};

use jde_core::Effect;
use jde_host::witness::{Seen, Step, Witness};
use jde_shadow::Shadow;

use super::{Known, Tamper, lock};

/// The shadow model of one application.
pub(super) struct Rules {
    known: Arc<Mutex<Known>>,
    shadow: Option<Shadow>,
}

impl Rules {
    pub(super) fn new(known: Arc<Mutex<Known>>) -> Self {
        Self { known, shadow: None }
    }
}

impl Witness for Rules {
    fn see(&mut self, seen: &Seen<'_>) {
        let mut known = lock(&self.known);
        let spec = seen.hierarchy.spec();
        let shadow = self.shadow.get_or_insert_with(|| Shadow::new(spec));
        if !known.history.knows() {
            known.history.begin(spec);
        }
        match seen.step {
            Step::Ended(id) => shadow.ended(id),
            Step::Over => shadow.shutting_down(),
            Step::Began(_) | Step::Told => {}
        }
        let lost = |effect: &Effect| matches!(effect, Effect::Withdrawn(_));
        let hides = seen.effects.iter().any(lost) && known.tampers(Tamper::Withdrawal);
        for effect in seen.effects {
            if hides && lost(effect) {
                continue;
            }
            if let Err(broken) = shadow.apply(spec, std::slice::from_ref(effect)) {
                known.tell(format!("{broken}, at {:.6} s", seen.began as f64 / 1e9));
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
                | Effect::Ask { .. }
                | Effect::Brake { .. }
                | Effect::Health { .. }
                | Effect::Decided(_)
                | Effect::Took { .. } => {}
            }
        }
        if let Step::Began(id) = seen.step {
            shadow.began(id);
        }
        // Without effects the states have not changed, and the shadow cannot disagree.
        if seen.effects.is_empty() {
            return;
        }
        if let Err(broken) = shadow.agrees(seen.hierarchy) {
            known.tell(format!("{broken}, at {:.6} s", seen.began as f64 / 1e9));
        }
    }
}
