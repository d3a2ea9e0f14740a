//! Snapshots: all schemas and groups at one instant.

use std::sync::atomic::Ordering::Relaxed;

use jde_core::{GroupId, Id, SchemaId};
use jde_records::snapshot::{Chattering, GroupView, SchemaView, Snapshot};

use super::Engine;
use super::rules::RulesState;

impl Engine {
    /// A snapshot of all schemas and groups at this instant.
    pub(crate) fn snapshot(&self) -> Snapshot {
        self.rules.read(|rules| self.snapshot_of(rules))
    }

    fn snapshot_of(&self, rules: &RulesState) -> Snapshot {
        let schemas = self.application.instances.entries();
        let groups = self.application.groups.entries();
        Snapshot {
            time: self.clock.now(),
            schemas: schemas.map(|(id, _)| self.schema_view(rules, id)).collect(),
            groups: groups.map(|(id, _)| self.group_view(rules, id)).collect(),
            standstill: self.clock.standstill_reason(),
        }
    }

    fn schema_view(&self, rules: &RulesState, id: SchemaId) -> SchemaView {
        let instance = &self.application.instances[id];
        let meter = &self.metrics[id];
        let mut holds = self.operators.hold_views(&rules.hierarchy, id).into_iter();
        SchemaView {
            name: instance.name.clone(),
            type_name: format!(
                "{}/{}",
                self.application.plugins[instance.plugin].name, instance.schema.name
            ),
            kind: instance.schema.kind,
            father: instance.father.map(Id::index),
            group: instance.group.map(Id::index),
            state: rules.hierarchy.state(id),
            health: rules.hierarchy.health(id).clone(),
            authority: rules.hierarchy.has_authority(id),
            period: meter.period.load(Relaxed),
            measured: meter.mean_period(self.clock.now()),
            longest: meter.longest_iteration.load(Relaxed),
            slow_turns: meter.slow_turns.load(Relaxed),
            slowest_turn: meter.slowest_turn.load(Relaxed),
            load: meter.load(),
            iterations: meter.iterations.load(Relaxed),
            overruns: meter.overruns.load(Relaxed),
            refused: meter.refused.load(Relaxed),
            faults: meter.faults.load(Relaxed),
            triggers_dropped: meter.triggers_dropped.load(Relaxed),
            restarts_left: rules.hierarchy.restarts_left(self.clock.now(), id),
            left: meter.abandoned_calls.load(Relaxed),
            operator: holds.next(),
            more_holds: holds.collect(),
            panel: self.panels.has_panel(id),
            reload: self.builds.view(id),
            process: self.processes.pid(id),
        }
    }

    fn group_view(&self, rules: &RulesState, id: GroupId) -> GroupView {
        let group = &self.application.groups[id];
        let kept = &rules.groups.groups[id];
        let between = kept.detector.dominant_pair().unwrap_or_default();
        GroupView {
            name: group.name.clone(),
            father: group.father.map(Id::index),
            members: group.members.iter().map(|member| member.index()).collect(),
            winner: rules.hierarchy.winner(id).map(Id::index),
            policy: rules.hierarchy.spec().groups[id].policy.name().to_owned(),
            switches: kept.switches,
            last: kept.last.as_ref().map(|(_, switch)| switch.clone()),
            worst: kept.worst,
            allowed: kept.allowed,
            late: kept.late,
            chatter: kept.chattering_since.map(|(since, _)| Chattering {
                since,
                between: between.map(|schema| schema.map(Id::index)),
                switches: kept.detector.count(),
            }),
        }
    }
}
