//! The present state as pages get it, in JSON: made once, for all pages. Its words are those of the timeline, and of
//! `jde why`.

use std::time::Duration;

use jde_records::Decision;
use jde_records::snapshot::SchemaView;
use jde_timeline::{
    Ending, Item, OTHERS, Switch, case_word, health_reason, health_severity, health_word, state_word,
};
use jde_types::Mission;
use serde::Serialize;

use crate::log::severity_word;
use crate::model::{Model, Present};

/// After this silence the page says that nothing new arrives. An application sends 20 snapshots a second.
const SILENCE: Duration = Duration::from_secs(1);

#[derive(Serialize)]
struct State<'p> {
    t: &'static str,
    time_s: f64,
    /// How long the application has been silent, s; `None` while it is not.
    silent_s: Option<f64>,
    ending: Option<EndingView>,
    standstill: Option<&'p str>,
    stopped: Option<StoppedView<'p>>,
    acting: Vec<ActingView<'p>>,
    missions: Vec<MissionView>,
    rows: Vec<RowView<'p>>,
    driving: Vec<DrivingView>,
    /// The greatest speed of each schema that drives by hand, m/s; none until it is known.
    limits: Vec<(&'p str, Option<f64>)>,
    missed: u64,
}

#[derive(Serialize)]
struct EndingView {
    word: &'static str,
    reason: String,
    severity: &'static str,
}

#[derive(Serialize)]
struct StoppedView<'p> {
    by: &'p str,
    /// The roots that nobody keeps stopped.
    others: Vec<&'p str>,
}

/// Who acts, or that nobody does, and why.
#[derive(Serialize)]
struct ActingView<'p> {
    name: &'p str,
    group: &'p str,
    since_s: Option<f64>,
    before: Option<&'p str>,
    reason: &'p str,
    case: Option<String>,
    decided_by: Option<String>,
    cause: Option<&'p str>,
}

#[derive(Serialize)]
struct MissionView {
    name: String,
    word: &'static str,
    text: String,
    severity: &'static str,
}

#[derive(Default, Serialize)]
struct RowView<'p> {
    kind: &'static str,
    name: &'p str,
    depth: usize,
    /// The winner of a group, or the type of a schema.
    detail: &'p str,
    state: &'static str,
    health: &'static str,
    health_reason: Option<&'p str>,
    severity: &'static str,
    authority: bool,
    /// What operators hold it to.
    held: Option<String>,
    stopped: bool,
    load: f64,
}

/// Who drives by hand.
#[derive(Clone, Serialize)]
pub(crate) struct DrivingView {
    pub(crate) schema: String,
    pub(crate) by: String,
}

/// Returns the state of an application as a message to its pages. If it is the last one, an application that is gone
/// without a known end is lost: before, the record of its end may still be under way.
pub(crate) fn message(model: &Model, driving: Vec<DrivingView>, is_last: bool) -> String {
    let gone = is_last && !model.remote.is_alive();
    let present = model.present();
    let Present {
        timeline, snapshot, ..
    } = &*present;
    let known = timeline.ending().cloned();
    let ending = known.or_else(|| gone.then_some(Ending::Lost));
    let silent = present.updated.elapsed();
    let state = State {
        t: "state",
        time_s: timeline.now() as f64 / 1e9,
        silent_s: (silent > SILENCE && ending.is_none()).then_some(silent.as_secs_f64()),
        ending: ending.map(|ending| EndingView {
            word: ending.word(),
            reason: ending.reason().to_owned(),
            severity: severity_word(ending.severity()),
        }),
        standstill: snapshot.standstill.as_deref(),
        stopped: stopped(&present),
        acting: acting(&present),
        missions: present
            .missions
            .iter()
            .map(|(name, mission)| mission_view(name, mission))
            .collect(),
        rows: rows(&present),
        driving,
        limits: model
            .teleoperators()
            .map(|schema| (schema, present.max_speeds(schema).map(|limits| limits.fast)))
            .collect(),
        missed: timeline.missed(),
    };
    // Text and numbers always have a form in JSON.
    serde_json::to_string(&state).unwrap_or_default()
}

/// Who stopped everything, as far as that still holds.
fn stopped(present: &Present) -> Option<StoppedView<'_>> {
    let snapshot = &present.snapshot;
    let groups = snapshot.groups.iter().filter(|group| group.father.is_none());
    let members = groups.flat_map(|group| &group.members);
    let roots: Vec<&SchemaView> = members
        .filter_map(|member| snapshot.schemas.get(*member))
        .collect();
    let mut holds = roots.iter().flat_map(|root| root.holds());
    let by = holds.find(|hold| hold.with_everything)?.by.as_str();
    let others = roots.iter().filter(|root| root.stop().is_none());
    Some(StoppedView {
        by,
        others: others.map(|root| root.name.as_str()).collect(),
    })
}

