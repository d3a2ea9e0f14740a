//! Two operators whose lasting actions and leases begin, end and overlap in every order (R14), over the real state
//! machine.
//!
//! A twin never sees an action under a lease. So whatever leases do, what lasts is the same in both. To test the model
//! itself, a defect runs through the same model, which must detect it.

use std::hash::{Hash, Hasher};

use jde_core::{
    Check, GroupId, GroupSpec, Hierarchy, Hold, HoldAction, Holder, Kind, Operator, SchemaId, SchemaSpec,
    Spec, State,
};
use stateright::{Checker, Model, Property};

const AHEAD: SchemaId = SchemaId(0);
const OTHER: SchemaId = SchemaId(1);
const EYE: SchemaId = SchemaId(2);
const ROOTS: GroupId = GroupId(0);
/// The operators that act. One more lease would make four times as many states, and no new pair of holders.
const HOLDERS: [Holder; 3] = [Holder::lasting(1), Holder::leased(1), Holder::leased(2)];

#[test]
fn r14_leases_that_begin_end_and_overlap_in_every_order_leave_what_lasts() {
    let checker = Operators {
        lease_ends_all: false,
    }
    .checker()
    .threads(2)
    .spawn_bfs()
    .join();
    println!("{} distinct states", checker.unique_state_count());
    checker.assert_properties();
}

#[test]
fn a_lease_whose_end_releases_the_schema_is_detected() {
    let checker = Operators { lease_ends_all: true }.checker().spawn_bfs().join();
    assert!(
        checker.discovery(WHAT_LASTS).is_some(),
        "the model detects nothing"
    );
}

const WHAT_LASTS: &str = "what lasts is the same without leases";

struct Operators {
    /// The defect: the end of a lease releases the schema, as one hold for each schema would.
    lease_ends_all: bool,
}

#[derive(Clone, Debug)]
struct World {
    h: Hierarchy,
    /// The same without any action under a lease.
    twin: Hierarchy,
}

#[derive(Copy, Clone, PartialEq, Eq, Debug)]
enum Step {
    Act(Holder, Operator),
    EndLease(Holder, SchemaId),
    StopAll,
    ReleaseAll,
}

impl Model for Operators {
    type State = World;
    type Action = Step;

    fn init_states(&self) -> Vec<World> {
        let schema = |name| SchemaSpec::new(name, Kind::Motor, 1);
        let mut spec = Spec {
            schemas: ["ahead", "other"].map(schema).to_vec().into(),
            groups: vec![GroupSpec::new("roots", None, vec![AHEAD, OTHER])].into(),
        };
        spec.schemas.push(SchemaSpec::new("eye", Kind::Perceptive, 1));
        spec.schemas[AHEAD].needs = vec![EYE];
        let mut h = Hierarchy::new(spec).expect("a valid specification");
        h.at(0, &mut Vec::new()).start();
        check_all(&mut h);
        vec![World { twin: h.clone(), h }]
    }

    fn actions(&self, _: &World, steps: &mut Vec<Step>) {
        for by in HOLDERS {
            let actions = [Operator::Play(AHEAD), Operator::Stop(AHEAD)];
            let forces = [Operator::Force(AHEAD), Operator::Force(OTHER)];
            steps.extend(
                actions
                    .into_iter()
                    .chain(forces)
                    .map(|action| Step::Act(by, action)),
            );
            if by.leased {
                steps.extend([AHEAD, OTHER].map(|id| Step::EndLease(by, id)));
            }
        }
        steps.extend([
            Step::Act(HOLDERS[0], Operator::Release(AHEAD)),
            Step::StopAll,
            Step::ReleaseAll,
        ]);
    }

    fn next_state(&self, before: &World, step: Step) -> Option<World> {
        let mut world = before.clone();
        let twin = match step {
            Step::Act(by, _) if by.leased => None,
            Step::EndLease(..) => None,
            Step::Act(..) | Step::StopAll | Step::ReleaseAll => Some(&mut world.twin),
        };
        for h in [Some(&mut world.h), twin].into_iter().flatten() {
            let mut out = Vec::new();
            match step {
                // A refusal changes nothing.
                Step::Act(by, action) => drop(h.at(0, &mut out).operator(by, action)),
                Step::EndLease(by, id) if self.lease_ends_all => {
                    drop(h.at(0, &mut out).operator(by, Operator::Release(id)));
                }
                Step::EndLease(by, id) => drop(h.at(0, &mut out).let_go(by, id)),
                Step::StopAll => drop(h.at(0, &mut out).stop_all(HOLDERS[0])),
                Step::ReleaseAll => drop(h.at(0, &mut out).release_all()),
            }
            check_all(h);
        }
        Some(world)
    }

    fn properties(&self) -> Vec<Property<Self>> {
        vec![
            Property::always(WHAT_LASTS, |_, w: &World| {
                let lasting = |h: &Hierarchy, id| sorted(h.holds(id).filter(|hold| !hold.by.leased));
                [AHEAD, OTHER]
                    .iter()
                    .all(|id| lasting(&w.h, *id) == lasting(&w.twin, *id))
            }),
            Property::always(
                "a stopped schema sleeps, and what it needed is awake",
                |_, w: &World| {
                    let stopped = w.h.holds(AHEAD).any(|hold| hold.action.stops());
                    stopped == (w.h.state(AHEAD) == State::Slept) && w.h.is_awake(EYE)
                },
            ),
            Property::always(
                "without leases everything is as if there had been none",
                |_, w: &World| {
                    let leased = [AHEAD, OTHER]
                        .iter()
                        .any(|id| w.h.holds(*id).any(|hold| hold.by.leased));
                    let facts =
                        |h: &Hierarchy| (h.state(AHEAD), h.state(OTHER), h.winner(ROOTS), h.forced(ROOTS));
                    leased || facts(&w.h) == facts(&w.twin)
                },
            ),
            Property::sometimes("a lease outlives a lasting stop", |_, w: &World| {
                !w.twin.is_stopped(AHEAD) && w.h.is_stopped(AHEAD)
            }),
            Property::sometimes("two leases force different schemas", |_, w: &World| {
                let forces = |id| {
                    w.h.holds(id)
                        .any(|hold| hold.action == HoldAction::Forced && hold.by.leased)
                };
                forces(AHEAD) && forces(OTHER)
            }),
        ]
    }
}

/// Every awake schema finds its precondition true.
fn check_all(h: &mut Hierarchy) {
    let check = Check {
        ready: true,
        urgency: 0.0,
        cause: 0,
    };
    for id in [AHEAD, OTHER] {
        h.at(0, &mut Vec::new()).checked(id, check);
    }
}

fn sorted(holds: impl Iterator<Item = Hold>) -> Vec<(Holder, u8)> {
    let mut holds: Vec<_> = holds.map(|hold| (hold.by, hold.action as u8)).collect();
    holds.sort_unstable();
    holds
}

impl World {
    /// Returns everything that determines the next steps: all but the numbers of records, and the order of holds other
    /// than forces.
    fn key(&self) -> impl Hash + PartialEq + '_ {
        [&self.h, &self.twin].map(|h| {
            let forces: Vec<_> = h.forces(ROOTS).collect();
            let schemas = [AHEAD, OTHER, EYE].map(|id| (sorted(h.holds(id)), h.state(id)));
            (schemas, forces, h.winner(ROOTS), h.actuation(ROOTS))
        })
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
