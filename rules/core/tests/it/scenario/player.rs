//! Plays a scenario on the real state machine, and compares it with the shadow model.
//!
//! It stops at the first difference from the scenario.

use jde_core::{
    ArbitrationReply, Check, Effect, Hierarchy, Holder, Nanos, Operator, Record, Refused, SchemaId,
    Transaction,
};

use super::phrases::{Names, Time, case, decider, health, number, policy, state, time};
use super::{Scenario, Step, Why};
use jde_shadow::{Shadow, ids};

/// Plays all steps and returns all effects.
pub(super) fn play(scenario: &Scenario) -> Result<Vec<Effect>, String> {
    let spec = scenario.spec()?;
    let shadow = Shadow::new(&spec);
    let join = |faults: Vec<jde_core::SpecError>| {
        faults
            .iter()
            .map(ToString::to_string)
            .collect::<Vec<_>>()
            .join("; ")
    };
    let h = Hierarchy::new(spec).map_err(join)?;
    let mut player = Player {
        h,
        shadow,
        now: 0,
        effects: Vec::new(),
        refused: Vec::new(),
    };
    let mut all = Vec::new();
    for (index, step) in scenario.step.iter().enumerate() {
        player
            .play(step)
            .map_err(|error| format!("step {} at {}: {error}", index + 1, step.at))?;
        all.append(&mut player.effects);
    }
    Ok(all)
}

struct Player {
    h: Hierarchy,
    shadow: Shadow,
    now: Nanos,
    /// The effects of the current step.
    effects: Vec<Effect>,
    refused: Vec<Refused>,
}

impl Player {
    fn play(&mut self, step: &Step) -> Result<(), String> {
        let at = time(&step.at)?;
        if at < self.now {
            return Err("the time is before the previous step".into());
        }
        self.now = at;
        self.refused.clear();
        self.call(|transaction| transaction.tick())?;
        for phrase in &step.when {
            self.perform(phrase)
                .map_err(|error| format!("when \"{phrase}\": {error}"))?;
        }
        self.check_expectations(step)
    }

    fn call<T>(&mut self, call: impl FnOnce(&mut Transaction) -> T) -> Result<T, String> {
        let mut out = Vec::new();
        let result = call(&mut self.h.at(self.now, &mut out));
        self.shadow.apply(self.h.spec(), &out)?;
        self.shadow.check_against(&self.h)?;
        self.effects.append(&mut out);
        Ok(result)
    }

