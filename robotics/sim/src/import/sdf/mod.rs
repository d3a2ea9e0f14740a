//! Worlds in SDF, the format of Gazebo: the solid things of the models of a world and of the models that it includes, seen
//! from above (specification of SDFormat 1.12: `world`, `model`, `link`, `collision`, `geometry`).
//!
//! It fetches nothing from the Web, and it converts no mesh. The numbers are those of libsdformat.

mod frames;
mod models;
mod population;
mod pose3;
mod shapes;
mod solids;
mod unused;
mod values;
mod walk;
mod xml;

use std::path::{Path, PathBuf};

use jde_document::{Fault, Faults};
use jde_files::{Budget, LeftOut};

use super::writer::Draft;
use super::{ImportedWorld, OVERHEAD};
use frames::{Frames, Id, Scope, Stated};
use models::Models;
use walk::Context;
use xml::{Document, ElementPlace, Node, ROOTS};

/// How far the bounds are from the things of a world, m, and as a part of its extent: room for the starts of robots.
const MARGIN: (f64, f64) = (2.0, 0.1);
/// The least half of a side of the bounds, m.
const ROOM: f64 = 5.0;

/// A collision, placed when all frames are known.
struct Solid {
    node: Node,
    scope: Scope,
    link: Id,
    stated: Stated,
    /// The name of its model.
    name: String,
    is_static: bool,
}

struct SdfReader<'a> {
    path: &'a Path,
    models: Models,
    /// The included files that are being read.
    open: Vec<PathBuf>,
    budget: Budget,
    frames: Frames,
    solids: Vec<Solid>,
    draft: Draft,
    /// Places of what is in the world and could not be converted.
    marks: Vec<[f64; 2]>,
    left_out: LeftOut,
    notes: Vec<String>,
    /// Things that could move, and things that are not upright: how many, and the first.
    movable: Count,
    tilted: Count,
    faults: Vec<Fault>,
}

#[derive(Default)]
struct Count {
    number: usize,
    first: String,
}

impl Count {
    fn add(&mut self, name: &str) {
        if self.number == 0 {
            name.clone_into(&mut self.first);
        }
        self.number += 1;
    }
}

pub(super) fn read(
    path: &Path,
    text: &str,
    stem: String,
    folders: &[PathBuf],
) -> Result<ImportedWorld, Faults> {
    let mut reader = SdfReader {
        path,
        models: Models::new(folders),
        open: Vec::new(),
        budget: Budget::default(),
        frames: Frames::new(),
        solids: Vec::new(),
        draft: Draft::default(),
        marks: Vec::new(),
        left_out: LeftOut::default(),
        notes: Vec::new(),
        movable: Count::default(),
        tilted: Count::default(),
        faults: Vec::new(),
    };
    let read = reader.file(text, &stem);
    reader.faults.extend(read.as_ref().err().cloned());
    match read {
        Ok(name) if reader.faults.is_empty() => Ok(reader.finish(&name, stem)),
        _ => Err(reader.faults.into()),
    }
}

