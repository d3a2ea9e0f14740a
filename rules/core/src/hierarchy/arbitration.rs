//! Arbitration by the father (R4): at most one open request per group, a budget, and a decision in every
//! case.
//!
//! It refuses to wait for the father: the current winner stays, and the priority order decides when the
//! budget ends.

use std::sync::Arc;

use super::Hierarchy;
use super::group::{PendingArbitration, TimedCause};
use super::snapshot::{Decision, Evaluation};
use super::timer::Timer;
use super::transaction::Transaction;
use crate::effect::{Effect, Level};
use crate::policy::Policy;
use crate::record::{Candidate, Case, Decider};
use crate::spec::{GroupId, SchemaId};
use crate::state::Health;

/// The reply of a father to an arbitration request.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub enum ArbitrationReply {
    /// The father decided.
    Chosen {
        /// Its choice; `None` for no child.
        child: Option<SchemaId>,
        /// The reason, as text.
        reason: String,
    },
    /// Its function panicked or returned an error.
    Failed {
        /// How it failed.
        reason: String,
    },
}

impl Hierarchy {
    /// Records that the machine was late, so that the father of a group could not reply to the open request.
    /// Has no effect if no request is open. When the budget ends, the priority order still decides, because a
    /// selection never waits for a machine. The father's health does not change.
    pub fn excuse(&mut self, group: GroupId) {
        if let Some(group) = self.groups.get_mut(group) {
            group.excuse();
        }
    }
}

impl Transaction<'_> {
    /// Applies the father's reply to the request with this ticket. Has no effect if that request is no longer
    /// open.
    ///
    /// If the father fails, or chooses a schema that it was not offered, its health shows this and the
    /// priority order decides instead. If the situation changed since the request, the group selects again
    /// afterwards.
    pub fn arbitrated(&mut self, group: GroupId, ticket: u64, reply: ArbitrationReply) {
        if self.pending_arbitration(group) != Some(ticket) {
            return;
        }
        let Some(pending) = self.cancel_arbitration(group) else {
            return;
        };
        match reply {
            ArbitrationReply::Failed { reason } => {
                self.set_arbitration_failed(group, &reason);
                self.overrule(group, pending.trigger, &reason);
            }
            ArbitrationReply::Chosen {
                child: Some(child), ..
            } if !pending.candidates.contains(&child) => {
                let who = if self.plan.contains(child) {
                    self.name(child)
                } else {
                    format!("#{}", child.0)
                };
                let reason = format!("it chose `{who}`, whom it was not offered");
                self.set_arbitration_failed(group, &reason);
                self.overrule(group, pending.trigger, &reason);
            }
            ArbitrationReply::Chosen { child, reason } => {
                self.clear_arbitration_failed(group);
                self.apply_reply(group, pending, child, reason);
            }
        }
        self.settle();
    }

    /// Opens a request.
    pub(super) fn request_arbitration(
        &mut self,
        group: GroupId,
        case: Case,
        candidates: Arc<[Candidate]>,
        trigger: TimedCause,
    ) {
        self.tickets += 1;
        let ticket = self.tickets;
        let is_offered =
            |c: &&Candidate| c.ready || (case == Case::Absence && self.node(c.id).can_be_chosen());
        let offered = candidates.iter().filter(is_offered).map(|c| c.id).collect();
        self.timers.disarm(Timer::Turn(group));
        let late = self.now.saturating_add(self.plan.group(group).budget);
        self.timers.arm(Timer::Arbitration(group), late);
        let winner = self.group(group).winner();
        self.group_mut(group).open_arbitration(PendingArbitration {
            ticket,
            case,
            candidates: offered,
            trigger,
            retrigger: None,
            excused: false,
        });
        self.out.push(Effect::Arbitrate {
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

    /// Closes an open request without a reply.
    pub(super) fn cancel_arbitration(&mut self, group: GroupId) -> Option<PendingArbitration> {
        let pending = self.group_mut(group).close_arbitration();
        if pending.is_some() {
            self.timers.disarm(Timer::Arbitration(group));
        }
        pending
    }

    pub(super) fn arbitration_late(&mut self, group: GroupId) {
        if let Some(pending) = self.cancel_arbitration(group) {
            let budget = self.plan.group(group).budget;
            let reason = format!("no answer within {} us", budget / 1_000);
            if !pending.excused {
                self.set_arbitration_failed(group, &reason);
            }
            self.overrule(group, pending.trigger, &reason);
        }
    }

    /// Carries out a valid reply and selects again if the situation changed meanwhile. If the chosen child
    /// can no longer win, it only selects again.
    fn apply_reply(
        &mut self,
        group: GroupId,
        pending: PendingArbitration,
        child: Option<SchemaId>,
        reason: String,
    ) {
        let is_valid = child.is_none_or(|child| {
            let node = self.node(child);
            node.can_be_chosen() && (node.is_ready() || pending.case == Case::Absence)
        });
        if !is_valid {
            self.select(group, pending.retrigger.unwrap_or(pending.trigger));
            return;
        }
        let list = self.candidates_of(group);
        let fallback = match child {
            Some(_) => None,
            None => {
                let absent = self.snapshot(group, &list).absent(pending.case);
                Some(absent).filter(|absent| absent.choice.is_some())
            }
        };
        let decision = match fallback {
            Some(fallback) => fallback.with_reason(&reason),
            None => Decision::new(pending.case, child, Decider::Father, reason),
        };
        self.decide(group, list, decision, pending.trigger);
        if let Some(retrigger) = pending.retrigger {
            self.select(group, retrigger);
        }
    }

    /// Decides instead of the father from the current snapshot, so no later selection is needed.
    fn overrule(&mut self, group: GroupId, trigger: TimedCause, reason: &str) {
        let list = self.candidates_of(group);
        let snapshot = self.snapshot(group, &list);
        let decision = match snapshot.evaluate(Policy::PRIORITY) {
            Evaluation::Decided(decision) => decision,
            Evaluation::FatherArbitrates(case) => snapshot.absent(case),
        };
        let decision = match decision.case {
            Case::Collision | Case::Absence => Decision {
                decider: Decider::ArbitrationFailed,
                ..decision.with_reason(reason)
            },
            Case::Alone | Case::Forced => decision,
        };
        self.decide(group, list, decision, trigger);
    }

    fn set_arbitration_failed(&mut self, group: GroupId, reason: &str) {
        if let Some(father) = self.plan.group(group).father {
            self.set_health(father, Health::ArbitrationFailed(reason.to_owned()));
        }
    }

    fn clear_arbitration_failed(&mut self, group: GroupId) {
        if let Some(father) = self.plan.group(group).father
            && matches!(self.health(father), Health::ArbitrationFailed(_))
        {
            self.set_health(father, Health::Ok);
        }
    }
}
