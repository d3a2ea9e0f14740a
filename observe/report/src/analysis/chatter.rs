//! Statistics of a group's chattering: how often, between which schemas, and which settings would have
//! prevented it.

use std::collections::BTreeMap;

use jde_core::{Case, Nanos};
use jde_records::Decision;
use jde_records::chattering::ChatterDetector;

use super::bounded::count;
use super::durations::Durations;

/// Most pairs that are counted separately.
const MOST_PAIRS: usize = 1000;
/// Urgencies are stored as whole billionths.
const URGENCY_SCALE: f64 = 1e9;
/// Advised dwell as a multiple of the time that nine in ten winners stayed; none of those could have switched
/// there and back in it.
const DWELL_FACTOR: f64 = 2.0;

/// Two schemas that alternate, in the order of their names; `None` for no winner.
type Pair = (Option<String>, Option<String>);

/// Statistics of a group while it chattered.
#[derive(Clone, Debug, Default)]
pub(crate) struct ChatterStatistics {
    chatter: ChatterDetector<Pair>,
    last: Option<Nanos>,
    /// How often chattering began.
    pub(crate) spells: u64,
    /// Switches while chattering.
    pub(crate) switches: u64,
    /// Switches at which two or more candidates were ready.
    pub(crate) collisions: u64,
    /// How long winners stayed.
    stays: Durations,
    /// By how much the new winner's urgency exceeded the old one's, billionths.
    margins: Durations,
    pairs: BTreeMap<Pair, u64>,
}

/// An advised setting of a sticky policy, and its basis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Advice {
    /// The advised value: s, or an urgency.
    pub(crate) value: f64,
    /// The bound that nine in ten did not exceed.
    pub(crate) bound: f64,
    /// The number of observations.
    pub(crate) count: u64,
}

impl ChatterStatistics {
    /// Records a switch of the group.
    pub(crate) fn add_switch(&mut self, time: Nanos, decision: &Decision) {
        if decision.decider.switches_by_intention() {
            return;
        }
        let mut pair = (decision.before.clone(), decision.choice.clone());
        if pair.1 < pair.0 {
            pair = (pair.1, pair.0);
        }
        let stay = self.last.replace(time).map(|last| time.saturating_sub(last));
        self.spells += u64::from(self.chatter.record_switch(time, pair.clone()).is_some());
        if !self.chatter.is_chattering() {
            return;
        }
        self.switches += 1;
        self.collisions += u64::from(decision.case == Case::Collision);
        if let Some(stay) = stay {
            self.stays.add(stay);
        }
        if let Some(margin) = margin(decision) {
            self.margins.add((margin * URGENCY_SCALE) as Nanos);
        }
        count(&mut self.pairs, &pair, MOST_PAIRS);
    }

    /// The pair with the most switches.
    pub(crate) fn between(&self) -> Option<(Option<&str>, Option<&str>)> {
        let (pair, _) = self.pairs.iter().max_by_key(|(_, count)| **count)?;
        Some((pair.0.as_deref(), pair.1.as_deref()))
    }

    /// Whether a policy would have helped: policies settle only collisions (R4).
    pub(crate) fn would_a_policy_help(&self) -> bool {
        2 * self.collisions >= self.switches
    }

    /// The advised dwell of a winner, s.
    pub(crate) fn dwell(&self) -> Option<Advice> {
        let bound = self.stays.quantile(0.9)? / 1e9;
        Some(Advice {
            value: rounded_up(DWELL_FACTOR * bound),
            bound,
            count: self.stays.count(),
        })
    }

    /// The advised hysteresis of urgency; none if no winner won by urgency.
    pub(crate) fn hysteresis(&self) -> Option<Advice> {
        let bound = self.margins.quantile(0.9)? / URGENCY_SCALE;
        Some(Advice {
            value: rounded_up(bound),
            bound,
            count: self.margins.count(),
        })
    }
}

