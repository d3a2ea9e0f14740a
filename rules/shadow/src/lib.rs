//! A shadow model of the hierarchy, which knows it only by its effects and reports which rule an effect
//! violates.
//!
//! The tests of the rules and the campaign of faults share it. Its checks do not use the code under test: it
//! rebuilds states and authority from the effects, and takes fathers and members from the specification.

use jde_core::{Decider, Effect, GroupId, Health, Hierarchy, Kind, SchemaId, Spec, State, Table};

/// The state of the hierarchy according to the effects so far. Errors name the violated rule.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub struct Shadow {
    states: Table<SchemaId, State>,
    authority: Table<SchemaId, bool>,
    /// The running iterations, as the executor knows them, and whether each was abandoned.
    running: Table<SchemaId, Option<Abandoned>>,
    braked: Table<GroupId, bool>,
    /// Schemas that had authority since the last takeover or brake of their commands: a command of them may
    /// be in force.
    may_command: Table<SchemaId, bool>,
    /// How far each schema with authority is in taking over.
    takeover_phases: Table<SchemaId, TakeoverPhase>,
    /// The schema whose first iteration has ended, until the commands that it did not write lapse.
    lapsing: Option<SchemaId>,
    /// Schemas that faulted as WINNER and have not restarted.
    faulted: Table<SchemaId, bool>,
    /// Schemas whose command a guard refused, until their retry (R18), also if they sleep meanwhile.
    refused: Table<SchemaId, bool>,
    /// Schemas of which a debugger holds a call.
    debugged: Table<SchemaId, bool>,
    /// The last choice of each group (R15).
    chosen: Table<GroupId, Option<SchemaId>>,
    /// Groups that slept since their last selection.
    slept: Table<GroupId, bool>,
    shut_down: bool,
}

/// How far a schema with authority is in taking over the earlier commands.
#[derive(Copy, Clone, PartialEq, Eq, Hash, Debug)]
enum TakeoverPhase {
    New,
    First,
    Settled,
}

#[derive(Copy, Clone, PartialEq, Eq, Hash, Debug)]
enum Abandoned {
    No,
    Yes,
}

impl Shadow {
    /// Returns a shadow in which all schemas sleep.
    #[must_use]
    pub fn new(spec: &Spec) -> Self {
        Self {
            states: spec.schemas.map_ids(|_| State::Slept),
            authority: spec.schemas.map_ids(|_| false),
            running: spec.schemas.map_ids(|_| None),
            braked: spec.groups.map_ids(|_| false),
            may_command: spec.schemas.map_ids(|_| false),
            takeover_phases: spec.schemas.map_ids(|_| TakeoverPhase::Settled),
            lapsing: None,
            faulted: spec.schemas.map_ids(|_| false),
            refused: spec.schemas.map_ids(|_| false),
            debugged: spec.schemas.map_ids(|_| false),
            chosen: spec.groups.map_ids(|_| None),
            slept: spec.groups.map_ids(|_| true),
            shut_down: false,
        }
    }

    /// Records that an iteration began.
    pub fn begin_iteration(&mut self, id: SchemaId) {
        self.running[id] = Some(Abandoned::No);
        if self.takeover_phases[id] == TakeoverPhase::New {
            self.takeover_phases[id] = TakeoverPhase::First;
        }
    }

    /// Records that an iteration ended. Must be called before the hierarchy gets the end.
    pub fn end_iteration(&mut self, id: SchemaId) {
        self.running[id] = None;
        if self.takeover_phases[id] == TakeoverPhase::First {
            self.takeover_phases[id] = TakeoverPhase::Settled;
            self.lapsing = Some(id);
        }
    }

    /// Records that a debugger holds a call of the schema, or lets it go on. Must be called before the hierarchy is
    /// told.
    pub fn set_debugged(&mut self, id: SchemaId, debugged: bool) {
        self.debugged[id] = debugged && self.state(id) != State::Slept;
    }

    /// Returns whether an iteration of the schema runs.
    #[must_use]
    pub fn is_running(&self, id: SchemaId) -> bool {
        self.running[id].is_some()
    }

    /// Returns whether the running iteration of the schema was abandoned.
    #[must_use]
    pub fn is_abandoned(&self, id: SchemaId) -> bool {
        self.running[id] == Some(Abandoned::Yes)
    }

