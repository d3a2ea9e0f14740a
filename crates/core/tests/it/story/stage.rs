//! Plays a story on the real state machine, observed by the shadow.
//!
//! It refuses to continue after the first difference from the story.

use jde_core::{ArbitrationReply, Check, Effect, Hierarchy, Nanos, Operator, Record, Refused, SchemaId};

use super::words::{Names, Told, case, decider, health, number, policy, state, time};
use super::{Step, Story, Why};
use jde_shadow::{Shadow, ids};

/// Plays all steps and returns all effects.
pub(super) fn play(story: &Story) -> Result<Vec<Effect>, String> {
    let spec = story.spec()?;
    let shadow = Shadow::new(&spec);
    let listed = |faults: Vec<jde_core::SpecError>| {
        faults
            .iter()
            .map(ToString::to_string)
            .collect::<Vec<_>>()
            .join("; ")
    };
    let h = Hierarchy::new(spec).map_err(listed)?;
    let mut stage = Stage {
        h,
        shadow,
        now: 0,
        effects: Vec::new(),
        refused: Vec::new(),
    };
    let mut all = Vec::new();
    for (index, step) in story.step.iter().enumerate() {
        stage
            .play(step)
            .map_err(|error| format!("step {} at {}: {error}", index + 1, step.at))?;
        all.append(&mut stage.effects);
    }
    Ok(all)
}

struct Stage {
    h: Hierarchy,
    shadow: Shadow,
    now: Nanos,
    /// The effects of the present step.
    effects: Vec<Effect>,
    refused: Vec<Refused>,
}

impl Stage {
    fn play(&mut self, step: &Step) -> Result<(), String> {
        let at = time(&step.at)?;
        if at < self.now {
            return Err("time runs backwards".into());
        }
        self.now = at;
        self.refused.clear();
        self.call(|h, out| h.tick(at, out))?;
        for phrase in &step.when {
            self.happen(phrase)
                .map_err(|error| format!("when \"{phrase}\": {error}"))?;
        }
        self.follows(step)
    }

    fn call<T>(&mut self, call: impl FnOnce(&mut Hierarchy, &mut Vec<Effect>) -> T) -> Result<T, String> {
        let mut out = Vec::new();
        let answer = call(&mut self.h, &mut out);
        self.shadow.apply(self.h.spec(), &out)?;
        self.shadow.check_against(&self.h)?;
        self.effects.append(&mut out);
        Ok(answer)
    }

    fn happen(&mut self, phrase: &str) -> Result<(), String> {
        let (head, reason) = phrase
            .split_once(": ")
            .map_or((phrase, ""), |(head, reason)| (head, reason));
        let words: Vec<&str> = head.split_whitespace().collect();
        let now = self.now;
        match words.as_slice() {
            ["the", "application", "starts"] => self.call(|h, out| h.start(now, out)),
            ["the", "application", "shuts", "down"] => {
                self.shadow.begin_shutdown();
                self.call(|h, out| h.shutdown(now, out))
            }
            ["operator", "may", "not", verb, name] => self.operate(verb, name).and_then(|r| self.refusal(r)),
            ["operator", verb, name] => self.operate(verb, name).and_then(granted),
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
            [father, "wakes", child] => self.lead(father, child, Hierarchy::wake).and_then(granted),
            [father, "may", "not", "wake", child] => self
                .lead(father, child, Hierarchy::wake)
                .and_then(|r| self.refusal(r)),
            [father, "lets", child, "sleep"] => self.lead(father, child, Hierarchy::sleep).and_then(granted),
            [name, "faults"] => self.on(name, |h, id, out| h.faulted(now, id, reason.to_owned(), out)),
            [name, "is", "replaced"] => self.on(name, |h, id, out| h.restored(now, id, out)),
            [name, "overruns"] => self.on(name, |h, id, out| h.overrun(id, out)),
            [name, "is", "on", "time"] => self.on(name, |h, id, out| h.on_time(id, out)),
            [name, "is", "retimed", "to", period] => {
                let period = time(period)?;
                self.on(name, |h, id, _| h.set_period(id, period))
            }
            [father, "chooses", child, "in", group] => {
                let child = if *child == "nobody" {
                    None
                } else {
                    Some(self.find(child)?)
                };
                self.answer(
                    father,
                    group,
                    ArbitrationReply::Chosen {
                        child,
                        reason: reason.to_owned(),
                    },
                )
            }
            [father, "fails", "to", "choose", "in", group] => self.answer(
                father,
                group,
                ArbitrationReply::Failed {
                    reason: reason.to_owned(),
                },
            ),
            [group, "turns", "to", told @ ..] => {
                let group = Names(self.h.spec()).find_group(group)?;
                let policy = policy(&told.join(" "))?;
                let set = self.call(|h, out| h.set_policy(now, group, policy, out))?;
                set.map_err(|error| error.to_string())
            }
            _ => Err("nobody knows what that means".into()),
        }
    }