/// By how much the new winner's urgency exceeded the old one's, which was ready as well.
fn margin(decision: &Decision) -> Option<f64> {
    let urgency = |name: &Option<String>| {
        let of = |name: &String| {
            decision
                .candidates
                .iter()
                .find(|candidate| candidate.name == *name)
        };
        name.as_ref()
            .and_then(of)
            .filter(|candidate| candidate.ready)?
            .urgency
    };
    let margin = urgency(&decision.choice)? - urgency(&decision.before)?;
    Some(margin).filter(|margin| *margin > 0.0 && *margin < 1e9)
}

/// Rounds up to two digits, for typing.
fn rounded_up(value: f64) -> f64 {
    if value <= 0.0 {
        return 0.0;
    }
    let unit = 10_f64.powf(value.log10().floor() - 1.0);
    // A value that is whole except for a rounding error stays.
    (value / unit - 1e-9).ceil() * unit
}

#[cfg(test)]
mod tests {
    use jde_core::State;
    use jde_records::{CandidateRecord, DecidedBy};

    use super::*;

    const MS: Nanos = 1_000_000;

    fn switch(to_vff: bool, case: Case, urgencies: Option<(f64, f64)>) -> Decision {
        let (before, choice) = if to_vff { ("goon", "vff") } else { ("vff", "goon") };
        let candidate = |name: &str, urgency: f64| CandidateRecord {
            name: name.to_owned(),
            state: State::Ready,
            ready: true,
            urgency: Some(urgency),
        };
        Decision {
            number: 1,
            time_s: 0.0,
            group: "roots".to_owned(),
            case,
            candidates: urgencies.map_or(Vec::new(), |(old, new)| {
                vec![candidate(before, old), candidate(choice, new)]
            }),
            before: Some(before.to_owned()),
            choice: Some(choice.to_owned()),
            decider: DecidedBy::Policy("urgency".to_owned()),
            reason: String::new(),
            cause: String::new(),
            changed: true,
            takeover_us: None,
            refused: Vec::new(),
        }
    }

    #[test]
    fn chattering_collisions_yield_an_advised_dwell_and_hysteresis() {
        let mut chatter = ChatterStatistics::default();
        for turn in 0..50_u64 {
            let decision = switch(turn % 2 == 0, Case::Collision, Some((0.50, 0.58)));
            chatter.add_switch(turn * 120 * MS, &decision);
        }
        assert_eq!(
            (chatter.spells, chatter.switches),
            (1, 46),
            "chattering begins with the fifth switch"
        );
        assert_eq!(chatter.between(), Some((Some("goon"), Some("vff"))));
        assert!(chatter.would_a_policy_help());
        let dwell = chatter.dwell().expect("there are stays");
        assert!(
            (dwell.bound - 0.12).abs() < 0.003 && (0.23..=0.25).contains(&dwell.value),
            "{dwell:?}"
        );
        let hysteresis = chatter.hysteresis().expect("urgencies decided");
        assert!((0.079..0.083).contains(&hysteresis.value), "{hysteresis:?}");
    }

    #[test]
    fn no_policy_would_help_where_one_candidate_alone_is_ready() {
        let mut chatter = ChatterStatistics::default();
        for turn in 0..20_u64 {
            chatter.add_switch(turn * 100 * MS, &switch(turn % 2 == 0, Case::Alone, None));
        }
        assert!(!chatter.would_a_policy_help());
        assert_eq!(chatter.hysteresis(), None);
    }

    #[test]
    fn four_switches_a_second_and_round_robin_are_not_chattering() {
        let mut chatter = ChatterStatistics::default();
        for turn in 0..40_u64 {
            chatter.add_switch(turn * 250 * MS, &switch(turn % 2 == 0, Case::Collision, None));
            let mut turns = switch(turn % 2 == 0, Case::Collision, None);
            turns.decider = DecidedBy::Policy("round-robin".to_owned());
            chatter.add_switch(turn * 250 * MS, &turns);
        }
        assert_eq!(chatter.spells, 0);
        assert_eq!(chatter.dwell(), None);
    }

    #[test]
    fn values_are_rounded_up_to_two_digits() {
        let rounded = [0.2341, 12.01, 0.24, 0.0].map(rounded_up);
        for (value, expected) in rounded.into_iter().zip([0.24, 13.0, 0.24, 0.0]) {
            assert!((value - expected).abs() < 1e-9, "{value}");
        }
    }
}
