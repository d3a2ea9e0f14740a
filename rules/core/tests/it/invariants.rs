//! Random hierarchies under random events: the rules hold after every transaction.
//!
//! The checks are independent of the implementation: those of R6 and R14 are in `Requests`, all others in `shadow`.
//!
//! long because one table of random events serves all checks.

use std::collections::BTreeSet;

use crate::random::{MS, POLICIES, specs};
use jde_core::{
    ArbitrationReply, Check, Effect, GroupId, Health, Hierarchy, Hold, HoldAction, Holder, Kind, Nanos,
    Operator, Policy, Refused, SchemaId, Spec, State, Timer, Transaction,
};
use jde_shadow::{Shadow, below, ids};
use proptest::prelude::*;

proptest! {
    #![proptest_config(ProptestConfig { cases: 1000, ..ProptestConfig::default() })]

    #[test]
    fn rules_hold_after_every_random_event(spec in specs(), events in prop::collection::vec(any::<[u16; 4]>(), 1..300)) {
        let mut run = Run::new(spec);
        run.transaction(|transaction| transaction.start())?;
        for event in events {
            run.step(event)?;
        }
        run.finish()?;
    }
}

struct Run {
    h: Hierarchy,
    shadow: Shadow,
    requests: Requests,
    now: Nanos,
    records: u64,
    tickets: Vec<(GroupId, u64, Vec<SchemaId>)>,
    running: bool,
}

/// The requests that keep perceptive schemas awake, besides the needs of schemas (R6), and the holds of operators
/// (R14), recorded independently.
#[derive(Default)]
struct Requests {
    fathers: BTreeSet<(SchemaId, SchemaId)>,
    /// Oldest first.
    holds: Vec<(SchemaId, Hold)>,
    /// Stopped schemas, and what they and the schemas below needed when they were stopped.
    kept: BTreeSet<(SchemaId, SchemaId)>,
}

impl Requests {
    fn of(&self, id: SchemaId) -> impl Iterator<Item = Hold> {
        let holds = self.holds.iter().filter(move |(held, _)| *held == id);
        holds.map(|(_, hold)| *hold)
    }

    fn stops(&self, id: SchemaId) -> Vec<Hold> {
        self.of(id).filter(|hold| hold.action.stops()).collect()
    }

    fn add(&mut self, id: SchemaId, by: Holder, action: HoldAction) {
        let hold = (id, Hold { by, action });
        if !self.holds.contains(&hold) {
            self.holds.push(hold);
        }
    }

    fn end(&mut self, id: SchemaId, which: impl Fn(Hold) -> bool) {
        self.holds.retain(|(held, hold)| *held != id || !which(*hold));
    }

    /// Ends what stops kept awake that ended.
    fn settle(&mut self) {
        let stopped = |id: SchemaId| {
            let mut stops = self.of(id).filter(|hold| hold.action.stops()).peekable();
            stops.peek().is_some() && stops.all(|hold| hold.action != HoldAction::Unloaded)
        };
        let kept = self.kept.iter().copied().filter(|(id, _)| stopped(*id));
        self.kept = kept.collect();
    }
}

impl Run {
    fn new(spec: Spec) -> Self {
        let shadow = Shadow::new(&spec);
        let h = Hierarchy::new(spec).expect("the generator makes valid specifications");
        Self {
            h,
            shadow,
            requests: Requests::default(),
            now: 0,
            records: 0,
            tickets: Vec::new(),
            running: true,
        }
    }

