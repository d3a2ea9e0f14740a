//! Selection in a group (R2, R3): one snapshot, one case, one choice, one record.
//!
//! It refuses to select below a father that is being replaced, and while a request to the father is open.

use std::borrow::Cow;

use super::Hierarchy;
use super::candidates::CandidateList;
use super::nodes::{Origin, Phase, RunState};
use super::timer::Timer;
use crate::effect::Effect;
use crate::policy::{Policy, PolicyInput};
use crate::record::{Candidate, Case, Cause, Decider, Record};
use crate::spec::{Absence, GroupId, Nanos, SchemaId};
use crate::state::ActuationState;

/// The cause of a selection, and when that situation began.
#[derive(Copy, Clone, PartialEq, Eq, Hash, Debug)]
pub(super) struct TimedCause {
    pub(super) cause: Cause,
    /// When the situation began.
    pub(super) time: Nanos,
}

/// The result of the evaluation of a snapshot.
pub(super) enum Evaluation {
    Decided(Decision),
    /// The father must decide.
    FatherArbitrates(Case),
}

pub(super) struct Decision {
    pub(super) case: Case,
    pub(super) choice: Option<SchemaId>,
    pub(super) decider: Decider,
    pub(super) reason: Cow<'static, str>,
    /// Whether the decision is carried out. False while no member can be chosen because not all have checked
    /// yet, so the absence policy waits. Also false when an operator stopped all schemas.
    pub(super) known: bool,
}

impl TimedCause {
    pub(super) const fn new(cause: Cause, time: Nanos) -> Self {
        Self { cause, time }
    }
}

impl Decision {
    fn new(case: Case, choice: Option<SchemaId>, decider: Decider, reason: &'static str) -> Self {
        Self {
            case,
            choice,
            decider,
            reason: Cow::Borrowed(reason),
            known: true,
        }
    }

    /// Returns the decision that no member wins, without the absence policy.
    pub(super) fn all_stopped() -> Self {
        Self {
            known: false,
            ..Self::new(
                Case::Absence,
                None,
                Decider::Operator,
                "an operator stopped everything",
            )
        }
    }
}

impl Hierarchy {
    /// Selects in a group, or requests an arbitration by its father.
    pub(super) fn select(&mut self, now: Nanos, id: GroupId, trigger: TimedCause, out: &mut Vec<Effect>) {
        if self.phase != Phase::Running || self.is_frozen(id) {
            return;
        }
        if self.forced_choice(id).is_some() {
            self.cancel_arbitration(id);
        }
        if let Some(pending) = &mut self.group_mut(id).pending {
            pending.retrigger.get_or_insert(trigger);
            return;
        }
        let list = self.candidates_of(id);
        match self.evaluate(now, id, &list, self.plan.group(id).policy) {
            Evaluation::Decided(decision) => self.decide(now, id, list, decision, trigger, out),
            Evaluation::FatherArbitrates(case) => {
                self.request_arbitration(now, id, case, list.candidates, trigger, out)
            }
        }
    }

    /// Whether a member can be chosen although it is not READY.
    pub(super) fn can_be_chosen(&self, id: SchemaId) -> bool {
        let node = self.node(id);
        self.is_awake(id) && node.should_be_awake() && node.run != RunState::Abandoned
    }

    /// Evaluates a snapshot under a policy.
    pub(super) fn evaluate(
        &self,
        now: Nanos,
        id: GroupId,
        list: &CandidateList,
        policy: Policy,
    ) -> Evaluation {
        if let Some(forced) = self.forced_choice(id) {
            let decision = Decision::new(
                Case::Forced,
                Some(forced),
                Decider::Operator,
                "forced by an operator",
            );
            return Evaluation::Decided(decision);
        }
        let case = match (list.first, list.several) {
            (None, _) => return self.evaluate_absence(id, &list.candidates, policy),
            (Some(index), false) => {
                let only = Some(list.candidates[index].id);
                let decision = Decision::new(Case::Alone, only, Decider::Nobody, "the only one ready");
                return Evaluation::Decided(decision);
            }
            (Some(_), true) => Case::Collision,
        };
        if policy == Policy::FATHER && self.can_father_arbitrate(id) {
            return Evaluation::FatherArbitrates(case);
        }
        let chosen = policy.choose(&self.policy_input(now, id, list));
        let (choice, reason) = chosen.map_or((None, "nobody is ready"), |(id, reason)| (Some(id), reason));
        let decider = if policy == Policy::FATHER {
            // The father sleeps: an operator plays the members.
            Decider::ArbitrationFailed
        } else {
            Decider::Policy(policy)
        };
        Evaluation::Decided(Decision::new(case, choice, decider, reason))
    }

