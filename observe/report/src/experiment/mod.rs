//! A page about an experiment: tables, distributions, where drives fail, and each failed drive with its path.
//! It draws and renders what it is given, and computes no statistics.

mod data;
mod distribution;
mod failures;
#[cfg(test)]
mod tests;

use jde_drawing::map;
use jde_drawing::text::counted;
use maud::{Markup, PreEscaped, html};

use crate::document::{Document, Part};

pub use data::{Cell, Distribution, DistributionRow, Fact, FailedDrive, FailureMap, Report, Table, Title};
pub use failures::IN_FULL;

const STYLE: &str = include_str!("style.css");

/// The size of a map of failures, units.
const FAILURE_MAP_SIZE: (f32, f32) = (760.0, 620.0);

/// Renders the page. The same report gives the same page.
#[must_use]
pub fn page(report: &Report) -> String {
    let mut parts: Vec<Part> = vec![
        ("results", "Results", table(&report.results)),
        ("differences", "Differences", table(&report.differences)),
        ("properties", "Properties", table(&report.properties)),
        (
            "distributions",
            "Distributions",
            distribution::distributions(&report.distributions),
        ),
        ("places", "Where drives fail", places(&report.places)),
    ];
    parts.push((
        "failures",
        "Drives that did not pass",
        failures::failures(&report.failures),
    ));
    Document {
        title: format!("{} – experiment", report.name),
        style: STYLE,
        head: html! {
            header {
                h1 { (report.name) }
                @if !report.doc.is_empty() { p { (report.doc) } }
            }
        },
        facts: facts(&report.facts),
        parts: &parts,
        footer: html! {
            (report.method) " Made by " code { "jde experiment" } " " (env!("CARGO_PKG_VERSION")) "."
        },
        script: None,
    }
    .render()
}

fn facts(facts: &[Fact]) -> Markup {
    html! {
        dl.facts {
            @for fact in facts {
                div {
                    dt { (fact.label) }
                    dd {
                        @if fact.is_bad { span.bad { (fact.value) } } @else { (fact.value) }
                        @if !fact.detail.is_empty() { small { (fact.detail) } }
                    }
                }
            }
        }
    }
}

fn table(table: &Table) -> Option<Markup> {
    if table.rows.is_empty() {
        return None;
    }
    let is_number = |column: usize| table.titles.get(column).is_some_and(|title| title.is_number);
    Some(html! {
        @if !table.note.is_empty() { p.note { (table.note) } }
        div.scroll {
            table {
                thead { tr { @for title in &table.titles { th.n[title.is_number] { (title.text) } } } }
                tbody {
                    @for row in &table.rows {
                        tr {
                            @for (column, cell) in row.iter().enumerate() {
                                td.n[is_number(column)].words[!is_number(column)] { (self::cell(cell)) }
                            }
                        }
                    }
                }
            }
        }
    })
}

fn cell(cell: &Cell) -> Markup {
    html! {
        @if cell.is_bad { span.bad { (cell.text) } } @else if cell.is_strong { b { (cell.text) } } @else { (cell.text) }
        @for detail in &cell.details { br; small { (detail) } }
    }
}

fn places(maps: &[FailureMap]) -> Option<Markup> {
    let maps: Vec<_> = maps.iter().filter(|map| !map.places.is_empty()).collect();
    if maps.is_empty() {
        return None;
    }
    Some(html! {
        p.note { "A dot is the place of a robot when the first property of its drive failed. The more of them are in a cell, the stronger is its colour." }
        @for (number, map) in maps.into_iter().enumerate() {
            @let drawing = map::draw_failures(&map.ground, &map.places, FAILURE_MAP_SIZE.0, FAILURE_MAP_SIZE.1);
            @let label = format!("Where {} of {} failed", counted(map.places.len() as u64, "drive"), map.title);
            figure.map {
                figcaption { (map.title) " " small { (counted(map.places.len() as u64, "drive")) } }
                @if !map.note.is_empty() { p.note { (map.note) } }
                (PreEscaped(drawing.svg(&label, &format!("w{number}-"))))
            }
        }
    })
}
