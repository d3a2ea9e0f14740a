//! A page about a recording: its parts, and the script that selects a time. It knows no style.

mod events;
mod figures;
mod groups;
mod schemas;
mod summary;
mod switches;
mod topics;

use jde_drawing::ColorRole;
use jde_drawing::map::Palette;
use jde_drawing::text::counted;
use maud::{Markup, html};

use crate::analysis::Analysis;
use crate::document::Document;

const SCRIPT: &str = include_str!("script.js");

/// Most columns of time on a page: two per pixel of common screens, so that the page can be enlarged.
const MAX_COLUMNS: usize = 2400;
/// Most columns of all schemas together, so that a page with a thousand schemas still opens.
const ALL_COLUMNS: usize = 600_000;

/// The data that the parts of a page share.
struct Page<'t> {
    analysis: &'t Analysis,
    /// The displayed name of the recording.
    file: &'t str,
    palette: Palette,
}

/// The number of time columns for the page of a recording with this many schemas.
#[must_use]
pub fn columns(schemas: usize) -> usize {
    (ALL_COLUMNS / schemas.max(1)).clamp(300, MAX_COLUMNS)
}

/// Renders the page. `file` is the displayed name of the recording.
#[must_use]
pub fn page(analysis: &Analysis, file: &str) -> String {
    let page = Page {
        analysis,
        file,
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
    Document {
        title: format!("{} – {file}", analysis.title),
        style: "",
        head: summary::summary(&page, file),
        facts: summary::facts(&page),
        parts: &parts,
        footer: footer(&page),
        script: Some(SCRIPT),
    }
    .render()
}

fn footer(page: &Page<'_>) -> Markup {
    let columns = page.analysis.columns;
    html! {
        "Time is divided into " (columns.count) " columns of "
        (crate::chart::seconds(columns.seconds() / columns.count as f64))
        ". For each column, bands show all states, fainter for a shorter time, and lines show the least and the greatest value. Means and "
        "worst times are exact, p50 and p99 within 2 %. Made by " code { "jde report" } " " (env!("CARGO_PKG_VERSION")) "."
    }
}

impl Page<'_> {
    /// A schema's name with its colour in the drawings.
    fn schema(&self, name: &str) -> Markup {
        let place = self.analysis.hierarchy().find(name);
        let color = match place {
            Some(place) if self.analysis.hierarchy().is_actor(place) => self.palette.tone(Some(place)),
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
