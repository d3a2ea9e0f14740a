//! The drives that did not pass: where, and how each of them came to it.

use std::path::PathBuf;

use jde_drawing::map::{DriveMap, FailurePlace, PathPoint, RobotPath, Takeover};
use jde_report::experiment::{FailedDrive, FailureMap, IN_FULL};
use jde_report::view_command;
use jde_sim::Footprint;

use super::Page;
use super::worlds::Worlds;
use crate::comparison::words;
use crate::result::{DriveFailure, DriveResult, Outcome};

/// Shapes on all maps of drives together: a world of an occupancy map has thousands, and every map repeats
/// them.
const MAX_SHAPES: usize = 40_000;

/// Where the drives of each world failed, the worlds in the order of their first failure.
pub(super) fn places(page: &Page<'_>, worlds: &mut Worlds<'_>) -> Vec<FailureMap> {
    let mut maps: Vec<(Option<PathBuf>, FailureMap)> = Vec::new();
    for result in &page.results {
        let Some([x, y, _]) = result.failure.as_ref().and_then(|failure| failure.pose) else {
            continue;
        };
        let place = FailurePlace {
            x,
            y,
            label: format!("drive {}: {}", result.drive, result.why),
        };
        let (path, ground) = worlds.of(result);
        match maps.iter_mut().find(|(known, _)| *known == path) {
            Some((_, map)) => map.places.push(place),
            None => maps.push((
                path,
                FailureMap {
                    title: ground.drive.title.clone(),
                    note: ground.note.clone(),
                    ground: ground.drive.clone(),
                    places: vec![place],
                },
            )),
        }
    }
    maps.into_iter().map(|(_, map)| map).collect()
}

/// The drives that did not pass, in their order.
pub(super) fn failures(page: &Page<'_>, worlds: &mut Worlds<'_>) -> Vec<FailedDrive> {
    let results = page.results.iter();
    let failed = results.filter(|result| result.outcome != Outcome::Passed);
    let mut shapes = 0;
    failed
        .enumerate()
        .map(|(place, result)| {
            let drawn = result
                .failure
                .as_ref()
                .filter(|failure| place < IN_FULL && !failure.path.is_empty());
            let path = drawn.map(|failure| {
                let mut ground = worlds.of(result).1.drive.clone();
                shapes += ground.shapes.len() + ground.paint.len();
                if shapes > MAX_SHAPES {
                    ground.shapes.clear();
                    ground.paint.clear();
                }
                drive(failure, ground, page.summary.robot.cloned())
            });
            let failure = result.failure.as_ref();
            FailedDrive {
                number: result.drive,
                axes: axes(page, result),
                outcome: result.outcome.word().to_owned(),
                why: result.why.clone(),
                path,
                selections: failure.map_or_else(Vec::new, |failure| failure.selections.clone()),
                command: match failure {
                    Some(failure) => format!(
                        "{} --record failure.mcap\n{}",
                        (page.summary.command)(result.drive),
                        view_command("failure.mcap", failure.at)
                    ),
                    None => (page.summary.command)(result.drive),
                },
            }
        })
        .collect()
}

fn axes(page: &Page<'_>, result: &DriveResult) -> String {
    let axes = page.summary.columns.axes.iter().zip(&result.axes);
    let words = axes.map(|(axis, value)| format!("{axis} {}", words(value)));
    words.collect::<Vec<_>>().join(", ")
}

/// The path of a robot until it failed, on its world.
fn drive(failure: &DriveFailure, ground: DriveMap, body: Option<Footprint>) -> DriveMap {
    let mut names: Vec<String> = Vec::new();
    let mut winners: Vec<Option<usize>> = Vec::new();
    let mut runs = failure.winners.iter().peekable();
    let mut winner = None;
    for place in 0..failure.path.len() {
        while let Some((_, name)) = runs.next_if(|(first, _)| *first <= place) {
            winner = name.as_ref().map(|name| number(&mut names, name));
        }
        winners.push(winner);
    }
    // Equal intervals of time; without winners, the time of which schema would be shown is not known.
    let step = match failure.winners.is_empty() {
        true => 0.0,
        false => failure.at / (failure.path.len() - 1).max(1) as f64,
    };
    let points: Vec<PathPoint> = (0..failure.path.len())
        .map(|place| PathPoint {
            time: place as f64 * step,
            x: failure.path[place][0],
            y: failure.path[place][1],
            heading: heading(failure, place),
            winner: winners[place],
        })
        .collect();
    let takeovers = points.windows(2).filter_map(|pair| {
        let to = pair[1].winner.filter(|_| pair[0].winner != pair[1].winner)?;
        Some(Takeover {
            x: pair[1].x,
            y: pair[1].y,
            to,
        })
    });
    DriveMap {
        takeovers: takeovers.collect(),
        schema_names: names,
        paths: vec![RobotPath {
            points,
            body,
            ..RobotPath::default()
        }],
        ..ground
    }
}

/// The number of a name in the list, which gets it if it is new.
fn number(names: &mut Vec<String>, name: &str) -> usize {
    names.iter().position(|known| known == name).unwrap_or_else(|| {
        names.push(name.to_owned());
        names.len() - 1
    })
}

/// The heading of the robot at a point of its path: that of its pose at the end, else towards the next point.
fn heading(failure: &DriveFailure, place: usize) -> f64 {
    let last = failure.path.len() - 1;
    match failure.pose {
        Some([_, _, heading]) if place == last => heading,
        _ => {
            let from = place.min(last.saturating_sub(1));
            let [[x, y], [to_x, to_y]] = [failure.path[from], failure.path[(from + 1).min(last)]];
            (to_y - y).atan2(to_x - x)
        }
    }
}
