//! Every order in which the threads of a small hierarchy can step, over the real state machine.
//!
//! Two roots, teleop before example; example wakes stop and goon, stop first. Each thread checks, begins,
//! commands, wakes, ends, or faults, a guard refuses a command, and each timer fires, at any moment. To test the model itself, executors with
//! a defect run through the same model, which must detect each of them.

use std::hash::{Hash, Hasher};

use jde_core::{
    Check, Effect, GroupId, GroupSpec, Hierarchy, Id, Kind, Restart, SchemaId, SchemaSpec, Spec, State,
    Timer, Transaction,
};
use jde_shadow::{Shadow, ids};
use stateright::{Checker, Model, Property};

const TELEOP: SchemaId = SchemaId(0);
const EXAMPLE: SchemaId = SchemaId(1);
const STOP: SchemaId = SchemaId(2);
const GOON: SchemaId = SchemaId(3);
const ROOTS: GroupId = GroupId(0);
const MOTION: GroupId = GroupId(1);

#[test]
fn every_interleaving_keeps_r1_r5_r7_and_r18_and_lets_stop_win() {
    let checker = Threads {
        executor: Executor::Correct,
    }
    .checker()
    .threads(2)
    .spawn_bfs()
    .join();
    println!(
        "{} states, {} of them distinct",
        checker.state_count(),
        checker.unique_state_count()
    );
    checker.assert_properties();
}

#[test]
fn an_executor_that_abandons_before_patience_ends_is_detected() {
    assert_detected(Executor::IgnoresPatience);
}

#[test]
fn an_executor_that_iterates_without_permission_is_detected() {
    assert_detected(Executor::IgnoresPermission);
}

#[test]
fn an_executor_that_accepts_every_command_is_detected() {
    assert_detected(Executor::IgnoresAuthority);
}

#[test]
fn an_executor_that_applies_the_effects_backwards_is_detected() {
    assert_detected(Executor::ReversesEffects);
}

#[test]
fn an_executor_that_keeps_a_losers_command_in_force_is_detected() {
    assert_detected(Executor::KeepsLosersCommand);
}

#[test]
fn an_executor_that_does_not_report_a_refusal_is_detected() {
    assert_detected(Executor::HidesRefusals);
}

#[test]
fn an_executor_that_keeps_a_command_taken_over_and_not_written_is_detected() {
    assert_detected(Executor::KeepsUnwrittenCommand);
}

fn assert_detected(executor: Executor) {
    let checker = Threads { executor }.checker().spawn_bfs().join();
    assert!(
        checker.discovery(RULES_KEPT).is_some() || checker.discovery(REFUSED_LOSES).is_some(),
        "{executor:?} violated no rule: the model detects nothing"
    );
}

const RULES_KEPT: &str = "the rules are kept";
const REFUSED_LOSES: &str = "a refused schema loses within one patience";

/// How the executor uses the state machine.
#[derive(Copy, Clone, PartialEq, Eq, Hash, Debug)]
enum Executor {
    Correct,
    /// Fires the patience of a group at once.
    IgnoresPatience,
    /// Iterates without permission.
    IgnoresPermission,
    /// Accepts a command without a check of authority.
    IgnoresAuthority,
    /// Applies the last effect first.
    ReversesEffects,
    /// Keeps a loser's command in force at a takeover.
    KeepsLosersCommand,
    /// Keeps a command in force that was taken over and not written.
    KeepsUnwrittenCommand,
    /// Does not report that a guard refused a command.
    HidesRefusals,
}

struct Threads {
    executor: Executor,
}

#[derive(Clone, Debug)]
struct World {
    h: Hierarchy,
    shadow: Shadow,
    threads: [Thread; 4],
    remaining_faults: u8,
    /// The schemas whose command the guard refused, until they may try again.
    refused: [bool; 4],
    remaining_refusals: u8,
    violation: Option<String>,
}

#[derive(Copy, Clone, PartialEq, Eq, Hash, Debug)]
enum Thread {
    Between,
    Iterating { commanded: bool },
}

#[derive(Copy, Clone, PartialEq, Eq, Debug)]
enum Step {
    Check(SchemaId, bool),
    Begin(SchemaId),
    Command(SchemaId),
    /// It commands, and the guard refuses.
    Refuse(SchemaId),
    Wake(SchemaId),
    End(SchemaId),
    /// Its iteration ends because an input has no value.
    EndUnready(SchemaId),
    Fault(SchemaId),
    Fire(Timer),
}

impl Model for Threads {
    type State = World;
    type Action = Step;

    fn init_states(&self) -> Vec<World> {
        let spec = spec();
        let shadow = Shadow::new(&spec);
        let h = Hierarchy::new(spec).expect("a valid specification");
        let mut world = World {
            h,
            shadow,
            threads: [Thread::Between; 4],
            remaining_faults: 1,
            refused: [false; 4],
            remaining_refusals: 1,
            violation: None,
        };
        world.call(self.executor, |transaction| transaction.start());
        vec![world]
    }

