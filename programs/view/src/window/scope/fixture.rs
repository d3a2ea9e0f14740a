//! Artificial hierarchies with a constant past, without an application.

use jde_abi::describe::Kind;
use jde_core::{Case, Health, State};
use jde_link::message::{GroupInfo, SchemaInfo, Schemas, VariableInfo};
use jde_records::event::{OperatorAction, StateChange, What};
use jde_records::snapshot::{GroupView, Hold, HoldKind, SchemaView, Snapshot};
use jde_records::{CandidateRecord, DecidedBy, Decision, RunRecord};
use jde_timeline::{Hierarchy, Keep, Timeline};

use super::Scope;
use super::input::{Input, Request};
use crate::style::Style;

impl Scope {
    /// Draws the window as for a running application.
    pub(crate) fn show_fixed(
        &mut self,
        ui: &mut eframe::egui::Ui,
        fixed: &Fixed,
        variables: &[VariableInfo],
        style: &Style,
    ) -> Vec<Request> {
        self.draw(ui, &fixed.input(), variables, style)
    }
}

/// A hierarchy at one instant, and its past.
pub(crate) struct Fixed {
    pub(crate) snapshot: Snapshot,
    pub(crate) schemas: Schemas,
    pub(crate) timeline: Timeline,
}

impl Fixed {
    pub(super) fn input(&self) -> Input<'_> {
        Input {
            snapshot: &self.snapshot,
            schemas: &self.schemas,
            timeline: &self.timeline,
            end_s: self.snapshot.time as f64 / 1e9,
            gaps: &[],
            is_recording: false,
            accepts_requests: true,
        }
    }

    /// Creates a hierarchy from a snapshot, with an empty past.
    pub(crate) fn of(snapshot: Snapshot) -> Self {
        let name = |place: usize| snapshot.schemas[place].name.clone();
        let groups = snapshot.groups.iter().map(|group| GroupInfo {
            name: group.name.clone(),
            father: group.father.map(name),
            members: group.members.iter().map(|&member| name(member)).collect(),
            policy: group.policy.clone(),
        });
        let schemas = snapshot.schemas.iter().map(|schema| {
            let info = serde_json::json!({
                "name": schema.name, "type": schema.type_name, "doc": "", "father": null, "group": null,
                "kind": match schema.kind { Kind::Motor => "motor", Kind::Perceptive => "perceptive", Kind::Driver => "driver" },
                "period_s": schema.period as f64 / 1e9, "budget_s": 0.01, "children": [], "ports": [],
            });
            serde_json::from_value::<SchemaInfo>(info).expect("the description is valid")
        });
        Self {
            schemas: Schemas {
                schemas: schemas.collect(),
                groups: groups.collect(),
            },
            timeline: Timeline::new(Hierarchy::of_snapshot(&snapshot), Keep::LIVE),
            snapshot,
        }
    }

    /// Adds a change of a schema's state.
    pub(crate) fn change(&mut self, time_s: f64, schema: &str, from: State, to: State) {
        let change = StateChange {
            time: (time_s * 1e9) as u64,
            schema: schema.to_owned(),
            from,
            to,
        };
        self.timeline.add(&RunRecord::State(change));
    }
}

pub(crate) fn schema(name: &str, kind: Kind, father: Option<usize>, group: Option<usize>) -> SchemaView {
    SchemaView {
        name: name.to_owned(),
        type_name: format!("{name}/{name}"),
        kind,
        father,
        group,
        state: State::Checking,
        period: 75_000_000,
        measured: Some(75_020_000),
        longest: 310_000,
        load: 0.002,
        iterations: 130,
        panel: kind == Kind::Motor,
        ..SchemaView::default()
    }
}

pub(crate) fn group(name: &str, father: Option<usize>, members: &[usize]) -> GroupView {
    GroupView {
        name: name.to_owned(),
        father,
        members: members.to_vec(),
        winner: members.last().copied(),
        policy: "priority".to_owned(),
        switches: 3,
        worst: 1_240_000,
        allowed: 85_000_000,
        ..GroupView::default()
    }
}

