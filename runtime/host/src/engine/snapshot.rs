//! Snapshots: all schemas and groups at one instant.

use std::sync::atomic::Ordering::Relaxed;

use jde_core::{GroupId, SchemaId};
use jde_records::snapshot::{Chattering, GroupView, SchemaView, Snapshot};

use super::rules::RulesState;
use super::{Engine, schema};

impl Engine {
    /// A snapshot of all schemas and groups at this instant.
    pub(crate) fn snapshot(&self) -> Snapshot {
        self.rules.read(|rules| self.snapshot_of(rules))
    }

    fn snapshot_of(&self, rules: &RulesState) -> Snapshot {
        let schemas = self.application.instances.iter().enumerate();
        let groups = self.application.groups.iter().enumerate();
        Snapshot {
            time: self.clock.now(),
            schemas: schemas
                .map(|(number, _)| self.schema_view(rules, number))
                .collect(),
            groups: groups.map(|(number, _)| self.group_view(rules, number)).collect(),
            standstill: self.clock.standstill_reason(),
        }
    }

    fn schema_view(&self, rules: &RulesState, number: usize) -> SchemaView {
        let instance = &self.application.instances[number];
        let meter = &self.metrics[number];
        let mut holds = self.operators.hold_views(&rules.hierarchy, number).into_iter();
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
            triggers_dropped: meter.triggers_dropped.load(Relaxed),
            restarts_left: rules.hierarchy.restarts_left(self.clock.now(), schema(number)),
            left: meter.abandoned_calls.load(Relaxed),
            operator: holds.next(),
            more_holds: holds.collect(),
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
