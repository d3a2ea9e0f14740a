//! The schemas of a page: how long each was WINNER, how well it kept its period, how busy it was, and its
//! faults.

use jde_core::State;
use jde_drawing::{ColorRole, Drawing, LineStyle};
use maud::{Markup, PreEscaped, html};

use super::{Page, percent, trouble};
use crate::analysis::SchemaTiming;
use crate::chart::{self, Area};

/// Size of a small chart, units.
const CHART_SIZE: (f32, f32) = (190.0, 34.0);

pub(super) fn schemas(page: &Page<'_>) -> Option<Markup> {
    let analysis = page.analysis;
    let rows = analysis.rows().into_iter();
    let schemas: Vec<(usize, usize)> = rows.filter_map(|row| Some((row.schema()?, row.depth))).collect();
    if schemas.is_empty() {
        return None;
    }
    let virtual_time = analysis.lockstep == Some(true);
    Some(html! {
        p.note {
            "The period is the time between two iterations at successive deadlines, without pauses. The first iteration after "
            "a takeover occurs at once and does not count. For drivers, whose turns are not recorded, it is the time between two values of "
            "their most frequent export. The chart shows the least and the greatest period over time; the dashed line is the "
            "configured period."
            @if virtual_time { " In virtual time, iterations take no time, so there is no load." }
        }
        div.scroll {
            table {
                thead { tr {
                    th { "schema" } th.n { "WINNER" } th.n { "iterations" } th.n { "configured" } th.n { "mean" } th.n { "p50" }
                    th.n { "p99" } th.n { "worst" } th { "period over time" }
                    @if !virtual_time { th.n { "longest turn" } th.n { "load" } }
                    th.n { "overruns" } th.n { "refused" } th.n { "faults" }
                } }
                tbody { @for (schema, depth) in schemas { (schema_row(page, schema, depth, virtual_time)) } }
            }
        }
    })
}

fn schema_row(page: &Page<'_>, schema: usize, depth: usize, virtual_time: bool) -> Markup {
    let analysis = page.analysis;
    let (about, band, work) = (
        &analysis.hierarchy().schemas()[schema],
        &analysis.bands[schema],
        &analysis.timings[schema],
    );
    let time = |nanos: Option<f64>| nanos.map_or("–".to_owned(), |nanos| chart::seconds(nanos / 1e9));
    let won = band.time(State::Winner);
    let configured = analysis.periods[schema];
    let known = &analysis.timeline.schemas()[schema];
    html! {
        tr {
            td.name style={ "padding-left:" (depth.min(8)) "em" } {
                (page.schema(&about.name))
                @if !about.type_name.is_empty() && about.type_name != format!("{0}/{0}", about.name) {
                    br; small { (about.type_name) }
                }
            }
            td.n { (percent(won as f64 / 1e9 / analysis.columns.seconds())) br; small { (chart::seconds(won as f64 / 1e9)) } }
            td.n { @if work.cycles > 0 { (work.iterations) } @else { "–" } }
            td.n { (configured.map_or("–".to_owned(), chart::seconds)) }
            td.n { (time(work.periods.mean())) }
            td.n { (time(work.periods.quantile(0.5))) }
            td.n { (time(work.periods.quantile(0.99))) }
            td.n { (time(work.periods.worst())) }
            td.chart { @if let Some(drawing) = periods(work, configured) { (PreEscaped(drawing.svg("period over time", &format!("p{schema}-")))) } }
            @if !virtual_time {
                td.n { (time(work.busy.worst())) }
                td.n { (load(page, schema)) }
            }
            td.n { (trouble(known.counts.overruns)) }
            td.n { (trouble(known.counts.refused)) }
            td.n {
                (trouble(known.counts.faults))
                @if let Some(fault) = &known.last_fault { br; small { (fault) } }
            }
        }
    }
}

/// The busy share of a schema's time awake.
fn load(page: &Page<'_>, schema: usize) -> String {
    let (band, work) = (&page.analysis.bands[schema], &page.analysis.timings[schema]);
    let awake: u64 = [State::Winner, State::Ready, State::Checking]
        .map(|state| band.time(state))
        .iter()
        .sum();
    if work.busy.count() == 0 || awake == 0 {
        return "–".to_owned();
    }
    percent(work.busy.sum() as f64 / awake as f64)
}

fn periods(work: &SchemaTiming, configured: Option<f64>) -> Option<Drawing> {
    let (least, greatest) = work.over_time.range()?;
    let top = greatest.max(configured.unwrap_or(0.0)) * 1.1;
    let mut drawing = Drawing::new(CHART_SIZE.0, CHART_SIZE.1);
    let area = Area {
        left: 0.5,
        top: 0.5,
        width: CHART_SIZE.0 - 1.0,
        height: CHART_SIZE.1 - 1.0,
    };
    let style = LineStyle::new(ColorRole::Of(0), 1.2);
    // The axis begins at 0, unless that would hide the variation.
    let bottom = if least > 0.8 * greatest { least * 0.95 } else { 0.0 };
    let bottom = configured.map_or(bottom, |configured| bottom.min(configured * 0.95));
    chart::small_chart(
        &mut drawing,
        area,
        &work.over_time,
        (bottom, top),
        configured,
        style,
    );
    Some(drawing)
}