    fn perform(&mut self, phrase: &str) -> Result<(), String> {
        let (head, reason) = phrase
            .split_once(": ")
            .map_or((phrase, ""), |(head, reason)| (head, reason));
        let words: Vec<&str> = head.split_whitespace().collect();
        let now = self.now;
        match words.as_slice() {
            ["the", "application", "starts"] => self.call(|transaction| transaction.start()),
            ["the", "application", "shuts", "down"] => {
                self.shadow.begin_shutdown();
                self.call(|transaction| transaction.shutdown())
            }
            [who @ ("operator" | "ana" | "ben"), what @ ..] => self.operate(who, what),
            ["everything", "goes", "on"] => self
                .call(|transaction| transaction.release_all())?
                .map(drop)
                .map_err(|refused| refused.to_string()),
            ["the", "debugger", "holds", name] => self.debug(name, true),
            ["the", "debugger", "lets", name, "go", "on"] => self.debug(name, false),
            [name, "becomes", "unready"] => self.check(name, false, None, now),
            [name, "becomes", "ready"] => self.check(name, true, None, now),
            [name, "becomes", "ready", "since", since] => self.check(name, true, None, time(since)?),
            [name, "becomes", "ready", "with", "urgency", urgency] => {
                self.check(name, true, Some(number(urgency)?), now)
            }
            [name, "begins"] => self.begin(name, true),
            [name, "may", "not", "begin"] => self.begin(name, false),
            [name, "ends"] => self.end(name),
            [name, "iterates"] => self.begin(name, true).and_then(|()| self.end(name)),
            [name, "commands"] => self.command(name, true),
            [name, "may", "not", "command"] => self.command(name, false),
            [father, "wakes", child] => self
                .call_child(father, child, |transaction, father, child| {
                    transaction.wake(father, child)
                })
                .and_then(accepted),
            [father, "may", "not", "wake", child] => self
                .call_child(father, child, |transaction, father, child| {
                    transaction.wake(father, child)
                })
                .and_then(|r| self.refusal(r)),
            [father, "lets", child, "sleep"] => self
                .call_child(father, child, |transaction, father, child| {
                    transaction.sleep(father, child)
                })
                .and_then(accepted),
            [name, "faults"] => self.on(name, |transaction, id| transaction.faulted(id, reason.to_owned())),
            ["the", "guard", "refuses", name] => self.on(name, |transaction, id| transaction.refused(id)),
            [name, "is", "replaced"] => self.on(name, |transaction, id| transaction.restored(id)),
            [name, "overruns"] => self.on(name, |transaction, id| transaction.overrun(id)),
            [name, "is", "on", "time"] => self.on(name, |transaction, id| transaction.on_time(id)),
            [name, "is", "retimed", "to", period] => {
                let period = time(period)?;
                self.on(name, |transaction, id| transaction.set_period(id, period))
            }
            [father, "chooses", child, "in", group] => {
                let child = if *child == "nobody" {
                    None
                } else {
                    Some(self.find(child)?)
                };
                self.reply(
                    father,
                    group,
                    ArbitrationReply::Chosen {
                        child,
                        reason: reason.to_owned(),
                    },
                )
            }
            [father, "fails", "to", "choose", "in", group] => self.reply(
                father,
                group,
                ArbitrationReply::Failed {
                    reason: reason.to_owned(),
                },
            ),
            [group, "turns", "to", text @ ..] => {
                let group = Names(self.h.spec()).find_group(group)?;
                let policy = policy(&text.join(" "))?;
                let result = self.call(|transaction| transaction.set_policy(group, policy))?;
                result.map_err(|error| error.to_string())
            }
            _ => Err("the phrase is unknown".into()),
        }
    }

    fn find(&self, name: &str) -> Result<SchemaId, String> {
        Names(self.h.spec()).find(name)
    }

    fn on(&mut self, name: &str, call: impl FnOnce(&mut Transaction, SchemaId)) -> Result<(), String> {
        let id = self.find(name)?;
        self.call(|transaction| call(transaction, id))
    }

    fn check(&mut self, name: &str, ready: bool, urgency: Option<f64>, cause: Nanos) -> Result<(), String> {
        let id = self.find(name)?;
        let check = Check {
            ready,
            urgency: urgency.unwrap_or(0.0),
            cause,
        };
        self.call(|transaction| transaction.checked(id, check))
    }

    fn begin(&mut self, name: &str, expected: bool) -> Result<(), String> {
        let id = self.find(name)?;
        if self.call(|transaction| transaction.begin(id))? != expected {
            return Err(format!("it {} begin", if expected { "may not" } else { "may" }));
        }
        if expected {
            self.shadow.begin_iteration(id);
        }
        Ok(())
    }

    fn end(&mut self, name: &str) -> Result<(), String> {
        let id = self.find(name)?;
        self.shadow.end_iteration(id);
        self.call(|transaction| transaction.end(id))
    }

    fn command(&self, name: &str, expected: bool) -> Result<(), String> {
        if self.h.has_authority(self.find(name)?) == expected {
            Ok(())
        } else {
            Err(format!(
                "it has {} authority",
                if expected { "no" } else { "the" }
            ))
        }
    }

    fn call_child(
        &mut self,
        father: &str,
        child: &str,
        call: impl FnOnce(&mut Transaction, SchemaId, SchemaId) -> Result<(), Refused>,
    ) -> Result<Result<(), Refused>, String> {
        let (father, child) = (self.find(father)?, self.find(child)?);
        self.call(|transaction| call(transaction, father, child))
    }

