//! The summary of a run as text.

use std::io::{self, Write};

use jde_drawing::text::counted;
use jde_terminal::{BAD, FAINT, GOOD, TITLE, WARN};

use super::RunSummary;
use super::data::{Ending, GroupSummary, SchemaSummary, SlowTurns, Unread};
use crate::run::{PartLeft, RecordedFile, RecordedParts, RecordingSummary, format_progress};

/// The most files that remain undeleted and are listed by name.
const MAX_LEFT: usize = 5;

/// Prints the result of a run.
///
/// # Errors
/// The stream cannot be written.
pub fn print_summary(summary: &RunSummary, output: &mut dyn Write) -> io::Result<()> {
    writeln!(output)?;
    print_headline(summary, output)?;
    for group in summary.groups.iter().filter(|group| !group.winners.is_empty()) {
        print_group(group, output)?;
    }
    writeln!(output)?;
    if let Some(recorded) = &summary.recording {
        print_recording(recorded, output)?;
    }
    for unwritten in &summary.unwritten {
        writeln!(output, "{BAD}{unwritten}{BAD:#}")?;
    }
    print_unread(&summary.unread, output)?;
    for schema in &summary.schemas {
        if let Some(SlowTurns {
            turns,
            longest_ms,
            budget_ms,
        }) = schema.slow
        {
            let (name, turns) = (&schema.schema, counted(turns, "turn"));
            writeln!(
                output,
                "{WARN}{name}{WARN:#}: {turns} of up to {longest_ms:.1} ms by this machine's clock, and its budget is {budget_ms:.1} ms: in real time it overruns"
            )?;
        }
    }
    let with_problems = |schema: &&SchemaSummary| {
        schema.faults + schema.overruns + schema.refused + schema.triggers_dropped > 0
    };
    let mut with_problems = summary.schemas.iter().filter(with_problems).peekable();
    let late = summary.late_takeovers();
    if late > 0 {
        let late = counted(late, "takeover");
        writeln!(
            output,
            "{BAD}{late} took longer than the contract allows{BAD:#}: `jde check` shows how the contract is computed"
        )?;
    } else if with_problems.peek().is_none() {
        return writeln!(output, "no faults, no overruns, nothing refused");
    }
    for SchemaSummary {
        schema,
        iterations,
        overruns,
        refused,
        refusals,
        triggers_dropped,
        faults,
        slow: _,
    } in with_problems
    {
        let style = if *faults > 0 { BAD } else { WARN };
        let (faults, overruns) = (counted(*faults, "fault"), counted(*overruns, "overrun"));
        writeln!(
            output,
            "{style}{schema}{style:#}: {faults}, {overruns}, {refused} refused in {}",
            counted(*iterations, "iteration")
        )?;
        if *triggers_dropped > 0 {
            let dropped = counted(*triggers_dropped, "trigger");
            writeln!(
                output,
                "  {FAINT}{dropped} dropped or delayed: they follow each other without a rest{FAINT:#}"
            )?;
        }
        for refusal in refusals {
            writeln!(output, "  {FAINT}{refusal}{FAINT:#}")?;
        }
    }
    Ok(())
}

fn print_unread(unread: &Unread, output: &mut dyn Write) -> io::Result<()> {
    let Unread {
        output_lines,
        log_lines,
        decisions,
        events,
    } = *unread;
    let losses = [
        (
            output_lines,
            "line",
            "of standard output",
            "they were not read in time",
        ),
        (log_lines, "line", "of the log", "they were not read in time"),
        (
            decisions,
            "decision",
            "on the way out",
            "they were not taken in time",
        ),
        (
            events,
            "event",
            "of this summary",
            "they came too fast to be counted",
        ),
    ];
    for (count, what, whose, why) in losses.into_iter().filter(|(count, ..)| *count > 0) {
        let lost = counted(count, what);
        writeln!(output, "{WARN}{lost} {whose} lost{WARN:#}: {why}")?;
    }
    Ok(())
}

/// Prints what was recorded.
pub fn print_recording(recorded: &RecordingSummary, output: &mut dyn Write) -> io::Result<()> {
    let Some(files) = &recorded.files else {
        let RecordingSummary {
            file,
            kept,
            lost,
            bytes,
            trouble,
            parts,
            ..
        } = recorded;
        write!(output, "recorded {TITLE}{file}{TITLE:#}")?;
        if let Some(parts) = parts {
            let files = counted(parts.count, "file");
            write!(output, " in {files}, {}", parts.first)?;
            if parts.last != parts.first {
                write!(output, " to {}", parts.last)?;
            }
            if parts.deleted > 0 {
                write!(output, ", {} deleted", parts.deleted)?;
            }
        }
        write!(output, ": ")?;
        print_file(*kept, *lost, *bytes, trouble.as_deref(), output)?;
        return parts.as_ref().map_or(Ok(()), |parts| print_parts(parts, output));
    };
    if files.is_empty() {
        writeln!(output, "recorded nothing: no condition came true")?;
    }
    for RecordedFile {
        file,
        reason,
        time_s,
        fired,
        kept,
        lost,
        bytes,
        trouble,
    } in files
    {
        write!(
            output,
            "recorded {TITLE}{file}{TITLE:#}, {reason} at {time_s:.3} s"
        )?;
        if let more @ 1.. = fired.saturating_sub(1) {
            write!(output, " and {more} more")?;
        }
        write!(output, ": ")?;
        print_file(*kept, *lost, *bytes, trouble.as_deref(), output)?;
    }
    if recorded.short > 0 {
        let short = counted(recorded.short, "message");
        writeln!(
            output,
            "{WARN}memory was too small{WARN:#}: {short} were dropped early; raise --memory or lower --before"
        )?;
    }
    Ok(())
}

