//! The groups of a page: how often their winners changed, how long takeovers took, and who alternates with whom.

use maud::{Markup, html};

use super::{Page, at, counted};
use crate::chart;
use crate::tale::{Contest, Row};

/// Pairs that are told of a group.
const PAIRS: usize = 5;

pub(super) fn groups(page: &Page<'_>) -> Option<Markup> {
    let tale = page.tale;
    let rows = tale.hierarchy.rows();
    let groups: Vec<usize> = rows
        .iter()
        .filter_map(|row| match row {
            Row::Group(group, _) => Some(*group),
            Row::Schema(..) => None,
        })
        .collect();
    if groups.is_empty() {
        return None;
    }
    let knows_contracts = groups
        .iter()
        .any(|group| tale.hierarchy.groups[*group].contract.is_some());
    Some(html! {
        p.note {
            "A takeover goes from its cause to the first iteration of the new winner."
            @if !knows_contracts { " What they may take by contract was not recorded." }
        }
        div.scroll {
            table {
                thead { tr {
                    th { "group" } th { "policy" } th.n { "selections" } th.n { "switches" } th.n { "a second" }
                    th.n { "busiest second" } th.n { "takeover p50" } th.n { "p99" } th.n { "worst" } th.n { "contract" }
                } }
                tbody { @for group in groups { (one(page, group)) } }
            }
        }
    })
}

fn one(page: &Page<'_>, group: usize) -> Markup {
    let (about, contest) = (&page.tale.hierarchy.groups[group], &page.tale.contests[group]);
    let rate = contest.switches as f64 / page.tale.columns.seconds();
    let time = |nanos: Option<f64>| nanos.map_or("–".to_owned(), |nanos| chart::seconds(nanos / 1e9));
    let worst = contest.takeovers.worst();
    let contract = about.contract.map(|contract| contract as f64);
    let broken = worst
        .zip(contract)
        .is_some_and(|(worst, contract)| worst > contract);
    html! {
        tr {
            td.name { b { (about.name) } }
            td { (about.policy) }
            td.n { (contest.decisions) (cases(contest)) }
            td.n { (contest.switches) }
            td.n { (format!("{rate:.2}")) }
            td.n {
                @match contest.busiest {
                    Some((most, time)) => { (most) br; small { "until " (at(time as f64 / 1e9)) } }
                    None => "–",
                }
            }
            td.n { (time(contest.takeovers.quantile(0.5))) }
            td.n { (time(contest.takeovers.quantile(0.99))) }
            td.n {
                @if broken { span.bad { (time(worst)) } } @else { (time(worst)) }
                @if let Some((when, who)) = &contest.worst { br; small { (who) " at " (at(*when as f64 / 1e9)) } }
            }
            td.n { (time(contract)) }
        }
        @let pairs = contest.pairs();
        @if !pairs.is_empty() {
            tr {
                td {}
                td colspan="9" {
                    small { "took over from each other: " }
                    @for (place, pair) in pairs.iter().take(PAIRS).enumerate() {
                        @if place > 0 { " · " }
                        (page.schema(&pair.one)) " ⇄ " (page.schema(&pair.other)) " "
                        (counted(pair.switches, "time"))
                        small { " (" (format!("{:.2}", pair.switches as f64 / page.tale.columns.seconds())) " a second)" }
                    }
                    @if pairs.len() > PAIRS { small { " and " (counted((pairs.len() - PAIRS) as u64, "other pair")) } }
                }
            }
        }
    }
}

/// In which cases (R3) it selected.
fn cases(contest: &Contest) -> Markup {
    let cases = contest
        .cases
        .iter()
        .map(|(case, count)| format!("{count} {case}"));
    let cases: Vec<_> = cases.collect();
    html! { @if !cases.is_empty() { br; small { (cases.join(", ")) } } }
}
