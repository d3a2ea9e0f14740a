//! The content of the cells of a map, by the shades of its image (`loadMapFromFile` of Nav2's `map_io.cpp`, August 2026).

use crate::picture::Picture;

/// The content of a cell of a map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MapCell {
    /// Nothing stands there.
    Free,
    /// Something stands there.
    Occupied,
    /// The map does not say.
    Unknown,
    /// Something stands there with a probability of 1 to 99 %; only in maps of the modes `scale` and `raw`.
    Likely(u8),
}

/// The free and the occupied end of the probabilities, %, of which a robot says neither between them.
const FREE_UP_TO: u8 = 19;
const OCCUPIED_FROM: u8 = 65;

impl MapCell {
    /// Returns the number of a `nav_msgs/OccupancyGrid`: 0 to 100, or -1.
    #[must_use]
    pub const fn to_ros(self) -> i8 {
        match self {
            Self::Free => 0,
            Self::Occupied => 100,
            Self::Unknown => -1,
            Self::Likely(percent) => percent as i8,
        }
    }

    /// Returns a cell that is free, occupied or unknown: a probability is free below 20 % and occupied from 65 %.
    #[must_use]
    pub const fn decided(self) -> Self {
        match self {
            Self::Likely(..=FREE_UP_TO) => Self::Free,
            Self::Likely(OCCUPIED_FROM..) => Self::Occupied,
            Self::Likely(_) => Self::Unknown,
            Self::Free | Self::Occupied | Self::Unknown => self,
        }
    }

    const fn of_percent(percent: u8) -> Self {
        match percent {
            0 => Self::Free,
            1..=99 => Self::Likely(percent),
            100 => Self::Occupied,
            101.. => Self::Unknown,
        }
    }
}

/// How the shades of an image state the content of the cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Mode {
    /// Free, occupied or unknown.
    Trinary,
    /// Probabilities between the thresholds.
    Scale,
    /// The numbers of an occupancy grid.
    Raw,
}

impl Mode {
    /// Returns the mode of this name.
    pub(crate) fn named(name: &str) -> Option<Self> {
        match name {
            "trinary" => Some(Self::Trinary),
            "scale" => Some(Self::Scale),
            "raw" => Some(Self::Raw),
            _ => None,
        }
    }
}

/// What likelihoods mean. A darker cell is more likely occupied; `negate` inverts that.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Thresholds {
    pub(crate) negate: bool,
    /// From this one on a cell is occupied.
    pub(crate) occupied: f32,
    /// Up to this one a cell is free.
    pub(crate) free: f32,
}

/// Returns the cells by rows, from the lowest row. Transparent pixels are unknown, except in raw maps.
pub(crate) fn classify(picture: &Picture, mode: Mode, thresholds: Thresholds) -> Vec<MapCell> {
    let table: Vec<MapCell> = (0..=u8::MAX).map(|shade| thresholds.cell(mode, shade)).collect();
    let Picture {
        width,
        shades,
        transparent,
        ..
    } = picture;
    let rows = shades.chunks_exact(*width).rev();
    let cells = rows.flatten().map(|&shade| table[usize::from(shade)]);
    let mut cells: Vec<MapCell> = cells.collect();
    if mode != Mode::Raw {
        let is_transparent = transparent.chunks_exact(*width).rev().flatten();
        let covered = cells
            .iter_mut()
            .zip(is_transparent)
            .filter(|(_, is_transparent)| **is_transparent);
        covered.for_each(|(cell, _)| *cell = MapCell::Unknown);
    }
    cells
}

impl Thresholds {
    fn cell(self, mode: Mode, shade: u8) -> MapCell {
        if mode == Mode::Raw {
            return MapCell::of_percent(shade);
        }
        let shade = f32::from(shade) / 255.0;
        let likely = if self.negate { shade } else { 1.0 - shade };
        let (free, occupied) = (self.free, self.occupied);
        if likely <= free {
            MapCell::Free
        } else if likely >= occupied {
            MapCell::Occupied
        } else if mode == Mode::Scale {
            MapCell::of_percent(((likely - free) / (occupied - free) * 100.0).round() as u8)
        } else {
            MapCell::Unknown
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cells(mode: Mode, shades: &[u8], transparent: &[bool]) -> Vec<MapCell> {
        let picture = Picture {
            width: shades.len(),
            height: 1,
            shades: shades.to_vec(),
            transparent: transparent.to_vec(),
        };
        let thresholds = Thresholds {
            negate: false,
            occupied: 0.65,
            free: 0.196,
        };
        classify(&picture, mode, thresholds)
    }

    #[test]
    fn a_threshold_belongs_to_what_it_limits() {
        let ends = |occupied, free| Thresholds {
            negate: true,
            occupied,
            free,
        };
        let cell = |thresholds: Thresholds, shade| thresholds.cell(Mode::Trinary, shade);
        assert_eq!(cell(ends(1.0, 0.0), 255), MapCell::Occupied);
        assert_eq!(cell(ends(1.0, 0.0), 254), MapCell::Unknown);
        assert_eq!(cell(ends(1.0, 0.0), 0), MapCell::Free);
        assert_eq!(cell(ends(51.0 / 255.0, 51.0 / 255.0), 51), MapCell::Free);
    }

    #[test]
    fn scaled_and_raw_maps_state_probabilities() {
        use MapCell::{Free, Likely, Occupied, Unknown};
        let shades = [255, 205, 200, 100, 0];
        assert_eq!(
            cells(Mode::Trinary, &shades, &[]),
            [Free, Unknown, Unknown, Unknown, Occupied]
        );
        assert_eq!(
            cells(Mode::Scale, &shades, &[false, false, true, false, true]),
            [Free, Free, Unknown, Likely(91), Unknown]
        );
        assert_eq!(
            cells(Mode::Raw, &[0, 1, 100, 101, 255], &[true; 5]),
            [Free, Likely(1), Occupied, Unknown, Unknown]
        );
        let decided = [1, 19, 20, 64, 65].map(|percent| Likely(percent).decided());
        assert_eq!(decided, [Free, Free, Unknown, Unknown, Occupied]);
    }
}