/// Who acts. If nobody does, the last switch says why.
fn acting(present: &Present) -> Vec<ActingView<'_>> {
    let timeline = &present.timeline;
    let (schemas, groups) = (timeline.hierarchy().schemas(), timeline.hierarchy().groups());
    let acting = timeline.acting().into_iter().filter_map(|schema| {
        let group = schemas[schema].group?;
        let last = timeline.groups()[group].switches.back();
        let last = last.filter(|last| last.to == Some(schema));
        Some(view(present, &schemas[schema].name, &groups[group].name, last))
    });
    let mut acting: Vec<_> = acting.collect();
    if acting.is_empty()
        && let Some((group, last)) = timeline.newest_switches(1).pop()
    {
        let last = Some(last).filter(|last| last.to.is_none());
        acting.push(view(present, "nobody", &groups[group].name, last));
    }
    acting
}

fn view<'p>(present: &'p Present, name: &'p str, group: &'p str, last: Option<&'p Switch>) -> ActingView<'p> {
    let timeline = &present.timeline;
    let number = last.and_then(|last| last.number);
    let decision = number.and_then(|number| timeline.log().decisions().find(number));
    ActingView {
        name,
        group,
        since_s: last.map(Switch::time_s),
        before: last.map(|last| timeline.hierarchy().name(last.from)),
        reason: last.map_or("", |last| &last.reason),
        case: decision.map(|decision| format!("{}: {}", case_word(decision.case), decision.case_text())),
        decided_by: decision.map(Decision::decider_text),
        cause: decision.map(|decision| decision.cause.as_str()),
    }
}

fn mission_view(variable: &str, mission: &Mission) -> MissionView {
    let (word, severity) = match mission.state {
        Mission::DONE => ("done", "good"),
        Mission::FAILED => ("failed", "bad"),
        // Other numbers are of later versions.
        _ => ("under way", "plain"),
    };
    let mut parts = Vec::new();
    if mission.total > 0 {
        parts.push(format!(
            "{} of {} targets reached",
            mission.reached, mission.total
        ));
    }
    if mission.state == Mission::RUNNING && mission.distance > 0.0 {
        parts.push(format!("{:.1} m to the next one", mission.distance));
    }
    let note = mission.note.as_str();
    parts.extend((!note.is_empty()).then(|| note.to_owned()));
    let owner = variable.rsplit_once('.').map_or(variable, |(owner, _)| owner);
    MissionView {
        name: owner.to_owned(),
        word,
        text: parts.join("; "),
        severity,
    }
}

fn rows(present: &Present) -> Vec<RowView<'_>> {
    let Present {
        timeline, snapshot, ..
    } = present;
    let rows = timeline.hierarchy().rows();
    let rows = rows.iter().filter(|row| row.is_in(snapshot));
    rows.map(|row| {
        let depth = row.depth;
        match row.item {
            Item::Group(group) => {
                let group = &snapshot.groups[group];
                RowView {
                    kind: "group",
                    name: &group.name,
                    depth,
                    detail: snapshot.winner_name(group),
                    ..RowView::default()
                }
            }
            Item::Schema(schema, _) => schema_row(&snapshot.schemas[schema], depth),
            Item::Others => RowView {
                kind: "others",
                name: OTHERS,
                depth,
                ..RowView::default()
            },
        }
    })
    .collect()
}

fn schema_row(view: &SchemaView, depth: usize) -> RowView<'_> {
    RowView {
        kind: "schema",
        name: &view.name,
        depth,
        detail: &view.type_name,
        state: state_word(view),
        health: health_word(&view.health),
        health_reason: health_reason(&view.health),
        severity: severity_word(health_severity(&view.health)),
        authority: view.authority,
        held: view.held_by(),
        stopped: view.stop().is_some(),
        load: view.load,
    }
}

#[cfg(test)]
mod tests {
    use jde_types::Text;

    use super::*;

    #[test]
    fn a_mission_is_described_in_words() {
        let mut mission = Mission {
            reached: 2,
            total: 5,
            distance: 3.42,
            ..Mission::default()
        };
        let view = mission_view("example.mission", &mission);
        assert_eq!((view.name.as_str(), view.word), ("example", "under way"));
        assert_eq!(view.text, "2 of 5 targets reached; 3.4 m to the next one");
        (mission.state, mission.note) = (Mission::FAILED, Text::new("no way leads there"));
        let view = mission_view("example.mission", &mission);
        assert_eq!((view.word, view.severity), ("failed", "bad"));
        assert_eq!(view.text, "2 of 5 targets reached; no way leads there");
    }
}
