//! `jde info`: prints an overview of a recording.

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, UNIX_EPOCH};

use clap::{Args, ValueHint};
use jde_drawing::text::{counted, format_size};
use jde_log::{Recording, SchemaProblems, Survey, TopicSurvey};
use jde_session::cli::print_value;
use jde_terminal::escape::escape;
use jde_terminal::{BAD, FAINT, TITLE, WARN};
use serde::Serialize;

use crate::failure::{Failure, display_path};
use crate::remote::table::{Alignment, Cell, Table};

/// The longest time, in ns, between the application's start and the first message of a recording that counts
/// as complete from the start.
const LATE_START_NS: u64 = 100_000_000;

/// The most topics that are shown.
const MAX_LINES: usize = 1000;
/// The most files of a recording that are listed by name.
const MAX_LISTED: usize = 6;

/// Print an overview of a recording: application, time, topics, decisions of each group, and faults.
///
/// Reads the whole file, of any MCAP writer, or a bag of ROS 2 in MCAP or SQLite. A damaged file is read up to the damage,
/// which is reported, and what cannot be read is named. Any
/// part of a recording in parts (`--split`), or a folder that contains only these parts, stands for the whole
/// recording; this is true of every verb that reads recordings.
#[derive(Args)]
#[command(after_help = "Examples:
  jde info drive.mcap
  jde info drive.mcap --json | jq '.topics[].topic'")]
pub(crate) struct Info {
    /// The recording.
    #[arg(value_name = "FILE", value_hint = ValueHint::FilePath)]
    file: PathBuf,
    /// Print one line of JSON.
    #[arg(long)]
    json: bool,
}

/// What a recording contains, as the object that `--json` prints.
#[derive(Serialize)]
pub(crate) struct RecordingInfo {
    file: String,
    seconds: f64,
    #[serde(flatten)]
    survey: Survey,
}

impl Info {
    pub(super) fn run(self) -> Result<(), Failure> {
        let info = RecordingInfo::of(&Recording::open(&self.file)?)?;
        Ok(print_value(self.json, &info, |info, out| {
            write(&info.file, &info.survey, out)
        })?)
    }
}

impl RecordingInfo {
    /// Reads the whole recording, up to its damage if it has any.
    ///
    /// # Errors
    /// It cannot be read.
    pub(crate) fn of(recording: &Recording) -> Result<Self, Failure> {
        let survey = Survey::of(recording)?;
        Ok(Self {
            file: display_path(recording.path()),
            seconds: survey.seconds(),
            survey,
        })
    }
}

fn write(file: &str, survey: &Survey, out: &mut dyn Write) -> io::Result<()> {
    write_headline(file, survey, out)?;
    if let Some(parts) = &survey.parts {
        writeln!(
            out,
            "in {}: {}",
            counted(parts.files.len() as u64, "file"),
            format_files(&parts.files)
        )?;
        if let Some(missing) = parts.describe_missing() {
            writeln!(out, "{WARN}{missing}{WARN:#}")?;
        }
    }
    for cause in &survey.triggers {
        writeln!(out, "{} at {:.3} s", cause.reason, cause.time_s)?;
    }
    if let Some(damage) = &survey.damage {
        let until = match seconds_since_start(survey, survey.last_ns) {
            Some(seconds) => format!("up to {seconds:.3} s"),
            None => "up to there, which contains no messages".to_owned(),
        };
        if damage.is_unfinished() {
            writeln!(out, "{WARN}still being written{WARN:#}: it can be read {until}")?;
        } else {
            write!(out, "{BAD}damaged")?;
            if let Some(offset) = damage.offset {
                write!(out, " at byte {offset}")?;
                if survey.parts.is_none() {
                    write!(out, " of {}", survey.bytes)?;
                }
            }
            writeln!(out, "{BAD:#}: {}; it can be read {until}", damage.reason)?;
        }
    }
    let lost = survey
        .lost
        .values()
        .fold(0_u64, |all, lost| all.saturating_add(*lost));
    if lost > 0 {
        let all = lost.saturating_add(survey.messages);
        writeln!(out, "{WARN}{lost} lost{WARN:#} of {all} while it was recorded")?;
    }
    for gap in &survey.gaps {
        writeln!(out, "{WARN}gap{WARN:#}: {gap}")?;
    }
    if !survey.topics.is_empty() {
        writeln!(out)?;
        topic_table(survey).write(out)?;
        write_more(survey.topics.len(), "topics", out)?;
    }
    if !survey.left_out.is_empty() {
        writeln!(out)?;
    }
    for line in &survey.left_out {
        writeln!(out, "{WARN}{}{WARN:#}", escape(line))?;
    }
    if survey.decisions > 0 {
        writeln!(out, "\n{}", counted(survey.decisions, "decision"))?;
        for group in &survey.groups {
            let switches = counted(group.switches, "switch");
            let (name, decisions) = (&group.group, group.decisions);
            writeln!(out, "  {TITLE}{name}{TITLE:#}: {decisions}, {switches}")?;
        }
    }
    if !survey.troubled.is_empty() {
        writeln!(out)?;
    }
    for schema in &survey.troubled {
        write_problems(schema, out)?;
    }
    for (topic, lost) in survey.lost.iter().take(MAX_LINES) {
        writeln!(out, "{WARN}{lost} lost{WARN:#} of {}", escape(topic))?;
    }
    write_more(survey.lost.len(), "topics with lost values", out)
}

