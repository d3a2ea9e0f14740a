//! Selection in a group (R2, R3): one snapshot, one case, one choice, one record.
//!
//! It refuses to select below a father that is being replaced, and while a question to the father is open.

use std::borrow::Cow;

use super::Hierarchy;
use super::lineup::Lineup;
use super::parts::{Origin, Phase, Run};
use super::policy::Field;
use super::timer::Timer;
use crate::effect::Effect;
use crate::record::{Candidate, Case, Cause, Decider, Record};
use crate::spec::{Absence, GroupId, Nanos, Policy, SchemaId};
use crate::state::Standing;

/// What led to a selection, and when that began.
#[derive(Copy, Clone, PartialEq, Eq, Hash, Debug)]
pub(super) struct Why {
    pub(super) cause: Cause,
    /// When the situation began.
    pub(super) time: Nanos,
}

/// The result of judging a snapshot.
pub(super) enum Verdict {
    Decided(Decision),
    /// The father must decide.
    Ask(Case),
}

pub(super) struct Decision {
    pub(super) case: Case,
    pub(super) choice: Option<SchemaId>,
    pub(super) decider: Decider,
    pub(super) reason: Cow<'static, str>,
    /// Whether the decision is carried out. False while no member can be chosen because not all have checked
    /// yet, so the absence policy waits. False, too, when an operator stopped everything.
    pub(super) known: bool,
}

impl Why {
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
    /// Selects in a group, or asks its father to.
    pub(super) fn select(&mut self, now: Nanos, id: GroupId, why: Why, out: &mut Vec<Effect>) {
        if self.phase != Phase::Running || self.frozen(id) {
            return;
        }
        if self.forced_choice(id).is_some() {
            self.drop_ask(id);
        }
        if let Some(asked) = &mut self.group_mut(id).asked {
            asked.again.get_or_insert(why);
            return;
        }
        let lineup = self.lineup(id);
        match self.judge(now, id, &lineup, self.plan.group(id).policy) {
            Verdict::Decided(decision) => self.decide(now, id, lineup, decision, why, out),
            Verdict::Ask(case) => self.ask(now, id, case, lineup.candidates, why, out),
        }
    }

    /// Whether a member can be chosen although it is not READY.
    pub(super) fn choosable(&self, id: SchemaId) -> bool {
        let node = self.node(id);
        self.is_awake(id) && node.wanted() && node.run != Run::Abandoned
    }

    /// Judges a snapshot under a policy.
    pub(super) fn judge(&self, now: Nanos, id: GroupId, lineup: &Lineup, policy: Policy) -> Verdict {
        if let Some(forced) = self.forced_choice(id) {
            let decision = Decision::new(
                Case::Forced,
                Some(forced),
                Decider::Operator,
                "forced by an operator",
            );
            return Verdict::Decided(decision);
        }
        let case = match (lineup.first, lineup.several) {
            (None, _) => return self.judge_absence(id, &lineup.candidates, policy),
            (Some(only), false) => {
                let only = Some(lineup.candidates[only].id);
                let decision = Decision::new(Case::Alone, only, Decider::Nobody, "the only one ready");
                return Verdict::Decided(decision);
            }
            (Some(_), true) => Case::Collision,
        };
        if policy == Policy::Father && self.father_hears(id) {
            return Verdict::Ask(case);
        }
        let chosen = self.field(now, id, lineup).choose(policy);
        let (choice, reason) = chosen.map_or((None, "nobody is ready"), |(id, reason)| (Some(id), reason));
        let decider = match policy {
            // The father sleeps: an operator plays the members.
            Policy::Father => Decider::ArbitrationFailed,
            Policy::Priority | Policy::HighestUrgency | Policy::Sticky { .. } | Policy::RoundRobin { .. } => {
                Decider::Policy(policy)
            }
        };
        Verdict::Decided(Decision::new(case, choice, decider, reason))
    }

    /// Returns the decision of the absence policy in a group where no member is to win: the fallback, if it
    /// can win.
    pub(super) fn absent(&self, id: GroupId, case: Case) -> Decision {
        let (choice, reason) = match self.plan.group(id).absence {
            Absence::Fallback(fallback) if self.choosable(fallback) => {
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
        lineup: Lineup,
        decision: Decision,
        why: Why,
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
        self.arm_turn(now, id, case, choice, &lineup);
        out.push(Effect::Decided(Record {
            number,
            time: now,
            cause_time: why.time,
            group: id,
            case,
            candidates: lineup.candidates,
            before,
            choice,
            decider,
            reason,
            cause: why.cause,
            changed,
        }));
        if known {
            self.carry_out(
                now,
                id,
                choice,
                Origin {
                    record: number,
                    cause_time: why.time,
                },
                why,
                out,
            );
        }
    }

    pub(super) fn turn_over(&mut self, now: Nanos, id: GroupId, out: &mut Vec<Effect>) {
        self.select(now, id, Why::new(Cause::Timer(Timer::Turn(id)), now), out);
    }

    fn judge_absence(&self, id: GroupId, candidates: &[Candidate], policy: Policy) -> Verdict {
        let unchecked = |c: &Candidate| !self.node(c.id).checked && self.choosable(c.id);
        // While the group commands, an absence cannot wait. When its members have just woken, it can.
        if self.group(id).standing != Standing::Commanding && candidates.iter().any(unchecked) {
            let reason = "nobody is ready yet; not all have been checked since they woke";
            let decision = Decision::new(Case::Absence, None, Decider::Nobody, reason);
            return Verdict::Decided(Decision {
                known: false,
                ..decision
            });
        }
        if policy == Policy::Father && !candidates.is_empty() && self.father_hears(id) {
            return Verdict::Ask(Case::Absence);
        }
        Verdict::Decided(self.absent(id, Case::Absence))
    }

    fn forced_choice(&self, id: GroupId) -> Option<SchemaId> {
        self.group(id).forced.filter(|&forced| self.choosable(forced))
    }

    fn father_hears(&self, id: GroupId) -> bool {
        self.plan
            .group(id)
            .father
            .is_some_and(|father| self.is_awake(father))
    }

    fn field<'a>(&'a self, now: Nanos, id: GroupId, lineup: &'a Lineup) -> Field<'a> {
        let group = self.group(id);
        let (since, last) = (group.since, group.last);
        Field {
            candidates: &lineup.candidates,
            first: lineup.first,
            members: self.plan.members(id),
            chosen: group.choice(),
            since,
            last,
            now,
        }
    }

    fn arm_turn(&mut self, now: Nanos, id: GroupId, case: Case, choice: Option<SchemaId>, lineup: &Lineup) {
        let end = match case {
            Case::Collision => {
                let field = Field {
                    chosen: choice,
                    ..self.field(now, id, lineup)
                };
                field.turn_end(self.plan.group(id).policy)
            }
            Case::Alone | Case::Absence | Case::Forced => None,
        };
        match end {
            Some(end) => self.arm(Timer::Turn(id), end),
            None => self.disarm(Timer::Turn(id)),
        }
    }
}
