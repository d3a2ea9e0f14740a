//! Statistics of a group's selections: changes of winner, takeover times, and which schemas alternate. A
//! bounded number of selections is stored completely.

use std::collections::{BTreeMap, VecDeque};

use jde_core::Nanos;
use jde_records::Decision;
use jde_timeline::case_word;

use super::bounded::count;
use super::chatter::ChatterStatistics;
use super::columns::Columns;
use super::durations::Durations;

/// The time window for the highest rate of switches, ns.
const BUSY_WINDOW: Nanos = 1_000_000_000;
/// Most pairs of schemas that are counted separately.
const MOST_PAIRS: usize = 10_000;

/// Statistics of a group.
#[derive(Clone, Debug, Default)]
pub(crate) struct GroupStatistics {
    /// The number of selections.
    pub(crate) decisions: u64,
    /// Selections that changed the winner.
    pub(crate) switches: u64,
    /// Switches by column.
    pub(crate) marks: Vec<u32>,
    /// Times from the cause to the winner's first iteration.
    pub(crate) takeovers: Durations,
    /// The longest takeover: its time, and the new winner.
    pub(crate) worst: Option<(Nanos, String)>,
    /// Most switches within a second, and the time when that second ended.
    pub(crate) busiest: Option<(usize, Nanos)>,
    /// Selections by case.
    pub(crate) cases: BTreeMap<&'static str, u64>,
    /// Statistics of chattering.
    pub(crate) chatter: ChatterStatistics,
    pairs: BTreeMap<(String, String), u64>,
    recent: VecDeque<Nanos>,
}

/// Two schemas that take over from each other.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Alternation {
    pub(crate) first_schema: String,
    pub(crate) second_schema: String,
    /// The number of takeovers in either direction.
    pub(crate) switches: u64,
}

impl GroupStatistics {
    pub(crate) fn new(columns: Columns) -> Self {
        Self {
            marks: vec![0; columns.count],
            ..Self::default()
        }
    }

    /// Records a selection of this group.
    pub(crate) fn add_decision(&mut self, columns: Columns, time: Nanos, decision: &Decision) {
        self.decisions += 1;
        *self.cases.entry(case_word(decision.case)).or_default() += 1;
        if !decision.changed {
            return;
        }
        self.switches += 1;
        self.chatter.add_switch(time, decision);
        self.marks[columns.column(time)] += 1;
        if let (Some(us), Some(choice)) = (decision.takeover_us, &decision.choice)
            && us >= 0.0
        {
            let took = (us * 1e3) as Nanos;
            if self.takeovers.worst().is_none_or(|worst| took as f64 > worst) {
                self.worst = Some((time, choice.clone()));
            }
            self.takeovers.add(took);
        }
        if let (Some(before), Some(choice)) = (&decision.before, &decision.choice) {
            let pair = if before < choice {
                (before.clone(), choice.clone())
            } else {
                (choice.clone(), before.clone())
            };
            count(&mut self.pairs, &pair, MOST_PAIRS);
        }
        self.recent.push_back(time);
        while self
            .recent
            .front()
            .is_some_and(|first| first.saturating_add(BUSY_WINDOW) < time)
        {
            self.recent.pop_front();
        }
        if self.busiest.is_none_or(|(count, _)| self.recent.len() > count) {
            self.busiest = Some((self.recent.len(), time));
        }
    }

    /// The pairs of schemas that alternate, the most frequent first.
    pub(crate) fn pairs(&self) -> Vec<Alternation> {
        let pairs = self
            .pairs
            .iter()
            .map(|((first_schema, second_schema), switches)| Alternation {
                first_schema: first_schema.clone(),
                second_schema: second_schema.clone(),
                switches: *switches,
            });
        let mut pairs: Vec<_> = pairs.collect();
        pairs.sort_by_key(|pair| std::cmp::Reverse(pair.switches));
        pairs
    }
}

#[cfg(test)]
mod tests {
    use jde_core::Case;
    use jde_records::DecidedBy;

    use super::*;

    fn switch(number: u64, before: Option<&str>, choice: Option<&str>, takeover_us: Option<f64>) -> Decision {
        Decision {
            number,
            time_s: number as f64,
            group: "roots".to_owned(),
            case: Case::Alone,
            candidates: Vec::new(),
            before: before.map(str::to_owned),
            choice: choice.map(str::to_owned),
            decider: DecidedBy::Nobody,
            reason: String::new(),
            cause: String::new(),
            changed: before != choice,
            takeover_us,
            refused: Vec::new(),
        }
    }

    #[test]
    fn statistics_count_switches_pairs_and_the_busiest_second() {
        let columns = Columns::new(0, 10_000_000_000, 10);
        let mut statistics = GroupStatistics::new(columns);
        let steps = [
            (0, None, Some("goon"), Some(100.0)),
            (1_000, Some("goon"), Some("vff"), Some(5000.0)),
            (1_400, Some("vff"), Some("goon"), Some(300.0)),
            (1_800, Some("goon"), Some("goon"), None),
            (2_900, Some("goon"), Some("vff"), None),
            (9_000, Some("vff"), None, None),
        ];
        for (ms, before, choice, took) in steps {
            statistics.add_decision(columns, ms * 1_000_000, &switch(ms, before, choice, took));
        }
        assert_eq!((statistics.decisions, statistics.switches), (6, 5));
        assert_eq!(statistics.marks, [1, 2, 1, 0, 0, 0, 0, 0, 0, 1]);
        assert_eq!(statistics.busiest, Some((2, 1_000_000_000)));
        assert_eq!(statistics.worst, Some((1_000_000_000, "vff".to_owned())));
        assert_eq!(statistics.takeovers.count(), 3);
        let pair = Alternation {
            first_schema: "goon".to_owned(),
            second_schema: "vff".to_owned(),
            switches: 3,
        };
        assert_eq!(statistics.pairs(), [pair]);
    }
}