/// Prints what hindered a recording in parts.
fn print_parts(parts: &RecordedParts, output: &mut dyn Write) -> io::Result<()> {
    for gap in &parts.gaps {
        writeln!(output, "  {BAD}gap{BAD:#}: {}", gap.text)?;
    }
    if parts.more_gaps > 0 {
        let more = counted(parts.more_gaps, "more gap");
        writeln!(output, "  {BAD}{more}{BAD:#}")?;
    }
    for PartLeft { file, reason } in parts.left.iter().take(MAX_LEFT) {
        writeln!(output, "  {WARN}{file} is not deleted{WARN:#}: {reason}")?;
    }
    if let more @ 1.. = parts.left.len().saturating_sub(MAX_LEFT) {
        let more = counted(more as u64, "more file");
        writeln!(output, "  {WARN}{more} could not be deleted{WARN:#}")?;
    }
    Ok(())
}

fn print_file(
    kept: u64,
    lost: u64,
    bytes: u64,
    trouble: Option<&str>,
    output: &mut dyn Write,
) -> io::Result<()> {
    let (kept, megabytes) = (counted(kept, "message"), bytes as f64 / 1e6);
    write!(output, "{kept}, {megabytes:.1} MB, ")?;
    match lost {
        0 => write!(output, "nothing lost")?,
        lost => write!(output, "{WARN}{lost} lost{WARN:#}")?,
    }
    match trouble {
        None => writeln!(output),
        Some(trouble) => writeln!(output, "; {BAD}it ends too soon{BAD:#}: {trouble}"),
    }
}

fn print_headline(summary: &RunSummary, output: &mut dyn Write) -> io::Result<()> {
    let (style, result) = match summary.outcome {
        Ending::Done => (GOOD, "the mission is done"),
        Ending::Failed => (BAD, "the mission failed"),
        Ending::Broken => (BAD, "the application could not continue"),
        Ending::TimeUp if summary.has_mission => (BAD, "the time was up before the mission was done"),
        Ending::TimeUp => (TITLE, "the time is up"),
        Ending::Stopped => (TITLE, "stopped"),
    };
    write!(
        output,
        "{TITLE}{}{TITLE:#}: {style}{result}{style:#}",
        summary.application
    )?;
    if !summary.note.is_empty() && summary.note != summary.counts {
        write!(output, " ({})", summary.note)?;
    }
    match (summary.reached, summary.targets) {
        // One without end has no total, and is none that can be completed.
        (_, Some(0)) if summary.has_mission => write!(output, "; it had no target")?,
        (Some(reached), Some(targets)) => {
            let is_one = targets == 1 || targets == 0 && reached == 1;
            let counts = match summary.counts.as_str() {
                "targets" if is_one => "target",
                counts => counts,
            };
            write!(output, "; {} {counts}", format_progress(reached, targets))?;
        }
        (None, _) | (_, None) => {}
    }
    writeln!(output, " in {:.1} s", summary.sim_seconds)?;
    match summary.collisions {
        None => {}
        Some(0) => write!(output, "no contact")?,
        Some(count) => write!(output, "{BAD}{}{BAD:#}", counted(count, "contact"))?,
    }
    // It is the time of the first sample that has the contact, which began a little before.
    if let Some(first) = summary.first_contact_s {
        write!(output, ", the first at {first:.1} s")?;
    }
    if let Some(clearance) = summary.min_clearance_m {
        write!(output, ", never nearer than {clearance:.2} m to anything")?;
    }
    if summary.collisions.is_some() {
        writeln!(output)?;
    }
    Ok(())
}

fn print_group(group: &GroupSummary, output: &mut dyn Write) -> io::Result<()> {
    let width = group
        .winners
        .iter()
        .map(|share| share.schema.len())
        .max()
        .unwrap_or(0)
        .max("nobody".len());
    writeln!(output)?;
    writeln!(
        output,
        "{TITLE}{}{TITLE:#}{FAINT}, as WINNER{FAINT:#}",
        group.group
    )?;
    for share in &group.winners {
        writeln!(
            output,
            "  {:<width$}  {:>8.1} s  {:>5.1} %  {FAINT}{}{FAINT:#}",
            share.schema,
            share.seconds,
            share.share * 100.0,
            counted(share.takeovers, "takeover")
        )?;
    }
    // A shorter time, less than a cycle, is that of the takeovers themselves.
    if group.nobody_seconds >= 0.05 {
        writeln!(
            output,
            "  {FAINT}{:<width$}  {:>8.1} s{FAINT:#}",
            "nobody", group.nobody_seconds
        )?;
    }
    if let Some(worst) = group.worst_takeover_us {
        let (style, why) = match group.late_takeovers {
            0 if worst > group.allowed_takeover_us => (WARN, ": the machine was late"),
            0 => (FAINT, ""),
            _ => (BAD, ""),
        };
        writeln!(
            output,
            "  {style}worst takeover {:.1} ms; its contract allows {:.1} ms{why}{style:#}",
            worst / 1e3,
            group.allowed_takeover_us / 1e3
        )?;
    }
    Ok(())
}
