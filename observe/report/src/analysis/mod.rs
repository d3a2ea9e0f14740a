//! The analysis of a recording: the data of all pictures and pages, collected in one pass. Memory does not
//! depend on the length of the recording: times become columns, durations become histograms, and lists store
//! a bounded number of items and count the rest.

mod band;
mod bounded;
mod chatter;
mod columns;
mod drive;
mod durations;
mod events;
mod group_statistics;
mod reader;
mod timing;
mod trace;

use std::time::{Duration, UNIX_EPOCH};

use jde_core::Nanos;
use jde_log::{Damaged, LeftOut, ReadError, Recording, Survey, record};
use jde_records::Decision;
use jde_timeline::{Hierarchy, HierarchyRow, Item, Timeline};
use jde_types::Mission;

pub(crate) use band::Band;
pub(crate) use chatter::ChatterStatistics;
pub(crate) use columns::Columns;
pub(crate) use drive::DriveSummary;
pub(crate) use events::Events;
pub(crate) use group_statistics::GroupStatistics;
pub(crate) use timing::SchemaTiming;
pub(crate) use trace::{ColumnRange, Trace};
pub use trace::{Number, Series};

use bounded::Ends;
use reader::AnalysisReader;

/// Messages between two reports of progress.
const PROGRESS_INTERVAL: u64 = 2000;

/// What to analyse of a recording.
#[derive(Default)]
pub struct Wanted {
    /// Beginning, application time, ns; that of the recording if absent.
    pub from: Option<Nanos>,
    /// End, application time, ns; that of the recording if absent.
    pub to: Option<Nanos>,
    /// The number of columns into which the time is divided.
    pub columns: usize,
    /// Numbers to trace.
    pub series: Vec<Series>,
}

/// The analysis of a recording.
pub struct Analysis {
    /// The survey of the whole recording, independent of the analysed time.
    pub(crate) survey: Survey,
    /// The name of the application, or of the file.
    pub(crate) title: String,
    /// The analysed time, in the application's clock.
    pub(crate) columns: Columns,
    /// The same time in the columns of small charts.
    pub(crate) coarse: Columns,
    /// What happened; only its present is kept.
    pub(crate) timeline: Timeline,
    /// States by schema.
    pub(crate) bands: Vec<Band>,
    /// Timing by schema.
    pub(crate) timings: Vec<SchemaTiming>,
    /// The last configured period by schema, s.
    pub(crate) periods: Vec<Option<f64>>,
    /// Selections by group.
    pub(crate) groups: Vec<GroupStatistics>,
    /// Selections that changed a winner.
    pub(crate) switches: Ends<Decision>,
    /// Other events.
    pub(crate) events: Events,
    /// The robots' paths.
    pub(crate) ending: DriveSummary,
    /// The traced numbers.
    pub(crate) traces: Vec<(Series, Trace)>,
    /// Files, topics and messages that cannot be read.
    pub(crate) left_out: LeftOut,
    /// Whether turns were recorded, from which working times are known.
    pub(crate) has_turns: bool,
    /// Whether the application ran in virtual time; none if unknown.
    pub(crate) lockstep: Option<bool>,
}

impl Analysis {
    /// Reads a recording to its end or to damage. `progress` receives the share read so far, 0 to 1.
    ///
    /// # Errors
    /// The file cannot be read. Damage is no error.
    pub fn read(
        recording: &Recording,
        wanted: Wanted,
        progress: &mut dyn FnMut(f64),
    ) -> Result<Self, ReadError> {
        let mut reader = AnalysisReader::new(recording, wanted)?;
        for (number, message) in (0_u64..).zip(recording.messages()?) {
            match message {
                Ok(message) => {
                    let record = record::read(&message);
                    reader.analysis.survey.add(&message, record.as_ref());
                    if number % PROGRESS_INTERVAL == 0 {
                        progress(reader.share(message.log_time));
                    }
                    reader.message(&message, record);
                }
                Err(error) => reader.analysis.survey.end_with(error)?,
            }
        }
        Ok(reader.finish())
    }

    /// Whether there is nothing to draw: no path, no states and no numbers.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        !self.ending.drive.has_path()
            && !self.bands.iter().any(Band::was_awake)
            && self.traces.iter().all(|(_, trace)| trace.range().is_none())
    }

    /// The schemas and groups.
    pub(crate) fn hierarchy(&self) -> &Hierarchy {
        self.timeline.hierarchy()
    }

    /// The rows of all groups and schemas. Those of schemas that do not compete have no title.
    pub(crate) fn rows(&self) -> Vec<HierarchyRow> {
        let mut rows = self.hierarchy().rows();
        if let Some(title) = rows.iter().position(|row| row.item == Item::Others) {
            rows.remove(title);
            rows[title..].iter_mut().for_each(|row| row.depth -= 1);
        }
        rows
    }

    /// The wall-clock time of the beginning: "2026-11-21 18:03:13 UTC"; none without messages.
    pub(crate) fn begun(&self) -> Option<String> {
        let time = UNIX_EPOCH + Duration::from_nanos(self.survey.first_ns?);
        let text = humantime::format_rfc3339_seconds(time).to_string();
        Some(text.replace('T', " ").replace('Z', " UTC"))
    }

    /// Remarks on what of the recording is missing.
    pub(crate) fn remarks(&self) -> Vec<String> {
        let mut remarks = self.losses();
        remarks.extend(self.left_out.lines());
        remarks.extend(self.ending.remarks.iter().cloned());
        remarks
    }

    /// Describes damage, missing parts, lost values and gaps.
    #[must_use]
    pub fn losses(&self) -> Vec<String> {
        let mut remarks = Vec::new();
        let damage = self.survey.damage.as_ref();
        if damage.is_some_and(Damaged::is_unfinished) {
            remarks.push("the recording is still being written; only what it has so far is shown".to_owned());
        } else if let Some(damage) = damage {
            let place = damage.offset.map_or(String::new(), |offset| {
                format!(", at byte {offset} of {}", self.survey.bytes)
            });
            remarks.push(format!(
                "the recording ends too soon{place}: {}; only the part before is shown",
                damage.reason
            ));
        }
        let parts = self.survey.parts.as_ref();
        remarks
            .extend(parts.and_then(|parts| Some(format!("of the recording {}", parts.describe_missing()?))));
        let lost = self
            .survey
            .lost
            .values()
            .fold(0_u64, |all, lost| all.saturating_add(*lost));
        if lost > 0 {
            remarks.push(format!("{lost} values were lost while it was recorded"));
        }
        remarks.extend(self.survey.gaps.iter().map(ToString::to_string));
        remarks
    }

    /// The mission's progress; none if there is no mission.
    pub(crate) fn mission(&self) -> Option<&Mission> {
        self.ending.mission.as_ref()
    }
}
