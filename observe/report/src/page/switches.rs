//! The switches of a page: every selection that changed a winner, with its why-record (R15).

use jde_core::State;
use jde_records::Decision;
use jde_records::wire::state_name;
use maud::{Markup, html};

use super::{Page, at, counted};
use crate::chart;

/// A table with more rows is collapsed.
const MAX_UNFOLDED_ROWS: usize = 60;

pub(super) fn switches(page: &Page<'_>) -> Option<Markup> {
    let switches = &page.analysis.switches;
    if switches.is_empty() {
        return None;
    }
    let count = switches.kept().count();
    let all = count as u64 + switches.left_out;
    Some(html! {
        p.note { "Every selection that changed the winner, with its reason and its candidates." }
        div.tools hidden {
            input type="search" placeholder="filter: vff conflict" aria-label="Show only switches with these words";
            button type="button" hidden { "all" }
            output {}
            span.note { "or drag over the bands above to select a time" }
        }
        details open[count <= MAX_UNFOLDED_ROWS] {
            summary { (counted(all, "switch")) }
            div.scroll {
                table {
                    thead { tr {
                        th.n { "time" } th { "group" } th { "from" } th { "to" } th { "because" } th { "case" } th { "decided by" }
                        th.n { "took" }
                    } }
                    tbody {
                        @for decision in &switches.first { (switch_row(page, decision)) }
                        @if switches.left_out > 0 {
                            tr data-s="-1" { td colspan="8" { (counted(switches.left_out, "more switch")) " are not listed: `jde why --in` prints all of them." } }
                        }
                        @for decision in &switches.last { (switch_row(page, decision)) }
                    }
                }
            }
        }
    })
}

fn switch_row(page: &Page<'_>, decision: &Decision) -> Markup {
    let Decision {
        time_s,
        group,
        before,
        choice,
        decider,
        reason,
        cause,
        takeover_us,
        ..
    } = decision;
    html! {
        tr data-s=(time_s) {
            td.n { (at(*time_s)) }
            td.name { (group) }
            td.name { (page.choice(before.as_deref())) }
            td.name { (page.choice(choice.as_deref())) }
            td { (reason) br; small { (cause) } br; (candidate_list(decision)) }
            td { (case(page, decision)) }
            td { (decider) }
            td.n { @if let Some(us) = takeover_us { (chart::seconds(us / 1e6)) } @else { "–" } }
        }
    }
}

/// The case of a selection in a word. An arrival is green.
fn case(page: &Page<'_>, decision: &Decision) -> Markup {
    let timeline = &page.analysis.timeline;
    let word = timeline.case_word(decision);
    html! { @if timeline.is_arrival(decision) { span.good { (word) } } @else { (word) } }
}

/// The candidates: `stop checking · vff winner, ready, urgency 0.42`. Those that were ready are in bold.
fn candidate_list(decision: &Decision) -> Markup {
    html! {
        span.who {
            @for (place, candidate) in decision.candidates.iter().enumerate() {
                @if place > 0 { " · " }
                @if candidate.ready { b { (candidate.name) } } @else { (candidate.name) }
                " " (state_name(candidate.state))
                @if candidate.ready && candidate.state != State::Ready { ", ready" }
                @if let Some(refusal) = decision.refusal_of(&candidate.name) { ", " (refusal) }
                @if let Some(urgency) = candidate.urgency.filter(|urgency| *urgency != 0.0) { ", urgency " (format!("{urgency:.3}")) }
            }
        }
    }
}