/// Writes how many things of a list are not shown.
fn write_more(count: usize, what: &str, out: &mut dyn Write) -> io::Result<()> {
    match count.saturating_sub(MAX_LINES) {
        0 => Ok(()),
        more => writeln!(out, "and {more} more {what}, which --json shows"),
    }
}

fn write_headline(file: &str, survey: &Survey, out: &mut dyn Write) -> io::Result<()> {
    write!(out, "{TITLE}{file}{TITLE:#}: ")?;
    if let Some(application) = &survey.application {
        write!(out, "{application}, ")?;
    }
    write!(out, "{:.1} s", survey.seconds())?;
    if let Some(first) = survey.first_ns {
        let time = UNIX_EPOCH + Duration::from_nanos(first);
        write!(out, " from {}", humantime::format_rfc3339_seconds(time))?;
    }
    // A recording that starts with the application needs no note.
    if let Some(start) = survey.application_start_ns
        && let Some(late) = survey.first_ns.map(|first| first.saturating_sub(start))
        && late >= LATE_START_NS
    {
        write!(out, ", {:.1} s after its start", late as f64 / 1e9)?;
    }
    writeln!(out)?;
    write!(
        out,
        "{}, {}",
        counted(survey.messages, "message"),
        format_size(survey.bytes)
    )?;
    if let Some(seed) = survey.seed {
        write!(out, ", seed {seed}")?;
    }
    if let Some(jde) = &survey.jde {
        write!(out, ", by jde {jde}")?;
    }
    for name in &survey.attachments {
        write!(out, ", with {name}")?;
    }
    writeln!(out)
}

/// The names of the files, or the first and the last if there are more than [`MAX_LISTED`].
fn format_files(files: &[String]) -> String {
    let files: Vec<_> = files.iter().map(|file| display_path(Path::new(file))).collect();
    match files.as_slice() {
        [first, .., last] if files.len() > MAX_LISTED => format!("{first} to {last}"),
        files => files.join(", "),
    }
}

fn topic_table(survey: &Survey) -> Table {
    let mut table = Table::new([
        ("topic", Alignment::Left),
        ("type", Alignment::Left),
        ("messages", Alignment::Right),
        ("rate", Alignment::Right),
        ("size", Alignment::Right),
    ]);
    for TopicSurvey {
        topic,
        type_name,
        messages,
        bytes,
        rate_hz,
        ..
    } in survey.topics.iter().take(MAX_LINES)
    {
        table.add_row([
            Cell::from(topic).styled(TITLE),
            Cell::from(type_name).styled(FAINT),
            messages.into(),
            rate_hz.map_or(String::new(), |hz| format!("{hz:.1} Hz")).into(),
            format_size(*bytes).into(),
        ]);
    }
    table
}

fn write_problems(schema: &SchemaProblems, out: &mut dyn Write) -> io::Result<()> {
    let SchemaProblems {
        schema,
        faults,
        overruns,
        refused,
        late,
        last_fault,
    } = schema;
    let style = if *faults + *late > 0 { BAD } else { WARN };
    let (faults, overruns) = (counted(*faults, "fault"), counted(*overruns, "overrun"));
    write!(
        out,
        "{style}{schema}{style:#}: {faults}, {overruns}, {refused} refused"
    )?;
    if *late > 0 {
        write!(
            out,
            ", {} longer than its contract allows",
            counted(*late, "takeover")
        )?;
    }
    match last_fault {
        Some(fault) => writeln!(out, "; {fault}"),
        None => writeln!(out),
    }
}

/// Returns a log time in seconds since the application's start, or since the first message if the start is
/// unknown.
fn seconds_since_start(survey: &Survey, log_time: Option<u64>) -> Option<f64> {
    let start = survey.application_start_ns.or(survey.first_ns)?;
    Some(log_time?.saturating_sub(start) as f64 / 1e9)
}

#[cfg(test)]
mod tests {
    use super::format_size;

    #[test]
    fn sizes_have_suitable_units() {
        let sizes = [999, 1_000, 4_310_000, 12_000_000_000].map(format_size);
        assert_eq!(sizes, ["999 B", "1.0 kB", "4.3 MB", "12.0 GB"]);
    }
}
