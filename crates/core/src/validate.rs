//! Checks a specification before anything runs, and reports all faults at once.
//!
//! It refuses to repair: a fault is named, never guessed away.

use std::collections::BTreeMap;
use std::fmt;

use crate::spec::{Absence, GroupSpec, Kind, Policy, SchemaId, Spec};

/// One fault of a specification.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub enum SpecError {
    /// Two schemas, or two groups, have the same name.
    DuplicateName {
        /// `"schema"` or `"group"`.
        what: &'static str,
        /// The name.
        name: String,
    },
    /// A group or a schema names a schema that does not exist.
    UnknownSchema {
        /// Who names it.
        by: String,
        /// The index it names.
        index: u32,
    },
    /// A group has no members.
    EmptyGroup {
        /// The group.
        group: String,
    },
    /// A schema is listed as a member twice.
    TwoFathers {
        /// The schema.
        schema: String,
        /// The group that lists it first.
        first: String,
        /// The group that lists it again.
        second: String,
    },
    /// A motor schema is in no group, so that it could never compete.
    NoGroup {
        /// The schema.
        schema: String,
    },
    /// A perceptive schema is the member of a group.
    PerceptiveMember {
        /// The schema.
        schema: String,
        /// The group.
        group: String,
    },
    /// A perceptive schema is the father of a group.
    PerceptiveFather {
        /// The schema.
        schema: String,
        /// The group.
        group: String,
    },
    /// A schema needs a motor schema, which nobody can keep awake.
    MotorNeeded {
        /// Who needs.
        schema: String,
        /// The motor schema.
        needs: String,
    },
    /// A schema is its own father, by way of others.
    FatherCycle {
        /// The names on the way round.
        path: Vec<String>,
    },
    /// Perceptive schemas need each other in a circle, so that none could ever go to sleep.
    NeedCycle {
        /// The names on the way round.
        path: Vec<String>,
    },
    /// The fallback of a group is not one of its members.
    FallbackNotMember {
        /// The group.
        group: String,
        /// The fallback.
        fallback: String,
    },
    /// A period of 0.
    ZeroPeriod {
        /// The schema.
        schema: String,
    },
    /// A round robin with turns of 0.
    ZeroTurn {
        /// The group.
        group: String,
    },
    /// A hysteresis that is negative or not finite.
    BadHysteresis {
        /// The group.
        group: String,
    },
    /// A group of roots is to be decided by a father it does not have.
    NobodyToAsk {
        /// The group.
        group: String,
    },
}

impl Spec {
    /// Checks the whole specification.
    ///
    /// # Errors
    /// Every fault found, in the order of schemas and groups.
    pub fn validate(&self) -> Result<(), Vec<SpecError>> {
        let mut faults = Vec::new();
        self.names(&mut faults);
        self.schemas_alone(&mut faults);
        for group in &self.groups {
            self.group_alone(group, &mut faults);
        }
        self.membership(&mut faults);
        self.father_cycles(&mut faults);
        self.need_cycles(&mut faults);
        if faults.is_empty() { Ok(()) } else { Err(faults) }
    }

    fn name(&self, id: SchemaId) -> String {
        self.schemas
            .get(id.index())
            .map_or_else(|| format!("#{}", id.0), |s| s.name.clone())
    }

    fn is_kind(&self, id: SchemaId, kind: Kind) -> bool {
        self.schemas.get(id.index()).is_some_and(|s| s.kind == kind)
    }

    fn names(&self, faults: &mut Vec<SpecError>) {
        let mut repeated = |what, names: Vec<&str>| {
            let mut seen = BTreeMap::new();
            for name in names {
                let count = seen.entry(name).or_insert(0);
                *count += 1;
                if *count == 2 {
                    faults.push(SpecError::DuplicateName {
                        what,
                        name: name.to_owned(),
                    });
                }
            }
        };
        repeated("schema", self.schemas.iter().map(|s| s.name.as_str()).collect());
        repeated("group", self.groups.iter().map(|g| g.name.as_str()).collect());
    }

    fn schemas_alone(&self, faults: &mut Vec<SpecError>) {
        for schema in &self.schemas {
            if schema.period == 0 {
                faults.push(SpecError::ZeroPeriod {
                    schema: schema.name.clone(),
                });
            }
            for &need in &schema.needs {
                if need.index() >= self.schemas.len() {
                    faults.push(SpecError::UnknownSchema {
                        by: schema.name.clone(),
                        index: need.0,
                    });
                } else if self.is_kind(need, Kind::Motor) {
                    faults.push(SpecError::MotorNeeded {
                        schema: schema.name.clone(),
                        needs: self.name(need),
                    });
                }
            }
        }
    }

    fn group_alone(&self, group: &GroupSpec, faults: &mut Vec<SpecError>) {
        let name = || group.name.clone();
        if group.members.is_empty() {
            faults.push(SpecError::EmptyGroup { group: name() });
        }
        for &id in group.father.iter().chain(&group.members) {
            if id.index() >= self.schemas.len() {
                faults.push(SpecError::UnknownSchema {
                    by: name(),
                    index: id.0,
                });
            }
        }
        if let Some(father) = group.father
            && self.is_kind(father, Kind::Perceptive)
        {
            faults.push(SpecError::PerceptiveFather {
                schema: self.name(father),
                group: name(),
            });
        }
        for &member in &group.members {
            if self.is_kind(member, Kind::Perceptive) {
                faults.push(SpecError::PerceptiveMember {
                    schema: self.name(member),
                    group: name(),
                });
            }
        }
        if let Absence::Fallback(fallback) = group.absence
            && !group.members.contains(&fallback)
        {
            faults.push(SpecError::FallbackNotMember {
                group: name(),
                fallback: self.name(fallback),
            });
        }
        faults.extend(policy_fault(group, group.policy));
    }

