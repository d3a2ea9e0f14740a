//! The timeline itself: what it is fed with, and what follows from it.

use std::collections::VecDeque;

use jde_core::{GroupId, Id, Nanos, Record, State};
use jde_records::event::{Event, Naming, Occurrence, What};
use jde_records::snapshot::Snapshot;
use jde_records::{DecidedBy, Decision, RunRecord};

use crate::ending::Ending;
use crate::hierarchy::Hierarchy;
use crate::keep::Keep;
use crate::record_log::RecordLog;
use crate::schema::{GroupTimeline, SchemaTimeline, Switch};
use crate::track::Span;

/// What happened in a run so far.
///
/// It is fed with the events of a run in this process, with the records of one elsewhere or of a file, and with snapshots,
/// in the order of their times. It has no clock and no I/O.
#[derive(Clone, Debug, PartialEq)]
pub struct Timeline {
    hierarchy: Hierarchy,
    schemas: Vec<SchemaTimeline>,
    groups: Vec<GroupTimeline>,
    /// The schemas of all marks, in the order of their arrival.
    marked: VecDeque<usize>,
    log: RecordLog,
    keep: Keep,
    /// The time from which on the first known state of a schema holds.
    begin: Nanos,
    now: Nanos,
    /// How and when the run ended.
    pub(crate) ending: Option<(Nanos, Ending)>,
    /// The time of the last snapshot.
    seen: Nanos,
    /// How many schemas and groups the last snapshot had.
    seen_places: Option<(usize, usize)>,
    missed: u64,
    rewinds: u64,
    ended: Vec<Span>,
}

impl Default for Timeline {
    /// The timeline of a run of which nothing is known, that keeps the present alone.
    fn default() -> Self {
        Self::new(Hierarchy::default(), Keep::PRESENT)
    }
}

impl Timeline {
    /// Creates the timeline of a run of which nothing is known but its hierarchy. Records may add to that.
    #[must_use]
    pub fn new(hierarchy: Hierarchy, keep: Keep) -> Self {
        let mut timeline = Self {
            hierarchy,
            schemas: Vec::new(),
            groups: Vec::new(),
            marked: VecDeque::new(),
            log: RecordLog::new(keep.records),
            keep,
            begin: 0,
            now: 0,
            ending: None,
            seen: 0,
            seen_places: None,
            missed: 0,
            rewinds: 0,
            ended: Vec::new(),
        };
        timeline.grow();
        timeline
    }

    /// Lets the states that the first records find hold from a time on, ns, instead of from the start of the application. What
    /// is earlier is not counted.
    #[must_use]
    pub fn beginning(self, begin: Nanos) -> Self {
        Self { begin, ..self }
    }

    /// Returns the schemas and groups.
    #[must_use]
    pub fn hierarchy(&self) -> &Hierarchy {
        &self.hierarchy
    }

    /// Changes what is known of the schemas and groups.
    pub fn describe<R>(&mut self, change: impl FnOnce(&mut Hierarchy) -> R) -> R {
        let result = change(&mut self.hierarchy);
        self.grow();
        result
    }

    /// Returns what happened to each schema, by the places of the hierarchy.
    #[must_use]
    pub fn schemas(&self) -> &[SchemaTimeline] {
        &self.schemas
    }

    /// Returns what happened to each group, by the places of the hierarchy.
    #[must_use]
    pub fn groups(&self) -> &[GroupTimeline] {
        &self.groups
    }

    /// Returns what happened to the schema of a name.
    #[must_use]
    pub fn schema(&self, name: &str) -> Option<&SchemaTimeline> {
        self.schemas.get(self.hierarchy.find(name)?)
    }

    /// Returns what happened to the group of a name.
    #[must_use]
    pub fn group(&self, name: &str) -> Option<&GroupTimeline> {
        self.groups.get(self.hierarchy.find_group(name)?)
    }

    /// Returns the records.
    #[must_use]
    pub fn log(&self) -> &RecordLog {
        &self.log
    }

    /// Returns the latest time that it knows of, ns.
    #[must_use]
    pub fn now(&self) -> Nanos {
        self.now
    }

    /// Returns how many records were lost on their way.
    #[must_use]
    pub fn missed(&self) -> u64 {
        self.missed
    }

    /// Returns how often the time went back, or the hierarchy became another one.
    #[must_use]
    pub fn rewinds(&self) -> u64 {
        self.rewinds
    }

