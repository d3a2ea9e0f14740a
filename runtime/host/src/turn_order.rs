//! The order in which schemas take turns that are due at the same instant: one after another in lockstep,
//! slightly staggered in real time. It schedules nothing.

use std::time::Duration;

use jde_abi::describe::Kind;
use jde_app::InstanceConfig;
use jde_core::{Nanos, SchemaId, Table};

use crate::clock::Clock;

/// The longest stagger between two schemas: longer than most turns take.
const MAX_STAGGER: Duration = Duration::from_millis(1);

/// Returns the instances in order: drivers, then perceptive schemas, then motor schemas; within a
/// kind, fathers before children. So a reader finds the values that were written at the same instant.
pub(crate) fn turn_order(instances: &Table<SchemaId, InstanceConfig>) -> Vec<SchemaId> {
    let depth = |mut id: SchemaId| {
        let mut depth = 0;
        while let Some(father) = instances[id].father {
            (id, depth) = (father, depth + 1);
        }
        depth
    };
    let mut order: Vec<SchemaId> = instances.ids().collect();
    order.sort_by_key(|id| {
        let rank = match instances[*id].schema.kind {
            Kind::Driver => 0,
            Kind::Perceptive => 1,
            Kind::Motor => 2,
        };
        (rank, depth(*id), *id)
    });
    order
}

/// Returns how long before the last instance each one is due, if all were woken at once. In virtual time
/// turns take no time, and all values are 0.
pub(crate) fn staggers(instances: &Table<SchemaId, InstanceConfig>, clock: &Clock) -> Table<SchemaId, Nanos> {
    if !clock.is_real() {
        return instances.map_ids(|_| 0);
    }
    let shortest = instances.iter().map(|instance| instance.period_ns).min();
    spread_staggers(
        &turn_order(instances),
        shortest.unwrap_or_default(),
        clock.scale_machine_time(MAX_STAGGER),
    )
}

/// Gives each instance one step for every instance after it. The step is short enough that all fit into the
/// shortest period.
fn spread_staggers(order: &[SchemaId], shortest: Nanos, most: Nanos) -> Table<SchemaId, Nanos> {
    let step = most.min(shortest / (order.len() as u64).max(1));
    let mut early = Table::from(vec![0; order.len()]);
    for (after, id) in order.iter().rev().enumerate() {
        early[*id] = after as u64 * step;
    }
    early
}

#[cfg(test)]
mod tests {
    use super::{SchemaId, spread_staggers};

    const MS: u64 = 1_000_000;

    #[test]
    fn r11_each_instance_is_due_one_step_after_the_one_before_it() {
        assert_eq!(
            *spread_staggers(&[2, 0, 3, 1].map(SchemaId), 50 * MS, MS),
            [2 * MS, 0, 3 * MS, MS]
        );
        assert!(spread_staggers(&[], 0, MS).is_empty());
    }

    #[test]
    fn r11_the_staggers_of_many_instances_divide_the_shortest_period_evenly() {
        let order: Vec<SchemaId> = (0..100).map(SchemaId).collect();
        let early = spread_staggers(&order, 10 * MS, MS);
        assert!(
            early.windows(2).all(|pair| pair[0] - pair[1] == MS / 10),
            "{early:?}"
        );
        assert!(early.iter().all(|early| *early < 10 * MS));
    }
}