    fn step(&mut self, [what, a, b, c]: [u16; 4]) -> Result<(), TestCaseError> {
        self.now += u64::from(c % 4) * MS;
        let now = self.now;
        let other = self.pick_schema(b);
        let schema = self.pick_applicable(a, what % 32);
        let group = self.pick_group(a);
        match what % 32 {
            0..=7 => {
                let urgency = [0.0, 0.5, 1.0, f64::NAN, f64::INFINITY, -1.0][usize::from(b) % 6];
                let check = Check {
                    ready: b % 3 != 0,
                    urgency,
                    cause: now.saturating_sub(u64::from(c)),
                };
                self.transaction(|transaction| transaction.checked(schema, check))
            }
            8..=12 => self.begin(schema),
            13..=15 => self.end(schema),
            16 => self.end_unready(schema),
            17..=21 => self.wake(schema, b),
            22 => self.sleep(schema, b),
            23 => {
                let policy = POLICIES[usize::from(b) % POLICIES.len()];
                self.transaction(|transaction| drop(transaction.set_policy(group, policy)))
            }
            24 | 25 => self.reply(a, b),
            26 => {
                self.transaction(|transaction| transaction.faulted(schema, "a fault".into()))?;
                self.end(schema)
            }
            27 => self.operate(schema, b, c),
            28 => self.transaction(|transaction| transaction.refused(schema)),
            29 => self.transaction(|transaction| transaction.tick()),
            30 => self.fire(a),
            _ => match b % 12 {
                0 => self.transaction(|transaction| transaction.restored(other)),
                1 => self.transaction(|transaction| transaction.overrun(other)),
                2 => self.transaction(|transaction| transaction.on_time(other)),
                3 if c % 8 == 0 => self.shutdown(),
                4 => self.stop_all(Holder::lasting(1 + u32::from(c % 2))),
                5 => self.release_all(),
                6 => {
                    self.shadow.set_debugged(other, c % 2 == 0);
                    self.transaction(|transaction| transaction.set_debugged(other, c % 2 == 0))
                }
                _ => {
                    self.now = self.h.next_timer().map_or(now, |due| due.max(now));
                    self.transaction(|transaction| transaction.tick())
                }
            },
        }
    }

    /// Runs one call on the hierarchy and on a copy, and checks the effects against the rules.
    fn transaction(&mut self, call: impl Fn(&mut Transaction)) -> Result<(), TestCaseError> {
        let mut twin = self.h.clone();
        let before: Vec<_> = self.group_ids().map(|g| self.h.winner(g)).collect();
        let (mut out, mut twin_out) = (Vec::new(), Vec::new());
        call(&mut self.h.at(self.now, &mut out));
        call(&mut twin.at(self.now, &mut twin_out));
        prop_assert_eq!(&out, &twin_out, "R16: the same call had other effects");
        prop_assert_eq!(&self.h, &twin, "R16: the same call led to another state");
        self.check_effects(&out)?;
        self.absences_have_an_effect(&before, &out)
    }

    fn check_effects(&mut self, out: &[Effect]) -> Result<(), TestCaseError> {
        let spec = self.h.spec().clone();
        self.shadow.apply(&spec, out).map_err(TestCaseError::fail)?;
        self.shadow.check_against(&self.h).map_err(TestCaseError::fail)?;
        for effect in out {
            match effect {
                Effect::Slept { id, .. } => {
                    self.requests.fathers.retain(|(father, _)| father != id);
                }
                Effect::Decided(record) => {
                    self.records += 1;
                    prop_assert_eq!(record.number, self.records, "R15: a record is missing");
                }
                Effect::Arbitrate { group, ticket, level } => {
                    let ids = level.candidates.iter().map(|c| c.id).collect();
                    self.tickets.push((*group, *ticket, ids));
                }
                _ => {}
            }
        }
        self.requests.settle();
        self.holds_are_those_of_the_operators()?;
        self.perceptive_schemas_are_awake_exactly_when_needed()?;
        self.groups_are_settled()
    }

    /// R14: no hold ends but by what ends it. A play of a motor schema also ends with its father's sleep, so only the
    /// others are compared.
    fn holds_are_those_of_the_operators(&self) -> Result<(), TestCaseError> {
        for id in ids(self.h.spec()) {
            let lasts = |hold: &Hold| hold.action != HoldAction::Played;
            let by_text = |holds: Vec<Hold>| {
                let mut holds: Vec<_> = holds.iter().map(|hold| format!("{hold:?}")).collect();
                holds.sort();
                holds
            };
            let expected = self.requests.of(id).filter(lasts).collect();
            let actual = self.h.holds(id).filter(lasts).collect();
            prop_assert_eq!(by_text(actual), by_text(expected), "R14: the holds on {:?}", id);
        }
        Ok(())
    }

