//! Occupancy grids, distance fields and costmaps, and planners over them.
//!
//! Everything is a function of its arguments: the crate has no clock, no thread and no I/O, and knows no
//! robot. Units are metres and radians; axes follow ROS REP-103. Rows begin at the origin, as in ROS.
//!
//! ```
//! use jde_grid::{Cell, Costmap, Geometry, Inflation, Occupancy, OccupancyGrid};
//!
//! let geometry = Geometry::new(200, 100, 0.05, (0.0, 0.0, 0.0))?;
//! let mut grid = OccupancyGrid::filled(geometry, Occupancy::Free);
//! grid.set(Cell::new(100, 50), Occupancy::Occupied);
//! let inflation = Inflation { inscribed: 0.2, circumscribed: 0.3, reach: 0.8, decay: 4.0 };
//! let costmap = Costmap::new(&grid, &inflation)?;
//! assert!(costmap.get(Cell::new(106, 50)) > costmap.get(Cell::new(110, 50)));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod costmap;
mod coverage;
mod distance;
mod edge;
mod field;
mod frontier;
mod geometry;
mod layers;
mod line;
#[cfg(test)]
mod maps;
mod nearest;
mod occupancy;
mod price;
mod rolling;
mod route;
mod search;
mod seen;
mod span;
mod way_out;
mod window;

pub use costmap::{Costmap, Inflation, InflationError};
pub use coverage::{CellSet, Floor, Stroke};
pub use distance::{Distances, NO_SOURCE, squared_distances};
pub use edge::edge_toward;
pub use field::Field;
pub use frontier::frontiers;
pub use geometry::{Cell, Geometry, GeometryError, MAX_CELLS};
pub use layers::{Drawing, Lanes, Layers};
pub use line::walk;
pub use nearest::{nearest_open, nearest_reachable};
pub use occupancy::{Occupancy, OccupancyGrid};
pub use price::{MAX_WEIGHT, Prices, UNIT, Unknown};
pub use rolling::{Ray, RollingGrid};
pub use route::{PlanError, Point, Route};
pub use search::{Angles, plan};
pub use seen::{Place, SeenObstacles};
pub use way_out::way_out;
