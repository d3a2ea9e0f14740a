//! Checks a specification before anything runs, and reports all faults at once.
//!
//! It refuses to repair: it reports each fault and changes nothing.

use std::collections::BTreeMap;

use crate::policy::Policy;
use crate::spec::{Absence, GroupSpec, Kind, SchemaId, Spec};
use crate::spec_error::SpecError;

impl Spec {
    /// Checks the whole specification.
    ///
    /// # Errors
    /// Every fault found. The kinds of fault are checked one after the other, each in the order of schemas
    /// and groups.
    pub fn validate(&self) -> Result<(), Vec<SpecError>> {
        let mut faults = Vec::new();
        self.check_names(&mut faults);
        self.check_schemas(&mut faults);
        for group in &self.groups {
            self.check_group(group, &mut faults);
        }
        self.check_membership(&mut faults);
        self.check_father_cycles(&mut faults);
        self.check_need_cycles(&mut faults);
        if faults.is_empty() { Ok(()) } else { Err(faults) }
    }

    fn name(&self, id: SchemaId) -> String {
        self.schemas
            .get(id)
            .map_or_else(|| format!("#{}", id.0), |s| s.name.clone())
    }

    fn is_kind(&self, id: SchemaId, kind: Kind) -> bool {
        self.schemas.get(id).is_some_and(|s| s.kind == kind)
    }

    fn check_names(&self, faults: &mut Vec<SpecError>) {
        let mut report_duplicates = |what, values: Vec<&str>| {
            let mut seen = BTreeMap::new();
            for name in values {
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
        report_duplicates("schema", self.schemas.iter().map(|s| s.name.as_str()).collect());
        report_duplicates("group", self.groups.iter().map(|g| g.name.as_str()).collect());
    }

    fn check_schemas(&self, faults: &mut Vec<SpecError>) {
        for schema in &self.schemas {
            if schema.period == 0 {
                faults.push(SpecError::ZeroPeriod {
                    schema: schema.name.clone(),
                });
            }
            for &need in &schema.needs {
                if self.schemas.get(need).is_none() {
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

    fn check_group(&self, group: &GroupSpec, faults: &mut Vec<SpecError>) {
        let name = || group.name.clone();
        if group.members.is_empty() {
            faults.push(SpecError::EmptyGroup { group: name() });
        }
        for &id in group.father.iter().chain(&group.members) {
            if self.schemas.get(id).is_none() {
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

    fn check_membership(&self, faults: &mut Vec<SpecError>) {
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
        for (id, schema) in self.schemas.entries() {
            if schema.kind == Kind::Motor && !first.contains_key(&id) {
                faults.push(SpecError::NoGroup {
                    schema: schema.name.clone(),
                });
            }
        }
    }

    fn check_father_cycles(&self, faults: &mut Vec<SpecError>) {
        let mut children: BTreeMap<SchemaId, Vec<SchemaId>> = BTreeMap::new();
        for group in &self.groups {
            if let Some(father) = group.father {
                children.entry(father).or_default().extend(&group.members);
            }
        }
        let children = |id: SchemaId| children.get(&id).cloned().unwrap_or_default();
        if let Some(path) = self.find_cycle(children) {
            faults.push(SpecError::FatherCycle { path });
        }
    }

    fn check_need_cycles(&self, faults: &mut Vec<SpecError>) {
        let perceptive = |id: &SchemaId| self.is_kind(*id, Kind::Perceptive);
        let needs = |id: SchemaId| {
            self.schemas[id]
                .needs
                .iter()
                .copied()
                .filter(perceptive)
                .collect()
        };
        if let Some(path) = self.find_cycle(needs) {
            faults.push(SpecError::NeedCycle { path });
        }
    }

    /// Returns the first cycle along `next`, found by a depth-first search without recursion.
    fn find_cycle(&self, next: impl Fn(SchemaId) -> Vec<SchemaId>) -> Option<Vec<String>> {
        let mut done = self.schemas.map_ids(|_| false);
        let mut on_path = done.clone();
        for start in self.schemas.ids() {
            if done[start] {
                continue;
            }
            let mut path = vec![(start, next(start))];
            on_path[start] = true;
            while let Some((current, rest)) = path.last_mut() {
                let current = *current;
                let Some(successor) = rest.pop() else {
                    done[current] = true;
                    on_path[current] = false;
                    path.pop();
                    continue;
                };
                if done.get(successor).is_none_or(|done| *done) {
                    continue;
                }
                if on_path[successor] {
                    let start = path.iter().position(|&(id, _)| id == successor)?;
                    let mut labels: Vec<String> =
                        path[start..].iter().map(|&(id, _)| self.name(id)).collect();
                    labels.push(self.name(successor));
                    return Some(labels);
                }
                on_path[successor] = true;
                path.push((successor, next(successor)));
            }
        }
        None
    }
}

/// Returns the fault of `policy` for this group, if there is one.
pub(crate) fn policy_fault(group: &GroupSpec, policy: Policy) -> Option<SpecError> {
    let name = || group.name.clone();
    let refused = policy.refused_parameter();
    let refused = refused.map(|(key, expected)| SpecError::BadParameter {
        group: name(),
        key,
        expected,
    });
    refused.or_else(|| {
        let has_no_father = policy == Policy::FATHER && group.father.is_none();
        has_no_father.then(|| SpecError::NoArbitrator { group: name() })
    })
}