    /// R6, computed independently.
    fn perceptive_schemas_are_awake_exactly_when_needed(&self) -> Result<(), TestCaseError> {
        let spec = self.h.spec();
        for id in ids(spec).filter(|id| spec.schemas[*id].kind == Kind::Perceptive) {
            let needed = ids(spec).any(|by| self.h.is_awake(by) && spec.schemas[by].needs.contains(&id));
            let woken = self.requests.fathers.iter().any(|&(_, child)| child == id);
            let down = !self.requests.stops(id).is_empty() || matches!(self.h.health(id), Health::Faulted(_));
            let played = self.requests.of(id).any(|hold| hold.action == HoldAction::Played);
            let kept = self.requests.kept.iter().any(|&(_, need)| need == id);
            let expected = self.running && !down && (needed || woken || played || kept);
            prop_assert_eq!(
                self.h.is_awake(id),
                expected,
                "R6: {:?}, needed {} woken {}",
                id,
                needed,
                woken
            );
        }
        Ok(())
    }

    /// R1, R3: the right member wins, unless a handover or an arbitration is pending.
    fn groups_are_settled(&self) -> Result<(), TestCaseError> {
        for id in self.group_ids() {
            let spec = &self.h.spec().groups[id];
            if let Some(handover) = self.h.handover(id) {
                let armed = self
                    .h
                    .timers()
                    .any(|armed| armed == (handover.deadline, Timer::Patience(id)));
                prop_assert!(armed, "R1: a handover without a patience timer");
                prop_assert!(
                    handover.to != self.h.winner(id),
                    "a handover to the winner itself"
                );
                continue;
            }
            if self.h.pending_arbitration(id).is_some() {
                let armed = self.h.timers().any(|(_, timer)| timer == Timer::Arbitration(id));
                prop_assert!(armed, "R4: an arbitration without a budget timer");
                continue;
            }
            if spec.father.is_some_and(|father| self.is_being_replaced(father)) {
                continue;
            }
            let ready: Vec<_> = spec
                .members
                .iter()
                .copied()
                .filter(|&m| self.h.is_ready(m))
                .collect();
            let mut forces = self
                .requests
                .holds
                .iter()
                .rev()
                .filter(|(held, hold)| hold.action == HoldAction::Forced && spec.members.contains(held));
            let forced = forces
                .find(|(held, _)| self.h.is_awake(*held) && !self.h.is_abandoned(*held))
                .map(|(held, _)| *held);
            match (forced, ready.as_slice()) {
                (Some(forced), _) => {
                    prop_assert_eq!(
                        self.h.winner(id),
                        Some(forced),
                        "R14: the forced schema does not win"
                    );
                }
                (None, []) => {}
                (None, [only]) => {
                    let wins = self.h.winner(id) == Some(*only);
                    prop_assert!(wins, "R3: alone and not WINNER: {:?}", only);
                }
                (None, several) => {
                    // Only the father's own arbitration may leave a collision without a winner.
                    let winner = self.h.winner(id);
                    let decided =
                        spec.policy == Policy::FATHER || winner.is_some_and(|w| several.contains(&w));
                    prop_assert!(decided, "R3: a collision without a winner");
                }
            }
        }
        Ok(())
    }

    /// R9: a group that loses its winner and has no other one brakes or holds in the same transaction.
    fn absences_have_an_effect(
        &self,
        before: &[Option<SchemaId>],
        out: &[Effect],
    ) -> Result<(), TestCaseError> {
        for (id, before) in self.group_ids().zip(before) {
            let group = &self.h.spec().groups[id];
            let live = group.members.iter().any(|&m| self.h.is_awake(m));
            let frozen = group.father.is_some_and(|father| self.is_being_replaced(father));
            let due = before.is_some() && self.h.winner(id).is_none();
            if due && live && !frozen && self.h.pending_arbitration(id).is_none() {
                let has_effect = out.iter().any(|effect| match *effect {
                    Effect::Brake { group } | Effect::Hold { group, .. } => group == id,
                    _ => false,
                });
                prop_assert!(
                    has_effect,
                    "R9: {} has no winner, and neither brakes nor holds",
                    group.name
                );
            }
        }
        Ok(())
    }

