//! The summary of a run in words.

use std::io::{self, Write};

use super::RunSummary;
use super::data::{Ending, GroupSummary, SchemaSummary, Unread};
use crate::session::{RecordedFile, RecordingSummary, format_progress};
use crate::terminal::{BAD, FAINT, GOOD, TITLE, WARN};

/// Prints the result of a run.
///
/// # Errors
/// The stream cannot be written.
pub(crate) fn print_summary(summary: &RunSummary, words: &mut dyn Write) -> io::Result<()> {
    writeln!(words)?;
    print_headline(summary, words)?;
    for group in summary.groups.iter().filter(|group| !group.winners.is_empty()) {
        print_group(group, words)?;
    }
    writeln!(words)?;
    if let Some(recorded) = &summary.recording {
        print_recording(recorded, words)?;
    }
    print_unread(&summary.unread, words)?;
    let troubled = |schema: &&SchemaSummary| schema.faults + schema.overruns + schema.refused > 0;
    let mut troubled = summary.schemas.iter().filter(troubled).peekable();
    if troubled.peek().is_none() {
        return writeln!(words, "no faults, no overruns, nothing refused");
    }
    for SchemaSummary {
        schema,
        iterations,
        overruns,
        refused,
        faults,
    } in troubled
    {
        let style = if *faults > 0 { BAD } else { WARN };
        let (faults, overruns) = (pluralize(*faults, "fault"), pluralize(*overruns, "overrun"));
        writeln!(
            words,
            "{style}{schema}{style:#}: {faults}, {overruns}, {refused} refused in {}",
            pluralize(*iterations, "iteration")
        )?;
    }
    Ok(())
}

fn print_unread(unread: &Unread, words: &mut dyn Write) -> io::Result<()> {
    let Unread {
        output_lines,
        log_lines,
        decisions,
        events,
    } = *unread;
    let of = [
        (
            output_lines,
            "line",
            "of standard output",
            "nobody read them in time",
        ),
        (log_lines, "line", "of the log", "nobody read them in time"),
        (
            decisions,
            "decision",
            "on the way out",
            "nobody took them in time",
        ),
        (
            events,
            "event",
            "of this summary",
            "they came too fast to be counted",
        ),
    ];
    for (count, what, whose, why) in of.into_iter().filter(|(count, ..)| *count > 0) {
        let lost = pluralize(count, what);
        writeln!(words, "{WARN}{lost} {whose} lost{WARN:#}: {why}")?;
    }
    Ok(())
}

/// Prints what was recorded.
pub(crate) fn print_recording(recorded: &RecordingSummary, words: &mut dyn Write) -> io::Result<()> {
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
        write!(words, "recorded {TITLE}{file}{TITLE:#}")?;
        if let Some(parts) = parts {
            let files = pluralize(parts.count, "file");
            write!(words, " in {files}, {} to {}", parts.first, parts.last)?;
            if parts.deleted > 0 {
                write!(words, ", {} deleted", parts.deleted)?;
            }
            if !parts.left.is_empty() {
                let left = parts.left.join(", ");
                write!(words, ", {left} not deleted because another recording writes it")?;
            }
        }
        write!(words, ": ")?;
        return print_file(*kept, *lost, *bytes, trouble.as_deref(), words);
    };
    if files.is_empty() {
        writeln!(words, "recorded nothing: no condition came true")?;
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
            words,
            "recorded {TITLE}{file}{TITLE:#}, {reason} at {time_s:.3} s"
        )?;
        if let more @ 1.. = fired.saturating_sub(1) {
            write!(words, " and {more} more")?;
        }
        write!(words, ": ")?;
        print_file(*kept, *lost, *bytes, trouble.as_deref(), words)?;
    }
    if recorded.short > 0 {
        let short = pluralize(recorded.short, "message");
        writeln!(
            words,
            "{WARN}memory was too small{WARN:#}: {short} had to go early; give more with --memory, or take less with --before"
        )?;
    }
    Ok(())
}

