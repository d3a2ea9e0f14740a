//! The evaluation of one group at one instant (R2, R3): the case, and the decision of an operator's force, a
//! policy or the absence policy.
//!
//! Read only. It refuses to decide for a father that is awake and arbitrates by itself.

use std::borrow::Cow;

use super::candidates::CandidateList;
use super::group::Group;
use super::nodes::Nodes;
use crate::policy::{Policy, PolicyInput};
use crate::record::{Candidate, Case, Decider};
use crate::spec::{Absence, GroupSpec, Nanos, SchemaId};
use crate::state::ActuationState;

/// All facts that a selection in one group uses.
pub(super) struct Snapshot<'a> {
    pub(super) now: Nanos,
    pub(super) spec: &'a GroupSpec,
    pub(super) group: &'a Group,
    pub(super) nodes: &'a Nodes,
    pub(super) list: &'a CandidateList,
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

impl Decision {
    pub(super) fn new(
        case: Case,
        choice: Option<SchemaId>,
        decider: Decider,
        reason: impl Into<Cow<'static, str>>,
    ) -> Self {
        Self {
            case,
            choice,
            decider,
            reason: reason.into(),
            known: true,
        }
    }

    /// Returns the decision that no member wins, without the absence policy.
    fn nobody(decider: Decider, reason: &'static str) -> Self {
        Self {
            known: false,
            ..Self::new(Case::Absence, None, decider, reason)
        }
    }

    pub(super) fn all_stopped() -> Self {
        Self::nobody(Decider::Operator, "an operator stopped everything")
    }

    pub(super) fn with_reason(self, first: &str) -> Self {
        Self {
            reason: Cow::Owned(format!("{first}; {}", self.reason)),
            ..self
        }
    }
}

/// Returns the member that operators force: that of the newest force whose schema can win.
pub(super) fn forced_choice(group: &Group, nodes: &Nodes) -> Option<SchemaId> {
    let mut forced = group.forces().map(|(_, forced)| forced);
    forced.find(|&forced| nodes.get(forced).can_be_chosen())
}

impl Snapshot<'_> {
    // Otherwise the decision passes through memory on its way to the selection.
    #[inline(always)]
    pub(super) fn evaluate(&self, policy: Policy) -> Evaluation {
        if let Some(forced) = forced_choice(self.group, self.nodes) {
            let (choice, reason) = (Some(forced), "forced by an operator");
            return Evaluation::Decided(Decision::new(Case::Forced, choice, Decider::Operator, reason));
        }
        let case = match (self.list.first, self.list.several) {
            (None, _) => return self.evaluate_absence(policy),
            (Some(index), false) => {
                let only = Some(self.list.candidates[index].id);
                let decision = Decision::new(Case::Alone, only, Decider::Nobody, "the only one ready");
                return Evaluation::Decided(decision);
            }
            (Some(_), true) => Case::Collision,
        };
        if policy == Policy::FATHER && self.can_father_arbitrate() {
            return Evaluation::FatherArbitrates(case);
        }
        let chosen = policy.choose(&self.policy_input());
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
    pub(super) fn absent(&self, case: Case) -> Decision {
        let (choice, reason) = match self.spec.absence {
            Absence::Fallback(fallback) if self.nodes.get(fallback).can_fall_back() => {
                (Some(fallback), "nobody is ready: the fallback wins")
            }
            Absence::Fallback(_) => (None, "nobody is ready, nor can the fallback win: brake"),
            Absence::Brake => (None, "nobody is ready: brake"),
            Absence::Hold { .. } => (None, "nobody is ready: hold the last command, then brake"),
        };
        Decision::new(case, choice, Decider::AbsencePolicy, reason)
    }

    /// Returns when the policy could replace this choice without an event.
    pub(super) fn turn_end(&self, case: Case, choice: Option<SchemaId>) -> Option<Nanos> {
        match case {
            Case::Collision => self.spec.policy.turn_end(&PolicyInput {
                chosen: choice,
                ..self.policy_input()
            }),
            Case::Alone | Case::Absence | Case::Forced => None,
        }
    }

    fn evaluate_absence(&self, policy: Policy) -> Evaluation {
        let is_unchecked = |candidate: &Candidate| {
            let node = self.nodes.get(candidate.id);
            !node.is_checked() && node.can_be_chosen()
        };
        let candidates = &self.list.candidates;
        // An absence waits for the first checks of members that have just woken, but not while the group
        // commands.
        if self.group.actuation() != ActuationState::Commanding && candidates.iter().any(is_unchecked) {
            let reason = "nobody is ready yet; not all have been checked since they woke";
            return Evaluation::Decided(Decision::nobody(Decider::Nobody, reason));
        }
        if policy == Policy::FATHER && !candidates.is_empty() && self.can_father_arbitrate() {
            return Evaluation::FatherArbitrates(Case::Absence);
        }
        Evaluation::Decided(self.absent(Case::Absence))
    }

    fn can_father_arbitrate(&self) -> bool {
        self.spec
            .father
            .is_some_and(|father| self.nodes.get(father).is_awake())
    }

    fn policy_input(&self) -> PolicyInput<'_> {
        self.group.policy_input(self.now, &self.spec.members, self.list)
    }
}
