//! Worlds of Stage: the bitmaps, blocks and robots of its models, seen from above (`model.cc`, `block.cc` and `stage.cc` of
//! Stage 4.3), with the names that versions before 2009 had for poses, sizes and sensors.
//!
//! The body and the sensors of a robot are left out: the driver of an application chooses the robot. What is not
//! understood is named.

mod keys;
mod raster;
mod syntax;

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::rc::Rc;

use jde_document::{Fault, Faults};
use jde_files::{Budget, LeftOut};
use jde_map_file::Picture;

use super::pose::Pose;
use super::writer::{Draft, DraftBox, DraftWall};
use super::{ImportedWorld, OVERHEAD};
use raster::Bitmap;
use syntax::Entity;

/// The size of a model that states none, m.
const SIZE: [f64; 3] = [0.4, 0.4, 1.0];
/// The outline of a model without blocks.
const SQUARE: [[f64; 2]; 4] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];

/// A part of a model: a polygon, in the units of its file, and its lower and upper edge.
struct Block {
    points: Vec<[f64; 2]>,
    z: [f64; 2],
}

struct WorldfileReader<'w> {
    /// The file of the world.
    path: &'w Path,
    /// Metres and radians of a unit.
    units: Units,
    draft: Draft,
    bitmaps: Vec<Bitmap>,
    /// The pictures of bitmaps that are read already.
    pictures: HashMap<PathBuf, Rc<Picture>>,
    budget: Budget,
    left_out: LeftOut,
    /// The names of robots, with the number of the next one of each name.
    robots: HashMap<String, usize>,
    names: HashSet<String>,
    faults: Vec<Fault>,
}

/// Metres and degrees of the units of a file.
#[derive(Clone, Copy, Debug)]
struct Units {
    length: f64,
    angle: f64,
}

/// What a world and all its files may take: many times the worlds that come with Stage.
const BUDGET: Budget = Budget::new(128 << 20, 100_000_000, 64);