    fn find(&self, name: &str) -> Result<SchemaId, String> {
        Names(self.h.spec()).find(name)
    }

    fn on(
        &mut self,
        name: &str,
        call: impl FnOnce(&mut Hierarchy, SchemaId, &mut Vec<Effect>),
    ) -> Result<(), String> {
        let id = self.find(name)?;
        self.call(|h, out| call(h, id, out))
    }

    fn check(&mut self, name: &str, ready: bool, urgency: Option<f64>, cause: Nanos) -> Result<(), String> {
        let (id, now) = (self.find(name)?, self.now);
        let check = Check {
            ready,
            urgency: urgency.unwrap_or(0.0),
            cause,
        };
        self.call(|h, out| h.checked(now, id, check, out))
    }

    fn begin(&mut self, name: &str, expected: bool) -> Result<(), String> {
        let (id, now) = (self.find(name)?, self.now);
        if self.call(|h, out| h.begin(now, id, out))? != expected {
            return Err(format!("it {} begin", if expected { "may not" } else { "may" }));
        }
        if expected {
            self.shadow.begin_iteration(id);
        }
        Ok(())
    }

    fn end(&mut self, name: &str) -> Result<(), String> {
        let (id, now) = (self.find(name)?, self.now);
        self.shadow.end_iteration(id);
        self.call(|h, out| h.end(now, id, out))
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

    #[allow(clippy::type_complexity, reason = "the signature of `wake` and `sleep`")]
    fn lead(
        &mut self,
        father: &str,
        child: &str,
        call: fn(&mut Hierarchy, Nanos, SchemaId, SchemaId, &mut Vec<Effect>) -> Result<(), Refused>,
    ) -> Result<Result<(), Refused>, String> {
        let (father, child, now) = (self.find(father)?, self.find(child)?, self.now);
        self.call(|h, out| call(h, now, father, child, out))
    }

    fn operate(&mut self, verb: &str, name: &str) -> Result<Result<(), Refused>, String> {
        let (id, now) = (self.find(name)?, self.now);
        let act = match verb {
            "plays" | "play" => Operator::Play(id),
            "stops" | "stop" => Operator::Stop(id),
            "forces" | "force" => Operator::Force(id),
            "releases" | "release" => Operator::Release(id),
            _ => return Err(format!("an operator cannot `{verb}`")),
        };
        self.call(|h, out| h.operator(now, act, out))
    }

    fn refusal(&mut self, answer: Result<(), Refused>) -> Result<(), String> {
        match answer {
            Ok(()) => Err("it was not refused".into()),
            Err(refused) => {
                self.refused.push(refused);
                Ok(())
            }
        }
    }

    fn answer(&mut self, father: &str, group: &str, answer: ArbitrationReply) -> Result<(), String> {
        let (id, now) = (Names(self.h.spec()).find_group(group)?, self.now);
        if self.h.spec().groups[id.index()].father != Some(self.find(father)?) {
            return Err(format!("`{father}` is not the father of `{group}`"));
        }
        let ticket = self.h.pending_arbitration(id).ok_or("nobody asked")?;
        self.call(|h, out| h.arbitrated(now, id, ticket, answer, out))
    }

    fn follows(&self, step: &Step) -> Result<(), String> {
        let names = Names(self.h.spec());
        let told: Vec<String> = self.effects.iter().map(|effect| names.effect(effect)).collect();
        let mut rest = told.iter();
        for expected in &step.order {
            if !rest.any(|effect| effect == expected) {
                return Err(format!(
                    "\"{expected}\" does not follow in this order; what follows: {told:#?}"
                ));
            }
        }
        if let Some(unwanted) = step.never.iter().find(|unwanted| told.contains(unwanted)) {
            return Err(format!("\"{unwanted}\" follows"));
        }
        for (name, expected) in &step.states {
            same(
                &format!("the state of {name}"),
                state(self.h.state(names.find(name)?)),
                expected,
            )?;
        }
        for (group, expected) in &step.winner {
            let winner = self.h.winner(names.find_group(group)?);
            same(&format!("the winner of {group}"), names.maybe(winner), expected)?;
        }
        if let Some(expected) = &step.authority {
            let mut holders: Vec<&str> = ids(names.0)
                .filter(|&id| self.h.has_authority(id))
                .map(|id| names.schema(id))
                .collect();
            let mut expected: Vec<&str> = expected.iter().map(String::as_str).collect();
            holders.sort_unstable();
            expected.sort_unstable();
            same("authority", &holders.join(", "), &expected.join(", "))?;
        }
        for (name, expected) in &step.health {
            same(
                &format!("the health of {name}"),
                &health(self.h.health(names.find(name)?)),
                expected,
            )?;
        }
        for (group, why) in &step.why {
            self.explains(group, why)
                .map_err(|error| format!("why {group}: {error}"))?;
        }
        let expected = step.refused.as_deref().unwrap_or_default();
        let refused: Vec<String> = self.refused.iter().map(ToString::to_string).collect();
        let alike = expected.len() == refused.len()
            && refused.iter().zip(expected).all(|(r, e)| r.contains(e.as_str()));
        if step.refused.is_some() && !alike {
            return Err(format!("the refusals are {refused:#?}, not {expected:#?}"));
        }
        if let Some(expected) = &step.timer {
            let due = self
                .h
                .next_timer()
                .map_or("none".into(), |due| Told(due).to_string());
            same("the next timer", &due, expected)?;
        }
        for (group, expected) in &step.contract {
            let id = names.find_group(group)?;
            let contracts = jde_core::contract(self.h.spec());
            let line = contracts
                .iter()
                .find(|c| c.group == id)
                .ok_or("no contract")?
                .to_string();
            same(&format!("the contract of {group}"), &line, expected)?;
        }
        Ok(())
    }

    fn explains(&self, group: &str, why: &Why) -> Result<(), String> {
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
            .ok_or("nothing was decided")?;
        let candidates: Vec<String> = record
            .candidates
            .iter()
            .map(|c| format!("{} {}", names.schema(c.id), state(c.state)))
            .collect();
        let maybe = |what, actual: &str, expected: &Option<String>| {
            expected
                .as_ref()
                .map_or(Ok(()), |expected| same(what, actual, expected))
        };
        maybe("case", case(record.case), &why.case)?;
        maybe("before", names.maybe(record.before), &why.before)?;
        maybe("choice", names.maybe(record.choice), &why.choice)?;
        maybe("decider", decider(record.decider), &why.decider)?;
        maybe("cause", &names.cause(record.cause), &why.cause)?;
        maybe("caused_at", &Told(record.cause_time).to_string(), &why.caused_at)?;
        if let Some(expected) = &why.reason
            && !record.reason.contains(expected.as_str())
        {
            return Err(format!("the reason is \"{}\", not \"{expected}\"", record.reason));
        }
        if let Some(expected) = why.changed {
            same("changed", &record.changed.to_string(), &expected.to_string())?;
        }
        if let Some(expected) = &why.candidates {
            same("candidates", &candidates.join(", "), &expected.join(", "))?;
        }
        Ok(())
    }
}

fn granted(answer: Result<(), Refused>) -> Result<(), String> {
    answer.map_err(|refused| format!("it was refused: {refused}"))
}

fn same(what: &str, actual: &str, expected: &str) -> Result<(), String> {
    if actual == expected {
        Ok(())
    } else {
        Err(format!("{what} is \"{actual}\", not \"{expected}\""))
    }
}
