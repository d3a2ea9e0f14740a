//! The title and the legend: the meaning of colours and symbols, and each schema's share of the time as
//! winner.
//!
//! Only what the picture shows has an entry.

use std::collections::BTreeSet;

use super::frame::Frame;
use super::palette::Palette;
use super::{DriveMap, RobotPath, ground, path};
use crate::text::{counted, percent};
use crate::{Align, ColorRole, Drawing, Font, LineStyle};

/// Text size of the title, pixels.
const TITLE_SIZE: f32 = 32.0;
/// Text size of the legend and of the line below the title, pixels.
const TEXT_SIZE: f32 = 18.0;
/// Width of an entry's symbol, and its distance from the text, pixels.
const SYMBOL_WIDTH: f32 = 30.0;
const SYMBOL_GAP: f32 = 10.0;

/// An entry of the legend.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct LegendEntry {
    pub(super) sign: Sign,
    pub(super) text: String,
}

/// The symbol of an entry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sign {
    /// The path while a schema won, or none did.
    Path(Option<usize>),
    /// A change of winner.
    Takeover,
    /// The start of a robot.
    Start,
    /// The end of a robot's path.
    End,
    /// A reached target.
    Reached,
    /// A target that was not reached.
    Missed,
    /// The start of a moving thing.
    Moving,
}

impl LegendEntry {
    /// The width in pixels.
    pub(super) fn width(&self, font: &Font) -> f32 {
        SYMBOL_WIDTH + SYMBOL_GAP + font.width(&self.text, TEXT_SIZE)
    }
}

/// The entries that a drive needs.
pub(super) fn entries(drive: &DriveMap, palette: &Palette) -> Vec<LegendEntry> {
    let times = times(drive);
    let total: f64 = times.iter().map(|(_, time)| time).sum();
    let share = |winner| {
        let time: f64 = times
            .iter()
            .filter(|(of, _)| *of == winner)
            .map(|(_, time)| time)
            .sum();
        percent(if total > 0.0 { time / total } else { 0.0 })
    };
    let name = |winner: usize| drive.schema_names.get(winner).map_or("unknown", String::as_str);
    let drawn_winners: BTreeSet<usize> = drive.drawn_winners().collect();
    let mut entries: Vec<LegendEntry> = palette
        .winners()
        .filter(|winner| drawn_winners.contains(winner))
        .map(|winner| LegendEntry {
            sign: Sign::Path(Some(winner)),
            text: format!("{} {}", name(winner), share(Some(winner))),
        })
        .collect();
    if !drive.schema_names.is_empty() && times.iter().any(|(winner, time)| winner.is_none() && *time > 0.0) {
        entries.push(LegendEntry {
            sign: Sign::Path(None),
            text: format!("nobody {}", share(None)),
        });
    }
    let signs = [
        (!drive.takeovers.is_empty(), Sign::Takeover, "takeover"),
        (drive.has_path(), Sign::Start, "start"),
        (drive.has_path(), Sign::End, "end"),
        (
            drive.targets.iter().any(|target| target.reached),
            Sign::Reached,
            "target reached",
        ),
        (
            drive.targets.iter().any(|target| !target.reached),
            Sign::Missed,
            "target missed",
        ),
        (
            drive.shapes.iter().any(|thing| thing.moving),
            Sign::Moving,
            "mover at start",
        ),
    ];
    let shown = signs.into_iter().filter(|(shown, _, _)| *shown);
    entries.extend(shown.map(|(_, sign, text)| LegendEntry {
        sign,
        text: text.to_owned(),
    }));
    entries
}

/// Draws the title and the numbers of the drive.
pub(super) fn heading(drawing: &mut Drawing, frame: &Frame, drive: &DriveMap) {
    drawing.text(
        &drive.title,
        TITLE_SIZE,
        (frame.map.left(), 52.0),
        Align::Left,
        ColorRole::Ink,
    );
    drawing.text(
        &numbers(drive),
        TEXT_SIZE,
        (frame.map.left(), 84.0),
        Align::Left,
        ColorRole::Soft,
    );
}

/// Draws the legend.
pub(super) fn draw(drawing: &mut Drawing, frame: &Frame, palette: &Palette, entries: &[LegendEntry]) {
    for (entry, &(x, y)) in entries.iter().zip(&frame.legend) {
        sign(drawing, entry.sign, (x + SYMBOL_WIDTH / 2.0, y), palette);
        drawing.label(
            &entry.text,
            TEXT_SIZE,
            (x + SYMBOL_WIDTH + SYMBOL_GAP, y),
            Align::Left,
            ColorRole::Ink,
        );
    }
}

fn sign(drawing: &mut Drawing, sign: Sign, (x, y): (f32, f32), palette: &Palette) {
    match sign {
        Sign::Path(winner) => {
            let line = LineStyle {
                width: 5.0,
                ..path::line(palette, winner)
            };
            drawing.polyline(
                &[
                    (x - SYMBOL_WIDTH / 2.0 + 3.0, y),
                    (x + SYMBOL_WIDTH / 2.0 - 3.0, y),
                ],
                line,
            );
        }
        Sign::Takeover => path::takeover(drawing, (x, y), ColorRole::Soft),
        Sign::Start => path::robot(
            drawing,
            (x, y),
            &path::RobotOutline::disc(11.0),
            0.0,
            path::PathEnd::Start,
        ),
        Sign::End => path::robot(
            drawing,
            (x, y),
            &path::RobotOutline::disc(11.0),
            0.0,
            path::PathEnd::End,
        ),
        Sign::Reached => path::badge(drawing, (x, y), "n", true),
        Sign::Missed => path::badge(drawing, (x, y), "n", false),
        Sign::Moving => ground::moving_disc(drawing, (x, y), 10.0),
    }
}

/// Duration, distance and outcome of the drive as text.
fn numbers(drive: &DriveMap) -> String {
    let mut numbers = Vec::new();
    let driven: Vec<_> = drive.paths.iter().filter(|path| path.points.len() > 1).collect();
    let times = || driven.iter().flat_map(|path| &path.points).map(|at| at.time);
    if !driven.is_empty() {
        let [first, last] = [times().fold(f64::INFINITY, f64::min), times().fold(0.0, f64::max)];
        numbers.push(format!("{:.1} s", last - first));
        let distance = |path: &&RobotPath| match drive.paths.len() {
            1 => format!("{:.1} m", path.distance),
            _ => format!("{} {:.1} m", path.robot, path.distance),
        };
        numbers.push(format!(
            "{} driven",
            driven.iter().map(distance).collect::<Vec<_>>().join(", ")
        ));
    }
    if !drive.targets.is_empty() {
        let reached = drive.targets.iter().filter(|target| target.reached).count();
        numbers.push(format!(
            "{reached} of {} reached",
            counted(drive.targets.len() as u64, "target")
        ));
    }
    if drive.takeover_count > 0 {
        numbers.push(counted(drive.takeover_count, "takeover"));
    }
    numbers.join("  ·  ")
}

/// The time steps of the paths with their winners, seconds. A step backwards in time counts as 0.
fn times(drive: &DriveMap) -> Vec<(Option<usize>, f64)> {
    let pairs = drive.paths.iter().flat_map(|path| path.points.windows(2));
    pairs
        .map(|pair| (pair[0].winner, (pair[1].time - pair[0].time).max(0.0)))
        .collect()
}
