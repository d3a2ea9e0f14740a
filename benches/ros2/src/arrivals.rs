//! When messages were sent and arrived, as the programs record it.

use std::collections::BTreeMap;
use std::time::{SystemTime, UNIX_EPOCH};

use anyhow::{Result, ensure};
use jde_measure::pairs::{Rounds, median};

/// The number of messages in a round.
const ROUND: usize = 25;

/// One message. Times are of the wall clock, ns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Arrival {
    pub(crate) sent: u64,
    pub(crate) arrived: u64,
    pub(crate) number: u64,
}

/// The messages of each topic, in the order of their arrival.
#[derive(Debug, Default)]
pub(crate) struct Arrivals(BTreeMap<String, Vec<Arrival>>);

impl Arrivals {
    /// Reads lines of a topic and three numbers. Other lines are messages of the middleware, which writes them between.
    pub(crate) fn read(text: &str) -> Self {
        let mut this = Self::default();
        for line in text.lines() {
            let words: Vec<&str> = line.split(' ').collect();
            if let [topic, sent, arrived, number] = words.as_slice()
                && let (Ok(sent), Ok(arrived), Ok(number)) = (sent.parse(), arrived.parse(), number.parse())
            {
                this.0.entry((*topic).to_owned()).or_default().push(Arrival {
                    sent,
                    arrived,
                    number,
                });
            }
        }
        this
    }

    /// The messages of a topic that were sent in a time.
    pub(crate) fn of(&self, topic: &str, (from, to): (u64, u64)) -> Vec<Arrival> {
        let all = self.0.get(topic).map(Vec::as_slice).unwrap_or_default();
        let within = all.iter().filter(|arrival| (from..to).contains(&arrival.sent));
        within.copied().collect()
    }

    /// The times of its messages from sending to arrival, as medians of rounds.
    pub(crate) fn ages(&self, topic: &str, within: (u64, u64)) -> Result<Rounds> {
        let ages: Vec<f64> = self.of(topic, within).iter().map(Arrival::age).collect();
        ensure!(!ages.is_empty(), "no message of `{topic}` arrived");
        Ok(Rounds::of(
            ages.chunks(ROUND).map(|round| median(round.to_vec())).collect(),
        ))
    }
}

impl Arrival {
    /// The time from sending to arrival, ns.
    pub(crate) fn age(&self) -> f64 {
        self.arrived.saturating_sub(self.sent) as f64
    }
}

/// The messages between the first and the last of these that did not arrive.
pub(crate) fn lost(arrivals: &[Arrival]) -> u64 {
    let numbers = || arrivals.iter().map(|arrival| arrival.number);
    let (Some(first), Some(last)) = (numbers().min(), numbers().max()) else {
        return 0;
    };
    let mut arrived: Vec<u64> = numbers().collect();
    arrived.sort_unstable();
    arrived.dedup();
    last - first + 1 - arrived.len() as u64
}

/// The wall clock, ns.
pub(crate) fn now() -> u64 {
    let time = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    time.as_nanos() as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_that_are_missing_between_others_are_lost() {
        let arrivals = Arrivals::read("a 10 15 4\na 20 27 6\nb 30 31 1\nWARN a b c\na 40 41 7\na 50 51");
        let all = arrivals.of("a", (0, 100));
        assert_eq!(all.len(), 3);
        assert_eq!(lost(&all), 1);
        assert_eq!(lost(&arrivals.of("a", (20, 100))), 0);
        assert_eq!(arrivals.ages("a", (0, 40)).unwrap().median(), 7.0);
        assert!(arrivals.ages("c", (0, 100)).is_err());
    }
}
