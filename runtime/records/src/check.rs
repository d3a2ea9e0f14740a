//! What makes sense in the messages of a run that others have written: places that exist, hierarchies that end, times and
//! names within bounds. Whoever decodes such a message calls this once, so that nobody behind it has to.
//!
//! A reason is words about the application: "schema 12 has father 99, and it has 3 schemas". The counts are from 0, as in
//! the messages.

use jde_core::Nanos;

use crate::RunRecord;
use crate::event::What;
use crate::snapshot::{GroupView, Snapshot};
use crate::wire::Nonsense;

/// The most schemas and the most groups: those of an application file.
pub const MAX_SCHEMAS: usize = 10_000;
/// The most fathers above a schema. Whatever walks through a hierarchy may recurse that deep.
pub const MAX_DEPTH: usize = jde_app::MAX_DEPTH - 1;
/// The longest name, bytes: `group` and `peer:schema.variable` contain several of 64.
pub const MAX_NAME: usize = 255;
/// The latest time, ns: 146 years. Sums of two times cannot overflow.
pub const MAX_TIME: Nanos = 1 << 62;

impl Snapshot {
    /// Checks a snapshot that others have written.
    ///
    /// # Errors
    /// The first thing that makes no sense.
    pub fn check(&self) -> Result<(), String> {
        check_count(self.schemas.len(), "schemas")?;
        check_count(self.groups.len(), "groups")?;
        check_time(self.time, "the snapshot's time")?;
        for (place, schema) in self.schemas.iter().enumerate() {
            let what = || format!("schema {place}");
            check_name(&schema.name, what)?;
            self.check_place(schema.father, || format!("{} has father", what()))?;
            if let Some(group) = schema.group.filter(|group| *group >= self.groups.len()) {
                let groups = self.groups.len();
                return Err(format!(
                    "{} is in group {group}, and it has {groups} groups",
                    what()
                ));
            }
            if !(0.0..=f64::MAX).contains(&schema.load) {
                return Err(format!("{} has a load of {}", what(), schema.load));
            }
        }
        let fathers: Vec<_> = self.schemas.iter().map(|schema| schema.father).collect();
        check_fathers(&fathers)?;
        let mut listed = vec![false; self.schemas.len()];
        for (place, group) in self.groups.iter().enumerate() {
            self.check_group(place, group, &mut listed)?;
        }
        Ok(())
    }

    /// Checks a group; `listed` are the members of those before.
    fn check_group(&self, place: usize, group: &GroupView, listed: &mut [bool]) -> Result<(), String> {
        let what = || format!("group {place}");
        check_name(&group.name, what)?;
        self.check_place(group.father, || format!("{} has father", what()))?;
        for &member in &group.members {
            self.check_place(Some(member), || format!("{} has member", what()))?;
            let schema = &self.schemas[member];
            // So the fathers of the groups are the fathers of the schemas, which end.
            if schema.group != Some(place) || schema.father != group.father {
                return Err(format!(
                    "schema {member} is a member of {}, and states another group or father",
                    what()
                ));
            }
            if std::mem::replace(&mut listed[member], true) {
                return Err(format!("{} has schema {member} twice", what()));
            }
        }
        self.check_place(group.winner, || format!("{} has winner", what()))?;
        if let Some(switch) = &group.last {
            check_time(switch.time, "a switch's time")?;
            for schema in [switch.from, switch.to] {
                self.check_place(schema, || format!("{} switched between", what()))?;
            }
        }
        if let Some(chatter) = &group.chatter {
            check_time(chatter.since, "the beginning of chattering")?;
            for schema in chatter.between {
                self.check_place(schema, || format!("{} chatters between", what()))?;
            }
        }
        Ok(())
    }

    fn check_place(&self, schema: Option<usize>, what: impl FnOnce() -> String) -> Result<(), String> {
        match schema {
            Some(place) if place >= self.schemas.len() => {
                let schemas = self.schemas.len();
                Err(format!("{} {place}, and it has {schemas} schemas", what()))
            }
            Some(_) | None => Ok(()),
        }
    }
}

