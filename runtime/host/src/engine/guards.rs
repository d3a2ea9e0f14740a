//! Guards of commands (R18): the judgement of a command, and what follows from it. A judgement calls a plugin and may
//! not return, so it runs under no lock, on copies; the guard answers for it.

use std::sync::atomic::Ordering;

use jde_core::{Nanos, SchemaId};
use jde_loader::{AlignedBytes, Judgement};
use jde_records::event::What;
use jde_records::turn::TurnKind;

use super::Engine;
use crate::instance::{
    CommandInForce, PortAccess, PortGuard, Refusal, StateCopy, UnjudgedCommand, UnjudgedInForce,
};

/// A command that guards judged: it may take effect.
pub(crate) struct JudgedCommand {
    /// What takes effect.
    pub(crate) bytes: AlignedBytes,
    /// The guard that limited it, and its reason in words.
    pub(crate) limit: Option<(SchemaId, String)>,
    /// The number of the state by which each guard judged.
    states: Vec<u64>,
}

impl Engine {
    /// Lets guards judge a command of a schema, in its call. In a replay nothing is refused: it repeats the recorded
    /// refusals.
    ///
    /// # Errors
    /// The refusal of the first guard that refuses it.
    pub(crate) fn judge(
        &self,
        commander: SchemaId,
        unjudged: UnjudgedCommand,
        now: Nanos,
    ) -> Result<JudgedCommand, Refusal> {
        let original = unjudged.bytes.clone();
        match self.judge_by_all(commander, unjudged, now) {
            Err(_) if self.clock.is_replayed() => Ok(JudgedCommand {
                bytes: original,
                limit: None,
                states: Vec::new(),
            }),
            judged => judged,
        }
    }

    fn judge_by_all(
        &self,
        commander: SchemaId,
        UnjudgedCommand { guards, mut bytes }: UnjudgedCommand,
        now: Nanos,
    ) -> Result<JudgedCommand, Refusal> {
        let (mut limit, mut states) = (None, Vec::new());
        // What the last guard limits, the others must accept as it is.
        let mut again = true;
        while std::mem::take(&mut again) {
            states.clear();
            for guard in guards.iter() {
                let refuse = |reason| Refusal {
                    commander,
                    guard: guard.guard,
                    reason,
                    in_force: None,
                };
                let state = guard.state.newest(now).map_err(refuse)?;
                states.push(state.sequence);
                let begun = self.metrics[commander].begin_judgement(guard.guard, now);
                let judgement = self.judge_by(guard.guard, &state, now, &bytes);
                self.metrics[commander].end_judgement(begun, self.clock.now());
                match judgement {
                    Judgement::Accepted => {}
                    Judgement::Refused(reason) => return Err(refuse(reason)),
                    Judgement::Limited(_, reason) if limit.is_some() => return Err(refuse(reason)),
                    Judgement::Limited(limited, reason) => {
                        bytes = limited;
                        limit = Some((guard.guard, reason));
                        again = guards.len() > 1;
                    }
                }
            }
        }
        Ok(JudgedCommand { bytes, limit, states })
    }

    /// Lets a guard judge the commands that are in force, in its own call.
    pub(crate) fn judge_in_force(
        &self,
        guard: SchemaId,
        unjudged: UnjudgedInForce,
        now: Nanos,
    ) -> Vec<(CommandInForce, Judgement)> {
        let UnjudgedInForce { state, commands } = unjudged;
        let judge = |bytes: &AlignedBytes| match &state {
            Ok(state) => self.judge_by(guard, state, now, bytes),
            Err(reason) => Judgement::Refused(reason.clone()),
        };
        let judged = commands
            .into_iter()
            .map(|(command, bytes)| (command, judge(&bytes)));
        judged.collect()
    }

    fn judge_by(&self, guard: SchemaId, state: &StateCopy, now: Nanos, command: &AlignedBytes) -> Judgement {
        match &self.builds.current(guard).judge {
            Some(judge) => state.judge(judge, now, command),
            None => Judgement::Refused(String::from("its build judges no command")),
        }
    }