    fn begin(&mut self, id: SchemaId) -> Result<(), TestCaseError> {
        let mut out = Vec::new();
        let accepted = self.h.at(self.now, &mut out).begin(id);
        let may = self.h.state(id) == State::Winner && !self.shadow.is_running(id);
        if accepted {
            prop_assert!(may, "begin accepted of {:?}", id);
            prop_assert!(
                !self.is_being_replaced(id),
                "R5: an iteration begins in a subtree that is being replaced"
            );
            self.shadow.begin_iteration(id);
        }
        self.check_effects(&out)
    }

    fn end(&mut self, id: SchemaId) -> Result<(), TestCaseError> {
        self.shadow.end_iteration(id);
        self.transaction(|transaction| transaction.end(id))
    }

    /// Its iteration ends because an input has no value.
    fn end_unready(&mut self, id: SchemaId) -> Result<(), TestCaseError> {
        let ran = self.h.is_running(id);
        self.shadow.end_iteration(id);
        self.transaction(|transaction| transaction.end_unready(id))?;
        let may_be_ready = !ran || self.h.group_of(id).is_none();
        prop_assert!(
            may_be_ready || !self.h.is_ready(id),
            "R19: {id:?} is READY without a value"
        );
        Ok(())
    }

    fn wake(&mut self, by: SchemaId, index: u16) -> Result<(), TestCaseError> {
        let (now, child) = (self.now, self.pick_child(by, index));
        let mut out = Vec::new();
        let may = self.h.has_authority(by) && !self.is_being_replaced(by);
        let result = self.h.at(now, &mut out).wake(by, child);
        match result {
            Ok(()) | Err(Refused::Stopped { .. }) => {
                prop_assert!(may, "R7: {:?} woke a child without authority", by);
                self.requests.fathers.insert((by, child));
            }
            Err(_) => prop_assert!(out.is_empty(), "a refused call has effects"),
        }
        self.check_effects(&out)
    }

    fn sleep(&mut self, by: SchemaId, index: u16) -> Result<(), TestCaseError> {
        let (now, child) = (self.now, self.pick_child(by, index));
        let mut out = Vec::new();
        if self.h.at(now, &mut out).sleep(by, child).is_ok() {
            self.requests.fathers.remove(&(by, child));
        }
        self.check_effects(&out)
    }

    fn reply(&mut self, index: u16, what: u16) -> Result<(), TestCaseError> {
        if self.tickets.is_empty() {
            return Ok(());
        }
        let (group, ticket, candidates) = self.tickets[usize::from(index) % self.tickets.len()].clone();
        let reason = "a reason".to_owned();
        let reply = match what % 6 {
            0 => ArbitrationReply::Failed { reason },
            1 => ArbitrationReply::Chosen { child: None, reason },
            2 => ArbitrationReply::Chosen {
                child: Some(SchemaId(u32::from(what) % 40)),
                reason,
            },
            _ => ArbitrationReply::Chosen {
                child: candidates
                    .get(usize::from(what) % candidates.len().max(1))
                    .copied(),
                reason,
            },
        };
        self.transaction(|transaction| transaction.arbitrated(group, ticket, reply.clone()))
    }

