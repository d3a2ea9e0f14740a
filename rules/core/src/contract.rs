//! The worst takeover time of every group, computed before the start (R17).
//!
//! It refuses to measure: it only adds up what the specification declares. Delays of the machine (a thread
//! that wakes late, too few processors) are not included.

use std::fmt;

use crate::policy::Policy;
use crate::spec::{GroupId, GroupSpec, Nanos, SchemaId, Spec};

/// The longest times from a situation to the first iteration of the member that responds to it, for one
/// group.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct GroupContract {
    /// The group.
    pub group: GroupId,
    /// Its name.
    pub name: String,
    /// A check finds that a precondition changed. A selection follows at once.
    pub by_check: TakeoverBound,
    /// A check finds another urgency, or a change of another value that only the policy uses. The next
    /// selection follows the winner's iteration (R2). Present only if the policy uses more than readiness.
    pub by_winner: Option<TakeoverBound>,
}

/// A sum of times.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct TakeoverBound {
    /// The member with the longest takeover.
    pub slowest: SchemaId,
    /// Its name.
    pub slowest_name: String,
    /// The summands of the worst case, in the order in which they occur.
    pub terms: Vec<Term>,
}

/// One summand of a contract.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Term {
    /// The activity that takes the time.
    pub description: String,
    /// The longest time that it takes.
    pub nanos: Nanos,
    /// Whether this is a wait that the policy imposes. The selection after it has a cause of its own (R15),
    /// so the wait is not part of the measured time.
    pub is_policy_wait: bool,
}

/// Computes the contract of every group of a valid specification. A group without known members has none.
#[must_use]
pub fn contract(spec: &Spec) -> Vec<GroupContract> {
    let mut arbitration_times = spec.schemas.map_ids(|_| 0);
    for group in &spec.groups {
        if let Some(father) = group.father.and_then(|father| arbitration_times.get_mut(father)) {
            *father = arbitration(group).saturating_add(*father);
        }
    }
    let calculator = ContractCalculator {
        spec,
        own: &|id| arbitration_times[id],
    };
    let groups = spec.groups.entries();
    groups
        .filter_map(|(id, group)| calculator.contract(id, group))
        .collect()
}

/// Returns how long a takeover in a group may take from its cause, as it is measured (R15): without the waits
/// of the policy. It does not allocate. `own` returns how long the arbitrations of a schema's own groups may
/// take in total.
pub(crate) fn allowed(spec: &Spec, id: GroupId, own: &dyn Fn(SchemaId) -> Nanos) -> Option<Nanos> {
    let calculator = ContractCalculator { spec, own };
    let group = spec.groups.get(id)?;
    let detection = calculator.detection_time(calculator.slowest_check(group)?);
    let father = arbitration(group).saturating_mul(2);
    let start = calculator.call_time(calculator.slowest_start(group)?);
    Some(saturating_sum([detection, father, group.patience, start]))
}

/// Returns how long the father of a group may take to arbitrate.
pub(crate) fn arbitration(group: &GroupSpec) -> Nanos {
    if group.policy == Policy::FATHER {
        group.budget
    } else {
        0
    }
}

impl GroupContract {
    /// Returns the longer of the two sums: from the situation to the first iteration.
    #[must_use]
    pub fn total(&self) -> Nanos {
        let by_urgency = self.by_winner.as_ref().map_or(0, TakeoverBound::total);
        self.by_check.total().max(by_urgency)
    }

    /// Returns how long a takeover may take from its cause, as it is measured (R15): without the waits of the
    /// policy.
    #[must_use]
    pub fn allowed(&self) -> Nanos {
        let measured = self.by_check.terms.iter().filter(|term| !term.is_policy_wait);
        saturating_sum(measured.map(|term| term.nanos))
    }
}

impl TakeoverBound {
    /// Returns the sum of the terms.
    #[must_use]
    pub fn total(&self) -> Nanos {
        saturating_sum(self.terms.iter().map(|term| term.nanos))
    }
}

/// One line for each sum.
impl fmt::Display for GroupContract {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.name, self.by_check)?;
        if let Some(by_urgency) = &self.by_winner {
            write!(f, "\n  {}, by urgency alone: {by_urgency}", self.name)?;
        }
        Ok(())
    }
}

