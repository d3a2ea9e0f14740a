//! The events of a page: faults, overruns, refusals, operators' actions and all others.

use jde_records::event::What;
use jde_timeline::{MarkKind, Severity};
use maud::{Markup, html};

use super::{Page, at, counted};
use crate::moment::view_command;

/// A table with more rows is collapsed.
const MAX_UNFOLDED_ROWS: usize = 40;

pub(super) fn events(page: &Page<'_>) -> Option<Markup> {
    let events = &page.analysis.events;
    let count = events.list.kept().count();
    if count == 0 {
        return None;
    }
    let kinds = events.kinds.iter().map(|(kind, count)| format!("{count} {kind}"));
    let kinds: Vec<_> = kinds.collect();
    Some(html! {
        p.note { (kinds.join(" · ")) }
        details open[count <= MAX_UNFOLDED_ROWS] {
            summary { (counted(count as u64 + events.list.left_out, "event")) }
            @if events.list.left_out > 0 {
                p.note { "The first and the last are shown; " (counted(events.list.left_out, "event")) " between are only counted." }
            }
            div.scroll {
                table {
                    thead { tr { th.n { "time" } th { "kind" } th { "schema" } th { "description" } } }
                    tbody {
                        @for event in events.list.kept() {
                            tr {
                                td.n { (at(event.time_s())) }
                                td.name { @if is_bad(&event.what) { span.bad { (event.what.kind()) } } @else { (event.what.kind()) } }
                                td.name { @if let Some(schema) = event.what.schema() { (page.schema(schema)) } }
                                td {
                                    (event.text())
                                    @if is_bad(&event.what) { br; code { (view_command(page.file, event.time_s())) } }
                                }
                            }
                        }
                    }
                }
            }
        }
    })
}

fn is_bad(what: &What<String>) -> bool {
    MarkKind::of(what).severity() == Severity::Bad
}
