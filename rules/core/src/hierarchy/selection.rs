//! Selection in a group (R2): one snapshot, one choice, one record.
//!
//! It refuses to select below a father that is being replaced, and while a request to the father is open.

use super::Phase;
use super::candidates::CandidateList;
use super::group::TimedCause;
use super::snapshot::{Decision, Evaluation, Snapshot, forced_choice};
use super::timer::Timer;
use super::transaction::Transaction;
use super::winner::Origin;
use crate::effect::Effect;
use crate::record::{Cause, Record};
use crate::spec::GroupId;

impl Transaction<'_> {
    /// Selects in a group, or requests an arbitration by its father.
    pub(super) fn select(&mut self, id: GroupId, trigger: TimedCause) {
        if self.phase != Phase::Running || self.is_frozen(id) {
            return;
        }
        if forced_choice(self.group(id), &self.nodes).is_some() {
            self.cancel_arbitration(id);
        }
        if self.group_mut(id).postpone(trigger) {
            return;
        }
        let list = self.candidates_of(id);
        match self.snapshot(id, &list).evaluate(self.plan.group(id).policy) {
            Evaluation::Decided(decision) => self.decide(id, list, decision, trigger),
            Evaluation::FatherArbitrates(case) => {
                self.request_arbitration(id, case, list.candidates, trigger)
            }
        }
    }

    /// Returns the current candidate list of a group.
    #[inline]
    pub(super) fn candidates_of(&mut self, id: GroupId) -> CandidateList {
        let hierarchy = &mut *self.hierarchy;
        hierarchy.nodes.candidates_of(&hierarchy.plan, id)
    }

    pub(super) fn snapshot<'a>(&'a self, id: GroupId, list: &'a CandidateList) -> Snapshot<'a> {
        Snapshot {
            now: self.now,
            spec: self.plan.group(id),
            group: self.group(id),
            nodes: &self.nodes,
            list,
        }
    }

    /// Records a decision and carries it out.
    pub(super) fn decide(
        &mut self,
        id: GroupId,
        list: CandidateList,
        decision: Decision,
        trigger: TimedCause,
    ) {
        let Decision {
            case,
            choice,
            decider,
            reason,
            known,
        } = decision;
        self.records += 1;
        let number = self.records;
        let before = self.hierarchy.group_mut(id).choose(self.now, choice);
        match self.snapshot(id, &list).turn_end(case, choice) {
            Some(end) => self.timers.arm(Timer::Turn(id), end),
            None => self.timers.disarm(Timer::Turn(id)),
        }
        self.out.push(Effect::Decided(Record {
            number,
            time: self.now,
            cause_time: trigger.time,
            group: id,
            case,
            candidates: list.candidates,
            before,
            choice,
            decider,
            reason,
            cause: trigger.cause,
            changed: before != choice,
        }));
        if known {
            let origin = Origin {
                record: number,
                cause_time: trigger.time,
            };
            self.apply_choice(id, choice, origin, trigger);
        }
    }

    pub(super) fn end_turn(&mut self, id: GroupId) {
        self.select(id, TimedCause::new(Cause::Timer(Timer::Turn(id)), self.now));
    }
}
