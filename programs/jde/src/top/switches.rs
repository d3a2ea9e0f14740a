//! The changes of winner that were seen, newest first.
//!
//! A snapshot contains the last change of each group. This keeps the earlier ones too, but no more than a
//! screen can show.

use std::collections::VecDeque;

use jde_records::snapshot::{Snapshot, Switch};

/// More than the tallest terminals show.
const MAX_SWITCHES: usize = 100;

/// The latest changes of winner of all groups.
#[derive(Debug, Default)]
pub(super) struct Switches {
    entries: VecDeque<(usize, Switch)>,
}

impl Switches {
    /// Adds the last change of every group, and updates its latency once that is known.
    pub(super) fn observe(&mut self, snapshot: &Snapshot) {
        self.entries.retain(|(_, switch)| switch.time <= snapshot.time);
        for (group, view) in snapshot.groups.iter().enumerate() {
            let Some(last) = &view.last else { continue };
            if let Some((_, known)) = self
                .entries
                .iter_mut()
                .find(|(of, known)| *of == group && known.time == last.time)
            {
                known.clone_from(last);
                continue;
            }
            let index = self
                .entries
                .iter()
                .position(|(_, known)| known.time <= last.time)
                .unwrap_or(self.entries.len());
            self.entries.insert(index, (group, last.clone()));
        }
        self.entries.truncate(MAX_SWITCHES);
    }

    /// Returns the changes with the places of their groups, newest first.
    pub(super) fn iter(&self) -> impl Iterator<Item = &(usize, Switch)> {
        self.entries.iter()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::top::tests::{group, schema, snapshot, switch};

    fn summary(switches: &Switches) -> Vec<(usize, u64, Option<u64>)> {
        switches
            .iter()
            .map(|(group, switch)| (*group, switch.time, switch.latency))
            .collect()
    }

    #[test]
    fn the_newest_takeover_is_first_and_its_latency_is_added_later() {
        let mut switches = Switches::default();
        let mut groups = vec![group("roots"), group("example/base")];
        groups[0].last = Some(switch(30));
        groups[1].last = Some(switch(20));
        switches.observe(&snapshot(40, vec![schema("a")], groups.clone()));
        assert_eq!(summary(&switches), [(0, 30, None), (1, 20, None)]);

        groups[0].last = Some(Switch {
            latency: Some(7),
            ..switch(30)
        });
        groups[1].last = Some(switch(45));
        switches.observe(&snapshot(50, vec![schema("a")], groups));
        assert_eq!(
            summary(&switches),
            [(1, 45, None), (0, 30, Some(7)), (1, 20, None)]
        );
    }
}
