//! A page about a recording: one self-contained HTML file. It loads nothing, is readable without a script,
//! and has styles for light, dark and print. Text from the recording is escaped and never becomes markup.

mod events;
mod figures;
mod groups;
mod schemas;
mod summary;
mod switches;
mod topics;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use maud::{DOCTYPE, Markup, PreEscaped, html};
use sha2::{Digest, Sha256};

use crate::analysis::Analysis;
use crate::drawing::{ColorRole, color_role};
use crate::map::Palette;
use crate::text::counted;

const STYLE: &str = include_str!("style.css");
const SCRIPT: &str = include_str!("script.js");

/// Most columns of time on a page: two per pixel of common screens, so that the page can be enlarged.
const COLUMNS: usize = 2400;
/// Most columns of all schemas together, so that a page with a thousand schemas still opens.
const ALL_COLUMNS: usize = 600_000;

/// The data that the parts of a page share.
struct Page<'t> {
    analysis: &'t Analysis,
    palette: Palette,
}

/// The number of time columns for the page of a recording with this many schemas.
#[must_use]
pub fn columns(schemas: usize) -> usize {
    (ALL_COLUMNS / schemas.max(1)).clamp(300, COLUMNS)
}

/// Renders the page. `file` is the displayed name of the recording.
#[must_use]
pub fn page(analysis: &Analysis, file: &str) -> String {
    let page = Page {
        analysis,
        palette: Palette::of(&analysis.ending.drive),
    };
    let parts = [
        ("path", "Path", figures::path(&page)),
        ("states", "States over time", figures::bands(&page)),
        ("groups", "Groups", groups::groups(&page)),
        ("schemas", "Schemas", schemas::schemas(&page)),
        ("switches", "Switches", switches::switches(&page)),
        ("events", "Events", events::events(&page)),
        ("topics", "Recorded topics", topics::topics(&page)),
    ];
    let style = format!("{}{STYLE}", color_role::style());
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta http-equiv="Content-Security-Policy" content=(policy());
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (analysis.title) " – " (file) }
                style { (PreEscaped(style)) }
            }
            body {
                main {
                    (summary::summary(&page, file))
                    nav aria-label="Parts of this page" {
                        @for (id, title, part) in &parts {
                            @if part.is_some() { a href={ "#" (id) } { (title) } }
                        }
                    }
                    (summary::facts(&page))
                    @for (id, title, part) in &parts {
                        @if let Some(part) = part {
                            section id=(id) {
                                h2 { (title) }
                                (part)
                            }
                        }
                    }
                    (footer(&page))
                }
                script { (PreEscaped(SCRIPT)) }
            }
        }
    }
    .into_string()
}

/// The content security policy: nothing is loaded, and only the page's own script runs, whatever the
/// recording contains.
fn policy() -> String {
    let hash = STANDARD.encode(Sha256::digest(SCRIPT));
    format!(
        "default-src 'none'; style-src 'unsafe-inline'; script-src 'sha256-{hash}'; base-uri 'none'; form-action 'none'"
    )
}

fn footer(page: &Page<'_>) -> Markup {
    let columns = page.analysis.columns;
    html! {
        footer {
            "Time is divided into " (columns.count) " columns of "
            (crate::chart::seconds(columns.seconds() / columns.count as f64))
            ". For each column, bands show all states, fainter for a shorter time, and lines show the least and the greatest value. Means and "
            "worst times are exact, p50 and p99 within 2 %. Made by " code { "jde report" } " " (env!("CARGO_PKG_VERSION")) "."
        }
    }
}

impl Page<'_> {
    /// A schema's name with its colour in the drawings.
    fn schema(&self, name: &str) -> Markup {
        let place = self.analysis.hierarchy.find(name);
        let color = match place {
            Some(place) if self.analysis.hierarchy.is_actor(place) => self.palette.tone(Some(place)),
            Some(_) | None => ColorRole::Edge,
        };
        html! { i.sign style={ "background:var(" (color) ")" } {} (name) }
    }

    /// The choice of a selection: a schema, or "nobody".
    fn choice(&self, choice: Option<&str>) -> Markup {
        match choice {
            Some(name) => self.schema(name),
            None => html! { span.who { "nobody" } },
        }
    }
}

/// Seconds since the application's start, to the millisecond.
fn at(seconds: f64) -> String {
    format!("{seconds:.3} s")
}

/// A share as a percentage.
fn percent(share: f64) -> String {
    match share * 100.0 {
        share if share > 0.0 && share < 0.1 => "<0.1 %".to_owned(),
        share if share < 10.0 => format!("{share:.1} %"),
        share => format!("{share:.0} %"),
    }
}

/// A count that is marked unless it is 0.
fn trouble(count: u64) -> Markup {
    html! { @if count == 0 { "0" } @else { span.bad { (count) } } }
}