    /// Returns the decision of the absence policy for a group in which no member wins: the fallback, if it
    /// can win.
    pub(super) fn absent(&self, id: GroupId, case: Case) -> Decision {
        let (choice, reason) = match self.plan.group(id).absence {
            Absence::Fallback(fallback) if self.can_be_chosen(fallback) => {
                (Some(fallback), "nobody is ready: the fallback wins")
            }
            Absence::Fallback(_) => (None, "nobody is ready, nor can the fallback win: brake"),
            Absence::Brake => (None, "nobody is ready: brake"),
            Absence::Hold { .. } => (None, "nobody is ready: hold the last command, then brake"),
        };
        Decision::new(case, choice, Decider::AbsencePolicy, reason)
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
        let group = self.group_mut(id);
        let before = group.lost.take().or_else(|| group.choice());
        let changed = before != choice;
        if changed && choice.is_some() {
            group.since = now;
            group.last = choice;
        }
        self.arm_turn(now, id, case, choice, &list);
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
            changed,
        }));
        if known {
            self.apply_choice(
                now,
                id,
                choice,
                Origin {
                    record: number,
                    cause_time: trigger.time,
                },
                trigger,
                out,
            );
        }
    }

    pub(super) fn end_turn(&mut self, now: Nanos, id: GroupId, out: &mut Vec<Effect>) {
        self.select(now, id, TimedCause::new(Cause::Timer(Timer::Turn(id)), now), out);
    }

    fn evaluate_absence(&self, id: GroupId, candidates: &[Candidate], policy: Policy) -> Evaluation {
        let is_unchecked = |c: &Candidate| !self.node(c.id).checked && self.can_be_chosen(c.id);
        // An absence waits for the first checks of members that have just woken, but not while the group
        // commands.
        if self.group(id).actuation != ActuationState::Commanding && candidates.iter().any(is_unchecked) {
            let reason = "nobody is ready yet; not all have been checked since they woke";
            let decision = Decision::new(Case::Absence, None, Decider::Nobody, reason);
            return Evaluation::Decided(Decision {
                known: false,
                ..decision
            });
        }
        if policy == Policy::FATHER && !candidates.is_empty() && self.can_father_arbitrate(id) {
            return Evaluation::FatherArbitrates(Case::Absence);
        }
        Evaluation::Decided(self.absent(id, Case::Absence))
    }

    fn forced_choice(&self, id: GroupId) -> Option<SchemaId> {
        self.group(id).forced.filter(|&forced| self.can_be_chosen(forced))
    }

    fn can_father_arbitrate(&self, id: GroupId) -> bool {
        self.plan
            .group(id)
            .father
            .is_some_and(|father| self.is_awake(father))
    }

    fn policy_input<'a>(&'a self, now: Nanos, id: GroupId, list: &'a CandidateList) -> PolicyInput<'a> {
        let group = self.group(id);
        let (since, last) = (group.since, group.last);
        PolicyInput {
            candidates: &list.candidates,
            first: list.first,
            members: self.plan.members(id),
            chosen: group.choice(),
            since,
            last,
            now,
        }
    }

    fn arm_turn(
        &mut self,
        now: Nanos,
        id: GroupId,
        case: Case,
        choice: Option<SchemaId>,
        list: &CandidateList,
    ) {
        let end = match case {
            Case::Collision => {
                let input = PolicyInput {
                    chosen: choice,
                    ..self.policy_input(now, id, list)
                };
                self.plan.group(id).policy.turn_end(&input)
            }
            Case::Alone | Case::Absence | Case::Forced => None,
        };
        match end {
            Some(end) => self.arm(Timer::Turn(id), end),
            None => self.disarm(Timer::Turn(id)),
        }
    }
}