    /// Removes and returns the intervals that are kept no more, if [`Keep::ended`] asks for them.
    pub fn take_ended(&mut self) -> impl Iterator<Item = Span> {
        std::mem::take(&mut self.ended).into_iter()
    }

    /// Returns the schemas that act: the winners without groups of their own, among the winners of the roots and of the
    /// groups below winners. A winner whose groups have no winner adds none.
    #[must_use]
    pub fn acting(&self) -> Vec<usize> {
        let groups = self.hierarchy.groups().iter().zip(&self.groups);
        let roots = groups.filter(|(group, _)| group.father.is_none());
        let mut winning: Vec<_> = roots.filter_map(|(_, group)| group.winner()).collect();
        let mut acting = Vec::new();
        while let Some(winner) = winning.pop() {
            let groups = &self.hierarchy.schemas()[winner].groups;
            if groups.is_empty() {
                acting.push(winner);
            }
            winning.extend(groups.iter().filter_map(|group| self.groups[*group].winner()));
        }
        acting
    }

    /// Returns how often any motor schema took over and began to iterate.
    #[must_use]
    pub fn takeovers(&self) -> u64 {
        self.schemas.iter().map(|schema| schema.counts.takeovers).sum()
    }

    /// Returns the newest switches of all groups, newest first, each with the place of its group.
    #[must_use]
    pub fn newest_switches(&self, most: usize) -> Vec<(usize, &Switch)> {
        let groups = self.groups.iter().enumerate();
        let switches = groups.flat_map(|(place, group)| {
            let newest = group.switches.iter().rev().take(most);
            newest.map(move |switch| (place, switch))
        });
        let mut switches: Vec<_> = switches.collect();
        switches.sort_by_key(|(place, switch)| std::cmp::Reverse((switch.time, switch.number, *place)));
        switches.truncate(most);
        switches
    }

    /// Adds an event of a run whose application the hierarchy is. It keeps no record of it.
    pub fn add_event(&mut self, event: &Event) {
        self.advance(event.time());
        match event {
            Event::Decision(record) => self.select(record.group, record),
            Event::State(change) => self.change(change.time, change.schema.index(), change.from, change.to),
            Event::Other(Occurrence { time, what }) => {
                self.end(*time, what);
                if let What::TookOver {
                    group,
                    record,
                    schema,
                    latency,
                    ..
                } = what
                {
                    self.schemas[schema.index()].count_takeover();
                    let group = &mut self.groups[group.index()];
                    group.add_takeover(*record, *latency);
                    group.counts.worst = group.counts.worst.max(Some(*latency));
                    group.counts.late += u64::from(what.is_late());
                }
                if let Some(schema) = what.schema() {
                    self.schemas[schema.index()].count(*time, what, || None);
                }
            }
        }
    }

    /// Counts records that were lost on their way.
    pub fn add_missed(&mut self, records: u64) {
        self.missed += records;
    }

    /// Adds a record.
    pub fn add(&mut self, record: &RunRecord) {
        self.advance(record.time());
        match record {
            RunRecord::Decision(decision) => self.add_decision(record.time(), decision),
            RunRecord::State(change) => {
                if let Some(schema) = self.describe(|hierarchy| hierarchy.add(&change.schema)) {
                    self.change(change.time, schema, change.from, change.to);
                }
            }
            RunRecord::Other(event) => {
                self.end(event.time, &event.what);
                let is_counted = event.time >= self.begin;
                if let What::TookOver { group, .. } = &event.what
                    && let Some(group) = self.hierarchy.find_group(group).filter(|_| is_counted)
                {
                    let is_late = event.what.is_late();
                    self.groups[group].counts.late += u64::from(is_late);
                }
                let name = event.what.schema();
                let schema = name.and_then(|name| self.describe(|hierarchy| hierarchy.add(name)));
                if let Some(schema) = schema.filter(|_| is_counted) {
                    self.schemas[schema].count(event.time, &event.what, || Some(event.text()));
                    self.mark(schema, event);
                }
            }
        }
        if self.keep.records.records > 0 {
            self.log.add(record.clone());
        }
    }

    /// Counts an iteration of a schema.
    pub fn add_iteration(&mut self, schema: usize) {
        if let Some(schema) = self.schemas.get_mut(schema) {
            schema.counts.iterations += 1;
        }
    }

