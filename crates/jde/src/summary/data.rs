//! What came of a run, as data: the object that `--json` prints and the words are made of.

use std::time::Duration;

use jde_host::Handle;
use jde_host::event::Outcome;
use serde::Serialize;

use crate::session::{Kept, Recorded};
use crate::terminal;

/// What came of a run. Times are in seconds unless a key says otherwise.
#[derive(Debug, Serialize)]
pub(crate) struct Summary {
    /// Name of the application.
    pub(crate) application: String,
    /// How it ended.
    pub(crate) outcome: Ending,
    /// The mission's own words, or why the application could not go on.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub(crate) note: String,
    /// Whether it has a mission that can be done, told of or not.
    #[serde(skip)]
    pub(crate) has_mission: bool,
    /// What the mission counts: "targets", or what it says itself.
    #[serde(skip)]
    pub(crate) counts: String,
    /// The seed.
    pub(crate) seed: u64,
    /// Targets of the mission, or whatever else it counts; 0 if it goes on for ever, none without one.
    pub(crate) targets: Option<u32>,
    /// Targets reached; none without a mission.
    pub(crate) reached: Option<u32>,
    /// Contacts with anything solid; none without ground truth.
    pub(crate) collisions: Option<u64>,
    /// The least gap to anything solid; none without ground truth.
    pub(crate) min_clearance_m: Option<f64>,
    /// How often a motor schema became WINNER.
    pub(crate) takeovers: u64,
    /// The longest time from the cause of a takeover to the winner's first iteration; none without takeovers.
    pub(crate) worst_takeover_us: Option<f64>,
    /// How long the application ran in its own time.
    pub(crate) sim_seconds: f64,
    /// How long it ran on this machine.
    pub(crate) wall_seconds: f64,
    /// SHA-256 of the decisions, a line of JSON each.
    pub(crate) decisions_sha256: String,
    /// What was recorded.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) recording: Option<Recorded>,
    /// What nobody took in time.
    #[serde(skip_serializing_if = "Unread::is_none")]
    pub(crate) unread: Unread,
    /// Who won how much.
    pub(crate) groups: Vec<GroupSummary>,
    /// How every schema did.
    pub(crate) schemas: Vec<SchemaSummary>,
}

/// What was told faster than it was taken: a robot waits for nobody who reads.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub(crate) struct Unread {
    /// Lines of standard output.
    pub(crate) output_lines: u64,
    /// Lines of the log.
    pub(crate) log_lines: u64,
    /// Decisions on their way to where `--decisions` says.
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
    /// Its mission is done.
    Done,
    /// Its mission failed.
    Failed,
    /// The time given to it was over.
    TimeUp,
    /// It was asked to stop.
    Stopped,
    /// It could not go on.
    Broken,
}

/// Who won how much of a group.
#[derive(Debug, Serialize)]
pub(crate) struct GroupSummary {
    /// Its name.
    pub(crate) group: String,
    /// Its members, in the father's order.
    pub(crate) winners: Vec<Share>,
    /// While its father was WINNER and nobody in it.
    pub(crate) nobody_seconds: f64,
    /// The longest takeover; none without any.
    pub(crate) worst_takeover_us: Option<f64>,
    /// The longest it may be by its contract (R17).
    pub(crate) allowed_takeover_us: f64,
}

/// How long a schema was WINNER.
#[derive(Debug, Serialize)]
pub(crate) struct Share {
    /// Its name.
    pub(crate) schema: String,
    /// How long.
    pub(crate) seconds: f64,
    /// Of the whole run, 0 to 1.
    pub(crate) share: f64,
    /// How often it became WINNER.
    pub(crate) takeovers: u64,
}

/// How a schema did.
#[derive(Debug, Serialize)]
pub(crate) struct SchemaSummary {
    /// Its name.
    pub(crate) schema: String,
    /// Iterations.
    pub(crate) iterations: u64,
    /// Deadlines missed and budgets passed.
    pub(crate) overruns: u64,
    /// Commands and wakes refused.
    pub(crate) refused: u64,
    /// Faults.
    pub(crate) faults: u64,
}

impl Summary {
    /// Sums up a run that has ended.
    pub(crate) fn new(
        handle: &Handle,
        kept: &Kept,
        outcome: &Outcome,
        wall: Duration,
        decisions_sha256: String,
        recording: Option<Recorded>,
    ) -> Self {
        let application = handle.application();
        let mission = kept.seen.mission.as_ref();
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
                Some(mission) if !mission.of_places => mission.note.clone(),
                Some(_) | None => "targets".to_owned(),
            },
            seed: application.seed,
            targets: mission.map(|mission| mission.total),
            reached: mission.map(|mission| mission.reached),
            collisions: kept.seen.collisions,
            min_clearance_m: kept.seen.min_clearance.filter(|clearance| clearance.is_finite()),
            takeovers: kept.tally.all_takeovers(),
            worst_takeover_us: worst,
            sim_seconds: seconds(kept.ended),
            wall_seconds: wall.as_secs_f64(),
            decisions_sha256,
            recording,
            unread: Unread {
                output_lines,
                log_lines,
                decisions: kept.unread,
                events: kept.missed,
            },
            groups,
            schemas: schemas
                .map(|schema| SchemaSummary {
                    schema: schema.name,
                    iterations: schema.iterations,
                    overruns: schema.overruns,
                    refused: schema.refused,
                    faults: schema.faults,
                })
                .collect(),
        }
    }

    /// Whether it came to what it was for: its mission is done, or it has none and came to no harm.
    pub(crate) fn is_fulfilled(&self) -> bool {
        match self.outcome {
            Ending::Done => true,
            Ending::TimeUp | Ending::Stopped => !self.has_mission,
            Ending::Failed | Ending::Broken => false,
        }
    }
}

fn group_summary(handle: &Handle, kept: &Kept, number: usize) -> GroupSummary {
    let application = handle.application();
    let group = &application.groups[number];
    let won = |schema: usize| kept.tally.won(schema, kept.ended);
    let open = group.father.map_or(kept.ended, won);
    let by_members: u64 = group.members.iter().map(|member| won(*member)).sum();
    GroupSummary {
        group: group.name.clone(),
        winners: group
            .members
            .iter()
            .map(|member| Share {
                schema: application.instances[*member].name.clone(),
                seconds: seconds(won(*member)),
                share: won(*member) as f64 / kept.ended.max(1) as f64,
                takeovers: kept.tally.takeovers(*member),
            })
            .collect(),
        nobody_seconds: seconds(open.saturating_sub(by_members)),
        worst_takeover_us: kept.tally.worst(number).map(|worst| worst as f64 / 1e3),
        allowed_takeover_us: handle.snapshot().groups[number].allowed as f64 / 1e3,
    }
}

fn seconds(nanos: u64) -> f64 {
    nanos as f64 / 1e9
}
