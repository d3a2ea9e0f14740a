//! The result of a run as data: the object that `--json` prints, and the source of the summary as text.

use std::io;
use std::path::Path;
use std::time::Duration;

use jde_host::Handle;
use jde_records::event::Outcome;
use serde::Serialize;

use crate::failure::display_path;
use crate::session::{RecordingSummary, RunData};
use crate::terminal;

/// The result of a run. Times are in seconds unless a key names another unit.
#[derive(Debug, Serialize)]
pub(crate) struct RunSummary {
    /// The name of the application.
    pub(crate) application: String,
    /// How the run ended.
    pub(crate) outcome: Ending,
    /// The mission's own text, or the reason why the application could not continue.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub(crate) note: String,
    /// Whether the application has a mission that can be completed. True also if the mission has published no
    /// progress.
    #[serde(skip)]
    pub(crate) has_mission: bool,
    /// What the mission counts: "targets", or its own text.
    #[serde(skip)]
    pub(crate) counts: String,
    /// The seed.
    pub(crate) seed: u64,
    /// Targets of the mission, or whatever else it counts; 0 for a mission without end, `None` without a
    /// mission.
    pub(crate) targets: Option<u32>,
    /// Targets reached; `None` without a mission.
    pub(crate) reached: Option<u32>,
    /// Contacts with obstacles; `None` without ground truth.
    pub(crate) collisions: Option<u64>,
    /// The least distance to an obstacle; `None` without ground truth.
    pub(crate) min_clearance_m: Option<f64>,
    /// How often a motor schema became WINNER.
    pub(crate) takeovers: u64,
    /// The longest time from the cause of a takeover to the winner's first iteration; `None` without
    /// takeovers.
    pub(crate) worst_takeover_us: Option<f64>,
    /// The length of the run in application time.
    pub(crate) sim_seconds: f64,
    /// The length of the run on this machine's clock.
    pub(crate) wall_seconds: f64,
    /// SHA-256 of the decisions, one line of JSON each.
    pub(crate) decisions_sha256: String,
    /// The recording.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) recording: Option<RecordingSummary>,
    /// The files that are missing or not complete, and why.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(crate) unwritten: Vec<String>,
    /// Output that was not read in time.
    #[serde(skip_serializing_if = "Unread::is_none")]
    pub(crate) unread: Unread,
    /// The shares of time that schemas won, by group.
    pub(crate) groups: Vec<GroupSummary>,
    /// The counters of each schema.
    pub(crate) schemas: Vec<SchemaSummary>,
}

/// Output that was dropped because its reader was too slow: a robot never waits for a reader.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub(crate) struct Unread {
    /// Lines of standard output.
    pub(crate) output_lines: u64,
    /// Lines of the log.
    pub(crate) log_lines: u64,
    /// Decisions for the file of `--decisions`.
    pub(crate) decisions: u64,
    /// Events that are missing in this summary.
    pub(crate) events: u64,
}

impl Unread {
    fn is_none(&self) -> bool {
        *self == Self::default()
    }
}

/// How a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Ending {
    /// The mission is done.
    Done,
    /// The mission failed.
    Failed,
    /// The time limit was reached.
    TimeUp,
    /// The run was asked to stop.
    Stopped,
    /// The application could not continue.
    Broken,
}

/// The shares of time that the members of a group won.
#[derive(Debug, Serialize)]
pub(crate) struct GroupSummary {
    /// The name of the group.
    pub(crate) group: String,
    /// The members, in the father's order.
    pub(crate) winners: Vec<Share>,
    /// Time without a winner while the father was WINNER; for the roots, during the whole run.
    pub(crate) nobody_seconds: f64,
    /// The longest takeover; `None` without takeovers.
    pub(crate) worst_takeover_us: Option<f64>,
    /// The longest takeover that the contract allows (R17).
    pub(crate) allowed_takeover_us: f64,
    /// The takeovers that took longer, and not because of the machine (R17).
    pub(crate) late_takeovers: u64,
}

/// How long a schema was WINNER.
#[derive(Debug, Serialize)]
pub(crate) struct Share {
    /// The name of the schema.
    pub(crate) schema: String,
    /// Time as WINNER.
    pub(crate) seconds: f64,
    /// The share of the whole run, 0 to 1.
    pub(crate) share: f64,
    /// How often it became WINNER.
    pub(crate) takeovers: u64,
}

/// The counters of a schema.
#[derive(Debug, Serialize)]
pub(crate) struct SchemaSummary {
    /// The name of the schema.
    pub(crate) schema: String,
    /// Iterations.
    pub(crate) iterations: u64,
    /// Missed deadlines and exceeded budgets.
    pub(crate) overruns: u64,
    /// Refused commands and wakes.
    pub(crate) refused: u64,
    /// What was refused, and why: the first different ones.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(crate) refusals: Vec<String>,
    /// Triggers that were dropped or had to rest.
    pub(crate) triggers_dropped: u64,
    /// Faults.
    pub(crate) faults: u64,
}

