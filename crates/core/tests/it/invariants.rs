//! Random hierarchies under random events: the rules hold after every transaction.
//!
//! The checks are independent of the implementation: those of R6 are in `Requests`, all others in `shadow`.

use std::collections::BTreeSet;

use crate::random::{MS, POLICIES, specs};
use jde_core::{
    ArbitrationReply, Check, Effect, GroupId, Health, Hierarchy, Kind, Nanos, Operator, Policy, Refused,
    SchemaId, Spec, State, Timer,
};
use jde_shadow::{Shadow, below, ids};
use proptest::prelude::*;

proptest! {
    #![proptest_config(ProptestConfig { cases: 1000, ..ProptestConfig::default() })]

    #[test]
    fn rules_hold_after_every_random_event(spec in specs(), events in prop::collection::vec(any::<[u16; 4]>(), 1..300)) {
        let mut run = Run::new(spec);
        run.transaction(|h, out| h.start(0, out))?;
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

/// The requests that keep perceptive schemas awake, besides the needs of schemas, recorded independently (R6).
#[derive(Default)]
struct Requests {
    fathers: BTreeSet<(SchemaId, SchemaId)>,
    played: BTreeSet<SchemaId>,
    stopped: BTreeSet<SchemaId>,
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
                self.transaction(|h, out| h.checked(now, schema, check, out))
            }
            8..=12 => self.begin(schema),
            13..=16 => self.end(schema),
            17..=21 => self.wake(schema, b),
            22 => self.sleep(schema, b),
            23 => {
                let policy = POLICIES[usize::from(b) % POLICIES.len()];
                self.transaction(|h, out| drop(h.set_policy(now, group, policy, out)))
            }
            24 | 25 => self.reply(a, b),
            26 => {
                self.transaction(|h, out| h.faulted(now, schema, "a fault".into(), out))?;
                self.end(schema)
            }
            27 => self.operate(schema, b),
            28 => self.transaction(|h, out| h.refused(now, schema, out)),
            29 => self.transaction(|h, out| h.tick(now, out)),
            30 => self.fire(a),
            _ => match b % 12 {
                0 => self.transaction(|h, out| h.restored(now, other, out)),
                1 => self.transaction(|h, out| h.overrun(other, out)),
                2 => self.transaction(|h, out| h.on_time(other, out)),
                3 if c % 8 == 0 => self.shutdown(),
                4 => self.transaction(|h, out| drop(h.stop_all(now, out))),
                5 => self.transaction(|h, out| drop(h.release_all(now, out))),
                _ => {
                    self.now = self.h.next_timer().map_or(now, |due| due.max(now));
                    let now = self.now;
                    self.transaction(|h, out| h.tick(now, out))
                }
            },
        }
    }

    /// Runs one call on the hierarchy and on a copy, and checks the effects against the rules.
    fn transaction(&mut self, call: impl Fn(&mut Hierarchy, &mut Vec<Effect>)) -> Result<(), TestCaseError> {
        let mut twin = self.h.clone();
        let before: Vec<_> = self.group_ids().map(|g| self.h.winner(g)).collect();
        let (mut out, mut twin_out) = (Vec::new(), Vec::new());
        call(&mut self.h, &mut out);
        call(&mut twin, &mut twin_out);
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
        self.perceptive_schemas_are_awake_exactly_when_needed()?;
        self.groups_are_settled()
    }

    /// R6, computed independently.
    fn perceptive_schemas_are_awake_exactly_when_needed(&self) -> Result<(), TestCaseError> {
        let spec = self.h.spec();
        for id in ids(spec).filter(|id| spec.schemas[id.index()].kind == Kind::Perceptive) {
            let needed =
                ids(spec).any(|by| self.h.is_awake(by) && spec.schemas[by.index()].needs.contains(&id));
            let woken = self.requests.fathers.iter().any(|&(_, child)| child == id);
            let down = self.requests.stopped.contains(&id) || matches!(self.h.health(id), Health::Faulted(_));
            let expected = self.running && !down && (needed || woken || self.requests.played.contains(&id));
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
            let spec = &self.h.spec().groups[id.index()];
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
            let forced = self
                .h
                .forced(id)
                .filter(|&f| self.h.is_awake(f) && !self.h.is_abandoned(f));
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
            let group = &self.h.spec().groups[id.index()];
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
        let accepted = self.h.begin(self.now, id, &mut out);
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
        let now = self.now;
        self.shadow.end_iteration(id);
        self.transaction(|h, out| h.end(now, id, out))
    }

    fn wake(&mut self, by: SchemaId, index: u16) -> Result<(), TestCaseError> {
        let (now, child) = (self.now, self.pick_child(by, index));
        let mut out = Vec::new();
        let may = self.h.has_authority(by) && !self.is_being_replaced(by);
        let result = self.h.wake(now, by, child, &mut out);
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
        if self.h.sleep(now, by, child, &mut out).is_ok() {
            self.requests.fathers.remove(&(by, child));
        }
        self.check_effects(&out)
    }

    fn reply(&mut self, index: u16, what: u16) -> Result<(), TestCaseError> {
        if self.tickets.is_empty() {
            return Ok(());
        }
        let (group, ticket, candidates) = self.tickets[usize::from(index) % self.tickets.len()].clone();
        let now = self.now;
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
        self.transaction(|h, out| h.arbitrated(now, group, ticket, reply.clone(), out))
    }

    fn operate(&mut self, id: SchemaId, what: u16) -> Result<(), TestCaseError> {
        let action = match what % 4 {
            0 => Operator::Play(id),
            1 => Operator::Stop(id),
            2 => Operator::Force(id),
            _ => Operator::Release(id),
        };
        let mut out = Vec::new();
        let result = if what % 8 == 7 {
            self.h.let_go(self.now, id, &mut out)
        } else {
            self.h.operator(self.now, action, &mut out)
        };
        if result.is_ok() {
            match action {
                Operator::Play(_) => {
                    self.requests.stopped.remove(&id);
                    self.requests.played.insert(id);
                }
                Operator::Stop(_) => {
                    self.requests.stopped.insert(id);
                    self.requests.played.remove(&id);
                }
                Operator::Release(_) => {
                    self.requests.stopped.remove(&id);
                    self.requests.played.remove(&id);
                }
                Operator::Force(_) => {}
            }
        } else {
            prop_assert!(out.is_empty(), "a refused call has effects");
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
        let now = self.now;
        self.transaction(|h, out| h.fire(now, timer, out))
    }

    fn shutdown(&mut self) -> Result<(), TestCaseError> {
        self.running = false;
        self.shadow.begin_shutdown();
        let now = self.now;
        self.transaction(|h, out| h.shutdown(now, out))?;
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
            let now = self.now;
            self.transaction(|h, out| h.tick(now, out))?;
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
        children.extend(ids(spec).filter(|id| spec.schemas[id.index()].kind == Kind::Perceptive));
        if children.is_empty() || index.is_multiple_of(16) {
            return self.pick_schema(index);
        }
        children[usize::from(index) % children.len()]
    }
}
