//! The reserved keys of a schema that concern no other schema: period, budget, restart and the like. Binds
//! nothing.

use jde_abi::describe::Schema;
use jde_core::{Nanos, Restart};

use super::isolation::{Isolation, isolation};
use super::time;
use jde_document::section::{Section, WordOrTable, integer};
use jde_document::{FaultReport, quote};

/// The default first back-off of a restart, ns: long enough for a device to recover and for a person to
/// notice the fault, short enough that a robot is not without a behaviour for a second.
const BACK_OFF: Nanos = 500_000_000;
/// The default number of restarts. The back-off doubles, so the fifth restart follows after 15 s; a schema
/// that still fails then is broken.
const DEFAULT_RESTARTS: u32 = 5;
/// The default time within which restarts are counted, ns. On a robot that runs for days, a schema that fails
/// occasionally is not broken.
const DEFAULT_RESTART_WINDOW: Nanos = 60_000_000_000;

/// The contents of a schema's own keys.
pub(super) struct InstanceSettings {
    pub(super) doc: String,
    pub(super) period_ns: Nanos,
    pub(super) stated_period_ns: Nanos,
    pub(super) budget_ns: Nanos,
    pub(super) hang_ns: Option<Nanos>,
    pub(super) restart: Restart,
    pub(super) isolate: Option<Isolation>,
}

impl InstanceSettings {
    /// Reads the keys; missing ones are the type's.
    pub(super) fn read(report: &mut FaultReport, section: &Section, schema: Option<&Schema>) -> Self {
        let type_period = schema.map_or(0, |schema| schema.period_ns);
        let type_budget = schema.and_then(|schema| schema.budget_ns);
        let period_ns = section
            .get("period")
            .and_then(|node| time::period(report, &section.key("period"), node))
            .unwrap_or(type_period);
        let budget_ns = time::of(report, section, "budget");
        // A type without a budget has the period as its budget, also if the file changes the period.
        let budget_ns = budget_ns.or(type_budget).unwrap_or(period_ns);
        Self {
            doc: section
                .text(report, "doc")
                .map(|doc| doc.text.to_owned())
                .unwrap_or_default(),
            period_ns,
            stated_period_ns: period_ns,
            budget_ns,
            hang_ns: hang(report, section, budget_ns),
            restart: restart(report, section),
            isolate: isolation(report, section),
        }
    }
}

/// Reads how long a call may take before it counts as hung. It must be longer than the budget, which a call
/// may exceed.
fn hang(report: &mut FaultReport, section: &Section, budget_ns: Nanos) -> Option<Nanos> {
    let node = section.get("hang")?;
    let what = section.key("hang");
    let hang_ns = time::time(report, &what, node)?;
    if hang_ns <= budget_ns {
        let budget = budget_ns as f64 / 1e6;
        report
            .fault(
                &node.span(),
                format!("{what} is not longer than its budget, which is {budget} ms"),
            )
            .advise("give several budgets, or leave it out for ten of them and at least a second");
    }
    Some(hang_ns)
}

/// Reads `restart = "never"`, or `"on-fault"`, or `{ back-off = "200ms", limit = 5, within = "60s" }`.
fn restart(report: &mut FaultReport, section: &Section) -> Restart {
    let on_fault = |backoff, limit, within| Restart::OnFault {
        backoff,
        limit,
        within,
    };
    const EXPECTED: &str =
        "\"never\", \"on-fault\" or a table such as { back-off = \"500ms\", limit = 5, within = \"60s\" }";
    if section.get("restart").is_none() {
        return on_fault(BACK_OFF, DEFAULT_RESTARTS, DEFAULT_RESTART_WINDOW);
    }
    let table = match section.word_or_table(report, "restart", EXPECTED) {
        None => return Restart::Never,
        Some(WordOrTable::Table(table)) => table,
        Some(WordOrTable::Word(mode)) => {
            match mode.text {
                "never" => return Restart::Never,
                "on-fault" => {}
                other => {
                    let (what, mode_name) = (section.key("restart"), quote(other));
                    report
                        .fault(
                            &mode.span,
                            format!("{what} is {mode_name}, which is not a way to restart"),
                        )
                        .suggest(other, "ways", ["never", "on-fault"]);
                }
            }
            return on_fault(BACK_OFF, DEFAULT_RESTARTS, DEFAULT_RESTART_WINDOW);
        }
    };
    table.refuse_unknown(report, &["back-off", "limit", "within"]);
    let backoff = time::of(report, &table, "back-off").unwrap_or(BACK_OFF);
    let limit = table.get("limit").map_or(Some(DEFAULT_RESTARTS), |node| {
        let limit = integer(node.get_ref())
            .and_then(|limit| u32::try_from(limit).ok())
            .filter(|limit| *limit > 0);
        if limit.is_none() {
            report
                .fault(
                    &node.span(),
                    format!("{} is not a whole number above 0", table.key("limit")),
                )
                .advise("state the number of restarts, or write restart = \"never\"");
        }
        limit
    });
    let within = time::of(report, &table, "within").unwrap_or(DEFAULT_RESTART_WINDOW);
    on_fault(backoff, limit.unwrap_or(DEFAULT_RESTARTS), within)
}