impl RunRecord {
    /// Checks a record that others have written.
    ///
    /// # Errors
    /// The first thing that makes no sense.
    pub fn check(&self) -> Result<(), String> {
        if let Some((_, gesture)) = self.what().and_then(What::gesture) {
            gesture.check().map_err(|broken| broken.to_string())?;
        }
        let time_s = match self {
            Self::Decision(decision) => decision.time_s,
            Self::State(_) | Self::Other(_) => 0.0,
        };
        if !(0.0..=MAX_TIME as f64 / 1e9).contains(&time_s) {
            return Err(Nonsense::Time(time_s).to_string());
        }
        Ok(())
    }
}

/// Refuses more than [`MAX_SCHEMAS`] of a kind.
///
/// # Errors
/// There are more.
pub fn check_count(count: usize, what: &str) -> Result<(), String> {
    if count > MAX_SCHEMAS {
        return Err(format!(
            "it has {count} {what}, of which at most {MAX_SCHEMAS} are possible"
        ));
    }
    Ok(())
}

/// Refuses an empty name, a long one, and one with control characters.
///
/// # Errors
/// The name is of these.
pub fn check_name(name: &str, what: impl FnOnce() -> String) -> Result<(), String> {
    if name.is_empty() || name.len() > MAX_NAME || name.contains(char::is_control) {
        let bytes = name.len();
        return Err(format!(
            "the name of {} has {bytes} bytes or control characters; it has 1 to {MAX_NAME} bytes and none of these",
            what()
        ));
    }
    Ok(())
}

/// Refuses a time after [`MAX_TIME`].
///
/// # Errors
/// It is later.
pub fn check_time(time: Nanos, what: &str) -> Result<(), String> {
    if time > MAX_TIME {
        return Err(format!("{what} is {time} ns, which is more than 146 years"));
    }
    Ok(())
}

