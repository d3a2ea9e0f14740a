//! The order in which schemas take turns that are due at the same instant: one after another in lockstep,
//! slightly staggered in real time. It schedules nothing.

use std::time::Duration;

use jde_abi::describe::Kind;
use jde_app::InstanceConfig;
use jde_core::Nanos;

use crate::clock::Clock;

/// The longest stagger between two schemas: longer than most turns take.
const MAX_STAGGER: Duration = Duration::from_millis(1);

/// Returns the instance numbers in order: drivers, then perceptive schemas, then motor schemas; within a
/// kind, fathers before children. So a reader finds the values that were written at the same instant.
pub(crate) fn turn_order(instances: &[InstanceConfig]) -> Vec<usize> {
    let depth = |mut number: usize| {
        let mut depth = 0;
        while let Some(father) = instances[number].father {
            (number, depth) = (father, depth + 1);
        }
        depth
    };
    let mut order: Vec<usize> = (0..instances.len()).collect();
    order.sort_by_key(|number| {
        let rank = match instances[*number].schema.kind {
            Kind::Driver => 0,
            Kind::Perceptive => 1,
            Kind::Motor => 2,
        };
        (rank, depth(*number), *number)
    });
    order
}

/// Returns how long before the last instance each one is due, if all were woken at once. In virtual time
/// turns take no time, and all values are 0.
pub(crate) fn staggers(instances: &[InstanceConfig], clock: &Clock) -> Vec<Nanos> {
    if !clock.is_real() {
        return vec![0; instances.len()];
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
fn spread_staggers(order: &[usize], shortest: Nanos, most: Nanos) -> Vec<Nanos> {
    let step = most.min(shortest / (order.len() as u64).max(1));
    let mut early = vec![0; order.len()];
    for (after, number) in order.iter().rev().enumerate() {
        early[*number] = after as u64 * step;
    }
    early
}

#[cfg(test)]
mod tests {
    use super::spread_staggers;

    const MS: u64 = 1_000_000;

    #[test]
    fn r11_each_instance_is_due_one_step_after_the_one_before_it() {
        assert_eq!(
            spread_staggers(&[2, 0, 3, 1], 50 * MS, MS),
            [2 * MS, 0, 3 * MS, MS]
        );
        assert!(spread_staggers(&[], 0, MS).is_empty());
    }

    #[test]
    fn r11_the_staggers_of_many_instances_divide_the_shortest_period_evenly() {
        let order: Vec<usize> = (0..100).collect();
        let early = spread_staggers(&order, 10 * MS, MS);
        assert!(
            early.windows(2).all(|pair| pair[0] - pair[1] == MS / 10),
            "{early:?}"
        );
        assert!(early.iter().all(|early| *early < 10 * MS));
    }
}