    /// Judges a command again that has just taken effect, if a guard has another state since it was judged: the guard
    /// may have judged what was in force without seeing it.
    pub(crate) fn judge_if_changed(
        &self,
        unjudged: UnjudgedCommand,
        judged: &JudgedCommand,
        command: CommandInForce,
    ) {
        let now = self.clock.now();
        let is_same = |(guard, judged_by): (&PortGuard, &u64)| {
            guard
                .state
                .newest(now)
                .is_ok_and(|state| state.sequence == *judged_by)
        };
        if self.clock.is_replayed() || unjudged.guards.iter().zip(&judged.states).all(is_same) {
            return;
        }
        let in_force = Some((command.variable, command.sequence));
        if let Err(refusal) = self.judge_by_all(command.commander, unjudged, now) {
            self.report_refusal(&Refusal { in_force, ..refusal });
        }
    }

    /// Carries out what a guard said of the commands in force.
    pub(crate) fn apply_in_force(&self, guard: SchemaId, judged: Vec<(CommandInForce, Judgement)>) {
        for (command, judgement) in judged {
            let CommandInForce {
                variable,
                sequence,
                commander,
            } = command;
            match judgement {
                Judgement::Accepted => {}
                Judgement::Limited(limited, _) => {
                    self.rules.limit_in_force(&variable, sequence, limited.bytes());
                }
                Judgement::Refused(reason) => self.report_refusal(&Refusal {
                    commander,
                    guard,
                    reason,
                    in_force: Some((variable, sequence)),
                }),
            }
        }
    }

    /// Reports that a guard refused a command. The schema that gave it is not READY until its retry. One that was in
    /// force is neutral from now on.
    pub(crate) fn report_refusal(&self, refusal: &Refusal) {
        let commander = refusal.commander;
        let words = self.words_of("refused", refusal.guard, &refusal.reason);
        self.metrics[commander].refused.fetch_add(1, Ordering::Relaxed);
        let moment = self
            .rules
            .transact_refusal(commander, words, refusal.in_force.as_ref());
        if moment.order > 0 {
            self.rules
                .record_turn(TurnKind::CommandRefused, commander, moment);
        }
    }

    /// Reports that a guard limited a command.
    pub(crate) fn report_limit(&self, commander: SchemaId, guard: SchemaId, reason: &str) {
        self.report_limited(commander, self.words_of("limited", guard, reason));
    }

    /// Reports that a command exceeded the limits of its driver.
    pub(crate) fn report_limits(&self, commander: SchemaId, stated_by: &str) {
        self.report_limited(commander, format!("command limited by `{stated_by}`"));
    }

    fn report_limited(&self, commander: SchemaId, description: String) {
        self.rules.report_now(What::Limited {
            schema: commander,
            description,
        });
    }

    /// How long a schema is not READY after a refusal, ns.
    pub(crate) fn retry_of(&self, commander: SchemaId) -> Nanos {
        let group = self.application.instances[commander].group;
        group.map_or(0, |group| self.application.groups[group].retry_ns)
    }

    /// Repeats a recorded refusal. The reason comes from another judgement of the command, by the state that
    /// the guard has in the replay; another build of the guard may accept it.
    pub(crate) fn repeat_refusal(&self, commander: SchemaId, ports: &PortAccess) {
        let now = self.clock.now();
        let commands = ports
            .with_ports(|ports| ports.newest_commands(now))
            .unwrap_or_default();
        let refused = commands
            .into_iter()
            .find_map(|command| self.judge_by_all(commander, command, now).err());
        let words = match refused {
            Some(refusal) => self.words_of("refused", refusal.guard, &refusal.reason),
            None => String::from("command refused in the recording, and accepted now"),
        };
        self.rules.transact_refusal(commander, words, None);
    }

    fn words_of(&self, what: &str, guard: SchemaId, reason: &str) -> String {
        format!("command {what} by the guard `{}`: {reason}", self.name(guard))
    }
}