/// Refuses fathers that are among their own children, and more than [`MAX_DEPTH`] above one schema. Every father is a place
/// in the list.
///
/// # Errors
/// The first schema of this kind.
pub fn check_fathers(fathers: &[Option<usize>]) -> Result<(), String> {
    // The fathers above each schema; none while unknown.
    let mut depths: Vec<Option<usize>> = vec![None; fathers.len()];
    let mut above = Vec::new();
    for start in 0..fathers.len() {
        let mut next = Some(start);
        let mut depth = loop {
            match next {
                None => break 0,
                Some(place) => match depths[place] {
                    Some(depth) => break depth + 1,
                    None if above.len() > MAX_DEPTH => {
                        return Err(format!(
                            "schema {start} has more than {MAX_DEPTH} fathers above it, or is among them itself"
                        ));
                    }
                    None => {
                        above.push(place);
                        next = fathers[place];
                    }
                },
            }
        };
        while let Some(place) = above.pop() {
            if depth > MAX_DEPTH {
                return Err(format!(
                    "schema {start} has more than {MAX_DEPTH} fathers above it"
                ));
            }
            depths[place] = Some(depth);
            depth += 1;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::Decision;
    use crate::event::StateChange;
    use crate::snapshot::{SchemaView, Switch};
    use crate::wire::StateMessage;

    fn snapshot(fathers: &[Option<usize>]) -> Snapshot {
        let schema = |(place, father): (usize, &Option<usize>)| SchemaView {
            name: format!("s{place}"),
            father: *father,
            ..SchemaView::default()
        };
        Snapshot {
            schemas: fathers.iter().enumerate().map(schema).collect(),
            ..Snapshot::default()
        }
    }

    fn refused(snapshot: &Snapshot) -> String {
        snapshot.check().expect_err("it makes no sense")
    }

    #[test]
    fn a_place_that_does_not_exist_is_named() {
        let mut bad = snapshot(&[None, Some(0), Some(99)]);
        assert_eq!(refused(&bad), "schema 2 has father 99, and it has 3 schemas");
        bad.schemas[2].father = Some(1);
        assert_eq!(bad.check(), Ok(()));
        bad.schemas[1].group = Some(1);
        assert_eq!(refused(&bad), "schema 1 is in group 1, and it has 0 groups");
        bad.schemas[1].group = Some(0);
        bad.groups.push(GroupView {
            name: "roots".to_owned(),
            father: Some(0),
            members: vec![1],
            winner: Some(3),
            ..GroupView::default()
        });
        assert_eq!(refused(&bad), "group 0 has winner 3, and it has 3 schemas");
        bad.groups[0].winner = Some(1);
        assert_eq!(bad.check(), Ok(()));
        bad.groups[0].last = Some(Switch {
            time: 1,
            from: None,
            to: Some(7),
            decider: crate::DecidedBy::Nobody,
            reason: String::new(),
            latency: None,
        });
        assert_eq!(refused(&bad), "group 0 switched between 7, and it has 3 schemas");
    }

    #[test]
    fn fathers_end_after_as_many_as_an_application_may_have() {
        let chain =
            |count: usize| -> Vec<_> { (0..count).map(|place: usize| place.checked_sub(1)).collect() };
        assert_eq!(check_fathers(&chain(MAX_DEPTH + 1)), Ok(()));
        assert!(check_fathers(&chain(MAX_DEPTH + 2)).is_err());
        assert!(check_fathers(&chain(30_000)).is_err());
        let backwards: Vec<_> = (1..=MAX_DEPTH + 1).map(Some).chain([None]).collect();
        assert!(check_fathers(&backwards).is_err());
        assert!(check_fathers(&[Some(1), Some(0)]).is_err());
        assert!(check_fathers(&[Some(0)]).is_err());
    }

    #[test]
    fn groups_cannot_nest_schemas_deeper_than_their_fathers_do() {
        let count = 300;
        let mut bad = snapshot(&vec![None; count]);
        for place in 1..count {
            bad.schemas[place].group = Some(place - 1);
            bad.groups.push(GroupView {
                name: "g".to_owned(),
                father: Some(place - 1),
                members: vec![place],
                ..GroupView::default()
            });
        }
        assert!(refused(&bad).contains("states another group or father"));
    }

    #[test]
    fn times_names_and_states_that_are_none_are_refused() {
        let mut bad = snapshot(&[None]);
        bad.time = u64::MAX;
        assert!(refused(&bad).contains("time"));
        bad = snapshot(&[None]);
        bad.schemas[0].name = "a\u{1b}[31m".to_owned();
        assert!(refused(&bad).contains("control characters"));
        for time_s in [f64::INFINITY, -1.0, 1e300] {
            let message = StateMessage {
                time_s,
                from: "slept".to_owned(),
                to: "ready".to_owned(),
                ..StateMessage::default()
            };
            assert!(StateChange::try_from(message).is_err());
            let decision = Decision {
                time_s,
                ..Decision::default()
            };
            assert!(RunRecord::Decision(decision).check().is_err());
        }
        let odd = StateMessage {
            from: "slept".to_owned(),
            to: "asleep".to_owned(),
            ..StateMessage::default()
        };
        assert!(StateChange::try_from(odd).is_err());
    }

    proptest! {
        #[test]
        fn whatever_passes_can_be_walked_through(fathers in proptest::collection::vec(proptest::option::of(0_usize..40), 1..40)) {
            let count = fathers.len();
            let all_exist = fathers.iter().flatten().all(|father| *father < count);
            let passes = snapshot(&fathers).check().is_ok();
            prop_assert!(all_exist || !passes);
            if passes {
                for start in 0..count {
                    let steps = std::iter::successors(Some(start), |place| fathers[*place]).take(count + 1).count();
                    prop_assert!(steps <= count);
                }
            }
        }
    }
}
