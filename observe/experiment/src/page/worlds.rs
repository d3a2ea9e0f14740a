//! The worlds of drives, each read once. One that cannot be read is not drawn, and the page says why.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use jde_drawing::map::DriveMap;
use jde_sim::World;

use crate::result::DriveResult;
use crate::summary::Summary;

/// The worlds that were read.
pub(super) struct Worlds<'a> {
    summary: &'a Summary<'a>,
    read: HashMap<PathBuf, Rc<Ground>>,
}

/// A world to draw on.
#[derive(Default)]
pub(super) struct Ground {
    /// Its bounds, shapes and paint.
    pub(super) drive: DriveMap,
    /// Why it is not drawn; empty if it is.
    pub(super) note: String,
}

impl<'a> Worlds<'a> {
    pub(super) fn new(summary: &'a Summary<'a>) -> Self {
        Self {
            summary,
            read: HashMap::new(),
        }
    }

    /// The world of a drive, and its file if it has one.
    pub(super) fn of(&mut self, result: &DriveResult) -> (Option<PathBuf>, Rc<Ground>) {
        let Some(path) = (self.summary.world)(result) else {
            return (None, Rc::default());
        };
        let read = self.read.entry(path.clone());
        let ground = read.or_insert_with(|| Rc::new(Ground::read(&path))).clone();
        (Some(path), ground)
    }
}

impl Ground {
    fn read(path: &Path) -> Self {
        // The seed moves nothing at the start.
        match World::load(path, 0) {
            Ok(world) => {
                let mut drive = DriveMap {
                    title: world.name().to_owned(),
                    ..DriveMap::default()
                };
                drive.set_world(&world);
                Self {
                    drive,
                    note: String::new(),
                }
            }
            Err(error) => Self {
                note: format!("The world is not drawn: {error}"),
                ..Self::default()
            },
        }
    }
}
