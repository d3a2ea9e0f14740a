//! What happened in a run: one model for all who show it, sum it up or judge it, whether the run goes on in this process,
//! goes on elsewhere, or is in a file.
//!
//! A [`Timeline`] is fed with events, records and snapshots. It gives the [`Hierarchy`] and its [rows](HierarchyRow), the
//! intervals of states and winners ([`Track`]), [switches](Switch), [marks](Mark), counts, the newest records, and who acts. A view
//! reads it and draws; it keeps no history of its own. What a timeline keeps is bounded as [`Keep`] says.
//!
//! A [`DriveTimeline`] is fed with values: the robots with their paths, the mission with its targets, and where schemas took
//! over. A [`Trace`] holds the newest values of a number.
//!
//! ```
//! use jde_core::State;
//! use jde_records::RunRecord;
//! use jde_records::event::StateChange;
//! use jde_timeline::{Hierarchy, Keep, Timeline};
//!
//! let mut timeline = Timeline::new(Hierarchy::default(), Keep::ALL);
//! let change = |time, from, to| RunRecord::State(StateChange { time, schema: "goon".to_owned(), from, to });
//! timeline.add(&change(2_000_000_000, State::Checking, State::Winner));
//! timeline.add(&change(5_000_000_000, State::Winner, State::Slept));
//!
//! let goon = timeline.schema("goon").expect("a record names it");
//! assert_eq!(goon.states.len(), 3, "CHECKING from the start, then WINNER, then SLEPT");
//! assert_eq!(goon.time_in(State::Winner, timeline.now()), 3_000_000_000);
//! ```

mod decimated;
mod drive;
mod ending;
mod hierarchy;
mod keep;
mod mark;
mod mission;
mod outline;
mod present;
mod record_log;
mod robot;
mod robot_sources;
mod rows;
mod schema;
mod timeline;
mod trace;
mod track;

pub use drive::{DriveTimeline, Takeover, Target};
pub use ending::{Ending, case_word};
pub use hierarchy::{Group, Hierarchy, SchemaEntry};
pub use keep::Keep;
pub use mark::{
    Mark, MarkKind, Severity, health_reason, health_severity, health_text, health_word, state_word,
};
pub use mission::MissionTimeline;
pub use outline::{outline, round};
pub use present::acting;
pub use record_log::{Decisions, LogLimits, RecordLog};
pub use robot::{PathPoint, RobotTimeline, is_placed};
pub use robot_sources::{Export, RobotSources};
pub use rows::{Children, HierarchyRow, Item, OTHERS};
pub use schema::{Counts, GroupCounts, GroupTimeline, SchemaTimeline, Switch};
pub use timeline::Timeline;
pub use trace::{Trace, range};
pub use track::{Interval, Span, Track};
