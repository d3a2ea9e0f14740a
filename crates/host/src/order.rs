//! In which order schemas take turns that are due at once: in lockstep one after another, in real time a little apart.

use jde_abi::describe::Kind;

use crate::app::Instance;

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
