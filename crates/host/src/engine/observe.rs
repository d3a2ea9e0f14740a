//! What is kept for observers: the last switch of every group, worst takeovers (R17), and snapshots.

use std::sync::atomic::AtomicBool;
use std::sync::atomic::Ordering::{Acquire, Relaxed, Release};
use std::sync::{Mutex, MutexGuard, PoisonError};

use jde_core::{GroupId, Hierarchy, Nanos, Record, SchemaId};
use jde_records::chattering::{self, ChatterDetector};
use jde_records::event::{Event, OperatorAction};
use jde_records::snapshot::{Chattering, GroupView, SchemaView, Snapshot, Switch};

use super::{Engine, RulesState, schema};

/// What is kept of every group.
pub(crate) struct GroupStatistics {
    groups: Vec<GroupStatistic>,
    /// The groups that chatter.
    chattering: Vec<usize>,
}

#[derive(Clone, Default)]
struct GroupStatistic {
    switches: u64,
    worst: Nanos,
    /// Worst takeover that the contract allows (R17).
    allowed: Nanos,
    late: u64,
    last: Option<(u64, Switch)>,
    detector: ChatterDetector<[Option<usize>; 2]>,
    /// When the group began to chatter, and its number of switches at that time.
    chattering_since: Option<(Nanos, u64)>,
}

impl GroupStatistics {
    pub(super) fn new(count: usize, hierarchy: &Hierarchy) -> Self {
        let mut groups = Self {
            groups: vec![GroupStatistic::default(); count],
            chattering: Vec::new(),
        };
        for group in 0..count {
            groups.update_contract(hierarchy, GroupId(group as u32));
        }
        groups
    }

    /// Recomputes the contract of a group from the periods and policies in force now.
    pub(super) fn update_contract(&mut self, hierarchy: &Hierarchy, group: GroupId) {
        self.groups[group.index()].allowed = hierarchy.allowed(group).unwrap_or_default();
    }

    /// Records a selection. Returns a further event if the group begins to chatter.
    pub(super) fn record_decision(&mut self, record: &Record) -> Option<Event> {
        if !record.changed {
            return None;
        }
        let number = record.group.index();
        let group = &mut self.groups[number];
        group.switches += 1;
        let switch = Switch {
            time: record.time,
            from: record.before.map(SchemaId::index),
            to: record.choice.map(SchemaId::index),
            decider: record.decider.name().to_owned(),
            reason: record.reason.to_string(),
            latency: None,
        };
        group.last = Some((record.number, switch));
        let between = chattering::switched_pair(record)?;
        let switches = group.detector.record_switch(record.time, between)?;
        group.chattering_since = Some((record.time, group.switches));
        self.chattering.push(number);
        Some(Event::ChatteringStarted {
            time: record.time,
            group: number,
            between: group.detector.dominant_pair().unwrap_or(between),
            switches,
        })
    }

    /// Whether any group chatters. Rarely true, and checked in every transaction.
    pub(super) fn is_any_chattering(&self) -> bool {
        !self.chattering.is_empty()
    }

    /// Advances the time. Returns an event for each group that has calmed down.
    pub(super) fn advance(&mut self, now: Nanos) -> Vec<Event> {
        let groups = &mut self.groups;
        let calmed = self
            .chattering
            .extract_if(.., |number| groups[*number].detector.advance(now));
        let calmed: Vec<usize> = calmed.collect();
        let told = calmed.into_iter().filter_map(|number| {
            let group = &mut groups[number];
            let (since, before) = group.chattering_since.take()?;
            Some(Event::ChatteringEnded {
                time: now,
                group: number,
                since,
                switches: group.switches - before,
            })
        });
        told.collect()
    }

    fn record_takeover(&mut self, group: GroupId, record: u64, latency: Nanos, late: bool) {
        let group = &mut self.groups[group.index()];
        group.worst = group.worst.max(latency);
        group.late += u64::from(late);
        if let Some((_, switch)) = group.last.as_mut().filter(|(number, _)| *number == record) {
            switch.latency = Some(latency);
        }
    }
}

/// Events that the next transaction reports.
#[derive(Default)]
pub(super) struct DeferredEvents {
    /// Whether there are any; checked in every transaction.
    has_events: AtomicBool,
    events: Mutex<Vec<Event>>,
}

impl DeferredEvents {
    fn push(&self, event: Event) {
        self.lock().push(event);
        self.has_events.store(true, Release);
    }

    pub(super) fn is_empty(&self) -> bool {
        !self.has_events.load(Relaxed)
    }

    pub(super) fn take(&self) -> Vec<Event> {
        if self.has_events.swap(false, Acquire) {
            std::mem::take(&mut *self.lock())
        } else {
            Vec::new()
        }
    }