    fn operate(&mut self, id: SchemaId, what: u16, who: u16) -> Result<(), TestCaseError> {
        let by = Holder {
            operator: 1 + u32::from(who % 2),
            leased: (who / 2).is_multiple_of(2),
        };
        let (now, kept) = (self.now, self.needed_by(id));
        let mut out = Vec::new();
        match what % 8 {
            0 | 1 => {
                let result = self.h.at(now, &mut out).operator(by, Operator::Play(id));
                if self.accepts(&result, by, id)? {
                    self.requests.end(id, |hold| hold.action.stops());
                    self.requests.add(id, by, HoldAction::Played);
                }
            }
            2 | 3 => {
                if self.h.at(now, &mut out).operator(by, Operator::Stop(id)).is_ok() {
                    let unloaded = Hold {
                        by,
                        action: HoldAction::Unloaded,
                    };
                    if !self.requests.stops(id).contains(&unloaded) {
                        let played = HoldAction::Played;
                        self.requests.end(id, |hold| hold == Hold { by, action: played });
                        self.requests.add(id, by, HoldAction::Stopped);
                        self.requests.kept.extend(kept);
                    }
                }
            }
            4 => {
                let result = self.h.at(now, &mut out).operator(by, Operator::Force(id));
                if self.accepts(&result, by, id)? {
                    let group = self.h.group_of(id).expect("only motor schemas are forced");
                    for member in self.h.spec().groups[group].members.clone() {
                        let action = HoldAction::Forced;
                        self.requests.end(member, |hold| hold == Hold { by, action });
                    }
                    self.requests.add(id, by, HoldAction::Forced);
                }
            }
            5 if !what.is_multiple_of(3) => {
                if self.h.at(now, &mut out).unload(by, id).is_ok() {
                    let replaced = [HoldAction::Played, HoldAction::Stopped];
                    self.requests
                        .end(id, |hold| hold.by == by && replaced.contains(&hold.action));
                    self.requests.add(id, by, HoldAction::Unloaded);
                }
            }
            5 => {
                if self.h.at(now, &mut out).load(id).is_ok() {
                    self.requests.end(id, |hold| hold.action == HoldAction::Unloaded);
                }
            }
            6 => {
                if self
                    .h
                    .at(now, &mut out)
                    .operator(by, Operator::Release(id))
                    .is_ok()
                {
                    self.requests.end(id, |_| true);
                }
            }
            _ => {
                if self.h.at(now, &mut out).let_go(by, id).is_ok() {
                    self.requests.end(id, |hold| {
                        hold.by.operator == by.operator
                            && (hold.by.leased || !by.leased)
                            && hold.action != HoldAction::StoppedWithAll
                    });
                }
            }
        }
        self.check_effects(&out)
    }

    /// R14: whether a play or a force was accepted. With a lease it is refused while somebody else stops the schema.
    fn accepts(&self, result: &Result<(), Refused>, by: Holder, id: SchemaId) -> Result<bool, TestCaseError> {
        let disarms = by.leased && self.requests.stops(id).iter().any(|stop| stop.by != by);
        if disarms {
            prop_assert!(result.is_err(), "R14: a lease ends a stop of {:?}", id);
        }
        Ok(result.is_ok())
    }

    /// What an awake schema and those below it need, with the fathers' requests for perceptive schemas.
    fn needed_by(&self, id: SchemaId) -> Vec<(SchemaId, SchemaId)> {
        let spec = self.h.spec();
        let users = below(spec, id)
            .into_iter()
            .chain([id])
            .filter(|user| self.h.is_awake(*user));
        let perceptive = |need: &SchemaId| spec.schemas[*need].kind == Kind::Perceptive;
        let needs = users.flat_map(|user| {
            let woken = self
                .requests
                .fathers
                .iter()
                .filter(move |(father, _)| *father == user);
            let needs = spec.schemas[user].needs.iter().copied();
            let only_commands = &spec.schemas[user].only_commands;
            let needs = needs.chain(woken.map(|(_, child)| *child));
            needs.filter(|need| !only_commands.contains(need))
        });
        needs.filter(perceptive).map(|need| (id, need)).collect()
    }

    fn stop_all(&mut self, by: Holder) -> Result<(), TestCaseError> {
        let spec = self.h.spec().clone();
        let tops = spec.groups.iter().filter(|group| group.father.is_none());
        let roots: Vec<_> = tops.flat_map(|group| group.members.clone()).collect();
        let kept: Vec<_> = roots.iter().map(|root| self.needed_by(*root)).collect();
        let mut out = Vec::new();
        if self.h.at(self.now, &mut out).stop_all(by).is_ok() {
            for (root, kept) in roots.iter().zip(kept) {
                self.requests.add(*root, by, HoldAction::StoppedWithAll);
                self.requests.kept.extend(kept);
            }
            prop_assert!(
                roots.iter().all(|root| !self.h.is_awake(*root)),
                "R14: a root is awake"
            );
        }
        self.check_effects(&out)
    }