impl RunSummary {
    /// Sums up a run that has ended.
    pub(crate) fn new(
        handle: &Handle,
        kept: &RunData,
        outcome: &Outcome,
        wall: Duration,
        decisions_sha256: String,
        recording: Option<RecordingSummary>,
    ) -> Self {
        let application = handle.application();
        let mission = kept.observation.mission.as_ref();
        let groups: Vec<_> = (0..application.groups.len())
            .map(|group| group_summary(handle, kept, group))
            .collect();
        let note = match outcome {
            Outcome::Broken(reason) => reason.clone(),
            Outcome::Done | Outcome::Failed | Outcome::TimeUp | Outcome::Stopped => {
                mission.map_or(String::new(), |mission| mission.note.clone())
            }
        };
        let worst = groups
            .iter()
            .filter_map(|group| group.worst_takeover_us)
            .reduce(f64::max);
        let schemas = handle.snapshot().schemas.into_iter();
        let [output_lines, log_lines] = terminal::lost();
        Self {
            application: application.name.clone(),
            outcome: match outcome {
                Outcome::Done => Ending::Done,
                Outcome::Failed => Ending::Failed,
                Outcome::TimeUp => Ending::TimeUp,
                Outcome::Stopped => Ending::Stopped,
                Outcome::Broken(_) => Ending::Broken,
            },
            note,
            has_mission: application.mission.is_some() && mission.is_none_or(|mission| mission.total > 0),
            counts: match mission {
                Some(mission) if !mission.counts_positions => mission.note.clone(),
                Some(_) | None => "targets".to_owned(),
            },
            seed: application.seed,
            targets: mission.map(|mission| mission.total),
            reached: mission.map(|mission| mission.reached),
            collisions: kept.observation.collisions,
            min_clearance_m: kept
                .observation
                .min_clearance
                .filter(|clearance| clearance.is_finite()),
            takeovers: kept.statistics.total_takeovers(),
            worst_takeover_us: worst,
            sim_seconds: seconds(kept.end_time),
            wall_seconds: wall.as_secs_f64(),
            decisions_sha256,
            recording,
            unwritten: Vec::new(),
            unread: Unread {
                output_lines,
                log_lines,
                decisions: kept.unread,
                events: kept.missed,
            },
            groups,
            schemas: schemas
                .enumerate()
                .map(|(number, schema)| SchemaSummary {
                    refusals: kept.statistics.refusals(number).to_vec(),
                    schema: schema.name,
                    iterations: schema.iterations,
                    overruns: schema.overruns,
                    refused: schema.refused,
                    triggers_dropped: schema.triggers_dropped,
                    faults: schema.faults,
                })
                .collect(),
        }
    }

    /// Adds a file that is not complete.
    pub(crate) fn add_unwritten(&mut self, file: &Path, error: &io::Error) {
        self.unwritten
            .push(format!("{} is not complete: {error}", display_path(file)));
    }

    /// How many takeovers took longer than their contracts permit (R17).
    pub(crate) fn late_takeovers(&self) -> u64 {
        self.groups.iter().map(|group| group.late_takeovers).sum()
    }

    /// Whether the run was asked to end.
    pub(crate) fn was_stopped(&self) -> bool {
        self.outcome == Ending::Stopped
    }

    /// Whether the run achieved its purpose: its mission is done, or it has none and neither failed nor
    /// broke.
    pub(crate) fn is_fulfilled(&self) -> bool {
        match self.outcome {
            Ending::Done => true,
            Ending::TimeUp | Ending::Stopped => !self.has_mission,
            Ending::Failed | Ending::Broken => false,
        }
    }
}

fn group_summary(handle: &Handle, kept: &RunData, number: usize) -> GroupSummary {
    let application = handle.application();
    let group = &application.groups[number];
    let won = |schema: usize| kept.statistics.winner_time(schema, kept.end_time);
    let open = group.father.map_or(kept.end_time, won);
    let by_members: u64 = group.members.iter().map(|member| won(*member)).sum();
    GroupSummary {
        group: group.name.clone(),
        winners: group
            .members
            .iter()
            .map(|member| Share {
                schema: application.instances[*member].name.clone(),
                seconds: seconds(won(*member)),
                share: won(*member) as f64 / kept.end_time.max(1) as f64,
                takeovers: kept.statistics.takeovers(*member),
            })
            .collect(),
        nobody_seconds: seconds(open.saturating_sub(by_members)),
        worst_takeover_us: kept.statistics.worst(number).map(|worst| worst as f64 / 1e3),
        allowed_takeover_us: handle.snapshot().groups[number].allowed as f64 / 1e3,
        late_takeovers: kept.statistics.late(number),
    }
}

fn seconds(nanos: u64) -> f64 {
    nanos as f64 / 1e9
}
