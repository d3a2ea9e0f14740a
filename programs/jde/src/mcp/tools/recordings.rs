//! Tools that read recordings.

use std::path::{Path, PathBuf};

use jde_core::Nanos;
use jde_log::{Recording, record};
use jde_records::RunRecord;
use jde_report::Size;
use jde_session::record_text::{format_record, format_takeover};
use jde_terminal::escape::without_styles;
use schemars::JsonSchema;
use serde::Deserialize;
use serde_json::json;

use super::Call;
use crate::analysis::TimeRange;
use crate::cli::tools::client::why::Selections;
use crate::cli::tools::info::RecordingInfo;
use crate::cli::tools::{plot, report};
use crate::failure::{Failure, display_path};
use crate::mcp::answer::Answer;

/// The most lines of each list in a report: the last ones.
const MAX_LINES: usize = 300;
/// The picture's size, pixels: what models look at without making it smaller.
const PICTURE_SIZE: (u32, u32) = (1200, 800);

/// A recording.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct OfRecording {
    /// The recording: a file in the folder of this server.
    recording: String,
}

/// What to report on.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct Report {
    /// The recording: a file in the folder of this server.
    recording: String,
    /// Begin at this time of the application, s.
    from_s: Option<f64>,
    /// End at this time of the application, s.
    to_s: Option<f64>,
    /// Numbers to draw over time instead of the path: "pioneer.velocity.linear.x".
    #[serde(default)]
    numbers: Vec<String>,
    /// Whether to return the HTML page too, which is long.
    #[serde(default)]
    page: bool,
}

/// Returns the real path of a recording, all of whose files are in the folder.
pub(super) fn open(call: &Call<'_>, given: &str) -> Result<PathBuf, Failure> {
    let path = call.session.folder.resolve(given)?;
    let recording = Recording::open(&path)?;
    call.session.folder.check_all(recording.files())?;
    Ok(path)
}

pub(super) fn info(call: &Call<'_>, arguments: OfRecording) -> Result<Answer, Failure> {
    let path = open(call, &arguments.recording)?;
    Answer::new(&RecordingInfo::of(&Recording::open(&path)?)?)
}

pub(super) fn report(call: &Call<'_>, arguments: Report) -> Result<Answer, Failure> {
    let path = open(call, &arguments.recording)?;
    let recording = Recording::open(&path)?;
    let [from, to] = [arguments.from_s, arguments.to_s].map(|time| time.map(nanos).transpose());
    let (from, to) = (from?, to?);
    let range = TimeRange::new(from, to);
    let size = Size {
        width: PICTURE_SIZE.0,
        height: PICTURE_SIZE.1,
    };
    let (picture, _) = plot::picture(&recording, &arguments.numbers, range, size)?;
    let is_within = |time_s: f64| {
        arguments.from_s.is_none_or(|from| from <= time_s) && arguments.to_s.is_none_or(|to| time_s <= to)
    };
    let (takeovers, notes) = takeovers(&path, is_within)?;
    let events = events(&recording, is_within)?;
    let data = json!({
        "recording": display_path(&path),
        "takeovers": last(&takeovers),
        "events": last(&events),
        "left_out": {
            "takeovers": takeovers.len().saturating_sub(MAX_LINES),
            "events": events.len().saturating_sub(MAX_LINES),
        },
        "notes": notes,
    });
    let answer = Answer::new(&data)?.with_picture(picture);
    if !arguments.page {
        return Ok(answer);
    }
    Ok(answer.with_page(
        path.with_extension("html")
            .file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned(),
        report::page(&recording, range)?.0,
    ))
}

/// Returns the takeovers as lines, and what is damaged or missing. A recording of another program has none.
fn takeovers(path: &Path, is_within: impl Fn(f64) -> bool) -> Result<(Vec<String>, Vec<String>), Failure> {
    let selections = match Selections::of_recording(path) {
        Err(Failure::Run(_)) => return Ok(Default::default()),
        selections => selections?,
    };
    let changed = selections
        .decisions
        .iter()
        .filter(|decision| decision.changed && is_within(decision.time_s));
    let lines = changed.map(|decision| plain(&format_takeover(decision)));
    Ok((lines.collect(), selections.notes))
}

/// Returns the events as lines.
fn events(recording: &Recording, is_within: impl Fn(f64) -> bool) -> Result<Vec<String>, Failure> {
    let mut lines = Vec::new();
    for message in recording.messages()? {
        let record = record::read(&message?);
        if let Some(RunRecord::Other(event)) = &record
            && is_within(event.time_s())
        {
            lines.extend(record.as_ref().map(|record| plain(&format_record(record))));
        }
    }
    Ok(lines)
}

/// A line of a terminal as text alone.
fn plain(line: &str) -> String {
    without_styles(line).trim().to_owned()
}

fn last(lines: &[String]) -> &[String] {
    &lines[lines.len().saturating_sub(MAX_LINES)..]
}

fn nanos(seconds: f64) -> Result<Nanos, Failure> {
    match seconds {
        _ if (0.0..1e9).contains(&seconds) => Ok((seconds * 1e9) as Nanos),
        _ => Err(Failure::broken(format!(
            "{seconds} s is no time of an application"
        ))),
    }
}
