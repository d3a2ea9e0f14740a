//! One message of a run as a line of text, as the verbs that follow a run print it.

use jde_app::period::format_duration;
use jde_core::Nanos;
use jde_records::event::What;
use jde_records::wire::state_name;
use jde_records::{DecidedBy, Decision, RunRecord};
use jde_terminal::{BAD, FAINT, GOOD, Style, WARN};
use jde_timeline::{MarkKind, Severity};

/// Returns a message in one line: `   12.402 s  goon faulted: it panicked`.
pub fn format_record(record: &RunRecord) -> String {
    match record {
        RunRecord::Decision(decision) => format_takeover(decision),
        RunRecord::State(change) => format!(
            "{FAINT}{:>9.3} s{FAINT:#}  {}: {} -> {}",
            change.time as f64 / 1e9,
            change.schema,
            state_name(change.from),
            state_name(change.to)
        ),
        RunRecord::Other(event) => {
            let style = style(&event.what);
            let schema = event.what.schema();
            let schema = schema.map_or(String::new(), |name| format!("{name} "));
            format!(
                "{FAINT}{:>9.3} s{FAINT:#}  {schema}{style}{}{style:#}: {}",
                event.time_s(),
                event.what.kind(),
                event.text()
            )
        }
    }
}

/// Returns a message in lines: that of [`format_record`], and below it the further lines of a text that has several, such as
/// a traceback.
pub fn record_lines(record: &RunRecord) -> Vec<String> {
    let text = format_record(record);
    let mut lines = text.lines();
    let first = lines.next().unwrap_or_default().to_owned();
    // The mark says that a line belongs to the text above: no text can forge a line of the log.
    let rest = lines.map(|line| format!("{:>12}| {line}", ""));
    std::iter::once(first).chain(rest).collect()
}

fn style(what: &What<String>) -> Style {
    match MarkKind::of(what).severity() {
        Severity::Good => GOOD,
        Severity::Warning => WARN,
        Severity::Bad => BAD,
    }
}

/// Returns a takeover in one line:
/// `12.402 s  example/base: goon -> vff  only vff is ready (nobody), took 400 µs`.
pub fn format_takeover(decision: &Decision) -> String {
    let decider = match &decision.decider {
        DecidedBy::Nobody => String::new(),
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
pub fn format_micros(micros: f64) -> String {
    format_duration((micros * 1e3).round() as Nanos)
}
