//! Worlds of Stage: the bitmaps, blocks and robots of its models, seen from above (the manual of Stage 4:
//! world files, `model`, `position`).
//!
//! The body and the sensors of a robot are left out: the driver of an application chooses the robot.

mod raster;
mod syntax;

use std::path::Path;

use jde_files::LeftOut;

use super::pose::Pose;
use super::writer::{Draft, DraftBox, DraftWall};
use super::{ImportedWorld, OVERHEAD};
use crate::error::Fault;
use raster::{Bitmap, Raster};
use syntax::Entity;

/// The size of a model that states none, m.
const SIZE: [f64; 3] = [0.4, 0.4, 1.0];
/// Types of models that sense or act.
const INSTRUMENTS: [&str; 9] = [
    "actuator",
    "blinkenlight",
    "blobfinder",
    "bumper",
    "camera",
    "fiducial",
    "gripper",
    "lightindicator",
    "ranger",
];
/// The outline of a model without blocks.
const SQUARE: [[f64; 2]; 4] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];

/// A part of a model: a polygon, in the units of its file, and its lower and upper edge.
struct Block {
    points: Vec<[f64; 2]>,
    z: [f64; 2],
}

#[derive(Default)]
struct Reader {
    draft: Draft,
    bitmaps: Vec<Bitmap>,
    notes: Vec<String>,
    faults: Vec<Fault>,
}

pub(super) fn read(path: &Path, text: &str, stem: String) -> Result<ImportedWorld, Vec<Fault>> {
    let root = syntax::parse(path, text).map_err(|fault| vec![fault])?;
    let mut reader = Reader::default();
    for (key, known) in [("unit_length", "m"), ("unit_angle", "degrees")] {
        if let Some(unit) = root.text(key).filter(|unit| *unit != known) {
            let message = format!("`{key}` is {unit:?}, and only {known:?} is supported");
            reader.faults.push(root.place.fault(message));
        }
    }
    for entity in root.children.iter().filter(|entity| entity.base != "window") {
        if let Err(fault) = reader.entity(entity, Pose::ORIGIN, "") {
            reader.faults.push(fault);
        }
    }
    let mut files = Vec::new();
    let starts: Vec<_> = (reader.draft.starts.iter())
        .map(|(_, [x, y, _])| [*x, *y])
        .collect();
    match Raster::draw(&reader.bitmaps, &starts) {
        Ok(None) => {}
        Ok(Some(raster)) => {
            let (map, picture) = (format!("{stem}.yaml"), format!("{stem}.pgm"));
            files.push((map.clone(), raster.yaml(&picture).into_bytes()));
            files.push((picture, raster.pgm));
            reader.draft.map = Some(map);
        }
        Err(message) => reader.faults.push(root.place.fault(message)),
    }
    if reader.faults.is_empty() && reader.draft.is_empty() {
        reader
            .faults
            .push(root.place.fault("has no model that stands on the floor"));
    }
    if !reader.faults.is_empty() {
        return Err(reader.faults);
    }
    if !reader.draft.starts.is_empty() {
        let count = reader.draft.starts.len();
        let message = "their starts are kept, their bodies and sensors are left out";
        reader.notes.push(format!("{count} robots: {message}."));
    }
    let comment = format!("Converted from the Stage world {stem}. Metres, degrees.");
    Ok(ImportedWorld {
        text: reader.draft.write(&comment, &stem),
        files,
        left_out: LeftOut::default(),
        notes: reader.notes,
        name: stem,
    })
}

/// Returns a property as a pose: x, y, z, and the angle in degrees.
fn pose(entity: &Entity, key: &str) -> Result<Pose, Fault> {
    let numbers = entity.numbers(key, 4..=4)?;
    Ok(numbers.map_or(Pose::ORIGIN, |numbers| Pose {
        x: numbers[0],
        y: numbers[1],
        z: numbers[2],
        yaw: numbers[3].to_radians(),
    }))
}

impl Reader {
    /// Reads a model and those on it. `frame` is the pose of its parent, at the height on which it stands.
    fn entity(&mut self, entity: &Entity, frame: Pose, prefix: &str) -> Result<(), Fault> {
        let base = entity.base.as_str();
        if matches!(base, "block" | "sensor") {
            return Ok(());
        }
        let name = format!("{prefix}{}", entity.text("name").unwrap_or(&entity.kind));
        if INSTRUMENTS.contains(&base) {
            self.notes.push(format!("`{name}` is a {base} and is left out."));
            return Ok(());
        }
        let pose = frame.compose(pose(entity, "pose")?);
        match base {
            "position" => {
                self.add_robot(name, pose);
                return Ok(());
            }
            "model" => {}
            _ => {
                let message = format!("`{base}` is no model: define it, or include the file that does");
                return Err(entity.place.fault(message));
            }
        }
        let mut size = SIZE;
        if let Some(numbers) = entity.numbers("size", 2..=3)? {
            size[..numbers.len()].copy_from_slice(numbers);
        }
        self.solid(entity, &name, pose, size)?;
        let mut top = pose;
        if entity.is_positive("stack_children", true)? {
            top.z += size[2];
        }
        for child in &entity.children {
            self.entity(child, top, &format!("{name}."))?;
        }
        Ok(())
    }

    fn add_robot(&mut self, name: String, pose: Pose) {
        let mut unique = name.clone();
        for number in 2.. {
            if self.draft.starts.iter().all(|(known, _)| *known != unique) {
                break;
            }
            unique = format!("{name} {number}");
        }
        let start = [pose.x, pose.y, pose.yaw.to_degrees()];
        self.draft.starts.push((unique, start));
    }

