//! The map that is exported: drawn a few keyframes an iteration, and anew when the graph has moved them.

use jde_grid::{GeometryError, Occupancy};
use jde_map_file::{Cell, MapFile};
use jde_schema::prelude::*;
use jde_slam::{Drawing, Slam};

/// The most keyframes that are drawn in one iteration.
const MOST: usize = 4;

/// The map as it is drawn, and another one that will take its place.
#[derive(Debug, Default)]
pub(crate) struct Map {
    shown: Option<Drawing>,
    next: Option<Drawing>,
    /// Changes of the one that is drawn; how many were exported, and how many saved.
    changes: u64,
    written: u64,
    saved: u64,
    /// Whether there was no room for the next one, and how many keyframes there were.
    refused: Option<usize>,
    /// When the map was last exported.
    pub(crate) exported: Option<Duration>,
}

impl Map {
    /// Draws a few keyframes.
    ///
    /// # Errors
    /// If the map would have too many cells, once; it stays as it is, and is tried again with the next keyframe.
    pub(crate) fn advance(&mut self, slam: &Slam, resolution: f64, margin: f64) -> Result<(), GeometryError> {
        if slam.scans().is_empty() {
            return Ok(());
        }
        if let Some(shown) = &mut self.shown {
            let drawn = shown.drawn();
            shown.advance(slam, MOST);
            self.changes += u64::from(shown.drawn() != drawn);
        }
        let is_right = self.shown.as_ref().is_some_and(|shown| shown.is_right(slam));
        let is_due = !is_right && self.refused != Some(slam.scans().len());
        if self.next.is_none() && is_due && slam.graph().is_settled() {
            match Drawing::new(slam, resolution, margin) {
                Ok(next) => (self.next, self.refused) = (Some(next), None),
                Err(error) => {
                    let is_known = self.refused.replace(slam.scans().len()).is_some();
                    return if is_known { Ok(()) } else { Err(error) };
                }
            }
        }
        if let Some(mut next) = self.next.take() {
            if next.advance(slam, MOST) {
                self.shown = Some(next);
                self.changes += 1;
            } else {
                self.next = Some(next);
            }
        }
        Ok(())
    }

    pub(crate) const fn is_new(&self) -> bool {
        self.changes != self.written
    }

    pub(crate) const fn is_unsaved(&self) -> bool {
        self.changes != self.saved
    }

    /// Returns how many changes the map has.
    pub(crate) const fn changes(&self) -> u64 {
        self.changes
    }

    /// Notes that the map was saved with so many changes.
    pub(crate) const fn set_saved(&mut self, changes: u64) {
        self.saved = changes;
    }

    /// Writes size, origin and cells.
    pub(crate) fn write(&mut self, map: &mut OccupancyGrid) {
        self.written = self.changes;
        let Some(shown) = &self.shown else { return };
        let geometry = shown.geometry();
        let (x, y, heading) = geometry.origin();
        map.info = MapMetaData {
            resolution: geometry.resolution() as f32,
            width: geometry.width(),
            height: geometry.height(),
            origin: Pose2D::new(x, y, heading).into(),
            ..MapMetaData::default()
        };
        shown.write_ros(map.data.resize(geometry.cells()));
    }

    /// Returns the map for a file.
    pub(crate) fn file(&self) -> Option<MapFile> {
        let shown = self.shown.as_ref()?;
        let geometry = shown.geometry();
        let (x, y, heading) = geometry.origin();
        let mut numbers = vec![0; geometry.cells()];
        shown.write_ros(&mut numbers);
        let cell = |&number: &i8| match Occupancy::from_ros(number) {
            Occupancy::Free => Cell::Free,
            Occupancy::Occupied => Cell::Occupied,
            Occupancy::Unknown => Cell::Unknown,
        };
        Some(MapFile {
            width: geometry.width() as usize,
            height: geometry.height() as usize,
            resolution: geometry.resolution(),
            origin: [x, y, heading],
            cells: numbers.iter().map(cell).collect(),
            left_out: Default::default(),
        })
    }
}
