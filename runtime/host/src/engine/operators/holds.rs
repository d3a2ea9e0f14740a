//! Who holds what outside the hierarchy: the numbers of operators there, the values that they overwrote and the exports
//! that they let fail. The hierarchy keeps the other holds.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use jde_app::InstancePort;
use jde_board::Variable;
use jde_core::{Hierarchy, Holder, SchemaId};
use jde_records::snapshot::{Hold, HoldKind};

use crate::sensor_fault::SensorFault;

/// An operator who acts, until somebody ends it or under one lease.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Actor {
    pub(crate) name: String,
    pub(crate) leased: bool,
}

/// The actions of operators that were not ended yet.
#[derive(Default)]
pub(super) struct OperatorHolds {
    /// The names of operators by their numbers in the hierarchy: of all that hold something there.
    names: BTreeMap<u32, String>,
    last_number: u32,
    pub(super) values: Vec<Overwritten>,
    /// The failures of each export, newest last. The newest is in force.
    pub(super) failing: BTreeMap<InstancePort, Vec<(Actor, SensorFault)>>,
}

/// A modulation or period that operators overwrote.
pub(super) struct Overwritten {
    pub(super) owner: SchemaId,
    pub(super) variable: Arc<Variable>,
    /// The value before the first of them.
    pub(super) previous: PreviousValue,
    /// What each of them wrote last, newest last. The newest is in force, unless a father has written since.
    pub(super) writes: Vec<(Actor, Vec<u8>)>,
}

pub(super) struct PreviousValue {
    pub(super) writer: u32,
    pub(super) bytes: Vec<u8>,
}

impl Actor {
    /// An operator without a lease.
    pub(crate) fn lasting(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            leased: false,
        }
    }

    /// Whether an end of what this actor holds concerns another: the same lease, or anything of the same operator if
    /// it is not one lease that ends.
    pub(super) fn covers(&self, other: &Self) -> bool {
        self.name == other.name && (other.leased || !self.leased)
    }

    pub(super) fn hold(&self, kind: HoldKind) -> Hold {
        Hold {
            kind,
            with_everything: false,
            leased: self.leased,
            by: self.name.clone(),
        }
    }
}

impl OperatorHolds {
    /// Returns an actor as the hierarchy knows it. Forgets the names of operators who hold nothing there, because the
    /// names of leases differ.
    pub(super) fn holder(&mut self, hierarchy: &Hierarchy, by: &Actor) -> Holder {
        let known = self.names.iter().find(|(_, name)| **name == by.name);
        let operator = match known {
            Some((number, _)) => *number,
            None => {
                let schemas = hierarchy.spec().schemas.ids();
                let holds = schemas.flat_map(|id| hierarchy.holds(id));
                let holding: BTreeSet<_> = holds.map(|hold| hold.by.operator).collect();
                self.names.retain(|number, _| holding.contains(number));
                self.last_number += 1;
                self.names.insert(self.last_number, by.name.clone());
                self.last_number
            }
        };
        Holder {
            operator,
            leased: by.leased,
        }
    }

    /// Returns the name of an operator; empty if a replay does not know it.
    pub(super) fn name(&self, holder: Holder) -> &str {
        self.names.get(&holder.operator).map_or("", String::as_str)
    }
}