pub(super) fn read(path: &Path, text: &str, stem: String) -> Result<ImportedWorld, Faults> {
    let (mut budget, mut left_out) = (BUDGET, LeftOut::default());
    let root = syntax::parse(path, text, &mut budget, &mut left_out)?;
    let mut reader = WorldfileReader {
        path,
        units: Units::read(&root)?,
        draft: Draft::default(),
        bitmaps: Vec::new(),
        pictures: HashMap::new(),
        budget,
        left_out,
        robots: HashMap::new(),
        names: HashSet::new(),
        faults: Vec::new(),
    };
    keys::report(&root, keys::WORLD, &mut reader.left_out);
    for entity in root.children.iter().filter(|entity| entity.base != "window") {
        if let Err(fault) = reader.entity(entity, Pose::ORIGIN, "") {
            reader.faults.push(fault);
        }
    }
    let mut files = Vec::new();
    let starts: Vec<_> = (reader.draft.starts.iter())
        .map(|(_, [x, y, _])| [*x, *y])
        .collect();
    match raster::draw(&reader.bitmaps, &starts, &mut reader.budget) {
        Ok(None) => {}
        Ok(Some(drawn)) => {
            let (map, picture) = super::map_files(&stem);
            files.push((map.clone(), drawn.yaml(&picture).into_bytes()));
            files.push((picture, drawn.image()));
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
        return Err(reader.faults.into());
    }
    let mut notes = Vec::new();
    if !reader.draft.starts.is_empty() {
        let count = reader.draft.starts.len();
        let message = "their starts are kept, their bodies and sensors are left out";
        notes.push(format!("{count} robots: {message}."));
    }
    let comment = format!("Converted from the Stage world {stem}. Metres, degrees.");
    Ok(ImportedWorld {
        text: reader.draft.write(&comment, &stem),
        files,
        left_out: reader.left_out,
        notes,
        name: stem,
    })
}

impl Units {
    fn read(root: &Entity) -> Result<Self, Fault> {
        let unit = |key: &str, known: &[(&str, f64)]| {
            let Some(stated) = root.text(key) else {
                return Ok(known[0].1);
            };
            let unit = known.iter().find(|(name, _)| *name == stated);
            unit.map(|(_, value)| *value).ok_or_else(|| {
                let names: Vec<_> = known.iter().map(|(name, _)| format!("{name:?}")).collect();
                let message = format!("`{key}` is {stated:?}: expected one of {}", names.join(", "));
                root.place.fault(message)
            })
        };
        Ok(Self {
            length: unit("unit_length", &[("m", 1.0), ("cm", 0.01), ("mm", 0.001)])?,
            angle: unit("unit_angle", &[("degrees", 1.0), ("radians", 1_f64.to_degrees())])?,
        })
    }

    /// Returns a property as a pose: x, y, z and the angle; x, y and the angle in versions before 2009.
    fn pose(self, entity: &Entity, key: &str) -> Result<Pose, Fault> {
        let [old, older] = [format!("{key}4"), format!("{key}3")];
        let key = [old.as_str(), older.as_str()]
            .into_iter()
            .find(|old| entity.has(old))
            .unwrap_or(key);
        let pose = |x, y, z, angle: f64| Pose {
            x: x * self.length,
            y: y * self.length,
            z: z * self.length,
            yaw: (angle * self.angle).to_radians(),
        };
        Ok(match entity.numbers(key, 3..=4)? {
            Some(&[x, y, angle]) => pose(x, y, 0.0, angle),
            Some(&[x, y, z, angle, ..]) => pose(x, y, z, angle),
            Some(_) | None => Pose::ORIGIN,
        })
    }
}

impl WorldfileReader<'_> {
    /// Names a part that is left out.
    fn leave_out(&mut self, what: String, entity: &Entity, why: &str) {
        self.left_out.add(what, Some(&entity.place), why);
    }

    /// Reads a model and those on it. `frame` is the pose of its parent, at the height on which it stands.
    fn entity(&mut self, entity: &Entity, frame: Pose, prefix: &str) -> Result<(), Fault> {
        let base = entity.base.as_str();
        if matches!(base, "block" | "sensor") {
            return Ok(());
        }
        let name = format!("{prefix}{}", entity.text("name").unwrap_or(&entity.kind));
        let counted = self
            .budget
            .work(1)
            .and_then(|()| self.budget.hold(2 * name.len()));
        counted.map_err(|exceeded| entity.place.fault(exceeded.to_string()))?;
        if keys::INSTRUMENTS.contains(&base) {
            let what = format!("`{name}`, a {base},");
            self.leave_out(what, entity, "the robot of an application has the sensors");
            return Ok(());
        }
        let pose = frame.compose(self.units.pose(entity, "pose")?);
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
        keys::report(entity, keys::MODEL, &mut self.left_out);
        let mut size = SIZE;
        let key = if entity.has("size3") { "size3" } else { "size" };
        if let Some(numbers) = entity.numbers(key, 2..=3)? {
            let lengths = numbers.iter().map(|length| length * self.units.length);
            size.iter_mut()
                .zip(lengths)
                .for_each(|(size, length)| *size = length);
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
        let next = self.robots.entry(name.clone()).or_insert(2);
        while !self.names.insert(unique.clone()) {
            unique = format!("{name} {next}");
            *next += 1;
        }
        let start = [pose.x, pose.y, pose.yaw.to_degrees()];
        self.draft.starts.push((unique, start));
    }

    /// Whether lasers see a model, and whether it stops robots.
    fn returns(entity: &Entity) -> Result<[bool; 2], Fault> {
        let reflected = entity.numbers("ranger_return", 1..=1)?;
        let is_seen = reflected.is_none_or(|reflected| reflected[0] >= 0.0);
        // The name of versions before 4, in numbers or in words.
        let is_seen = is_seen
            && entity.is_positive("laser_return", true)?
            && entity.text("laser_return") != Some("invisible");
        Ok([is_seen, entity.is_positive("obstacle_return", true)?])
    }

    /// Adds what a model is made of.
    fn solid(&mut self, entity: &Entity, name: &str, pose: Pose, size: [f64; 3]) -> Result<(), Fault> {
        let [is_seen, is_obstacle] = Self::returns(entity)?;
        if !is_seen && !is_obstacle {
            let why = "it is a mark, which no laser sees and which stops no robot";
            self.leave_out(format!("`{name}`"), entity, why);
            return Ok(());
        }
        if is_seen != is_obstacle {
            let why = "what stops robots is seen by lasers in a world, and what is seen stops them";
            let what = if is_seen {
                "obstacle_return"
            } else {
                "ranger_return"
            };
            self.leave_out(format!("`{what}` of `{name}`"), entity, why);
        }
        let pose = pose.compose(self.units.pose(entity, "origin")?);
        let [x, y, height] = size;
        if !size.iter().all(|length| *length > 0.0) {
            return Err(entity
                .place
                .fault(format!("the size of `{name}` is wrong: expected lengths above 0")));
        }
        if pose.z > OVERHEAD {
            let why = format!("it is {:.2} m above the floor", pose.z);
            self.leave_out(format!("`{name}`"), entity, &why);
            return Ok(());
        }
        let boundary = entity.is_positive("boundary", false)?;
        if let Some((path, place)) = entity.path("bitmap", self.path) {
            let refused = |exceeded| place.fault(format!("the bitmaps are too large: {exceeded}"));
            let picture = match self.pictures.get(&path) {
                Some(picture) => Rc::clone(picture),
                None => {
                    let picture = Bitmap::picture(&path).map_err(|message| place.fault(message))?;
                    self.budget.hold(picture.shades.len()).map_err(refused)?;
                    let picture = Rc::new(picture);
                    self.pictures.insert(path, Rc::clone(&picture));
                    picture
                }
            };
            let bitmap = Bitmap::new(picture, pose, [x, y], &mut self.budget);
            match bitmap.map_err(refused)? {
                Some(bitmap) => self.bitmaps.push(bitmap),
                None => self.leave_out(format!("the bitmap of `{name}`"), entity, "it has no dark pixel"),
            }
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
                let why = format!("it is {bottom:.2} m above the floor");
                self.leave_out(format!("a block of `{name}`"), entity, &why);
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
