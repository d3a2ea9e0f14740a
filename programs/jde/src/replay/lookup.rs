//! What a recording had at one time, for those who ask once: the newest values of some variables, the last records, or the
//! state of all schemas. Of the file it reads only the channels and the time that this needs.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use jde_core::Nanos;
use jde_link::Events;
use jde_log::{ReadError, record};
use jde_records::{RecordKind, RunRecord};

use super::index::{Index, IndexEntry, RecordedValue, TURNS_TOPIC};
use super::player::Player;
use super::publisher::Publisher;
use crate::failure::Failure;

/// How far before the time the newest is searched first.
const FIRST_SEARCH: Nanos = 2_000_000_000;
/// How much farther each further search goes.
const SEARCH_FACTOR: Nanos = 8;

/// What is asked of a recording.
pub(crate) enum Asked {
    /// The newest values of the variables of which these are the names or the fields; of all if there are none.
    Values(Vec<String>),
    /// The state, the health and the counts of all schemas.
    Hierarchy,
    /// So many of the last records of each kind. All, or only those that changed a choice and other events.
    Records { last: usize, all: bool },
}

/// Reads what is asked, as it was at a time, that one included, and gives it to whoever serves it. Returns the error that
/// ended the reading, if one did.
///
/// # Errors
/// The file cannot be read.
pub(super) fn read(
    player: &Player,
    at: Nanos,
    asked: &Asked,
    publisher: &mut Publisher,
    events: &Events,
) -> Result<Option<ReadError>, Failure> {
    match asked {
        Asked::Values(names) => {
            let (values, error) = newest_values(&player.index, at, |name| is_asked(name, names))?;
            publish(publisher, values);
            Ok(error)
        }
        Asked::Hierarchy => read_run(player, at, publisher),
        Asked::Records { last, all } => {
            let (records, error) = last_records(&player.index, at, *last, *all)?;
            records.into_iter().for_each(|record| events.push(record));
            Ok(error)
        }
    }
}

/// Whether a variable is one of these names, or the beginning of one that goes on with a field.
fn is_asked(variable: &str, names: &[String]) -> bool {
    let is_of = |name: &String| {
        let rest = name.strip_prefix(variable);
        rest.is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '[']))
    };
    names.is_empty() || names.iter().any(is_of)
}

fn publish(publisher: &mut Publisher, values: impl IntoIterator<Item = RecordedValue>) {
    for value in values {
        publisher.publish(&value);
        if let Some(ended) = value.ended {
            publisher.end(&value.topic, ended);
        }
    }
}

/// Returns the times of one search after the other, each of which goes farther back, and whether it is the last.
fn searches(index: &Index, at: Nanos) -> impl Iterator<Item = (Nanos, bool)> + use<> {
    let begin = index.begin;
    let lengths = std::iter::successors(Some(FIRST_SEARCH), |length| {
        Some(length.saturating_mul(SEARCH_FACTOR))
    });
    lengths.map(move |length| match at.saturating_sub(length) {
        from if from > begin => (from, false),
        _ => (0, true),
    })
}

/// Returns the newest values of the variables with a name, and when they had ended, if they had.
fn newest_values(
    index: &Index,
    at: Nanos,
    is_wanted: impl Fn(&str) -> bool,
) -> Result<(Vec<RecordedValue>, Option<ReadError>), Failure> {
    let wanted = index
        .variables
        .iter()
        .filter(|variable| is_wanted(&variable.name));
    let topics: BTreeSet<&str> = wanted.map(|variable| variable.topic.as_str()).collect();
    if topics.is_empty() {
        return Ok((Vec::new(), None));
    }
    let mut shorter = BTreeMap::new();
    for (from, is_last) in searches(index, at) {
        let (mut newest, mut ended) = (BTreeMap::new(), None);
        let entries = index.entries_of(from..=at, |channel| {
            topics.contains(channel.topic.as_str()) || record::kind(channel) == Some(RecordKind::Event)
        })?;
        for entry in entries {
            match entry {
                Ok(entry) => note_value(index, &mut newest, entry),
                Err(error) => ended = Some(error),
            }
        }
        // A search ends at a damaged place; what a shorter one found is behind it, and newer.
        if ended.is_some() {
            newest.append(&mut shorter);
        }
        if is_last || newest.len() == topics.len() {
            return Ok((newest.into_values().collect(), ended));
        }
        shorter = newest;
    }
    Ok((Vec::new(), None))
}

