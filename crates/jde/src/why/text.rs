//! A selection in words: the candidates, the choice, the decider and the reason.

use std::io::{self, Write};

use jde_records::{CandidateRecord, Decision};

use super::answer::Answer;
use crate::terminal::{FAINT, GOOD, TITLE, WARN};

/// Prints an answer. `asked` is the schema of the question, which is marked among the candidates.
///
/// # Errors
/// The stream cannot be written.
pub(crate) fn write(answer: &Answer<'_>, asked: Option<&str>, words: &mut dyn Write) -> io::Result<()> {
    match answer {
        Answer::NoMatch(reason) => writeln!(words, "{reason}"),
        Answer::Match {
            decision,
            before,
            after,
        } => {
            write_decision(decision, asked, words)?;
            if let Some(before) = before {
                write_neighbour("before", before, words)?;
            }
            if let Some(after) = after {
                write_neighbour("after", after, words)?;
            }
            Ok(())
        }
    }
}

/// Returns a takeover in one line:
/// `12.402 s  example/base: goon -> vff  only vff is ready (nobody), took 0.40 ms`.
pub(crate) fn format_takeover(decision: &Decision) -> String {
    let name = |name: &Option<String>| name.as_deref().unwrap_or("nobody").to_owned();
    let decider = match decision.decider.as_str() {
        "nobody" => String::new(),
        decider => format!(" {FAINT}({decider}){FAINT:#}"),
    };
    let took = match decision.takeover_us {
        Some(took) => format!("{FAINT}, took {}{FAINT:#}", format_millis(took)),
        None => String::new(),
    };
    format!(
        "{FAINT}{:>9.3} s{FAINT:#}  {}: {} -> {GOOD}{}{GOOD:#}  {}{decider}{took}",
        decision.time_s,
        decision.group,
        name(&decision.before),
        name(&decision.choice),
        decision.reason,
    )
}

fn write_decision(decision: &Decision, asked: Option<&str>, words: &mut dyn Write) -> io::Result<()> {
    let Decision {
        number,
        time_s,
        group,
        case,
        candidates,
        before,
        choice,
        decider,
        reason,
        cause,
        changed,
        takeover_us,
    } = decision;
    let name = |name: &Option<String>| name.as_deref().unwrap_or("nobody").to_owned();
    let what = if *changed {
        format!("{} -> {GOOD}{}{GOOD:#}", name(before), name(choice))
    } else {
        format!("{GOOD}{}{GOOD:#} stays", name(choice))
    };
    writeln!(
        words,
        "{TITLE}{group}{TITLE:#} at {time_s:.3} s: {what}  {FAINT}(selection {number}){FAINT:#}"
    )?;
    writeln!(words, "  because     {reason}")?;
    writeln!(words, "  case        {case}: {}", describe_case(case))?;
    writeln!(words, "  decided by  {}", describe_decider(decider))?;
    writeln!(words, "  set off by  {cause}")?;
    if let Some(took) = takeover_us {
        writeln!(
            words,
            "  took        {} from the cause to its first iteration",
            format_millis(*took)
        )?;
    }
    let width = candidates
        .iter()
        .map(|candidate| candidate.name.len())
        .max()
        .unwrap_or(0);
    for (place, candidate) in candidates.iter().enumerate() {
        let title = if place == 0 { "candidates" } else { "" };
        let mark = match asked {
            Some(asked) if asked == candidate.name => {
                format!("  {WARN}<- {}{WARN:#}", verdict(candidate, decision))
            }
            _ if choice.as_ref() == Some(&candidate.name) => format!("  {GOOD}<- chosen{GOOD:#}"),
            _ => String::new(),
        };
        let urgency = match candidate.urgency {
            Some(urgency) if urgency != 0.0 => format!("  urgency {urgency:.3}"),
            Some(_) | None => String::new(),
        };
        let wants = if candidate.ready { "ready" } else { "not ready" };
        writeln!(
            words,
            "  {title:<10}  {:<width$}  {:<8} {wants}{urgency}{mark}",
            candidate.name, candidate.state
        )?;
    }
    if let Some(asked) = asked
        && candidates.iter().all(|candidate| candidate.name != asked)
    {
        writeln!(
            words,
            "  {:<10}  {asked:<width$}  {WARN}was not awake{WARN:#}",
            ""
        )?;
    }
    Ok(())
}

fn write_neighbour(title: &str, decision: &Decision, words: &mut dyn Write) -> io::Result<()> {
    writeln!(
        words,
        "  {FAINT}{title:<10}{FAINT:#}{}",
        format_takeover(decision)
    )
}

/// Returns the result of the candidate that the question names.
fn verdict(candidate: &CandidateRecord, decision: &Decision) -> &'static str {
    if decision.choice.as_ref() == Some(&candidate.name) {
        "chosen"
    } else if candidate.ready {
        "ready, and somebody else was chosen"
    } else {
        "its precondition did not hold"
    }
}

fn describe_case(case: &str) -> &'static str {
    match case {
        "alone" => "exactly one was ready, and nobody is asked",
        "collision" => "two or more were ready",
        "absence" => "nobody was ready",
        "forced" => "an operator forces one",
        _ => "",
    }
}

fn describe_decider(decider: &str) -> String {
    match decider {
        "nobody" => String::from("nobody: there was nothing to decide"),
        "father" => String::from("the father's own arbitration"),
        "arbitration-failed" => String::from("the priority order, for the father's arbitration failed"),
        "absence-policy" => String::from("the absence policy of the group"),
        "operator" => String::from("an operator"),
        policy => format!("the policy of the group, {policy}"),
    }
}

/// Returns microseconds as text in ms, with the digits that matter.
fn format_millis(micros: f64) -> String {
    let ms = micros / 1e3;
    if ms >= 10.0 {
        format!("{ms:.1} ms")
    } else {
        format!("{ms:.2} ms")
    }
}