    /// Carries out what an operator does, or may not do, lastingly or under a lease.
    fn operate(&mut self, who: &str, what: &[&str]) -> Result<(), String> {
        let operator = match who {
            "operator" => 1,
            "ana" => 2,
            _ => 3,
        };
        let lasting = Holder::lasting(operator);
        let ended = match what {
            ["stops", "everything"] => self.call(|transaction| transaction.stop_all(lasting))?,
            ["lets", "go", "of", name] => self.let_go(lasting, name)?,
            ["ends", "the", "lease", "on", name] => self.let_go(Holder::leased(operator), name)?,
            ["loads", name] => {
                let id = self.find(name)?;
                self.call(|transaction| transaction.load(id))?
            }
            ["may", "not", verb, name, lease @ ..] => {
                let refused = self.act(holder(operator, lease)?, verb, name)?;
                return self.refusal(refused);
            }
            [verb, name, lease @ ..] => self.act(holder(operator, lease)?, verb, name)?,
            _ => return Err("an operator cannot do this".into()),
        };
        accepted(ended)
    }

    fn let_go(&mut self, by: Holder, name: &str) -> Result<Result<(), Refused>, String> {
        let id = self.find(name)?;
        Ok(self.call(|transaction| transaction.let_go(by, id))?.map(drop))
    }

    fn act(&mut self, by: Holder, verb: &str, name: &str) -> Result<Result<(), Refused>, String> {
        let id = self.find(name)?;
        let action = match verb {
            "unloads" => return self.call(|transaction| transaction.unload(by, id)),
            "plays" | "play" => Operator::Play(id),
            "stops" | "stop" => Operator::Stop(id),
            "forces" | "force" => Operator::Force(id),
            "releases" | "release" => Operator::Release(id),
            _ => return Err(format!("an operator cannot `{verb}`")),
        };
        self.call(|transaction| transaction.operator(by, action))
    }

    fn debug(&mut self, name: &str, debugged: bool) -> Result<(), String> {
        let id = self.find(name)?;
        self.shadow.set_debugged(id, debugged);
        self.call(|transaction| transaction.set_debugged(id, debugged))
    }

    fn refusal(&mut self, result: Result<(), Refused>) -> Result<(), String> {
        match result {
            Ok(()) => Err("it was not refused".into()),
            Err(refused) => {
                self.refused.push(refused);
                Ok(())
            }
        }
    }

    fn reply(&mut self, father: &str, group: &str, reply: ArbitrationReply) -> Result<(), String> {
        let id = Names(self.h.spec()).find_group(group)?;
        if self.h.spec().groups[id].father != Some(self.find(father)?) {
            return Err(format!("`{father}` is not the father of `{group}`"));
        }
        let ticket = self
            .h
            .pending_arbitration(id)
            .ok_or("no arbitration is pending")?;
        self.call(|transaction| transaction.arbitrated(id, ticket, reply))
    }

