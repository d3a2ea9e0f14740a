//! Lists of worlds in the form of the BARN challenge (Perille, Truong, Xiao and Stone, *Benchmarking Metric
//! Ground Navigation*, 2020): a line has the number of a world and the centres of its cylinders.

use std::collections::HashSet;
use std::path::Path;

use jde_document::{Fault, Faults};
use jde_files::LeftOut;

use super::ImportedWorld;
use super::writer::Draft;

/// The radius of a cylinder, m.
const RADIUS: f64 = 0.075;
/// The height of a cylinder, m: above every laser of a small robot.
const HEIGHT: f64 = 1.0;
/// Where the robot of the challenge starts: m, m, degrees.
const START: [f64; 3] = [-2.25, 3.0, 90.0];

pub(super) fn read(path: &Path, text: &str) -> Result<Vec<ImportedWorld>, Faults> {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let fault = |line, message| Fault::at_line(path, line, message);
    let mut worlds = Vec::new();
    let mut faults = Vec::new();
    let mut seen = HashSet::new();
    let lines = (1..)
        .zip(text.lines())
        .filter(|(_, line)| !line.trim().is_empty());
    for (number, line) in lines {
        match world(line) {
            Ok((index, _)) if !seen.insert(index) => {
                faults.push(fault(number, format!("world {index} is there twice")));
            }
            Ok((index, draft)) => worlds.push(ImportedWorld {
                name: format!("{index:03}"),
                text: draft.write(
                    &format!("World {index} of {stem}. Metres, degrees."),
                    &format!("{stem} {index}"),
                ),
                files: Vec::new(),
                left_out: LeftOut::default(),
                notes: Vec::new(),
            }),
            Err(message) => faults.push(fault(number, message)),
        }
    }
    if worlds.is_empty() && faults.is_empty() {
        faults.push(fault(
            1,
            "has no world: expected lines `NUMBER X,Y X,Y ...`".to_owned(),
        ));
    }
    if faults.is_empty() {
        Ok(worlds)
    } else {
        Err(faults.into())
    }
}

fn world(line: &str) -> Result<(u32, Draft), String> {
    let mut words = line.split_whitespace();
    let index = words.next().unwrap_or_default();
    let index = index
        .parse()
        .map_err(|_| format!("`{}` is not a number of a world", index.escape_debug()))?;
    let mut draft = Draft {
        starts: vec![("robot".to_owned(), START)],
        ..Draft::default()
    };
    for word in words {
        let center = point(word)
            .ok_or_else(|| format!("`{}` is no centre: expected X,Y in metres", word.escape_debug()))?;
        draft.add_circle(center, RADIUS, HEIGHT);
    }
    if draft.is_empty() {
        return Err("has no cylinder: expected `NUMBER X,Y X,Y ...`".to_owned());
    }
    Ok((index, draft))
}

fn point(word: &str) -> Option<[f64; 2]> {
    let (x, y) = word.split_once(',')?;
    let coordinate = |text: &str| text.parse().ok().filter(|value: &f64| value.is_finite());
    Some([coordinate(x)?, coordinate(y)?])
}
