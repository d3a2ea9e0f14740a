//! A selection as text: the candidates, the choice, the decider and the reason.

use std::io::{self, Write};

use jde_records::wire::state_name;
use jde_records::{CandidateRecord, Decision};
use jde_session::record_text::{format_micros, format_takeover};
use jde_terminal::{FAINT, GOOD, TITLE, WARN};
use jde_timeline::case_word;

use super::answer::Answer;
use super::asleep::Asleep;

/// Prints an answer. `marked` is the schema of the question, which is marked among the candidates.
///
/// # Errors
/// The stream cannot be written.
pub(crate) fn write(answer: &Answer<'_>, marked: Option<&str>, output: &mut dyn Write) -> io::Result<()> {
    match answer {
        Answer::NoMatch(reason) => writeln!(output, "{reason}"),
        Answer::Asleep(asleep) => write_asleep(asleep, output),
        Answer::Match {
            decision,
            before,
            after,
            limits,
            steps,
        } => {
            write_decision(decision, marked, output)?;
            if let [first, others @ ..] = limits.as_slice() {
                let (time_s, text) = (first.time_s(), first.text());
                writeln!(output, "  {WARN}limited{WARN:#}     at {time_s:.3} s: {text}")?;
                match others.len() {
                    0 => {}
                    1 => writeln!(output, "              and once more")?,
                    times => writeln!(output, "              and {times} more times")?,
                }
            }
            for (place, step) in steps.iter().enumerate() {
                let title = if place == 0 { "came due" } else { "" };
                writeln!(output, "  {title:<10}  at {:.3} s: {}", step.time_s, step.text())?;
            }
            if let Some(before) = before {
                write_neighbour("before", before, output)?;
            }
            if let Some(after) = after {
                write_neighbour("after", after, output)?;
            }
            Ok(())
        }
    }
}

fn write_asleep(asleep: &Asleep<'_>, output: &mut dyn Write) -> io::Result<()> {
    let Asleep {
        group,
        since_s,
        loser,
        father,
        selection,
        event,
    } = asleep;
    writeln!(output, "{TITLE}{group}{TITLE:#} since {since_s:.3} s: nobody")?;
    match father {
        Some(father) => writeln!(
            output,
            "  reason      its members sleep, because their father {father} lost"
        )?,
        None => writeln!(
            output,
            "  reason      its members sleep, so there is nobody to select"
        )?,
    }
    if let Some(event) = event {
        writeln!(
            output,
            "  cause       {}, at {:.3} s",
            event.text(),
            event.time_s()
        )?;
    }
    if let Some(selection) = selection {
        write_neighbour("selection", selection, output)?;
    }
    match loser {
        Some(loser) => writeln!(output, "  until then  {GOOD}{loser}{GOOD:#}"),
        None => Ok(()),
    }
}

fn write_decision(decision: &Decision, marked: Option<&str>, output: &mut dyn Write) -> io::Result<()> {
    let Decision {
        number,
        time_s,
        group,
        case,
        candidates,
        choice,
        reason,
        cause,
        changed,
        takeover_us,
        ..
    } = decision;
    let what = if *changed {
        format!(
            "{} -> {GOOD}{}{GOOD:#}",
            decision.before_name(),
            decision.choice_name()
        )
    } else {
        format!("{GOOD}{}{GOOD:#} stays", decision.choice_name())
    };
    writeln!(
        output,
        "{TITLE}{group}{TITLE:#} at {time_s:.3} s: {what}  {FAINT}(selection {number}){FAINT:#}"
    )?;
    writeln!(output, "  reason      {reason}")?;
    writeln!(
        output,
        "  case        {}: {}",
        case_word(*case),
        decision.case_text()
    )?;
    writeln!(output, "  decided by  {}", decision.decider_text())?;
    writeln!(output, "  cause       {cause}")?;
    if let Some(took) = takeover_us {
        writeln!(
            output,
            "  took        {} from the cause to its first iteration",
            format_micros(*took)
        )?;
    }
    let width = candidates
        .iter()
        .map(|candidate| candidate.name.len())
        .max()
        .unwrap_or(0);
    for (index, candidate) in candidates.iter().enumerate() {
        let title = if index == 0 { "candidates" } else { "" };
        let mark = match (decision.refusal_of(&candidate.name), marked) {
            (Some(refusal), _) if !candidate.ready => format!("  {WARN}<- {refusal}{WARN:#}"),
            (_, Some(marked)) if marked == candidate.name => {
                format!("  {WARN}<- {}{WARN:#}", verdict(candidate, decision))
            }
            _ if choice.as_ref() == Some(&candidate.name) => format!("  {GOOD}<- chosen{GOOD:#}"),
            _ => String::new(),
        };
        let urgency = match candidate.urgency {
            Some(urgency) if urgency != 0.0 => format!("  urgency {urgency:.3}"),
            Some(_) | None => String::new(),
        };
        let readiness = if candidate.ready { "ready" } else { "not ready" };
        writeln!(
            output,
            "  {title:<10}  {:<width$}  {:<8} {readiness}{urgency}{mark}",
            candidate.name,
            state_name(candidate.state)
        )?;
    }
    if let Some(marked) = marked
        && candidates.iter().all(|candidate| candidate.name != marked)
    {
        writeln!(
            output,
            "  {:<10}  {marked:<width$}  {WARN}was not awake{WARN:#}",
            ""
        )?;
    }
    Ok(())
}

fn write_neighbour(title: &str, decision: &Decision, output: &mut dyn Write) -> io::Result<()> {
    writeln!(
        output,
        "  {FAINT}{title:<10}{FAINT:#}{}",
        format_takeover(decision)
    )
}

/// Returns the result of the candidate that the question names.
fn verdict(candidate: &CandidateRecord, decision: &Decision) -> &'static str {
    if decision.choice.as_ref() == Some(&candidate.name) {
        "chosen"
    } else if candidate.ready {
        "ready, and another schema was chosen"
    } else {
        "its precondition did not hold"
    }
}