    /// Records that the application shuts down, so every group brakes.
    pub fn begin_shutdown(&mut self) {
        self.shut_down = true;
    }

    /// Applies the effects of one transaction in order.
    ///
    /// # Errors
    /// The rule that an effect violates, and the effect.
    pub fn apply(&mut self, spec: &Spec, effects: &[Effect]) -> Result<(), String> {
        for effect in effects {
            self.apply_one(spec, effect)
                .map_err(|violation| format!("{violation}, at {effect:?}"))?;
        }
        Ok(())
    }

    /// Compares the shadow with the hierarchy after a transaction, and checks the invariants between
    /// transactions.
    ///
    /// # Errors
    /// The rule that does not hold, or the difference between the hierarchy and its effects.
    pub fn check_against(&self, h: &Hierarchy) -> Result<(), String> {
        let spec = h.spec();
        if let Some(id) = self.lapsing {
            return Err(format!(
                "R7: what {id:?} took over is still in force after its first iteration"
            ));
        }
        let paths = self.winning_paths(spec);
        for id in ids(spec) {
            check(self.states[id] == h.state(id), || {
                format!("the effects do not agree with the state of {id:?}")
            })?;
            check(self.authority[id] == h.has_authority(id), || {
                format!("the effects do not agree with the authority of {id:?}")
            })?;
            let chain = spec.schemas[id].kind == Kind::Motor && paths[id];
            check(self.refused[id] == h.is_refused(id), || {
                format!("the effects do not agree with the refusal of {id:?}")
            })?;
            check(h.has_authority(id) == chain, || {
                format!("R7: authority of {id:?} and the chain of winners differ")
            })?;
        }
        for (index, group) in (0u32..).zip(&spec.groups) {
            let id = GroupId(index);
            let winners: Vec<_> = group
                .members
                .iter()
                .filter(|m| self.states[**m] == State::Winner)
                .collect();
            check(winners.len() <= 1, || {
                format!("R1: two winners in {}", group.name)
            })?;
            check(winners.first().copied().copied() == h.winner(id), || {
                format!("the winner of {} is not the member in state WINNER", group.name)
            })?;
        }
        Ok(())
    }