/// Replaces the newest value of a topic by a newer one, or notes that it ended.
fn note_value(index: &Index, newest: &mut BTreeMap<String, RecordedValue>, entry: IndexEntry) {
    match entry {
        IndexEntry::Value(value) => drop(newest.insert(value.topic.clone(), value)),
        IndexEntry::Line(time, line) => {
            if let Some(topic) = index.retracted_topic(&line)
                && let Some(value) = newest.get_mut(topic)
            {
                value.ended = Some(time);
            }
        }
        IndexEntry::Cycle(_) => {}
    }
}

/// Returns the last records of each kind, in their order.
fn last_records(
    index: &Index,
    at: Nanos,
    last: usize,
    all: bool,
) -> Result<(Vec<RunRecord>, Option<ReadError>), Failure> {
    let is_shown = |record: &RunRecord| match record {
        RunRecord::Decision(decision) => all || decision.changed,
        RunRecord::State(_) => all,
        RunRecord::Other(_) => true,
    };
    if last == 0 {
        return Ok((Vec::new(), None));
    }
    let mut shorter = Vec::new();
    for (from, is_last) in searches(index, at) {
        let mut kept: [VecDeque<(u64, RunRecord)>; 3] = Default::default();
        let (mut count, mut ended) = (0, None);
        let entries = index.entries_of(from..=at, |channel| {
            record::kind(channel).is_some_and(|kind| all || kind != RecordKind::State)
        })?;
        for entry in entries {
            match entry {
                Ok(IndexEntry::Line(_, record)) if is_shown(&record) => {
                    let kept = &mut kept[record.kind() as usize];
                    if kept.len() == last {
                        kept.pop_front();
                    }
                    count += 1;
                    kept.push_back((count, record));
                }
                Ok(IndexEntry::Line(..) | IndexEntry::Value(_) | IndexEntry::Cycle(_)) => {}
                Err(error) => ended = Some(error),
            }
        }
        let is_full =
            |kind: RecordKind| kept[kind as usize].len() == last || (kind == RecordKind::State && !all);
        let is_done = is_last || RecordKind::ALL.into_iter().all(is_full);
        let mut records: Vec<_> = kept.into_iter().flatten().collect();
        records.sort_by_key(|(number, _)| *number);
        let records: Vec<_> = records.into_iter().map(|(_, record)| record).collect();
        // A search ends at a damaged place; the last records are those that a shorter one found behind it.
        if ended.is_some() && !shorter.is_empty() {
            return Ok((shorter, ended));
        }
        if is_done {
            return Ok((records, ended));
        }
        shorter = records;
    }
    Ok((Vec::new(), None))
}

/// Reads the run until a time: what the schemas did since the start is in the records and in the turns, and their periods are
/// in variables.
fn read_run(player: &Player, at: Nanos, publisher: &mut Publisher) -> Result<Option<ReadError>, Failure> {
    let index = &player.index;
    let periods = index
        .variables
        .iter()
        .filter(|variable| variable.name.ends_with(".period"));
    let periods: BTreeSet<&str> = periods.map(|variable| variable.topic.as_str()).collect();
    let entries = index.entries_of(0..=at, |channel| {
        let topic = channel.topic.as_str();
        topic == TURNS_TOPIC || periods.contains(topic) || record::kind(channel).is_some()
    })?;
    let (mut newest, mut ended) = (BTreeMap::new(), None);
    for entry in entries {
        match entry {
            Ok(entry) => {
                player.apply(&entry);
                note_value(index, &mut newest, entry);
            }
            Err(error) => ended = Some(error),
        }
    }
    publish(publisher, newest.into_values());
    Ok(ended)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_field_asks_for_its_variable() {
        let names = ["pioneer.laser.ranges[3]".to_owned(), "goon.fast".to_owned()];
        assert!(is_asked("pioneer.laser", &names) && is_asked("goon.fast", &names));
        assert!(!is_asked("pioneer.las", &names) && !is_asked("pioneer.odometry", &names));
        assert!(is_asked("pioneer.odometry", &[]), "without names, all are asked");
    }
}
