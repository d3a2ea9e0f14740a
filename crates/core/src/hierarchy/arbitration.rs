//! Arbitration by the father (R4): at most one open question per group, a budget, and a decision in every
//! case.
//!
//! It refuses to wait for the father: the present winner stays, and the priority order decides when the
//! budget ends.

use std::borrow::Cow;
use std::sync::Arc;

use super::Hierarchy;
use super::nodes::PendingArbitration;
use super::selection::{Decision, Evaluation, TimedCause};
use super::timer::Timer;
use crate::effect::{Effect, Level};
use crate::policy::Policy;
use crate::record::{Candidate, Case, Decider};
use crate::spec::{GroupId, Nanos, SchemaId};
use crate::state::Health;

/// The outcome of asking a father.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub enum ArbitrationReply {
    /// The father decided.
    Chosen {
        /// Its choice; `None` for no child.
        child: Option<SchemaId>,
        /// The reason, in words.
        reason: String,
    },
    /// Its function panicked or returned an error.
    Failed {
        /// How it failed.
        reason: String,
    },
}

impl Hierarchy {
    /// Applies the father's answer to the question with this ticket. Has no effect if that question is no
    /// longer open.
    ///
    /// If the father fails, or chooses a schema that it was not offered, its health shows it and the priority
    /// order decides instead. If the situation changed since the question, the group selects again
    /// afterwards.
    pub fn arbitrated(
        &mut self,
        now: Nanos,
        group: GroupId,
        ticket: u64,
        answer: ArbitrationReply,
        out: &mut Vec<Effect>,
    ) {
        if self.pending_arbitration(group) != Some(ticket) {
            return;
        }
        let Some(asked) = self.cancel_arbitration(group) else {
            return;
        };
        match answer {
            ArbitrationReply::Failed { reason } => {
                self.set_arbitration_failed(group, &reason, out);
                self.overrule(now, group, asked.why, &reason, out);
            }
            ArbitrationReply::Chosen {
                child: Some(child), ..
            } if !asked.candidates.contains(&child) => {
                let who = if self.plan.contains(child) {
                    self.name(child)
                } else {
                    format!("#{}", child.0)
                };
                let reason = format!("it chose `{who}`, whom it was not offered");
                self.set_arbitration_failed(group, &reason, out);
                self.overrule(now, group, asked.why, &reason, out);
            }
            ArbitrationReply::Chosen { child, reason } => {
                self.clear_arbitration_failed(group, out);
                self.apply_reply(now, group, asked, child, reason, out);
            }
        }
        self.settle(out);
    }

    /// Notes that the machine was late, so the father of a group had no chance to answer the open question.
    /// Has no effect if none is open. When the budget ends, the priority order still decides, because a
    /// selection never waits for a machine. The father's health does not change.
    pub fn excuse(&mut self, group: GroupId) {
        if let Some(asked) = self
            .groups
            .get_mut(group.index())
            .and_then(|group| group.pending.as_mut())
        {
            asked.excused = true;
        }
    }

    /// Opens a question.
    pub(super) fn request_arbitration(
        &mut self,
        now: Nanos,
        group: GroupId,
        case: Case,
        candidates: Arc<[Candidate]>,
        why: TimedCause,
        out: &mut Vec<Effect>,
    ) {
        self.tickets += 1;
        let ticket = self.tickets;
        let on_offer = |c: &&Candidate| c.ready || (case == Case::Absence && self.choosable(c.id));
        let offered = candidates.iter().filter(on_offer).map(|c| c.id).collect();
        self.disarm(Timer::Turn(group));
        self.arm(
            Timer::Arbitration(group),
            now.saturating_add(self.plan.group(group).budget),
        );
        let winner = self.group(group).winner;
        self.group_mut(group).pending = Some(PendingArbitration {
            ticket,
            case,
            candidates: offered,
            why,
            retrigger: None,
            excused: false,
        });
        out.push(Effect::Arbitrate {
            group,
            ticket,
            level: Level {
                group,
                case,
                candidates,
                winner,
            },
        });
    }

    /// Closes an open question without an answer.
    pub(super) fn cancel_arbitration(&mut self, group: GroupId) -> Option<PendingArbitration> {
        let asked = self.group_mut(group).pending.take();
        if asked.is_some() {
            self.disarm(Timer::Arbitration(group));
        }
        asked
    }

    pub(super) fn arbitration_late(&mut self, now: Nanos, group: GroupId, out: &mut Vec<Effect>) {
        if let Some(asked) = self.cancel_arbitration(group) {
            let budget = self.plan.group(group).budget;
            let reason = format!("no answer within {} us", budget / 1_000);
            if !asked.excused {
                self.set_arbitration_failed(group, &reason, out);
            }
            self.overrule(now, group, asked.why, &reason, out);
        }
    }

    /// Carries out a valid answer and selects again if the situation changed meanwhile. If the chosen child
    /// can no longer win, it only selects again.
    fn apply_reply(
        &mut self,
        now: Nanos,
        group: GroupId,
        asked: PendingArbitration,
        child: Option<SchemaId>,
        reason: String,
        out: &mut Vec<Effect>,
    ) {
        let valid = child.is_none_or(|child| {
            self.choosable(child) && (self.node(child).ready || asked.case == Case::Absence)
        });
        if !valid {
            self.select(now, group, asked.retrigger.unwrap_or(asked.why), out);
            return;
        }
        let said = match child {
            Some(_) => None,
            None => Some(self.absent(group, asked.case)).filter(|absent| absent.choice.is_some()),
        };
        let decision = match said {
            Some(fallback) => fallback.with_reason(&reason),
            None => Decision {
                case: asked.case,
                choice: child,
                decider: Decider::Father,
                reason: Cow::Owned(reason),
                known: true,
            },
        };
        let lineup = self.candidates_of(group);
        self.decide(now, group, lineup, decision, asked.why, out);
        if let Some(again) = asked.retrigger {
            self.select(now, group, again, out);
        }
    }

    /// Decides in the father's place over the present snapshot, so no later selection is needed.
    fn overrule(&mut self, now: Nanos, group: GroupId, why: TimedCause, reason: &str, out: &mut Vec<Effect>) {
        let lineup = self.candidates_of(group);
        let decision = match self.evaluate(now, group, &lineup, Policy::PRIORITY) {
            Evaluation::Decided(decision) => decision,
            Evaluation::AskFather(case) => self.absent(group, case),
        };
        let decision = match decision.case {
            Case::Collision | Case::Absence => Decision {
                decider: Decider::ArbitrationFailed,
                ..decision.with_reason(reason)
            },
            Case::Alone | Case::Forced => decision,
        };
        self.decide(now, group, lineup, decision, why, out);
    }

    fn set_arbitration_failed(&mut self, group: GroupId, reason: &str, out: &mut Vec<Effect>) {
        if let Some(father) = self.plan.group(group).father {
            self.set_health(father, Health::ArbitrationFailed(reason.to_owned()), out);
        }
    }

    fn clear_arbitration_failed(&mut self, group: GroupId, out: &mut Vec<Effect>) {
        if let Some(father) = self.plan.group(group).father
            && matches!(self.health(father), Health::ArbitrationFailed(_))
        {
            self.set_health(father, Health::Ok, out);
        }
    }
}

impl Decision {
    fn with_reason(self, first: &str) -> Self {
        Self {
            reason: Cow::Owned(format!("{first}; {}", self.reason)),
            ..self
        }
    }
}
