//! Finds cycles in a graph. Without recursion, because a file can be arbitrarily long.

use std::ops::Range;

use jde_core::{SchemaId, Table};

/// An edge: its target, and its position in the file.
pub(super) type Edge = (SchemaId, Range<usize>);

/// The most cycles that are returned. Each may be as long as the file, and breaking some may break all.
const MAX_CYCLES: usize = 20;

/// The most names of a cycle that are shown.
const MAX_SHOWN: usize = 12;

/// Formats the names of a cycle: `a -> b -> a`.
pub(super) fn in_words(cycle: &[SchemaId], name: impl Fn(SchemaId) -> String) -> String {
    let mut names: Vec<_> = cycle.iter().take(MAX_SHOWN).map(|node| name(*node)).collect();
    if cycle.len() > MAX_SHOWN {
        names[MAX_SHOWN - 1] = format!("{} more", cycle.len() - MAX_SHOWN);
        names.extend(cycle.last().map(|node| name(*node)));
    }
    names.join(" -> ")
}

/// Returns the cycles closed by edges, at most [`MAX_CYCLES`]: the nodes of the cycle, with the first again at the
/// end, and the position of the closing edge.
pub(super) fn find_cycles(edges: &Table<SchemaId, Vec<Edge>>) -> Vec<(Vec<SchemaId>, Range<usize>)> {
    let mut found = Vec::new();
    let mut done = edges.map_ids(|_| false);
    let mut on_path = edges.map_ids(|_| false);
    for start in edges.ids() {
        if done[start] || found.len() == MAX_CYCLES {
            continue;
        }
        // The path: nodes, each with the number of its next edge.
        let mut path = vec![(start, 0)];
        on_path[start] = true;
        while let Some((node, next)) = path.last_mut() {
            let node = *node;
            let Some((to, span)) = edges[node].get(*next) else {
                done[node] = true;
                on_path[node] = false;
                path.pop();
                continue;
            };
            *next += 1;
            if on_path[*to] {
                if found.len() < MAX_CYCLES {
                    let from = path.iter().position(|(node, _)| node == to).unwrap_or_default();
                    let cycle = path[from..].iter().map(|(node, _)| *node).chain([*to]);
                    found.push((cycle.collect(), span.clone()));
                }
            } else if !done[*to] {
                on_path[*to] = true;
                path.push((*to, 0));
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::{SchemaId, find_cycles};

    fn cycles(edges: &[&[u32]]) -> Vec<Vec<u32>> {
        let edges = edges
            .iter()
            .map(|to| to.iter().map(|to| (SchemaId(*to), 0..0)).collect())
            .collect();
        let cycles = find_cycles(&edges).into_iter();
        cycles
            .map(|(cycle, _)| cycle.into_iter().map(|id| id.0).collect())
            .collect()
    }

    #[test]
    fn each_cycle_is_found_once() {
        assert_eq!(cycles(&[&[1], &[2], &[1], &[3]]), [vec![1, 2, 1], vec![3, 3]]);
    }

    #[test]
    fn two_paths_to_one_node_are_not_a_cycle() {
        assert_eq!(cycles(&[&[1, 2], &[3], &[3], &[]]), Vec::<Vec<u32>>::new());
    }

    #[test]
    fn a_very_long_cycle_does_not_overflow_the_stack() {
        let edges = (0..100_000)
            .map(|node| vec![(SchemaId((node + 1) % 100_000), 0..0)])
            .collect();
        assert_eq!(find_cycles(&edges).len(), 1);
    }
}