    /// Adds what a model is made of.
    fn solid(&mut self, entity: &Entity, name: &str, pose: Pose, size: [f64; 3]) -> Result<(), Fault> {
        let is_seen = entity
            .numbers("ranger_return", 1..=1)?
            .is_none_or(|reflected| reflected[0] >= 0.0);
        if !is_seen && !entity.is_positive("obstacle_return", true)? {
            self.notes.push(format!(
                "`{name}` is a mark: nothing detects it, and it is left out."
            ));
            return Ok(());
        }
        let pose = pose.compose(self::pose(entity, "origin")?);
        let [x, y, height] = size;
        if !size.iter().all(|length| *length > 0.0) {
            return Err(entity
                .place
                .fault(format!("the size of `{name}` is wrong: expected lengths above 0")));
        }
        if pose.z > OVERHEAD {
            self.notes.push(format!(
                "`{name}` is {:.2} m above the floor and is left out.",
                pose.z
            ));
            return Ok(());
        }
        let boundary = entity.is_positive("boundary", false)?;
        if let Some((path, place)) = entity.path("bitmap") {
            let bitmap = Bitmap::load(&path, pose, [x, y]).map_err(|message| place.fault(message))?;
            self.bitmaps.push(bitmap);
        } else if !entity.is_positive("noblocks", false)? {
            self.blocks(entity, name, pose, size)?;
        }
        if boundary {
            let points = SQUARE.map(|[u, v]| pose.point([(u - 0.5) * x, (v - 0.5) * y]));
            self.draft.walls.push(DraftWall {
                name: name.to_owned(),
                points: points.to_vec(),
                height: pose.z + height,
            });
        }
        Ok(())
    }

    /// Adds the blocks of a model, which Stage stretches over its size.
    fn blocks(&mut self, entity: &Entity, name: &str, pose: Pose, size: [f64; 3]) -> Result<(), Fault> {
        let mut blocks = Vec::new();
        for block in entity.children.iter().filter(|child| child.base == "block") {
            blocks.push(Block::read(block)?);
        }
        if blocks.is_empty() {
            blocks.push(Block {
                points: SQUARE.to_vec(),
                z: [0.0, 1.0],
            });
        }
        let places: Vec<[f64; 3]> = (blocks.iter())
            .flat_map(|block| {
                block
                    .points
                    .iter()
                    .flat_map(|[x, y]| block.z.map(|z| [*x, *y, z]))
            })
            .collect();
        let extent = |axis: usize, pick: fn(f64, f64) -> f64| {
            places
                .iter()
                .map(|place| place[axis])
                .reduce(pick)
                .unwrap_or_default()
        };
        let lower = [0, 1, 2].map(|axis| extent(axis, f64::min));
        let upper = [0, 1, 2].map(|axis| extent(axis, f64::max));
        // A part of 0 to 1 along an axis; a side without an extent stays at its start.
        let part = |axis: usize, value: f64| {
            let range = upper[axis] - lower[axis];
            if range > 0.0 {
                (value - lower[axis]) / range
            } else {
                0.0
            }
        };
        for Block { points, z } in blocks {
            let [bottom, top] = z.map(|z| pose.z + part(2, z) * size[2]);
            if bottom > OVERHEAD {
                self.notes.push(format!(
                    "a block of `{name}` is {bottom:.2} m above the floor and is left out."
                ));
                continue;
            }
            let local: Vec<[f64; 2]> = (points.iter())
                .map(|[x, y]| [(part(0, *x) - 0.5) * size[0], (part(1, *y) - 0.5) * size[1]])
                .collect();
            self.polygon(name, pose, &local, top);
        }
        Ok(())
    }

    /// Adds a polygon: a rectangle along the axes of its model as a box, and any other as its outline.
    fn polygon(&mut self, name: &str, pose: Pose, points: &[[f64; 2]], height: f64) {
        let along = |axis: usize| {
            points
                .iter()
                .zip(points.iter().cycle().skip(1))
                .map(move |(a, b)| a[axis] == b[axis])
        };
        let is_rectangle = points.len() == 4 && along(0).zip(along(1)).all(|(x, y)| x != y);
        let [first, _, third, ..] = points else { return };
        let size = [0, 1].map(|axis| (third[axis] - first[axis]).abs());
        if is_rectangle && size.iter().all(|length| *length > 0.0) {
            self.draft.boxes.push(DraftBox {
                name: name.to_owned(),
                center: pose.point([0, 1].map(|axis| (first[axis] + third[axis]) / 2.0)),
                size,
                angle: pose.yaw.to_degrees(),
                height,
            });
        } else {
            self.draft.walls.push(DraftWall {
                name: name.to_owned(),
                points: points.iter().map(|point| pose.point(*point)).collect(),
                height,
            });
        }
    }
}

impl Block {
    fn read(block: &Entity) -> Result<Self, Fault> {
        let wrong = || {
            block
                .place
                .fault("a block needs `points`, 3 or more, and `point[0] [x y]` and so on")
        };
        let count = block.numbers("points", 1..=1)?.ok_or_else(wrong)?[0];
        if !(3.0..=1000.0).contains(&count) {
            return Err(wrong());
        }
        let point = |index: usize| {
            let point = block
                .numbers(&format!("point[{index}]"), 2..=2)?
                .ok_or_else(wrong)?;
            Ok([point[0], point[1]])
        };
        let points = (0..count as usize).map(point).collect::<Result<_, Fault>>()?;
        let z = block.numbers("z", 2..=2)?;
        Ok(Self {
            points,
            z: z.map_or([0.0, 1.0], |z| [z[0], z[1]]),
        })
    }
}