    fn membership(&self, faults: &mut Vec<SpecError>) {
        let mut first: BTreeMap<SchemaId, &str> = BTreeMap::new();
        for group in &self.groups {
            for &member in &group.members {
                match first.get(&member) {
                    None => {
                        first.insert(member, &group.name);
                    }
                    Some(earlier) => faults.push(SpecError::TwoFathers {
                        schema: self.name(member),
                        first: (*earlier).to_owned(),
                        second: group.name.clone(),
                    }),
                }
            }
        }
        for (index, schema) in (0u32..).zip(&self.schemas) {
            if schema.kind == Kind::Motor && !first.contains_key(&SchemaId(index)) {
                faults.push(SpecError::NoGroup {
                    schema: schema.name.clone(),
                });
            }
        }
    }

    fn father_cycles(&self, faults: &mut Vec<SpecError>) {
        let children = |id: SchemaId| {
            self.groups
                .iter()
                .filter(move |g| g.father == Some(id))
                .flat_map(|g| g.members.iter().copied())
                .collect()
        };
        if let Some(path) = self.cycle(children) {
            faults.push(SpecError::FatherCycle { path });
        }
    }

    fn need_cycles(&self, faults: &mut Vec<SpecError>) {
        let needs = |id: SchemaId| self.schemas[id.index()].needs.clone();
        if let Some(path) = self.cycle(needs) {
            faults.push(SpecError::NeedCycle { path });
        }
    }

    /// The first way round along `next`, by depth-first search without recursion.
    fn cycle(&self, next: impl Fn(SchemaId) -> Vec<SchemaId>) -> Option<Vec<String>> {
        let mut done = vec![false; self.schemas.len()];
        for start in 0..self.schemas.len() {
            let start = SchemaId(u32::try_from(start).ok()?);
            if done[start.index()] {
                continue;
            }
            let mut path = vec![(start, next(start))];
            while let Some((here, rest)) = path.last_mut() {
                let here = *here;
                let Some(to) = rest.pop() else {
                    done[here.index()] = true;
                    path.pop();
                    continue;
                };
                if to.index() >= done.len() || done[to.index()] {
                    continue;
                }
                if let Some(at) = path.iter().position(|&(id, _)| id == to) {
                    let mut names: Vec<String> = path[at..].iter().map(|&(id, _)| self.name(id)).collect();
                    names.push(self.name(to));
                    return Some(names);
                }
                path.push((to, next(to)));
            }
        }
        None
    }
}

/// What is wrong with `policy` for this group, if anything.
pub(crate) fn policy_fault(group: &GroupSpec, policy: Policy) -> Option<SpecError> {
    let name = || group.name.clone();
    match policy {
        Policy::Priority | Policy::HighestUrgency => None,
        Policy::Sticky { hysteresis, .. } if hysteresis >= 0.0 && hysteresis.is_finite() => None,
        Policy::Sticky { .. } => Some(SpecError::BadHysteresis { group: name() }),
        Policy::RoundRobin { turn: 0 } => Some(SpecError::ZeroTurn { group: name() }),
        Policy::RoundRobin { .. } => None,
        Policy::Father if group.father.is_none() => Some(SpecError::NobodyToAsk { group: name() }),
        Policy::Father => None,
    }
}

impl fmt::Display for SpecError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::DuplicateName { what, name } => {
                write!(f, "two {what}s are called `{name}`: give each its own name")
            }
            Self::UnknownSchema { by, index } => {
                write!(
                    f,
                    "`{by}` names schema number {index}, which does not exist: name a listed one"
                )
            }
            Self::EmptyGroup { group } => {
                write!(
                    f,
                    "the group `{group}` has no members: list a motor schema or remove the group"
                )
            }
            Self::TwoFathers {
                schema,
                first,
                second,
            } => write!(
                f,
                "`{schema}` is a member of `{first}` and again of `{second}`: a schema has one place; use a second instance"
            ),
            Self::NoGroup { schema } => {
                write!(
                    f,
                    "the motor schema `{schema}` is in no group: make it a root or someone's child"
                )
            }
            Self::PerceptiveMember { schema, group } => {
                write!(
                    f,
                    "`{schema}` is perceptive but a member of `{group}`: list it among the needs instead"
                )
            }
            Self::PerceptiveFather { schema, group } => {
                write!(
                    f,
                    "`{schema}` is perceptive but the father of `{group}`: only a motor schema has children"
                )
            }
            Self::MotorNeeded { schema, needs } => write!(
                f,
                "`{schema}` needs the motor schema `{needs}`: needs are perceptive schemas and drivers"
            ),
            Self::FatherCycle { path } => {
                write!(
                    f,
                    "a schema is its own father: {}; break the circle",
                    path.join(" > ")
                )
            }
            Self::NeedCycle { path } => {
                write!(
                    f,
                    "perceptive schemas need each other: {}; break the circle",
                    path.join(" > ")
                )
            }
            Self::FallbackNotMember { group, fallback } => {
                write!(
                    f,
                    "the fallback `{fallback}` is not a member of `{group}`: name a member"
                )
            }
            Self::ZeroPeriod { schema } => {
                write!(f, "`{schema}` has a period of 0: give a time above 0")
            }
            Self::ZeroTurn { group } => {
                write!(
                    f,
                    "the round robin of `{group}` has turns of 0: give a time above 0"
                )
            }
            Self::BadHysteresis { group } => {
                write!(
                    f,
                    "the hysteresis of `{group}` must be a finite number, 0 or more"
                )
            }
            Self::NobodyToAsk { group } => {
                write!(
                    f,
                    "the roots `{group}` have no father to decide: choose a ready-made policy"
                )
            }
        }
    }
}

impl std::error::Error for SpecError {}
