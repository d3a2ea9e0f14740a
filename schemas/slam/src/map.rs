//! The map that is exported: drawn a few keyframes an iteration, and anew when the graph has moved them.

use jde_grid::{GeometryError, Occupancy};
use jde_map_file::{MapCell, MapFile};
use jde_schema::prelude::*;
use jde_slam::{MapDrawing, Slam};

/// The most keyframes that are drawn in one iteration.
const KEYFRAMES_PER_ITERATION: usize = 16;
/// The largest side of a cell, m: that of the parameter.
const MAX_RESOLUTION: f64 = 1.0;

/// The map as it is drawn, and another one that will take its place.
#[derive(Debug, Default)]
pub(crate) struct Map {
    shown: Option<MapDrawing>,
    next: Option<MapDrawing>,
    /// Changes of the one that is drawn; how many were exported, and how many saved.
    changes: u64,
    written: u64,
    saved: u64,
    /// The side of a cell of a map that would have too many of the cells that are asked for, m.
    coarse: f64,
    /// When the map was last exported.
    pub(crate) exported: Option<Duration>,
}

impl Map {
    /// Draws a few keyframes. A map with too many cells gets larger ones: it returns their side in m, once.
    ///
    /// # Errors
    /// If the map would have too many cells of any size.
    pub(crate) fn advance(
        &mut self,
        slam: &Slam,
        resolution: f64,
        margin: f64,
    ) -> Result<Option<f64>, GeometryError> {
        let before = self.coarse;
        if slam.scans().is_empty() {
            return Ok(None);
        }
        self.next = self.next.take().filter(|next| next.is_numbered(slam));
        if let Some(shown) = self.shown.as_mut().filter(|shown| shown.is_numbered(slam)) {
            let drawn = shown.drawn();
            shown.advance(slam, KEYFRAMES_PER_ITERATION);
            self.changes += u64::from(shown.drawn() != drawn);
        }
        let is_right = self.shown.as_ref().is_some_and(|shown| shown.is_right(slam));
        if self.next.is_none() && !is_right && slam.graph().is_settled() {
            let mut side = resolution.max(self.coarse);
            self.next = loop {
                match MapDrawing::new(slam, side, margin) {
                    Ok(next) => break Some(next),
                    Err(error) if 2.0 * side > MAX_RESOLUTION => return Err(error),
                    Err(_) => side *= 2.0,
                }
                self.coarse = side;
            };
        }
        if let Some(mut next) = self.next.take() {
            if next.advance(slam, KEYFRAMES_PER_ITERATION) {
                self.shown = Some(next);
                self.changes += 1;
            } else {
                self.next = Some(next);
            }
        }
        Ok((self.coarse != before).then_some(self.coarse))
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
            Occupancy::Free => MapCell::Free,
            Occupancy::Occupied => MapCell::Occupied,
            Occupancy::Unknown => MapCell::Unknown,
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
