//! The groups of a page: how often their winners changed, how long takeovers took, and which schemas
//! alternate.

use jde_records::chattering::MAX_SWITCHES;
use maud::{Markup, html};

use super::{Page, at, counted};
use crate::analysis::{ChatterStatistics, GroupStatistics};
use crate::chart;

/// Most pairs listed for a group.
const MAX_PAIRS: usize = 5;

pub(super) fn groups(page: &Page<'_>) -> Option<Markup> {
    let analysis = page.analysis;
    let rows = analysis.rows().into_iter();
    let groups: Vec<usize> = rows.filter_map(|row| row.group()).collect();
    if groups.is_empty() {
        return None;
    }
    let knows_contracts = groups
        .iter()
        .any(|group| analysis.hierarchy().groups()[*group].contract.is_some());
    Some(html! {
        p.note {
            "A takeover lasts from its cause to the first iteration of the new winner."
            @if !knows_contracts { " The limits of the contracts were not recorded." }
        }
        div.scroll {
            table {
                thead { tr {
                    th { "group" } th { "policy" } th.n { "selections" } th.n { "switches" } th.n { "a second" }
                    th.n { "busiest second" } th.n { "takeover p50" } th.n { "p99" } th.n { "worst" } th.n { "contract" }
                } }
                tbody { @for group in groups { (group_rows(page, group)) } }
            }
        }
    })
}

fn group_rows(page: &Page<'_>, group: usize) -> Markup {
    let (about, statistics) = (
        &page.analysis.hierarchy().groups()[group],
        &page.analysis.groups[group],
    );
    let rate = statistics.switches as f64 / page.analysis.columns.seconds();
    let time = |nanos: Option<f64>| nanos.map_or("–".to_owned(), |nanos| chart::seconds(nanos / 1e9));
    let worst = statistics.takeovers.worst();
    let contract = about.contract.map(|contract| contract as f64);
    let broken = worst
        .zip(contract)
        .is_some_and(|(worst, contract)| worst > contract);
    html! {
        tr {
            td.name { b { (about.name) } }
            td { (about.policy) }
            td.n { (statistics.decisions) (cases(statistics)) }
            td.n { (statistics.switches) }
            td.n { (format!("{rate:.2}")) }
            td.n {
                @match statistics.busiest {
                    Some((count, time)) => { (count) br; small { "until " (at(time as f64 / 1e9)) } }
                    None => "–",
                }
            }
            td.n { (time(statistics.takeovers.quantile(0.5))) }
            td.n { (time(statistics.takeovers.quantile(0.99))) }
            td.n {
                @if broken { span.bad { (time(worst)) } } @else { (time(worst)) }
                @if let Some((time_ns, schema)) = &statistics.worst { br; small { (schema) " at " (at(*time_ns as f64 / 1e9)) } }
            }
            td.n { (time(contract)) }
        }
        @if statistics.chatter.spells > 0 {
            tr { td {} td colspan="9" { (chatter_report(page, &statistics.chatter)) } }
        }
        @let pairs = statistics.pairs();
        @if !pairs.is_empty() {
            tr {
                td {}
                td colspan="9" {
                    small { "took over from each other: " }
                    @for (place, pair) in pairs.iter().take(MAX_PAIRS).enumerate() {
                        @if place > 0 { " · " }
                        (page.schema(&pair.first_schema)) " ⇄ " (page.schema(&pair.second_schema)) " "
                        (counted(pair.switches, "time"))
                        small { " (" (format!("{:.2}", pair.switches as f64 / page.analysis.columns.seconds())) " a second)" }
                    }
                    @if pairs.len() > MAX_PAIRS { small { " and " (counted((pairs.len() - MAX_PAIRS) as u64, "other pair")) } }
                }
            }
        }
    }
}

/// Reports that the group chattered, and which policy settings would have prevented it.
fn chatter_report(page: &Page<'_>, chatter: &ChatterStatistics) -> Markup {
    let spells = match chatter.spells {
        1 => String::from("once"),
        count => format!("{count} times"),
    };
    let switches = counted(chatter.switches, "switch");
    html! {
        span.bad { "chattered " (spells) }
        @if let Some((first, second)) = chatter.between() {
            ", most between " (page.choice(first)) " and " (page.choice(second))
        }
        ": " (switches) " at more than " (MAX_SWITCHES) " a second, "
        (chatter.collisions) " of them where several were ready. "
        @if chatter.would_a_policy_help() {
            @if let Some(dwell) = chatter.dwell() {
                "Nine in ten of " (counted(dwell.count, "stay")) " were no longer than " (chart::seconds(dwell.bound))
                ". Twice that is " code { "policy = \"sticky\", dwell = \"" (milliseconds(dwell.value)) "\"" }
                ", which limits the group to " (format!("{:.1}", 1.0 / dwell.value)) " changes per second. "
            }
            @if let Some(hysteresis) = chatter.hysteresis() {
                "Nine in ten of " (counted(hysteresis.count, "takeover")) " were won by an urgency no more than "
                (format!("{:.3}", hysteresis.bound)) " greater: " code { "hysteresis = " (short(hysteresis.value)) } " would have prevented them. "
            }
        } @else {
            "Where only one candidate is ready, no policy decides (R4). Let its precondition begin and end at different values with "
            code { "Hysteresis" } " of the SDK. "
            @if let Some(dwell) = chatter.dwell() {
                "Nine in ten of " (counted(dwell.count, "stay")) " were no longer than " (chart::seconds(dwell.bound)) "."
            }
        }
    }
}

/// Whole milliseconds, in the format of application files.
fn milliseconds(seconds: f64) -> String {
    format!("{}ms", (seconds * 1e3).ceil())
}

/// A number of two digits, without rounding errors in its last digits.
fn short(value: f64) -> String {
    let text = format!("{value:.9}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// The cases (R3) of the selections, with their numbers.
fn cases(statistics: &GroupStatistics) -> Markup {
    let cases = statistics
        .cases
        .iter()
        .map(|(case, count)| format!("{count} {case}"));
    let cases: Vec<_> = cases.collect();
    html! { @if !cases.is_empty() { br; small { (cases.join(", ")) } } }
}
