//! Arbitration by the father (R4): at most one open question per group, a budget, and a decision in every
//! case.
//!
//! It refuses to wait for the father: the present winner stays, and the priority order decides when the
//! budget ends.

use std::borrow::Cow;
use std::sync::Arc;

use super::Hierarchy;
use super::parts::Asked;
use super::selection::{Decision, Verdict, Why};
use super::timer::Timer;
use crate::effect::{Effect, Level};
use crate::record::{Candidate, Case, Decider};
use crate::spec::{GroupId, Nanos, Policy, SchemaId};
use crate::state::Health;

/// The outcome of asking a father.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub enum Answer {
    /// The father decided.
    Chose {
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
    pub fn answered(
        &mut self,
        now: Nanos,
        group: GroupId,
        ticket: u64,
        answer: Answer,
        out: &mut Vec<Effect>,
    ) {
        if self.asked(group) != Some(ticket) {
            return;
        }
        let Some(asked) = self.drop_ask(group) else { return };
        match answer {
            Answer::Failed { reason } => {
                self.blame(group, &reason, out);
                self.overrule(now, group, asked.why, &reason, out);
            }
            Answer::Chose {
                child: Some(child), ..
            } if !asked.offered.contains(&child) => {
                let who = if self.plan.knows(child) {
                    self.name(child)
                } else {
                    format!("#{}", child.0)
                };
                let reason = format!("it chose `{who}`, whom it was not offered");
                self.blame(group, &reason, out);
                self.overrule(now, group, asked.why, &reason, out);
            }
            Answer::Chose { child, reason } => {
                self.arbitration_went_well(group, out);
                self.follow(now, group, asked, child, reason, out);
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
            .and_then(|group| group.asked.as_mut())
        {
            asked.excused = true;
        }
    }

    /// Opens a question.
    pub(super) fn ask(
        &mut self,
        now: Nanos,
        group: GroupId,
        case: Case,
        candidates: Arc<[Candidate]>,
        why: Why,
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
        self.group_mut(group).asked = Some(Asked {
            ticket,
            case,
            offered,
            why,
            again: None,
            excused: false,
        });
        out.push(Effect::Ask {
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
    pub(super) fn drop_ask(&mut self, group: GroupId) -> Option<Asked> {
        let asked = self.group_mut(group).asked.take();
        if asked.is_some() {
            self.disarm(Timer::Arbitration(group));
        }
        asked
    }

    pub(super) fn arbitration_late(&mut self, now: Nanos, group: GroupId, out: &mut Vec<Effect>) {
        if let Some(asked) = self.drop_ask(group) {
            let budget = self.plan.group(group).budget;
            let reason = format!("no answer within {} us", budget / 1_000);
            if !asked.excused {
                self.blame(group, &reason, out);
            }
            self.overrule(now, group, asked.why, &reason, out);
        }
    }

    /// Carries out a valid answer and selects again if the situation changed meanwhile. If the chosen child
    /// can no longer win, it only selects again.
    fn follow(
        &mut self,
        now: Nanos,
        group: GroupId,
        asked: Asked,
        child: Option<SchemaId>,
        reason: String,
        out: &mut Vec<Effect>,
    ) {
        let valid = child.is_none_or(|child| {
            self.choosable(child) && (self.node(child).ready || asked.case == Case::Absence)
        });
        if !valid {
            self.select(now, group, asked.again.unwrap_or(asked.why), out);
            return;
        }
        let said = match child {
            Some(_) => None,
            None => Some(self.absent(group, asked.case)).filter(|absent| absent.choice.is_some()),
        };
        let decision = match said {
            Some(fallback) => fallback.because(&reason),
            None => Decision {
                case: asked.case,
                choice: child,
                decider: Decider::Father,
                reason: Cow::Owned(reason),
                known: true,
            },
        };
        let lineup = self.lineup(group);
        self.decide(now, group, lineup, decision, asked.why, out);
        if let Some(again) = asked.again {
            self.select(now, group, again, out);
        }
    }

    /// Decides in the father's place over the present snapshot, so no later selection is needed.
    fn overrule(&mut self, now: Nanos, group: GroupId, why: Why, reason: &str, out: &mut Vec<Effect>) {
        let lineup = self.lineup(group);
        let decision = match self.judge(now, group, &lineup, Policy::Priority) {
            Verdict::Decided(decision) => decision,
            Verdict::Ask(case) => self.absent(group, case),
        };
        let decision = match decision.case {
            Case::Collision | Case::Absence => Decision {
                decider: Decider::ArbitrationFailed,
                ..decision.because(reason)
            },
            Case::Alone | Case::Forced => decision,
        };
        self.decide(now, group, lineup, decision, why, out);
    }

    fn blame(&mut self, group: GroupId, reason: &str, out: &mut Vec<Effect>) {
        if let Some(father) = self.plan.group(group).father {
            self.set_health(father, Health::ArbitrationFailed(reason.to_owned()), out);
        }
    }

    fn arbitration_went_well(&mut self, group: GroupId, out: &mut Vec<Effect>) {
        if let Some(father) = self.plan.group(group).father
            && matches!(self.health(father), Health::ArbitrationFailed(_))
        {
            self.set_health(father, Health::Ok, out);
        }
    }
}

impl Decision {
    fn because(self, first: &str) -> Self {
        Self {
            reason: Cow::Owned(format!("{first}; {}", self.reason)),
            ..self
        }
    }
}
