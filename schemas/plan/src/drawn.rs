//! What an operator draws on the panel, and the drawing of it and of what the application states. It refuses
//! zones that enclose nothing.

use jde_grid::Drawing;
use jde_schema::types::{Point2D, Zone, Zones};

/// The farthest corner from the origin, in metres, as for the origin of a map.
const FARTHEST: f64 = 1e6;

/// Why a keep-out zone is refused.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub(crate) enum ZoneError {
    /// It has too few corners.
    #[error("keep-out zone {zone} has {corners} corners: give it three or more")]
    Corners {
        /// Its number, from 1 on.
        zone: usize,
        /// How many it has.
        corners: usize,
    },
    /// A corner is on no map.
    #[error("keep-out zone {zone} has a corner at ({x}, {y}) m: expected numbers up to {FARTHEST} m")]
    Far {
        /// Its number, from 1 on.
        zone: usize,
        /// x in metres.
        x: f64,
        /// y in metres.
        y: f64,
    },
}

/// What an operator has drawn.
#[derive(Debug, Default)]
pub(crate) struct Drawn {
    /// The corners of the zone that is being drawn.
    pub(crate) corners: Zone,
    /// The zones that are complete.
    pub(crate) zones: Zones,
}

impl Drawn {
    /// Returns the drawing of the application's zones and the operator's, `margin` metres wider.
    pub(crate) fn over(&self, zones: &Zones, margin: f64) -> Result<Drawing, ZoneError> {
        check(zones)?;
        let all = zones.zones.iter().chain(&self.zones.zones);
        Ok(Drawing {
            zones: all.map(corners).collect(),
            margin,
        })
    }

    /// Adds a corner to the zone that is being drawn. Returns whether it has room for it.
    pub(crate) fn add_corner(&mut self, x: f64, y: f64) -> bool {
        x.abs().max(y.abs()) <= FARTHEST && self.corners.corners.push(Point2D { x, y }).is_ok()
    }

    /// Whether the zone that is being drawn has enough corners.
    pub(crate) fn can_close(&self) -> bool {
        self.corners.corners.len() >= 3
    }

    /// Completes the zone that is being drawn, and returns it; `None` if it has too few corners, or there is no
    /// room for it.
    pub(crate) fn close(&mut self) -> Option<Zone> {
        let zone = Some(self.corners).filter(|_| self.can_close())?;
        self.zones.zones.push(zone).ok()?;
        self.corners = Zone::default();
        Some(zone)
    }
}

/// Checks zones that a file or an operator states.
pub(crate) fn check(zones: &Zones) -> Result<(), ZoneError> {
    for (index, Zone { corners }) in zones.zones.iter().enumerate() {
        let zone = index + 1;
        if corners.len() < 3 {
            let corners = corners.len();
            return Err(ZoneError::Corners { zone, corners });
        }
        let is_far = |corner: &&Point2D| corner.x.abs().max(corner.y.abs()) > FARTHEST;
        if let Some(&Point2D { x, y }) = corners.iter().find(is_far) {
            return Err(ZoneError::Far { zone, x, y });
        }
    }
    Ok(())
}

/// The corners of a zone.
pub(crate) fn corners(zone: &Zone) -> Vec<(f64, f64)> {
    zone.corners.iter().map(|corner| (corner.x, corner.y)).collect()
}