    fn actions(&self, world: &World, steps: &mut Vec<Step>) {
        if world.violation.is_some() {
            return;
        }
        for id in ids(world.h.spec()) {
            match world.threads[id.index()] {
                Thread::Between => {
                    if world.h.is_awake(id) {
                        steps.extend([Step::Check(id, true), Step::Check(id, false), Step::Begin(id)]);
                    }
                }
                Thread::Iterating { commanded } => {
                    if !commanded {
                        steps.push(Step::Command(id));
                        if world.remaining_refusals > 0 {
                            steps.push(Step::Refuse(id));
                        }
                    }
                    steps.extend([Step::End(id), Step::EndUnready(id)]);
                }
            }
            if world.remaining_faults > 0 {
                steps.push(Step::Fault(id));
            }
        }
        if matches!(world.threads[EXAMPLE.index()], Thread::Iterating { .. }) {
            steps.extend([Step::Wake(STOP), Step::Wake(GOON)]);
        }
        steps.extend(world.h.timers().map(|(_, timer)| Step::Fire(timer)));
    }

    fn next_state(&self, before: &World, step: Step) -> Option<World> {
        let mut world = before.clone();
        world.step(self.executor, step);
        Some(world)
    }

    fn properties(&self) -> Vec<Property<Self>> {
        vec![
            Property::always(RULES_KEPT, |_, w: &World| w.violation.is_none()),
            Property::always("after the patience every chosen schema wins", |_, w: &World| {
                [ROOTS, MOTION].into_iter().all(|group| {
                    let Some(handover) = w.h.handover(group) else {
                        return true;
                    };
                    let mut later = w.h.clone();
                    later.at(0, &mut Vec::new()).fire(Timer::Patience(group));
                    later.winner(group) == handover.to
                })
            }),
            Property::always("a ready stop wins within one patience", |_, w: &World| {
                let due = w.h.is_ready(STOP) && w.h.has_authority(EXAMPLE) && w.h.handover(ROOTS).is_none();
                let mut later = w.h.clone();
                later.at(0, &mut Vec::new()).fire(Timer::Patience(MOTION));
                !due || later.has_authority(STOP)
            }),
            Property::always(REFUSED_LOSES, |_, w: &World| {
                ids(w.h.spec()).filter(|id| w.refused[id.index()]).all(|id| {
                    let group = w.h.group_of(id).expect("a motor schema");
                    let mut later = w.h.clone();
                    for group in [ROOTS, MOTION] {
                        later.at(0, &mut Vec::new()).fire(Timer::Patience(group));
                    }
                    later.winner(group) != Some(id)
                })
            }),
            Property::sometimes("goon wins because stop is refused", |_, w: &World| {
                w.refused[STOP.index()] && w.h.is_checked(STOP) && w.h.has_authority(GOON)
            }),
            Property::sometimes("a refused schema wins again", |_, w: &World| {
                w.remaining_refusals == 0 && !w.h.is_refused(STOP) && w.h.has_authority(STOP)
            }),
            Property::sometimes("stop wins while goon hangs", |_, w: &World| {
                w.h.has_authority(STOP) && w.threads[GOON.index()] == Thread::Iterating { commanded: false }
            }),
            Property::sometimes("teleop wins while goon hangs", |_, w: &World| {
                w.h.has_authority(TELEOP) && w.h.is_abandoned(GOON)
            }),
            Property::sometimes(
                "goon wakes again inside its abandoned iteration",
                |_, w: &World| w.h.is_awake(GOON) && w.h.is_abandoned(GOON),
            ),
            Property::sometimes("a faulted schema wins again", |_, w: &World| {
                w.h.restarts_left(0, GOON) == Some(0) && w.h.has_authority(GOON)
            }),
        ]
    }
}

impl World {
    fn step(&mut self, executor: Executor, step: Step) {
        let abandoned = self.abandoned();
        let within_patience = !matches!(step, Step::Fire(_) | Step::Fault(_));
        match step {
            Step::Check(id, ready) => {
                let check = Check {
                    ready,
                    urgency: 0.0,
                    cause: 0,
                };
                self.call(executor, |transaction| transaction.checked(id, check));
            }
            Step::Begin(id) => self.begin(executor, id),
            Step::Command(id) => {
                self.threads[id.index()] = Thread::Iterating { commanded: true };
                let accepted = executor == Executor::IgnoresAuthority || self.h.has_authority(id);
                if accepted && !self.may_command(id) {
                    self.violation = Some(format!("R7: a command of {id:?} was accepted"));
                }
            }
            Step::Refuse(id) => {
                self.threads[id.index()] = Thread::Iterating { commanded: true };
                self.remaining_refusals -= 1;
                self.refused[id.index()] = self.h.has_authority(id);
                if executor != Executor::HidesRefusals {
                    self.call(executor, |transaction| transaction.refused(id));
                }
            }
            Step::Wake(child) => {
                let has_authority = self.h.has_authority(EXAMPLE);
                self.call(executor, |transaction| {
                    let woken = transaction.wake(EXAMPLE, child).is_ok();
                    assert!(has_authority || !woken, "R7: woken without authority");
                });
            }
            Step::End(id) | Step::EndUnready(id) => {
                self.threads[id.index()] = Thread::Between;
                self.shadow.end_iteration(id);
                if step == Step::End(id) {
                    return self.call(executor, |transaction| transaction.end(id));
                }
                self.call(executor, |transaction| transaction.end_unready(id));
                if self.h.is_ready(id) {
                    self.violation = Some(format!("R19: {id:?} is READY without a value"));
                }
            }
            Step::Fault(id) => {
                self.remaining_faults -= 1;
                self.call(executor, |transaction| transaction.faulted(id, "a fault".into()));
            }
            Step::Fire(timer) => {
                if let Timer::Retry(id) = timer {
                    self.refused[id.index()] = false;
                }
                self.call(executor, |transaction| transaction.fire(timer));
            }
        }
        if executor == Executor::IgnoresPatience && within_patience {
            for group in [ROOTS, MOTION] {
                self.call(executor, |transaction| transaction.fire(Timer::Patience(group)));
            }
        }
        if within_patience && self.abandoned() > abandoned {
            self.violation
                .get_or_insert("R1: abandoned before the patience ended".into());
        }
    }