    fn check_expectations(&self, step: &Step) -> Result<(), String> {
        let names = Names(self.h.spec());
        let effects: Vec<String> = self.effects.iter().map(|effect| names.effect(effect)).collect();
        let mut rest = effects.iter();
        for expected in &step.order {
            if !rest.any(|effect| effect == expected) {
                return Err(format!(
                    "\"{expected}\" does not follow in this order; the effects are {effects:#?}"
                ));
            }
        }
        if let Some(unwanted) = step.never.iter().find(|unwanted| effects.contains(unwanted)) {
            return Err(format!("\"{unwanted}\" follows"));
        }
        for (name, expected) in &step.states {
            expect_equal(
                &format!("the state of {name}"),
                state(self.h.state(names.find(name)?)),
                expected,
            )?;
        }
        for (group, expected) in &step.winner {
            let winner = self.h.winner(names.find_group(group)?);
            expect_equal(
                &format!("the winner of {group}"),
                names.optional(winner),
                expected,
            )?;
        }
        if let Some(expected) = &step.authority {
            let mut holders: Vec<&str> = ids(names.0)
                .filter(|&id| self.h.has_authority(id))
                .map(|id| names.schema(id))
                .collect();
            let mut expected: Vec<&str> = expected.iter().map(String::as_str).collect();
            holders.sort_unstable();
            expected.sort_unstable();
            expect_equal("authority", &holders.join(", "), &expected.join(", "))?;
        }
        for (name, expected) in &step.health {
            expect_equal(
                &format!("the health of {name}"),
                &health(self.h.health(names.find(name)?)),
                expected,
            )?;
        }
        for (group, why) in &step.why {
            self.check_record(group, why)
                .map_err(|error| format!("why {group}: {error}"))?;
        }
        let expected = step.refused.as_deref().unwrap_or_default();
        let refused: Vec<String> = self.refused.iter().map(ToString::to_string).collect();
        let matches = expected.len() == refused.len()
            && refused.iter().zip(expected).all(|(r, e)| r.contains(e.as_str()));
        if step.refused.is_some() && !matches {
            return Err(format!("the refusals are {refused:#?}, not {expected:#?}"));
        }
        if let Some(expected) = &step.timer {
            let due = self
                .h
                .next_timer()
                .map_or("none".into(), |due| Time(due).to_string());
            expect_equal("the next timer", &due, expected)?;
        }
        for (group, expected) in &step.contract {
            let id = names.find_group(group)?;
            let contracts = jde_core::contract(self.h.spec());
            let line = contracts
                .iter()
                .find(|c| c.group == id)
                .ok_or("no contract")?
                .to_string();
            expect_equal(&format!("the contract of {group}"), &line, expected)?;
        }
        Ok(())
    }

    fn check_record(&self, group: &str, why: &Why) -> Result<(), String> {
        let names = Names(self.h.spec());
        let id = names.find_group(group)?;
        let record: &Record = self
            .effects
            .iter()
            .rev()
            .find_map(|effect| match effect {
                Effect::Decided(record) if record.group == id => Some(record),
                _ => None,
            })
            .ok_or("the step has no decision")?;
        let candidates: Vec<String> = record
            .candidates
            .iter()
            .map(|c| format!("{} {}", names.schema(c.id), state(c.state)))
            .collect();
        let compare = |what, actual: &str, expected: &Option<String>| {
            expected
                .as_ref()
                .map_or(Ok(()), |expected| expect_equal(what, actual, expected))
        };
        compare("case", case(record.case), &why.case)?;
        compare("before", names.optional(record.before), &why.before)?;
        compare("choice", names.optional(record.choice), &why.choice)?;
        compare("decider", decider(record.decider), &why.decider)?;
        compare("cause", &names.cause(record.cause), &why.cause)?;
        compare("caused_at", &Time(record.cause_time).to_string(), &why.caused_at)?;
        if let Some(expected) = &why.reason
            && !record.reason.contains(expected.as_str())
        {
            return Err(format!("the reason is \"{}\", not \"{expected}\"", record.reason));
        }
        if let Some(expected) = why.changed {
            expect_equal("changed", &record.changed.to_string(), &expected.to_string())?;
        }
        if let Some(expected) = &why.candidates {
            expect_equal("candidates", &candidates.join(", "), &expected.join(", "))?;
        }
        Ok(())
    }
}

fn holder(operator: u32, lease: &[&str]) -> Result<Holder, String> {
    match lease {
        [] => Ok(Holder::lasting(operator)),
        ["under", "a", "lease"] => Ok(Holder::leased(operator)),
        _ => Err("an operator acts lastingly or `under a lease`".into()),
    }
}

fn accepted(result: Result<(), Refused>) -> Result<(), String> {
    result.map_err(|refused| format!("it was refused: {refused}"))
}

fn expect_equal(what: &str, actual: &str, expected: &str) -> Result<(), String> {
    if actual == expected {
        Ok(())
    } else {
        Err(format!("{what} is \"{actual}\", not \"{expected}\""))
    }
}