    fn apply_one(&mut self, spec: &Spec, effect: &Effect) -> Result<(), String> {
        match *effect {
            Effect::Woken(id) => {
                check(!self.shut_down, || "a schema wakes after the shutdown".into())?;
                check(self.state(id) == State::Slept, || {
                    "an awake schema is woken".into()
                })
            }
            Effect::Slept { id, abandoned } => {
                check(self.state(id) != State::Slept, || {
                    "a sleeping schema goes to sleep".into()
                })?;
                check(!self.authority[id], || {
                    "R7: a schema with authority goes to sleep".into()
                })?;
                check(self.all_slept_below(spec, id), || {
                    "R5, R6: a father sleeps before its children".into()
                })?;
                check(self.is_running(id) == abandoned, || {
                    "R10: a running iteration is not marked as abandoned".into()
                })?;
                if abandoned {
                    self.running[id] = Some(Abandoned::Yes);
                }
                self.debugged[id] = false;
                Ok(())
            }
            Effect::TakesOver { group, id } => {
                check(group_of(spec, id) == Some(group), || {
                    "R7: a schema takes over in a group that is not its own".into()
                })?;
                for other in level(spec, group) {
                    check(!self.authority[other], || {
                        format!("R7: it takes over from {other:?}, which has authority")
                    })?;
                    self.may_command[other] = false;
                }
                Ok(())
            }
            Effect::Granted(id) => {
                if let Some(group) = group_of(spec, id) {
                    for other in level(spec, group) {
                        check(!self.may_command[other], || {
                            format!("R7: a command of {other:?} is in force and was not taken over")
                        })?;
                    }
                }
                self.may_command[id] = true;
                self.takeover_phases[id] = TakeoverPhase::New;
                check(!self.authority[id], || "authority is granted twice".into())?;
                check(self.state(id) == State::Winner, || {
                    "R7: authority without being WINNER".into()
                })?;
                let father = group_of(spec, id).and_then(|g| spec.groups[g].father);
                let delegates = |f: SchemaId| self.authority[f] && !self.debugged[f];
                check(father.is_none_or(delegates), || {
                    "R7: authority below a father without authority, or that a debugger holds".into()
                })?;
                self.authority[id] = true;
                check(self.siblings(spec, id).all(|s| !self.authority[s]), || {
                    "R1: two members of a group have authority".into()
                })
            }
            Effect::Lapsed(id) => {
                check(self.lapsing == Some(id), || {
                    "R7: commands that were taken over lapse before the first iteration has ended".into()
                })?;
                self.lapsing = None;
                Ok(())
            }
            Effect::Refused(id) => {
                check(self.authority[id], || {
                    "R18: a schema without authority is refused".into()
                })?;
                self.refused[id] = true;
                self.takeover_phases[id] = TakeoverPhase::Settled;
                Ok(())
            }
            Effect::Retries(id) => check(std::mem::take(&mut self.refused[id]), || {
                "R18: a schema retries that was not refused".into()
            }),
            Effect::Withdrawn(id) => {
                self.takeover_phases[id] = TakeoverPhase::Settled;
                check(self.authority[id], || {
                    "authority is withdrawn from a schema without authority".into()
                })?;
                let below = below(spec, id);
                check(below.iter().all(|b| !self.authority[*b]), || {
                    "R7: authority of a father is withdrawn before that of its children".into()
                })?;
                self.authority[id] = false;
                Ok(())
            }
            Effect::Promoted(id) => {
                check(self.state(id) == State::Winner, || {
                    "a schema is promoted that is not WINNER".into()
                })?;
                check(!self.is_running(id), || {
                    "a schema is promoted inside an old iteration".into()
                })?;
                if let Some(group) = group_of(spec, id) {
                    self.braked[group] = false;
                }
                // A schema below a sibling, played by an operator, may be awake. A loser has emptied its
                // subtree when it is demoted.
                check(
                    self.siblings(spec, id)
                        .all(|s| self.running[s] != Some(Abandoned::No)),
                    || "R1: promoted while the loser iterates with authority".into(),
                )
            }
            Effect::Demoted(id) => {
                check(!self.authority[id], || "R7: demoted with authority".into())?;
                check(self.all_slept_below(spec, id), || {
                    "R5: demoted before its subtree sleeps".into()
                })?;
                if self.is_running(id) {
                    self.running[id] = Some(Abandoned::Yes);
                }
                Ok(())
            }
            Effect::Brake { group } => {
                let members = &spec.groups[group].members;
                // A second brake ends the commands of members that slept during a cancelled handover.
                let all_asleep = members.iter().all(|&m| self.state(m) == State::Slept);
                check(self.shut_down || all_asleep || !self.braked[group], || {
                    "R9: a group brakes twice".into()
                })?;
                check(
                    self.shut_down || members.iter().all(|&m| self.state(m) != State::Winner),
                    || "R9: a group with a winner brakes".into(),
                )?;
                self.braked[group] = true;
                for other in level(spec, group) {
                    self.may_command[other] = self.authority[other];
                }
                Ok(())
            }
            Effect::Hold { group, .. } => check(!self.braked[group], || {
                "R9: a group holds after it has braked".into()
            }),
            Effect::Changed { id, from, to } => {
                check(self.state(id) == from && from != to, || {
                    "a change from another state".into()
                })?;
                self.states[id] = to;
                if let Some(group) = group_of(spec, id) {
                    let members = &spec.groups[group].members;
                    let winners = members
                        .iter()
                        .filter(|&&m| self.state(m) == State::Winner)
                        .count();
                    check(winners <= 1, || "R1: two winners".into())?;
                    if members.iter().all(|&m| self.state(m) == State::Slept) {
                        self.slept[group] = true;
                        self.chosen[group] = None;
                    }
                    if from == State::Slept
                        && members.iter().all(|&m| m == id || self.state(m) == State::Slept)
                    {
                        // The first member wakes: the group starts again.
                        self.braked[group] = false;
                    }
                }
                Ok(())
            }
            Effect::Decided(ref record) => {
                check(record.changed == (record.before != record.choice), || {
                    "R15: `changed` is wrong".into()
                })?;
                let ready = record.candidates.iter().find(|c| c.ready && self.refused[c.id]);
                check(ready.is_none(), || {
                    format!("R18: a refused schema is READY: {ready:?}")
                })?;
                let by_rule = !matches!(
                    record.decider,
                    Decider::Operator | Decider::Father | Decider::ArbitrationFailed
                );
                check(!by_rule || record.choice.is_none_or(|c| !self.refused[c]), || {
                    "R18: a refused schema is chosen".into()
                })?;
                check(record.cause_time <= record.time, || {
                    "R15: a cause after its effect".into()
                })?;
                let chosen = std::mem::replace(&mut self.chosen[record.group], record.choice);
                // A group forgets its choice when all its members sleep, when the chosen schema was put to
                // sleep, or when no schema was chosen.
                let slept = std::mem::take(&mut self.slept[record.group]);
                let put_to_sleep = |id: SchemaId| self.state(id) == State::Slept && !self.faulted[id];
                let forgotten = slept || chosen.is_none_or(put_to_sleep);
                check(record.before == chosen || forgotten, || {
                    format!("R15: {chosen:?} was chosen before")
                })?;
                check(!record.reason.is_empty(), || "R15: no reason".into())
            }
            Effect::TookOver { id, .. } => check(self.state(id) == State::Winner, || {
                "R15: took over without being WINNER".into()
            }),
            Effect::Health { id, ref health } => {
                let wins = self.state(id) == State::Winner;
                self.faulted[id] = wins && matches!(health, Health::Faulted(_));
                Ok(())
            }
            Effect::Arbitrate { .. } => Ok(()),
        }
    }