impl fmt::Display for TakeoverBound {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (name, total) = (&self.slowest_name, Millis(self.total()));
        write!(f, "{name} takes over within {total} = ")?;
        for (n, term) in self.terms.iter().enumerate() {
            let plus = if n == 0 { "" } else { " + " };
            write!(f, "{plus}{} {}", term.description, Millis(term.nanos))?;
        }
        Ok(())
    }
}

struct Millis(Nanos);

impl fmt::Display for Millis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (whole, rest) = (self.0 / 1_000_000, self.0 % 1_000_000);
        if rest == 0 {
            write!(f, "{whole} ms")
        } else {
            write!(f, "{whole}.{} ms", format!("{rest:06}").trim_end_matches('0'))
        }
    }
}

fn saturating_sum(nanos: impl IntoIterator<Item = Nanos>) -> Nanos {
    nanos.into_iter().fold(0, Nanos::saturating_add)
}

/// The arithmetic over one specification.
struct ContractCalculator<'s> {
    spec: &'s Spec,
    own: &'s dyn Fn(SchemaId) -> Nanos,
}

impl ContractCalculator<'_> {
    fn contract(&self, id: GroupId, group: &GroupSpec) -> Option<GroupContract> {
        let (slowest_check, slowest_start) = (self.slowest_check(group)?, self.slowest_start(group)?);
        let wait = self.policy_wait(group);
        let bound = |start: SchemaId, between: Vec<Term>| TakeoverBound {
            slowest: start,
            slowest_name: self.name(start),
            terms: [
                self.detection_terms(slowest_check),
                between,
                self.handover_terms(group, start),
            ]
            .concat(),
        };
        let waited = wait.as_ref().map_or(0, |wait| wait.nanos);
        let pair = self.slowest_pair(group, waited);
        let by_winner = pair
            .filter(|_| group.policy.kind().compares_urgency)
            .map(|(start, winner)| {
                // The wait or the iteration, whichever ends later.
                let longer = wait.clone().filter(|wait| wait.nanos > self.pace_time(winner));
                bound(start, longer.map_or_else(|| self.pace(winner), |wait| vec![wait]))
            });
        Some(GroupContract {
            group: id,
            name: group.name.clone(),
            by_winner,
            by_check: bound(slowest_start, wait.into_iter().collect()),
        })
    }

    /// Returns the member that may take longest to report a change of readiness (its own rise or fall).
    fn slowest_check(&self, group: &GroupSpec) -> Option<SchemaId> {
        self.slowest(group, |id| self.detection_time(id))
    }

    /// Returns the member that may take longest to start its first iteration.
    fn slowest_start(&self, group: &GroupSpec) -> Option<SchemaId> {
        self.slowest(group, |id| self.call_time(id))
    }

    /// Returns the first member with the longest time.
    fn slowest(&self, group: &GroupSpec, time: impl Fn(SchemaId) -> Nanos) -> Option<SchemaId> {
        self.reversed_members(group).max_by_key(|id| time(*id))
    }

    /// Returns the member that takes over and the winner before it, which is another one, whose times together are
    /// the longest. The policy makes the member wait for `wait`. `None` if no other schema can win.
    fn slowest_pair(&self, group: &GroupSpec, wait: Nanos) -> Option<(SchemaId, SchemaId)> {
        let pairs = self.reversed_members(group).flat_map(move |start| {
            let winners = self
                .reversed_members(group)
                .filter(move |winner| *winner != start);
            winners.map(move |winner| (start, winner))
        });
        pairs.max_by_key(|(start, winner)| {
            let until = self.pace_time(*winner).max(wait);
            until.saturating_add(self.call_time(*start))
        })
    }

    /// Returns the known members, the last one first.
    fn reversed_members(&self, group: &GroupSpec) -> impl Iterator<Item = SchemaId> {
        let members = group.members.iter().rev().copied();
        members.filter(move |id| self.spec.schemas.get(*id).is_some())
    }

    /// Returns the time from the situation to the end of the check that reports it: whole periods, until the
    /// previous check has ended (for a triggered schema, a turn under way), and the check.
    fn detection_time(&self, id: SchemaId) -> Nanos {
        self.before_check(id).saturating_add(self.call_time(id))
    }

    fn before_check(&self, id: SchemaId) -> Nanos {
        let schema = &self.spec.schemas[id];
        if schema.triggered {
            schema.budget
        } else {
            self.between_turns(id)
        }
    }

    fn detection_terms(&self, id: SchemaId) -> Vec<Term> {
        let name = self.name(id);
        let schema = &self.spec.schemas[id];
        let before = match schema.budget.checked_div(schema.period).unwrap_or(0) {
            _ if schema.triggered => format!("turn of {name} that is under way"),
            0 => format!("period of {name}"),
            more => format!("{} periods of {name}", more.saturating_add(1)),
        };
        self.call_terms(before, self.before_check(id), id, format!("check by {name}"))
    }

    /// Returns the terms from the decision to the first iteration. The father arbitrates, twice if an
    /// arbitration is under way. The loser ends its iteration, or its patience ends. The winner checks again
    /// before it acts (R8).
    fn handover_terms(&self, group: &GroupSpec, slowest_start: SchemaId) -> Vec<Term> {
        let (time, name) = (arbitration(group), self.name(slowest_start));
        let mut terms = terms([
            ("arbitration that is under way".to_owned(), time),
            ("arbitration by the father".to_owned(), time),
        ]);
        let patience = "patience with the loser".to_owned();
        let check = format!("check of {name} before it acts");
        terms.extend(self.call_terms(patience, group.patience, slowest_start, check));
        terms
    }

    /// The times until a call of a schema has ended. What may be under way when it is due comes first: a
    /// drawing and a gesture, an arbitration and another that waits for it.
    fn call_times(&self, id: SchemaId) -> [Nanos; 3] {
        let budget = self.spec.schemas[id].budget;
        [self.panel(id), (self.own)(id).saturating_mul(2), budget]
    }

    fn call_time(&self, id: SchemaId) -> Nanos {
        saturating_sum(self.call_times(id))
    }

    /// Returns the terms of what comes before a call of a schema is due, and of the call.
    fn call_terms(&self, before: String, before_time: Nanos, id: SchemaId, call: String) -> Vec<Term> {
        let name = self.name(id);
        let [panel, arbitrations, budget] = self.call_times(id);
        terms([
            (before, before_time),
            (
                format!("drawing of the panel of {name} and a gesture on it"),
                panel,
            ),
            (format!("arbitrations by {name}"), arbitrations),
            (call, budget),
        ])
    }

    /// Returns how long a policy may make a READY member wait before it is chosen.
    fn policy_wait(&self, group: &GroupSpec) -> Option<Term> {
        let others = group.members.len().saturating_sub(1) as Nanos;
        let (description, nanos) = group.policy.wait(others)?;
        Some(Term {
            description: description.to_owned(),
            nanos,
            is_policy_wait: true,
        })
        .filter(|term| term.nanos > 0)
    }

    /// Returns the longest time from any moment to the end of a winner's next iteration. A winner iterates at
    /// its period even if it is triggered.
    fn pace_time(&self, winner: SchemaId) -> Nanos {
        self.between_turns(winner).saturating_add(self.call_time(winner))
    }

    fn pace(&self, winner: SchemaId) -> Vec<Term> {
        let name = self.name(winner);
        let (period, iteration) = (
            format!("period of the winner {name}"),
            format!("iteration of {name}"),
        );
        let mut terms = self.call_terms(period, self.between_turns(winner), winner, iteration);
        for term in &mut terms {
            term.is_policy_wait = true;
        }
        terms
    }

    /// Returns the time from one due turn to the next: whole periods, as many as an iteration takes at most
    /// (R11).
    fn between_turns(&self, id: SchemaId) -> Nanos {
        let schema = &self.spec.schemas[id];
        let skipped = schema.budget.checked_div(schema.period).unwrap_or(0);
        schema.period.saturating_mul(skipped.saturating_add(1))
    }

    /// Returns the time for a drawing that is under way and a gesture after it.
    fn panel(&self, id: SchemaId) -> Nanos {
        let schema = &self.spec.schemas[id];
        if schema.panel {
            schema.budget.saturating_mul(2)
        } else {
            0
        }
    }

    fn name(&self, id: SchemaId) -> String {
        self.spec.schemas[id].name.clone()
    }
}

/// Returns the terms that are not 0.
fn terms<const N: usize>(terms: [(String, Nanos); N]) -> Vec<Term> {
    let terms = terms.into_iter().map(|(description, nanos)| Term {
        description,
        nanos,
        is_policy_wait: false,
    });
    terms.filter(|term| term.nanos > 0).collect()
}