impl SdfReader<'_> {
    /// Reads the file, and returns the name of the world.
    fn file(&mut self, text: &str, stem: &str) -> Result<String, Fault> {
        let fault = |line, message| Fault::at_line(self.path, line, message);
        let document =
            Document::parse(text, None, &mut self.budget).map_err(|(line, message)| fault(line, message))?;
        let root = document.root(&ROOTS).filter(|root| ROOTS.contains(&root.name()));
        let Some(root) = root else {
            let found = document
                .root(&ROOTS)
                .map_or(String::new(), |root| format!("`{}` is no SDF: ", root.name()));
            return Err(fault(1, format!("{found}expected <sdf>")));
        };
        let mut world = None;
        for part in root.children() {
            match part.name() {
                "world" if world.is_none() => world = Some(part),
                "world" => self.leave(&part, unused::named(&part), unused::BESIDE),
                _ => {}
            }
        }
        if world.is_some() {
            for part in root.children().filter(|part| part.name() != "world") {
                self.leave(&part, unused::named(&part), unused::BESIDE);
            }
        }
        let world = world.unwrap_or(root);
        let saved = world.child("state");
        self.parts(
            &world,
            Context {
                scope: Frames::WORLD,
                prefix: "",
                is_static: false,
                saved: saved.as_ref(),
            },
            None,
        )?;
        for solid in std::mem::take(&mut self.solids) {
            self.place(&solid)?;
        }
        Ok(world.attribute("name").unwrap_or(stem).to_owned())
    }

    /// Returns the pose of an element; `implied` is the frame that it is in if it states none.
    fn stated(&mut self, node: &Node, implied: &str) -> Stated {
        match values::pose(node) {
            Ok(stated) if stated.relative_to.is_empty() => Stated {
                relative_to: implied.to_owned(),
                ..stated
            },
            Ok(stated) => stated,
            Err((pose, message)) => {
                let name = node.attribute("name").unwrap_or(node.name());
                let fault = self.fault(&pose.place(), format!("the pose of `{name}` is wrong: {message}"));
                self.faults.push(fault);
                Stated::ORIGIN
            }
        }
    }

    fn frame(&mut self, node: &Node, scope: Scope, stated: Stated) -> Result<Id, Fault> {
        let name = node.attribute("name").unwrap_or_default();
        let added = self.frames.add(scope, name, stated, &mut self.budget);
        added.map_err(|error| self.fault(&node.place(), error))
    }

    fn work(&mut self, node: &Node) -> Result<(), Fault> {
        self.budget
            .work(1)
            .map_err(|error| self.fault(&node.place(), error))
    }

    fn leave(&mut self, node: &Node, what: impl std::fmt::Display, why: impl std::fmt::Display) {
        self.left_out.add(what, Some(&node.place()), why);
    }

    fn leave_unused(&mut self, node: &Node) {
        self.leave(node, unused::named(node), unused::reason(node.name()));
    }

    fn fault(&self, place: &ElementPlace, message: impl ToString) -> Fault {
        let file = place.file.as_deref().unwrap_or(self.path);
        Fault::at_line(
            file,
            place.line,
            message.to_string().replace(char::is_control, " "),
        )
    }

    fn finish(mut self, name: &str, stem: String) -> ImportedWorld {
        let Count { number, first } = &self.movable;
        match number {
            0 => {}
            1 => self
                .notes
                .push(format!("`{first}` could move in Gazebo, and is fixed.")),
            more => self.notes.push(format!(
                "{more} things could move in Gazebo, and are fixed: `{first}` is one."
            )),
        }
        let Count { number, first } = &self.tilted;
        if *number > 0 {
            let things = if *number == 1 {
                "One thing is"
            } else {
                "Some things are"
            };
            self.notes.push(format!(
                "{things} not upright: the outline up to {OVERHEAD} m above the floor is in the world ({number}: `{first}`)."
            ));
        }
        if self.draft.is_empty() {
            self.notes
                .push("Nothing that stands on the floor is converted: the world is empty.".to_owned());
        }
        self.draft.bounds = Some(self.bounds());
        let comment = format!("Converted from the SDF world {name}. Metres, degrees.");
        ImportedWorld {
            text: self.draft.write(&comment.replace(char::is_control, " "), name),
            files: Vec::new(),
            left_out: self.left_out,
            notes: self.notes,
            name: stem,
        }
    }

    /// Returns a rectangle around everything and the origin, where robots start.
    fn bounds(&self) -> [[f64; 2]; 2] {
        let (mut min, mut max) = ([0.0_f64; 2], [0.0_f64; 2]);
        for point in self.draft.points().chain(self.marks.iter().copied()) {
            for axis in [0, 1] {
                min[axis] = min[axis].min(point[axis]);
                max[axis] = max[axis].max(point[axis]);
            }
        }
        for axis in [0, 1] {
            let (least, part) = MARGIN;
            let margin = least.max(part * (max[axis] - min[axis]));
            // Whole metres.
            min[axis] = (min[axis] - margin).min(-ROOM).floor();
            max[axis] = (max[axis] + margin).max(ROOM).ceil();
        }
        [min, max]
    }
}
