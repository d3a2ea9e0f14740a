//! One message of a run as a line of text, as the verbs that follow a run print it.

use jde_app::period::format_duration;
use jde_core::Nanos;
use jde_records::{Decision, RunRecord};

use crate::terminal::{BAD, FAINT, GOOD, WARN};

/// Returns a message in one line: `   12.402 s  goon faulted: it panicked`.
pub(crate) fn format_record(record: &RunRecord) -> String {
    match record {
        RunRecord::Decision(decision) => format_takeover(decision),
        RunRecord::State(change) => format!(
            "{FAINT}{:>9.3} s{FAINT:#}  {}: {} -> {}",
            change.time_s, change.schema, change.from, change.to
        ),
        RunRecord::Event(happening) => {
            let style = match happening.kind.as_str() {
                "faulted" | "hung" | "left-behind" | "late" | "chatters" | "stalled" => BAD,
                "ok" | "ended" => GOOD,
                _ => WARN,
            };
            let schema = happening.schema.as_ref();
            let schema = schema.map_or(String::new(), |name| format!("{name} "));
            format!(
                "{FAINT}{:>9.3} s{FAINT:#}  {schema}{style}{}{style:#}: {}",
                happening.time_s, happening.kind, happening.text
            )
        }
    }
}

/// Returns a takeover in one line:
/// `12.402 s  example/base: goon -> vff  only vff is ready (nobody), took 400 µs`.
pub(crate) fn format_takeover(decision: &Decision) -> String {
    let decider = match decision.decider.as_str() {
        "nobody" => String::new(),
        decider => format!(" {FAINT}({decider}){FAINT:#}"),
    };
    let took = match decision.takeover_us {
        Some(took) => format!("{FAINT}, took {}{FAINT:#}", format_micros(took)),
        None => String::new(),
    };
    format!(
        "{FAINT}{:>9.3} s{FAINT:#}  {}: {} -> {GOOD}{}{GOOD:#}  {}{decider}{took}",
        decision.time_s,
        decision.group,
        decision.before_name(),
        decision.choice_name(),
        decision.reason,
    )
}

/// Returns microseconds as text in a suitable unit.
pub(crate) fn format_micros(micros: f64) -> String {
    format_duration((micros * 1e3).round() as Nanos)
}
