//! The drives that did not pass: the first ones with their paths and selections, more of them as rows, and of
//! the rest only their number.

use jde_drawing::map::{self, DriveMap};
use jde_drawing::text::counted;
use maud::{Markup, PreEscaped, html};

use super::FailedDrive;

/// The number of drives that are shown in full: more than anybody looks at in one page.
pub const IN_FULL: usize = 50;
/// The number of drives that have a row: a page of ten thousand opens slowly.
const MAX_ROWS: usize = 1_000;
/// The size of a map of a drive, units: half of a wide page, so that its texts are readable on a narrow one.
const DRIVE_MAP_SIZE: (f32, f32) = (680.0, 560.0);

pub(super) fn failures(drives: &[FailedDrive]) -> Option<Markup> {
    if drives.is_empty() {
        return None;
    }
    let (full, others) = drives.split_at(drives.len().min(IN_FULL));
    let (rows, left_out) = others.split_at(others.len().min(MAX_ROWS));
    Some(html! {
        @for drive in full { (in_full(drive)) }
        @if !rows.is_empty() {
            details {
                summary { (counted(rows.len() as u64, "more drive")) }
                div.scroll {
                    table {
                        thead { tr { th.n { "drive" } th { "axes" } th { "outcome" } th { "why" } th { "to repeat it" } } }
                        tbody {
                            @for drive in rows {
                                tr {
                                    td.n { (drive.number) }
                                    td.words { (drive.axes) }
                                    td { span.bad { (drive.outcome) } }
                                    td.words { (drive.why) }
                                    td { code { (drive.command) } }
                                }
                            }
                        }
                    }
                }
            }
        }
        @if !left_out.is_empty() {
            p.note { (counted(left_out.len() as u64, "further drive")) " are only in " code { "results.jsonl" } "." }
        }
    })
}

fn in_full(drive: &FailedDrive) -> Markup {
    html! {
        article.drive id={ "drive-" (drive.number) } {
            h3 { "Drive " (drive.number) " " span.bad { (drive.outcome) } }
            @if !drive.axes.is_empty() { p.note { (drive.axes) } }
            @if !drive.why.is_empty() { p.why { (drive.why) } }
            div.parts {
                @if let Some(path) = drive.path.as_ref().filter(|path| path.has_path()) { (figure(drive.number, path)) }
                div {
                    @if !drive.selections.is_empty() {
                        h4 { "The selections before it" }
                        ol.selections { @for selection in &drive.selections { li { (selection) } } }
                    }
                    h4 { "To repeat it and see it" }
                    code.command { (drive.command) }
                }
            }
        }
    }
}

fn figure(number: usize, path: &DriveMap) -> Markup {
    let drawing = map::draw_within_page(path, DRIVE_MAP_SIZE.0, DRIVE_MAP_SIZE.1);
    let label = format!("The path of drive {number} until it failed");
    html! { figure.map { (PreEscaped(drawing.svg(&label, &format!("f{number}-")))) } }
}