    fn lock(&self) -> MutexGuard<'_, Vec<Event>> {
        self.events.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Engine {
    pub(super) fn report_takeover(
        &self,
        rules: &mut RulesState,
        now: Nanos,
        group: GroupId,
        record: u64,
        id: SchemaId,
        latency: Nanos,
    ) {
        let allowed = rules.groups.groups[group.index()].allowed;
        // In a replay, lateness was reported when it first happened.
        let late = latency > allowed && !self.clock.is_replayed();
        rules.groups.record_takeover(group, record, latency, late);
        if late {
            tracing::warn!(
                group = self.application.groups[group.index()].name,
                winner = self.name(id.index()),
                "took over in {:.1} ms, and its contract allows {:.1} ms",
                latency as f64 / 1e6,
                allowed as f64 / 1e6
            );
        }
        let event = Event::TookOver {
            time: now,
            group: group.index(),
            record,
            schema: id.index(),
            latency,
            allowed,
        };
        self.notify_observers(rules, &event);
        if late {
            let event = Event::TookOverLate {
                time: now,
                group: group.index(),
                record,
                schema: id.index(),
                latency,
                allowed,
            };
            self.notify_observers(rules, &event);
        }
    }

    /// Reports an operator's action to the observers.
    pub(super) fn report_operation(&self, by: &str, action: OperatorAction) {
        let mut rules = self.lock();
        let event = Event::Operator {
            time: self.clock.now(),
            by: by.to_owned(),
            action,
        };
        self.notify_observers(&mut rules, &event);
    }

    /// Reports an event to the observers, outside a transaction.
    pub(crate) fn report(&self, event: &Event) {
        let mut rules = self.lock();
        self.notify_observers(&mut rules, event);
    }

    /// Leaves an event for the next transaction to report. For publications, which do not take the rules'
    /// lock.
    pub(crate) fn report_later(&self, event: Event) {
        self.deferred_events.push(event);
    }

    /// A snapshot of all schemas and groups at this instant.
    pub(crate) fn snapshot(&self) -> Snapshot {
        let rules = self.lock();
        let schemas = self.application.instances.iter().enumerate();
        let groups = self.application.groups.iter().enumerate();
        Snapshot {
            time: self.clock.now(),
            schemas: schemas
                .map(|(number, _)| self.schema_view(&rules, number))
                .collect(),
            groups: groups
                .map(|(number, _)| self.group_view(&rules, number))
                .collect(),
        }
    }

    fn schema_view(&self, rules: &RulesState, number: usize) -> SchemaView {
        let instance = &self.application.instances[number];
        let meter = &self.metrics[number];
        SchemaView {
            name: instance.name.clone(),
            type_name: format!(
                "{}/{}",
                self.application.plugins[instance.plugin].name, instance.schema.name
            ),
            kind: instance.schema.kind,
            father: instance.father,
            group: instance.group,
            state: rules.hierarchy.state(schema(number)),
            health: rules.hierarchy.health(schema(number)).clone(),
            authority: rules.hierarchy.has_authority(schema(number)),
            period: meter.period.load(Relaxed),
            measured: meter.mean_period(),
            longest: meter.longest_iteration.load(Relaxed),
            load: meter.load(),
            iterations: meter.iterations.load(Relaxed),
            overruns: meter.overruns.load(Relaxed),
            refused: meter.refused.load(Relaxed),
            faults: meter.faults.load(Relaxed),
            restarts_left: rules.hierarchy.restarts_left(self.clock.now(), schema(number)),
            left: meter.abandoned_calls.load(Relaxed),
            operator: self.hold_view(&rules.hierarchy, number),
            panel: self.panels.has_panel(number),
            reload: self.builds.view(number),
            process: self.processes.pid(number),
        }
    }

    fn group_view(&self, rules: &RulesState, number: usize) -> GroupView {
        let group = &self.application.groups[number];
        let kept = &rules.groups.groups[number];
        let id = GroupId(number as u32);
        GroupView {
            name: group.name.clone(),
            father: group.father,
            members: group.members.clone(),
            winner: rules.hierarchy.winner(id).map(SchemaId::index),
            policy: rules.hierarchy.spec().groups[number].policy.name().to_owned(),
            switches: kept.switches,
            last: kept.last.as_ref().map(|(_, switch)| switch.clone()),
            worst: kept.worst,
            allowed: kept.allowed,
            late: kept.late,
            chatter: kept.chattering_since.map(|(since, _)| Chattering {
                since,
                between: kept.detector.dominant_pair().unwrap_or_default(),
                switches: kept.detector.count(),
            }),
        }
    }
}