fn print_file(
    kept: u64,
    lost: u64,
    bytes: u64,
    trouble: Option<&str>,
    words: &mut dyn Write,
) -> io::Result<()> {
    let (kept, megabytes) = (pluralize(kept, "message"), bytes as f64 / 1e6);
    write!(words, "{kept}, {megabytes:.1} MB, ")?;
    match lost {
        0 => write!(words, "nothing lost")?,
        lost => write!(words, "{WARN}{lost} lost{WARN:#}")?,
    }
    match trouble {
        None => writeln!(words),
        Some(trouble) => writeln!(words, "; {BAD}it ends too soon{BAD:#}: {trouble}"),
    }
}

/// Returns a count with its noun, in the plural unless the count is 1.
pub(crate) fn pluralize(count: u64, what: &str) -> String {
    let plural = if count == 1 { "" } else { "s" };
    format!("{count} {what}{plural}")
}

fn print_headline(summary: &RunSummary, words: &mut dyn Write) -> io::Result<()> {
    let (style, how) = match summary.outcome {
        Ending::Done => (GOOD, "the mission is done"),
        Ending::Failed => (BAD, "the mission failed"),
        Ending::Broken => (BAD, "the application could not go on"),
        Ending::TimeUp if summary.has_mission => (BAD, "the time was up before the mission was done"),
        Ending::TimeUp => (TITLE, "the time is up"),
        Ending::Stopped => (TITLE, "stopped"),
    };
    write!(
        words,
        "{TITLE}{}{TITLE:#}: {style}{how}{style:#}",
        summary.application
    )?;
    if !summary.note.is_empty() && summary.note != summary.counts {
        write!(words, " ({})", summary.note)?;
    }
    if let (Some(reached), Some(targets)) = (summary.reached, summary.targets) {
        write!(
            words,
            "; {} {}",
            format_progress(reached, targets),
            summary.counts
        )?;
    }
    writeln!(words, " in {:.1} s", summary.sim_seconds)?;
    match summary.collisions {
        None => {}
        Some(0) => write!(words, "no collision")?,
        Some(1) => write!(words, "{BAD}1 collision{BAD:#}")?,
        Some(many) => write!(words, "{BAD}{many} collisions{BAD:#}")?,
    }
    if let Some(clearance) = summary.min_clearance_m {
        write!(words, ", never nearer than {clearance:.2} m to anything")?;
    }
    if summary.collisions.is_some() {
        writeln!(words)?;
    }
    Ok(())
}

fn print_group(group: &GroupSummary, words: &mut dyn Write) -> io::Result<()> {
    let width = group
        .winners
        .iter()
        .map(|share| share.schema.len())
        .max()
        .unwrap_or(0)
        .max("nobody".len());
    writeln!(
        words,
        "\n{TITLE}{}{TITLE:#}{FAINT}, as WINNER{FAINT:#}",
        group.group
    )?;
    for share in &group.winners {
        writeln!(
            words,
            "  {:<width$}  {:>8.1} s  {:>5.1} %  {FAINT}{}{FAINT:#}",
            share.schema,
            share.seconds,
            share.share * 100.0,
            pluralize(share.takeovers, "takeover")
        )?;
    }
    // A shorter time, less than a cycle, is that of the takeovers themselves.
    if group.nobody_seconds >= 0.05 {
        writeln!(
            words,
            "  {FAINT}{:<width$}  {:>8.1} s{FAINT:#}",
            "nobody", group.nobody_seconds
        )?;
    }
    if let Some(worst) = group.worst_takeover_us {
        let style = if worst > group.allowed_takeover_us {
            WARN
        } else {
            FAINT
        };
        writeln!(
            words,
            "  {style}worst takeover {:.1} ms; its contract allows {:.1} ms{style:#}",
            worst / 1e3,
            group.allowed_takeover_us / 1e3
        )?;
    }
    Ok(())
}