    /// Adds a snapshot. It supplies what was lost, and all counts. One of an earlier time than the snapshot before removes
    /// all that is later; one of another hierarchy begins a new timeline.
    pub fn add_snapshot(&mut self, snapshot: &Snapshot) {
        if !self.is_of(snapshot) {
            let rewinds = self.rewinds + 1;
            *self = Self::new(Hierarchy::of_snapshot(snapshot), self.keep);
            self.rewinds = rewinds;
        } else if snapshot.time < self.seen {
            self.rewind(snapshot.time);
        }
        self.seen = snapshot.time;
        self.advance(snapshot.time);
        // An application that has ended may stay to be looked at. Its time stands still.
        let time = snapshot.time.min(self.end_time());
        self.seen_places = Some((snapshot.schemas.len(), snapshot.groups.len()));
        // A record arrives before the snapshot that shows its change, or was lost.
        let states = self.schemas.iter().map(|schema| schema.states.last());
        let is_older: Vec<_> = states
            .map(|last| last.is_none_or(|last| last.from < time))
            .collect();
        // Once more, since the loss of a father puts its children to sleep, and an operator may have played one since.
        for _ in 0..2 {
            for (schema, view) in snapshot
                .schemas
                .iter()
                .enumerate()
                .filter(|(place, _)| is_older[*place])
            {
                self.set_state(time, schema, view.state);
            }
        }
        for (schema, view) in self.schemas.iter_mut().zip(&snapshot.schemas) {
            // As with states: what a record said since is newer.
            if schema.faulted.last().is_none_or(|last| last.from < time) {
                schema.set_health(time, &view.health);
            }
            schema.counts.iterations = view.iterations;
            schema.counts.overruns = view.overruns;
            schema.counts.refused = view.refused;
            schema.counts.faults = view.faults;
        }
        for (group, view) in self.groups.iter_mut().zip(&snapshot.groups) {
            group.counts.switches = view.switches;
            group.counts.worst = Some(view.worst).filter(|worst| *worst > 0);
            group.counts.late = view.late;
            if let Some(last) = view.last.clone() {
                group.add_switch(Switch {
                    number: None,
                    time: last.time,
                    from: last.from,
                    to: last.to,
                    decider: last.decider,
                    reason: last.reason,
                    latency: last.latency,
                });
            }
        }
    }

    fn end(&mut self, time: Nanos, what: &What<impl Naming>) {
        if let What::Ended { outcome } = what {
            self.ending = Some((time, Ending::Known(outcome.clone())));
            self.now = time;
        }
    }

    /// When the run ended; the latest possible time while it goes on.
    fn end_time(&self) -> Nanos {
        self.ending.as_ref().map_or(Nanos::MAX, |(time, _)| *time)
    }

    fn advance(&mut self, time: Nanos) {
        self.now = self.now.max(time.min(self.end_time()));
    }

    fn is_of(&self, snapshot: &Snapshot) -> bool {
        // Records may have named more, but an application does not lose schemas.
        let places = (snapshot.schemas.len(), snapshot.groups.len());
        if self.seen_places.is_some_and(|seen| seen != places) {
            return false;
        }
        let (schemas, groups) = (self.hierarchy.schemas(), self.hierarchy.groups());
        let mut schemas = schemas.iter().map(|schema| &schema.name);
        let mut groups = groups.iter().map(|group| &group.name);
        snapshot
            .schemas
            .iter()
            .all(|view| schemas.next() == Some(&view.name))
            && snapshot
                .groups
                .iter()
                .all(|view| groups.next() == Some(&view.name))
    }

    fn grow(&mut self) {
        let keep = self.keep;
        self.schemas
            .resize_with(self.hierarchy.schemas().len(), || SchemaTimeline::new(&keep));
        self.groups
            .resize_with(self.hierarchy.groups().len(), || GroupTimeline::new(&keep));
    }

    fn rewind(&mut self, now: Nanos) {
        self.schemas.iter_mut().for_each(|schema| schema.rewind(now));
        self.groups.iter_mut().for_each(|group| group.rewind(now));
        let schemas = self.schemas.iter().enumerate();
        let marks =
            schemas.flat_map(|(place, schema)| schema.marks.iter().map(move |mark| (mark.time, place)));
        let mut marks: Vec<_> = marks.collect();
        marks.sort_by_key(|(time, _)| *time);
        self.marked = marks.into_iter().map(|(_, place)| place).collect();
        self.log.rewind(now);
        self.ending.take_if(|(time, _)| *time > now);
        self.now = now;
        self.rewinds += 1;
    }