/// Safe navigation after 10 s: goon, vff and stop have won in turn, and an operator holds `stop`.
pub(crate) fn navigation() -> Fixed {
    let mut schemas = vec![
        schema("pioneer", Kind::Driver, None, None),
        schema("teleop", Kind::Motor, None, Some(0)),
        schema("example", Kind::Motor, None, Some(0)),
        schema("goon", Kind::Motor, Some(2), Some(1)),
        schema("vff", Kind::Motor, Some(2), Some(1)),
        schema("stop", Kind::Motor, Some(2), Some(1)),
    ];
    for place in [0, 2, 5] {
        schemas[place].state = State::Winner;
        schemas[place].authority = place != 0;
    }
    schemas[0].measured = Some(50_000_000);
    schemas[0].load = 0.41;
    schemas[3].health = Health::Overrun;
    schemas[3].overruns = 2;
    schemas[4].state = State::Ready;
    schemas[5].operator = Some(Hold {
        kind: HoldKind::Forced,
        with_everything: false,
        leased: false,
        by: "ana@laptop".to_owned(),
    });
    schemas[5].period = 200_000_000;
    let snapshot = Snapshot {
        time: 10_000_000_000,
        schemas,
        groups: vec![
            group("roots", None, &[1, 2]),
            group("example/base", Some(2), &[3, 4, 5]),
        ],
        ..Snapshot::default()
    };
    let mut fixed = Fixed::of(snapshot);
    for (time, schema, from, to) in [
        (0.1, "pioneer", State::Slept, State::Winner),
        (0.1, "teleop", State::Slept, State::Checking),
        (0.1, "example", State::Slept, State::Winner),
        (0.2, "goon", State::Slept, State::Checking),
        (0.2, "vff", State::Slept, State::Checking),
        (0.2, "stop", State::Slept, State::Checking),
        (1.0, "goon", State::Checking, State::Winner),
        (4.0, "vff", State::Checking, State::Ready),
        (4.0, "goon", State::Winner, State::Ready),
        (4.0, "vff", State::Ready, State::Winner),
        (4.5, "goon", State::Ready, State::Checking),
        (8.0, "vff", State::Winner, State::Ready),
        (8.0, "stop", State::Ready, State::Winner),
    ] {
        fixed.change(time, schema, from, to);
    }
    for step in 0..12 {
        let time = 5.0 + f64::from(step) * 0.1;
        let (from, to) = if step % 2 == 0 {
            (State::Checking, State::Ready)
        } else {
            (State::Ready, State::Checking)
        };
        fixed.change(time, "goon", from, to);
    }
    let turns = [
        (0.1, "roots", None, "example", Case::Alone),
        (1.0, "example/base", None, "goon", Case::Alone),
        (4.0, "example/base", Some("goon"), "vff", Case::Collision),
        (8.0, "example/base", Some("vff"), "stop", Case::Forced),
    ];
    for (number, (time_s, group, before, choice, case)) in (1..).zip(turns) {
        let selection = selection(number, time_s, group, before, choice, case);
        fixed.timeline.add(&RunRecord::Decision(selection));
    }
    let overrun = What::Overrun {
        schema: "goon".to_owned(),
        took: 12_300_000,
        budget: 10_000_000,
    };
    let operator = What::Operator {
        by: "ana@laptop".to_owned(),
        action: OperatorAction::Force {
            schema: "stop".to_owned(),
        },
        losses: Vec::new(),
    };
    for event in [overrun.at(2_500_000_000), operator.at(8_000_000_000)] {
        fixed.timeline.add(&RunRecord::Other(event));
    }
    fixed.timeline.add_snapshot(&fixed.snapshot);
    fixed
}

pub(crate) fn selection(
    number: u64,
    time_s: f64,
    group: &str,
    before: Option<&str>,
    choice: &str,
    case: Case,
) -> Decision {
    let mut candidates = vec![CandidateRecord {
        name: choice.to_owned(),
        state: State::Ready,
        ready: true,
        urgency: Some(0.5),
    }];
    candidates.extend(before.map(|before| CandidateRecord {
        name: before.to_owned(),
        state: State::Winner,
        ready: case == Case::Collision,
        urgency: Some(0.25),
    }));
    Decision {
        number,
        time_s,
        group: group.to_owned(),
        case,
        candidates,
        before: before.map(str::to_owned),
        choice: Some(choice.to_owned()),
        decider: match case {
            Case::Forced => DecidedBy::Operator,
            Case::Collision => DecidedBy::Policy("priority".to_owned()),
            Case::Alone | Case::Absence => DecidedBy::Nobody,
        },
        reason: format!("{choice} is the only one that is ready"),
        cause: format!("the readiness of {choice} changed"),
        changed: true,
        takeover_us: Some(1240.0),
        refused: Vec::new(),
    }
}