    fn abandoned(&self) -> usize {
        ids(self.h.spec()).filter(|&id| self.h.is_abandoned(id)).count()
    }

    fn begin(&mut self, executor: Executor, id: SchemaId) {
        let began = if executor == Executor::IgnoresPermission {
            self.h.state(id) == State::Winner
        } else {
            self.h.at(0, &mut Vec::new()).begin(id)
        };
        if began {
            self.threads[id.index()] = Thread::Iterating { commanded: false };
            self.shadow.begin_iteration(id);
            if self.is_being_replaced(id) {
                self.violation = Some(format!(
                    "R5: {id:?} begins while it or its father is being replaced"
                ));
            }
        }
    }

    fn call(&mut self, executor: Executor, call: impl FnOnce(&mut Transaction)) {
        let mut out = Vec::new();
        call(&mut self.h.at(0, &mut out));
        if executor == Executor::ReversesEffects {
            out.reverse();
        }
        out.retain(|effect| match effect {
            Effect::TakesOver { .. } => executor != Executor::KeepsLosersCommand,
            Effect::Lapsed(_) => executor != Executor::KeepsUnwrittenCommand,
            _ => true,
        });
        let result = self
            .shadow
            .apply(self.h.spec(), &out)
            .and_then(|()| self.shadow.check_against(&self.h));
        if let Err(violation) = result {
            self.violation.get_or_insert(violation);
        }
    }

    /// Whether R7 allows a command, by the states alone and not inside an abandoned iteration.
    fn may_command(&self, id: SchemaId) -> bool {
        let wins = |id| self.shadow.state(id) == State::Winner;
        let chain = match id {
            STOP | GOON => wins(id) && wins(EXAMPLE),
            _ => wins(id),
        };
        chain && !self.shadow.is_abandoned(id)
    }

    fn is_being_replaced(&self, id: SchemaId) -> bool {
        let loses = |group, id| self.h.handover(group).is_some() && self.h.winner(group) == Some(id);
        match id {
            STOP | GOON => loses(MOTION, id) || loses(ROOTS, EXAMPLE),
            _ => loses(ROOTS, id),
        }
    }

    /// Returns everything that determines the next steps: all but times and the numbers of records.
    fn key(&self) -> impl Hash + PartialEq + '_ {
        let nodes: Vec<_> = ids(self.h.spec())
            .map(|id| {
                let flags = [
                    self.h.is_ready(id),
                    self.h.is_checked(id),
                    self.h.is_running(id),
                    self.h.is_abandoned(id),
                    self.h.has_authority(id),
                    self.h.is_refused(id),
                ];
                (
                    self.h.state(id),
                    self.h.health(id),
                    flags,
                    self.h.requesters(id),
                    self.h.restarts_left(0, id),
                )
            })
            .collect();
        let groups = [ROOTS, MOTION].map(|g| {
            (
                self.h.winner(g),
                self.h.handover(g).map(|h| h.to),
                self.h.actuation(g),
            )
        });
        let timers: Vec<_> = self.h.timers().map(|(_, timer)| timer).collect();
        (
            nodes,
            groups,
            timers,
            &self.shadow,
            self.threads,
            self.remaining_faults,
            (self.refused, self.remaining_refusals),
            &self.violation,
        )
    }
}

impl Hash for World {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.key().hash(state);
    }
}

impl PartialEq for World {
    fn eq(&self, other: &Self) -> bool {
        self.key() == other.key()
    }
}

fn spec() -> Spec {
    let restart = Restart::OnFault {
        backoff: 1,
        limit: 1,
        within: 1,
    };
    let schema = |name| SchemaSpec {
        restart,
        ..SchemaSpec::new(name, Kind::Motor, 1)
    };
    Spec {
        schemas: ["teleop", "example", "stop", "goon"].map(schema).to_vec().into(),
        groups: vec![
            GroupSpec::new("roots", None, vec![TELEOP, EXAMPLE]),
            GroupSpec::new("motion", Some(EXAMPLE), vec![STOP, GOON]),
        ]
        .into(),
    }
}
