//! In which order schemas take turns that are due at once: in lockstep one after another, in real time a little apart.

use std::time::Duration;

use jde_abi::describe::Kind;
use jde_core::Nanos;

use crate::app::Instance;
use crate::clock::Clock;

/// Most time from one to the next: longer than most turns take.
const STEP: Duration = Duration::from_millis(1);

/// The numbers of the instances in order: drivers and perceptive schemas, then motor schemas, fathers before children. So whoever
/// reads finds what was written at the same instant.
pub(crate) fn order(instances: &[Instance]) -> Vec<usize> {
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

/// How long before the last of all each instance is due, if all were woken at once: a step for each that comes after it, so short
/// that all of them fit into the shortest period. In virtual time nobody is: there it takes none to take turns.
pub(crate) fn early(instances: &[Instance], clock: &Clock) -> Vec<Nanos> {
    let shortest = instances.iter().map(|instance| instance.period_ns).min();
    let fits = shortest.unwrap_or_default() / (instances.len() as u64).max(1);
    let mut early = vec![0; instances.len()];
    if clock.is_real() {
        spread(&order(instances), fits.min(clock.of_machine(STEP)), &mut early);
    }
    early
}

fn spread(order: &[usize], step: Nanos, early: &mut [Nanos]) {
    for (after, number) in order.iter().rev().enumerate() {
        early[*number] = after as u64 * step;
    }
}

#[cfg(test)]
mod tests {
    use super::spread;

    #[test]
    fn who_comes_later_is_due_a_step_later() {
        let mut early = [0; 4];
        spread(&[2, 0, 3, 1], 10, &mut early);
        assert_eq!(early, [20, 0, 30, 10]);
    }
}
