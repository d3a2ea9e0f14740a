//! Random valid specifications.
//!
//! `specification.rs` tests the invalid ones.

use std::time::Duration;

use jde_core::{Absence, GroupSpec, Kind, Nanos, Policy, Restart, SchemaId, SchemaSpec, Spec};
use proptest::prelude::*;

pub(crate) const MS: Nanos = 1_000_000;

pub(crate) const POLICIES: [Policy; 7] = [
    Policy::PRIORITY,
    Policy::URGENCY,
    Policy::sticky(Duration::from_millis(3), 0.5),
    Policy::sticky(Duration::ZERO, 0.0),
    Policy::round_robin(Duration::from_millis(2)),
    Policy::FATHER,
    Policy::FATHER,
];

/// Generates up to ten motor schemas at most four deep, up to two groups for each father, and up to four
/// shared perceptive schemas.
pub(crate) fn specs() -> impl Strategy<Value = Spec> {
    let motors = prop::collection::vec(any::<[u8; 4]>(), 1..=10);
    let perceptive = prop::collection::vec(any::<u8>(), 0..=4);
    (motors, perceptive, any::<[u8; 24]>())
        .prop_map(|(motors, perceptive, groups)| spec(&motors, &perceptive, &groups))
}

fn spec(motors: &[[u8; 4]], perceptive: &[u8], shape: &[u8; 24]) -> Spec {
    let count = u32::try_from(motors.len()).expect("few");
    let selected = |mask: u8, count_of_bits: u32| -> Vec<SchemaId> {
        (0..count_of_bits)
            .filter(|bit| mask & (1 << bit) != 0)
            .map(|bit| SchemaId(count + bit))
            .collect()
    };
    let mut spec = Spec::default();
    let mut depths = Vec::new();
    for (index, &[father, slot, needs, restart]) in motors.iter().enumerate() {
        let father = usize::from(father) % (index + 1);
        // The last value is a root. A father at the maximum depth gets no more children.
        let father = Some(father).filter(|&f| f < index && depths[f] < 4);
        depths.push(father.map_or(1, |f| depths[f] + 1));
        let mut schema = SchemaSpec::new(format!("motor{index}"), Kind::Motor, 10 * MS);
        schema.needs = selected(needs, u32::try_from(perceptive.len()).expect("few"));
        // Of every other schema, the first need is a driver that it only commands.
        schema.only_commands = schema.needs.iter().copied().take(usize::from(slot % 2)).collect();
        if restart % 2 == 0 {
            schema.restart = Restart::OnFault {
                backoff: MS,
                limit: u32::from(restart % 4),
                within: 20 * MS,
            };
        }
        spec.schemas.push(schema);
        let id = SchemaId(u32::try_from(index).expect("few"));
        let father = father.map(|f| SchemaId(u32::try_from(f).expect("few")));
        let name = format!("{father:?}.{}", slot % 2);
        match spec.groups.iter_mut().find(|g| g.name == name) {
            Some(group) => group.members.push(id),
            None => spec.groups.push(GroupSpec::new(name, father, vec![id])),
        }
    }
    for (index, &needs) in (0u32..).zip(perceptive) {
        let mut schema = SchemaSpec::new(format!("perceptive{index}"), Kind::Perceptive, 10 * MS);
        schema.needs = selected(needs, index);
        schema.restart = Restart::OnFault {
            backoff: MS,
            limit: 2,
            within: 20 * MS,
        };
        spec.schemas.push(schema);
    }
    for (group, shape) in spec.groups.iter_mut().zip(shape.iter().cycle()) {
        let policy = POLICIES[usize::from(*shape) % POLICIES.len()];
        group.policy = if group.father.is_none() && policy == Policy::FATHER {
            Policy::PRIORITY
        } else {
            policy
        };
        group.absence = match shape / 8 % 4 {
            0 => Absence::Hold { for_: 4 * MS },
            1 => Absence::Fallback(group.members[usize::from(*shape) % group.members.len()]),
            _ => Absence::Brake,
        };
        group.retry = if shape / 64 % 2 == 0 { 0 } else { 3 * MS };
        group.patience = if shape / 32 % 4 == 0 { 0 } else { 2 * MS };
    }
    spec
}