    /// Marks an event of a schema. If there are too many marks, the oldest of all is forgotten.
    fn mark(&mut self, schema: usize, event: &Occurrence<String>) {
        if self.keep.marks > 0 && self.schemas[schema].mark(event) {
            self.marked.push_back(schema);
        }
        if self.marked.len() > self.keep.marks
            && let Some(oldest) = self.marked.pop_front()
        {
            self.schemas[oldest].marks.pop_front();
        }
    }

    fn select(&mut self, group: GroupId, record: &Record) {
        let group = &mut self.groups[group.index()];
        group.counts.selections += 1;
        group.counts.switches += u64::from(record.changed);
        if record.changed {
            group.add_switch(Switch {
                number: Some(record.number),
                time: record.time,
                from: record.before.map(Id::index),
                to: record.choice.map(Id::index),
                decider: record.decider.into(),
                reason: record.reason.to_string(),
                latency: None,
            });
        }
    }

    fn add_decision(&mut self, time: Nanos, decision: &Decision) {
        let Some(group) = self.describe(|hierarchy| hierarchy.add_decision(decision)) else {
            return;
        };
        if let DecidedBy::Policy(policy) = &decision.decider
            && let Some(known) = self
                .hierarchy
                .group_mut(group)
                .filter(|known| known.policy != *policy)
        {
            known.policy.clone_from(policy);
        }
        // A schema whose state never changes is known from selections alone.
        for candidate in &decision.candidates {
            if let Some(schema) = self.hierarchy.find(&candidate.name)
                && self.schemas[schema].states.is_empty()
            {
                self.set_state(self.begin, schema, candidate.state);
            }
        }
        let place = |name: &Option<String>| self.hierarchy.find(name.as_deref()?);
        let (from, to) = (place(&decision.before), place(&decision.choice));
        let latency = decision.takeover_us.filter(|us| *us >= 0.0);
        let latency = latency.map(|us| (us * 1e3).round() as Nanos);
        let is_counted = time >= self.begin;
        let known = &mut self.groups[group];
        if is_counted {
            known.counts.selections += 1;
            known.counts.switches += u64::from(decision.changed);
            known.counts.worst = known.counts.worst.max(latency);
        }
        if decision.changed {
            known.add_switch(Switch {
                number: Some(decision.number),
                time,
                from,
                to,
                decider: decision.decider.clone(),
                reason: decision.reason.clone(),
                latency,
            });
        }
        if let (Some(_), Some(schema)) = (latency, to.filter(|_| is_counted)) {
            self.schemas[schema].count_takeover();
        }
    }

    /// Takes a change of state.
    fn change(&mut self, time: Nanos, schema: usize, from: State, to: State) {
        if self.schemas[schema].states.is_empty() && self.begin < time {
            self.set_state(self.begin, schema, from);
        }
        self.set_state(time, schema, to);
    }

    /// Begins a state of a schema. What a schema loses ends for all below it as well (R5, R6): nobody who watches depends
    /// on the records of its children.
    fn set_state(&mut self, time: Nanos, schema: usize, state: State) {
        let mut pending = vec![(schema, state)];
        while let Some((schema, state)) = pending.pop() {
            let known = &mut self.schemas[schema];
            let before = known.states.last().map(|interval| interval.value);
            if before == Some(state) {
                continue;
            }
            if let Some((ended, to)) = known.set_state(time, state)
                && self.keep.ended
            {
                let (state, from) = (ended.value, ended.from);
                self.ended.push(Span {
                    schema,
                    state,
                    from,
                    to,
                });
            }
            let about = &self.hierarchy.schemas()[schema];
            if let Some(group) = about.group.map(|group| &mut self.groups[group]) {
                if state == State::Winner {
                    group.winners.set(time, Some(schema));
                } else if group.winner() == Some(schema) {
                    group.winners.set(time, None);
                }
            }
            if before == Some(State::Winner) {
                let groups = about.groups.iter();
                let members = groups.flat_map(|group| &self.hierarchy.groups()[*group].members);
                let awake = members.filter(|member| self.schemas[**member].state() != State::Slept);
                pending.extend(awake.map(|member| (*member, State::Slept)));
            }
        }
    }
}
