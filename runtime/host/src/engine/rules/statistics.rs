//! What is kept for observers: the last switch of every group, worst takeovers (R17), and events that wait
//! for the next transaction.

use std::sync::atomic::AtomicBool;
use std::sync::atomic::Ordering::{Acquire, Relaxed, Release};

use jde_core::{GroupId, Hierarchy, Id, Nanos, Record, SchemaId, Table};
use jde_records::chattering::{self, ChatterDetector};
use jde_records::event::{Occurrence, What};
use jde_records::snapshot::Switch;
use parking_lot::Mutex;

/// What is kept of every group.
pub(crate) struct GroupStatistics {
    pub(crate) groups: Table<GroupId, GroupStatistic>,
    /// The groups that chatter.
    chattering: Vec<GroupId>,
}

#[derive(Clone, Default)]
pub(crate) struct GroupStatistic {
    pub(crate) switches: u64,
    pub(crate) worst: Nanos,
    /// Worst takeover that the contract allows (R17).
    pub(crate) allowed: Nanos,
    pub(crate) late: u64,
    pub(crate) last: Option<(u64, Switch)>,
    pub(crate) detector: ChatterDetector<[Option<SchemaId>; 2]>,
    /// When the group began to chatter, and its number of switches at that time.
    pub(crate) chattering_since: Option<(Nanos, u64)>,
}

impl GroupStatistics {
    pub(super) fn new(hierarchy: &Hierarchy) -> Self {
        Self {
            groups: hierarchy.spec().groups.map_ids(|group| GroupStatistic {
                allowed: hierarchy.allowed(group).unwrap_or_default(),
                ..GroupStatistic::default()
            }),
            chattering: Vec::new(),
        }
    }

    /// Recomputes the contract of a group from the periods and policies in force now.
    pub(super) fn update_contract(&mut self, hierarchy: &Hierarchy, group: GroupId) {
        self.groups[group].allowed = hierarchy.allowed(group).unwrap_or_default();
    }

    /// Records a selection. Returns a further event if the group begins to chatter.
    pub(super) fn record_decision(&mut self, record: &Record) -> Option<Occurrence> {
        if !record.changed {
            return None;
        }
        let id = record.group;
        let group = &mut self.groups[id];
        group.switches += 1;
        let switch = Switch {
            time: record.time,
            from: record.before.map(SchemaId::index),
            to: record.choice.map(SchemaId::index),
            decider: record.decider.into(),
            reason: record.reason.to_string(),
            latency: None,
        };
        group.last = Some((record.number, switch));
        let between = chattering::switched_pair(record)?;
        let switches = group.detector.record_switch(record.time, between)?;
        group.chattering_since = Some((record.time, group.switches));
        self.chattering.push(id);
        Some(
            What::ChatteringStarted {
                group: id,
                between: group.detector.dominant_pair().unwrap_or(between),
                switches,
            }
            .at(record.time),
        )
    }

    /// Whether any group chatters. Rarely true, and checked in every transaction.
    pub(super) fn is_any_chattering(&self) -> bool {
        !self.chattering.is_empty()
    }

    /// Advances the time. Returns an event for each group that has calmed down.
    pub(super) fn advance(&mut self, now: Nanos) -> Vec<Occurrence> {
        let groups = &mut self.groups;
        let calmed = self
            .chattering
            .extract_if(.., |id| groups[*id].detector.advance(now));
        let calmed: Vec<GroupId> = calmed.collect();
        let events = calmed.into_iter().filter_map(|id| {
            let group = &mut groups[id];
            let (since, before) = group.chattering_since.take()?;
            Some(
                What::ChatteringEnded {
                    group: id,
                    since,
                    switches: group.switches - before,
                }
                .at(now),
            )
        });
        events.collect()
    }

    pub(super) fn record_takeover(&mut self, group: GroupId, record: u64, latency: Nanos, late: bool) {
        let group = &mut self.groups[group];
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
    events: Mutex<Vec<Occurrence>>,
}

impl DeferredEvents {
    pub(super) fn push(&self, event: Occurrence) {
        self.events.lock().push(event);
        self.has_events.store(true, Release);
    }

    pub(super) fn is_empty(&self) -> bool {
        !self.has_events.load(Relaxed)
    }

    pub(super) fn take(&self) -> Vec<Occurrence> {
        if self.has_events.swap(false, Acquire) {
            std::mem::take(&mut *self.events.lock())
        } else {
            Vec::new()
        }
    }
}