    /// Returns the state of a schema.
    #[must_use]
    pub fn state(&self, id: SchemaId) -> State {
        self.states[id]
    }

    /// Returns whether the schema may command and wake children (R7).
    #[must_use]
    pub fn has_authority(&self, id: SchemaId) -> bool {
        self.authority[id]
    }

    fn siblings<'a>(&self, spec: &'a Spec, id: SchemaId) -> impl Iterator<Item = SchemaId> + use<'a> {
        let group = group_of(spec, id);
        group
            .into_iter()
            .flat_map(|g| spec.groups[g].members.iter().copied())
            .filter(move |&m| m != id)
    }

    fn all_slept_below(&self, spec: &Spec, id: SchemaId) -> bool {
        below(spec, id).iter().all(|&b| self.state(b) == State::Slept)
    }

    /// Returns which schemas are WINNER with all their fathers, of which a debugger holds none. Schemas in no group
    /// count as roots.
    fn winning_paths(&self, spec: &Spec) -> Table<SchemaId, bool> {
        let mut fathers = spec.schemas.map_ids(|_| None);
        for group in &spec.groups {
            for member in &group.members {
                fathers[*member] = group.father;
            }
        }
        let wins = |id: SchemaId| self.state(id) == State::Winner;
        let path = |id| std::iter::successors(Some(id), |id: &SchemaId| fathers[*id]);
        let is_free = |id: SchemaId| wins(id) && !self.debugged[id];
        spec.schemas
            .map_ids(|id| wins(id) && path(id).skip(1).all(is_free))
    }
}

/// Returns all schemas.
pub fn ids(spec: &Spec) -> impl Iterator<Item = SchemaId> + use<> {
    spec.schemas.ids()
}

/// Returns the group in which the schema competes.
#[must_use]
pub fn group_of(spec: &Spec, id: SchemaId) -> Option<GroupId> {
    spec.groups.find(|g| g.members.contains(&id))
}

/// Returns the members of a group and everything below them.
fn level(spec: &Spec, group: GroupId) -> Vec<SchemaId> {
    let members = &spec.groups[group].members;
    members
        .iter()
        .flat_map(|&member| std::iter::once(member).chain(below(spec, member)))
        .collect()
}

/// Returns all motor schemas below a schema, by a plain search.
#[must_use]
pub fn below(spec: &Spec, id: SchemaId) -> Vec<SchemaId> {
    let mut found = Vec::new();
    for group in spec.groups.iter().filter(|g| g.father == Some(id)) {
        for &member in &group.members {
            found.push(member);
            found.extend(below(spec, member));
        }
    }
    found
}

fn check(holds: bool, violation: impl FnOnce() -> String) -> Result<(), String> {
    if holds { Ok(()) } else { Err(violation()) }
}
