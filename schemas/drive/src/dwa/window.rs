//! The costs of the map around the robot, and what the padded footprint costs at a pose. It plans nothing.

use jde_grid::costmap::{LETHAL, UNKNOWN};
use jde_grid::{Cell, Costmap, Geometry, Inflation, Occupancy, OccupancyGrid as Grid};
use jde_schema::types::{Footprint, MapMetaData, OccupancyGrid, Pose2D};

/// The most cells from the robot to a side of the window.
const MAX_HALF: f64 = 200.0;

/// The outline of the robot as points, with padding, in the frame of the base.
#[derive(Clone, Debug)]
pub(super) struct Perimeter {
    points: Vec<(f64, f64)>,
    spacing: f64,
}

impl Perimeter {
    /// The outline of a footprint, each point `padding` m farther from both axes as in ROS's `costmap_2d`, and
    /// at most `spacing` m from the next one.
    pub(super) fn new(footprint: &Footprint, padding: f64, spacing: f64) -> Self {
        let corners: Vec<(f64, f64)> = if footprint.points.is_empty() {
            let radius = footprint.radius + padding;
            let count = (core::f64::consts::TAU * radius / spacing).ceil().max(8.0);
            (0..count as u32)
                .map(|step| libm::sincos(core::f64::consts::TAU * f64::from(step) / count))
                .map(|(sin, cos)| (radius * cos, radius * sin))
                .collect()
        } else {
            let padded = |at: f64| if at == 0.0 { 0.0 } else { at + padding.copysign(at) };
            let points = footprint.points.iter();
            points.map(|point| (padded(point.x), padded(point.y))).collect()
        };
        let mut points = Vec::new();
        for (index, from) in corners.iter().enumerate() {
            let to = corners[(index + 1) % corners.len()];
            let steps = (libm::hypot(to.0 - from.0, to.1 - from.1) / spacing)
                .ceil()
                .max(1.0);
            points.extend((0..steps as u32).map(|step| {
                let share = f64::from(step) / steps;
                (from.0 + share * (to.0 - from.0), from.1 + share * (to.1 - from.1))
            }));
        }
        Self { points, spacing }
    }

    pub(super) const fn spacing(&self) -> f64 {
        self.spacing
    }
}

/// Returns the geometry of a map and the cell of the robot; `None` if the robot is not on the map, or the map is no
/// map.
pub(super) fn place(map: &OccupancyGrid, robot: &Pose2D) -> Option<(Geometry, Cell)> {
    let MapMetaData {
        width,
        height,
        resolution,
        ref origin,
        ..
    } = map.info;
    let place = (origin.position.x, origin.position.y, origin.orientation.yaw());
    let geometry = Geometry::new(width, height, f64::from(resolution), place).ok()?;
    let robot = geometry.cell_at((robot.x, robot.y))?;
    (map.data.len() == geometry.cells()).then_some((geometry, robot))
}

/// The costs within a square around the robot.
#[derive(Clone, Debug)]
pub(super) struct Window {
    costs: Costmap,
}

impl Window {
    /// The costs up to `half` m from the robot along the axes of the map; `None` if the robot is not on the
    /// map, or the map is no map. Unknown cells cost nothing. A point costs something up to `reach` m from an
    /// obstacle, by a factor of e less every 1/`decay` m.
    pub(super) fn new(
        map: &OccupancyGrid,
        robot: &Pose2D,
        half: f64,
        (reach, decay): (f64, f64),
    ) -> Option<Self> {
        let (whole, middle) = place(map, robot)?;
        let half = (half / whole.resolution()).ceil().min(MAX_HALF) as u32;
        let least = Cell::new(middle.x.saturating_sub(half), middle.y.saturating_sub(half));
        let width = (middle.x + half + 1).min(whole.width()) - least.x;
        let height = (middle.y + half + 1).min(whole.height()) - least.y;
        let (x, y) = whole.to_world((f64::from(least.x), f64::from(least.y)));
        let geometry = Geometry::new(width, height, whole.resolution(), (x, y, whole.origin().2)).ok()?;
        let mut grid = Grid::filled(geometry, Occupancy::Free);
        for index in 0..geometry.cells() {
            let cell = geometry.cell(index);
            let at = whole.index(Cell::new(least.x + cell.x, least.y + cell.y));
            if Occupancy::from_ros(map.data.as_slice()[at]) == Occupancy::Occupied {
                grid.set(cell, Occupancy::Occupied);
            }
        }
        let inflation = Inflation {
            inscribed: 0.0,
            circumscribed: 0.0,
            reach,
            decay,
        };
        Some(Self {
            costs: Costmap::new(&grid, &inflation).ok()?,
        })
    }

    /// What the outline is on at a pose.
    pub(super) fn contact(&self, pose: &Pose2D, perimeter: &Perimeter) -> Contact {
        let (sin, cos) = libm::sincos(pose.theta);
        let geometry = self.costs.geometry();
        let cost = |(x, y): (f64, f64)| {
            let cell = geometry.cell_at((pose.x + cos * x - sin * y, pose.y + sin * x + cos * y));
            cell.map_or(UNKNOWN, |cell| self.costs.get(cell))
        };
        let mut contact = Contact::default();
        for point in core::iter::once((0.0, 0.0)).chain(perimeter.points.iter().copied()) {
            match cost(point) {
                LETHAL => contact.touching += 1,
                UNKNOWN => {}
                cost => contact.cost = contact.cost.max(cost),
            }
        }
        contact
    }
}

/// What an outline is on.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Contact {
    /// How many of its points are on an obstacle.
    pub(super) touching: u32,
    /// The greatest cost of the others and of its origin, 0 to 252.
    pub(super) cost: u8,
}
