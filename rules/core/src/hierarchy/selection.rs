//! Selection in a group (R2): one snapshot, one choice, one record.
//!
//! It refuses to select below a father that is being replaced, and while a request to the father is open.

use super::candidates::CandidateList;
use super::group::TimedCause;
use super::snapshot::{Decision, Evaluation, Snapshot, forced_choice};
use super::timer::Timer;
use super::winner::Origin;
use super::{Hierarchy, Phase};
use crate::effect::Effect;
use crate::record::{Cause, Record};
use crate::spec::{GroupId, Nanos};

impl Hierarchy {
    /// Selects in a group, or requests an arbitration by its father.
    pub(super) fn select(&mut self, now: Nanos, id: GroupId, trigger: TimedCause, out: &mut Vec<Effect>) {
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
        match self.snapshot(now, id, &list).evaluate(self.plan.group(id).policy) {
            Evaluation::Decided(decision) => self.decide(now, id, list, decision, trigger, out),
            Evaluation::FatherArbitrates(case) => {
                self.request_arbitration(now, id, case, list.candidates, trigger, out)
            }
        }
    }

    /// Returns the current candidate list of a group.
    #[inline]
    pub(super) fn candidates_of(&mut self, id: GroupId) -> CandidateList {
        self.nodes.candidates_of(&self.plan, id)
    }

    pub(super) fn snapshot<'a>(&'a self, now: Nanos, id: GroupId, list: &'a CandidateList) -> Snapshot<'a> {
        Snapshot {
            now,
            spec: self.plan.group(id),
            group: self.group(id),
            nodes: &self.nodes,
            list,
        }
    }

    /// Records a decision and carries it out.
    pub(super) fn decide(
        &mut self,
        now: Nanos,
        id: GroupId,
        list: CandidateList,
        decision: Decision,
        trigger: TimedCause,
        out: &mut Vec<Effect>,
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
        let before = self.group_mut(id).choose(now, choice);
        match self.snapshot(now, id, &list).turn_end(case, choice) {
            Some(end) => self.timers.arm(Timer::Turn(id), end),
            None => self.timers.disarm(Timer::Turn(id)),
        }
        out.push(Effect::Decided(Record {
            number,
            time: now,
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
            self.apply_choice(now, id, choice, origin, trigger, out);
        }
    }

    pub(super) fn end_turn(&mut self, now: Nanos, id: GroupId, out: &mut Vec<Effect>) {
        self.select(now, id, TimedCause::new(Cause::Timer(Timer::Turn(id)), now), out);
    }
}
