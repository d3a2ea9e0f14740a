//! The worst takeover time of every group, computed before the start (R17).
//!
//! It only adds up what the specification declares; whether a run keeps to it is measured elsewhere.

use std::fmt;

use crate::spec::{GroupId, GroupSpec, Nanos, Policy, SchemaId, Spec};

/// The longest time from a situation to the first iteration of the member that answers it, for one group.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct GroupContract {
    /// The group.
    pub group: GroupId,
    /// Its name.
    pub name: String,
    /// The slowest member, for which the sum is largest.
    pub slowest: SchemaId,
    /// The name of that member.
    pub slowest_name: String,
    /// What adds up to the worst case, in the order in which it happens.
    pub terms: Vec<Term>,
}

/// One summand of a contract.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Term {
    /// What takes the time.
    pub what: String,
    /// How long at most.
    pub nanos: Nanos,
}

/// Computes the contract of every group of a valid specification; a group without known members has none.
///
/// A member notices a situation within its period and one iteration, or within one iteration if publications
/// trigger it (it may be in the middle of one); one drawing of its panel more, if it has one. The father's arbitration and the loser's patience follow.
#[must_use]
pub fn contract(spec: &Spec) -> Vec<GroupContract> {
    (0u32..)
        .zip(&spec.groups)
        .filter_map(|(index, group)| group_contract(spec, GroupId(index), group))
        .collect()
}

impl GroupContract {
    /// The sum of the terms.
    #[must_use]
    pub fn total(&self) -> Nanos {
        total(&self.terms)
    }
}

impl fmt::Display for GroupContract {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{}: {} takes over within {} = ",
            self.name,
            self.slowest_name,
            Millis(self.total())
        )?;
        for (n, term) in self.terms.iter().enumerate() {
            let plus = if n == 0 { "" } else { " + " };
            write!(f, "{plus}{} {}", term.what, Millis(term.nanos))?;
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

fn total(terms: &[Term]) -> Nanos {
    terms.iter().fold(0, |sum, term| sum.saturating_add(term.nanos))
}

fn group_contract(spec: &Spec, id: GroupId, group: &GroupSpec) -> Option<GroupContract> {
    let mut worst: Option<GroupContract> = None;
    for &member in &group.members {
        let terms = terms(spec, group, member)?;
        if worst.as_ref().is_none_or(|w| total(&terms) > w.total()) {
            let slowest_name = spec.schemas[member.index()].name.clone();
            worst = Some(GroupContract {
                group: id,
                name: group.name.clone(),
                slowest: member,
                slowest_name,
                terms,
            });
        }
    }
    worst
}

fn terms(spec: &Spec, group: &GroupSpec, member: SchemaId) -> Option<Vec<Term>> {
    let schema = spec.schemas.get(member.index())?;
    let mut terms = Vec::new();
    if !schema.triggered {
        terms.push(Term {
            what: format!("period of {}", schema.name),
            nanos: schema.period,
        });
    }
    terms.push(Term {
        what: format!("longest iteration of {}", schema.name),
        nanos: schema.budget,
    });
    if schema.panel {
        terms.push(Term {
            what: "drawing of its panel".into(),
            nanos: schema.budget,
        });
    }
    if group.policy == Policy::Father {
        terms.push(Term {
            what: "arbitration of the father".into(),
            nanos: group.budget,
        });
    }
    terms.push(Term {
        what: "patience with the loser".into(),
        nanos: group.patience,
    });
    Some(terms)
}