    fn release_all(&mut self) -> Result<(), TestCaseError> {
        let mut out = Vec::new();
        if self.h.at(self.now, &mut out).release_all().is_ok() {
            for id in ids(self.h.spec()) {
                self.requests
                    .end(id, |hold| hold.action == HoldAction::StoppedWithAll);
            }
        }
        self.check_effects(&out)
    }

    fn fire(&mut self, index: u16) -> Result<(), TestCaseError> {
        let timers: Vec<_> = self.h.timers().collect();
        if timers.is_empty() {
            return Ok(());
        }
        let (due, timer) = timers[usize::from(index) % timers.len()];
        self.now = self.now.max(due);
        self.transaction(|transaction| transaction.fire(timer))
    }

    fn shutdown(&mut self) -> Result<(), TestCaseError> {
        self.running = false;
        self.shadow.begin_shutdown();
        self.transaction(|transaction| transaction.shutdown())?;
        prop_assert!(
            ids(self.h.spec()).all(|id| !self.h.is_awake(id)),
            "a schema is awake after the shutdown"
        );
        prop_assert_eq!(self.h.next_timer(), None);
        Ok(())
    }

    /// Ends every iteration and fires every timer, so that nothing remains pending.
    fn finish(&mut self) -> Result<(), TestCaseError> {
        for id in ids(self.h.spec()) {
            if self.shadow.is_running(id) {
                self.end(id)?;
            }
        }
        for id in self.group_ids() {
            prop_assert_eq!(
                self.h.handover(id),
                None,
                "R1: a handover without a running loser"
            );
        }
        for _ in 0..50 {
            let Some(due) = self.h.next_timer() else { break };
            self.now = self.now.max(due);
            self.transaction(|transaction| transaction.tick())?;
        }
        self.shutdown()
    }

    fn is_being_replaced(&self, id: SchemaId) -> bool {
        self.group_ids().any(|g| {
            self.h.handover(g).is_some()
                && self
                    .h
                    .winner(g)
                    .is_some_and(|loser| loser == id || below(self.h.spec(), loser).contains(&id))
        })
    }

    fn group_ids(&self) -> impl Iterator<Item = GroupId> + use<> {
        (0..u32::try_from(self.h.spec().groups.len()).expect("few groups")).map(GroupId)
    }

    fn pick_schema(&self, index: u16) -> SchemaId {
        SchemaId(u32::from(index) % u32::try_from(self.h.spec().schemas.len()).expect("few schemas"))
    }

    /// Usually picks a schema to which the event applies, sometimes any.
    fn pick_applicable(&self, index: u16, event: u16) -> SchemaId {
        let applies = |id: &SchemaId| match event {
            0..=7 => self.h.is_awake(*id) && self.h.group_of(*id).is_some(),
            8..=12 => self.h.state(*id) == State::Winner,
            13..=16 => self.shadow.is_running(*id),
            28 => self.h.has_authority(*id),
            17..=22 => self.h.has_authority(*id) && !self.h.subtree(*id).is_empty(),
            _ => true,
        };
        let applicable: Vec<_> = ids(self.h.spec()).filter(applies).collect();
        if applicable.is_empty() || index.is_multiple_of(16) {
            return self.pick_schema(index / 16);
        }
        applicable[usize::from(index / 16) % applicable.len()]
    }

    fn pick_group(&self, index: u16) -> GroupId {
        GroupId(u32::from(index) % u32::try_from(self.h.spec().groups.len()).expect("few groups"))
    }

    /// Usually picks a schema that `by` may wake, sometimes any.
    fn pick_child(&self, by: SchemaId, index: u16) -> SchemaId {
        let spec = self.h.spec();
        let mut children: Vec<_> = spec
            .groups
            .iter()
            .filter(|g| g.father == Some(by))
            .flat_map(|g| g.members.clone())
            .collect();
        children.extend(ids(spec).filter(|id| spec.schemas[*id].kind == Kind::Perceptive));
        if children.is_empty() || index.is_multiple_of(16) {
            return self.pick_schema(index);
        }
        children[usize::from(index) % children.len()]
    }
}
