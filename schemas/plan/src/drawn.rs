//! What an operator draws on the panel, and what is in force: that, and what the application states. It refuses
//! zones that enclose nothing, and lanes that lead nowhere.

use jde_grid::{Drawing, Lanes as DrawnLanes};
use jde_schema::types::{Lanes, Part, Point2D, Seq, Strip, TooLong, Zone, Zones};

/// The farthest point from the origin, in metres, as for the origin of a map.
const MAX_COORDINATE: f64 = 1e6;

/// Why a keep-out zone or a lane is refused.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub(crate) enum DrawnError {
    /// It has too few points.
    #[error("{what} {number} has {given} points: give it {least} or more")]
    Points {
        /// "keep-out zone" or "lane".
        what: &'static str,
        /// Its number, from 1 on.
        number: usize,
        /// How many it has.
        given: usize,
        /// How many it needs.
        least: usize,
    },
    /// A point is on no map.
    #[error("{what} {number} has a point at ({x}, {y}) m: expected numbers up to {MAX_COORDINATE} m")]
    Far {
        /// "keep-out zone" or "lane".
        what: &'static str,
        /// Its number, from 1 on.
        number: usize,
        /// x in metres.
        x: f64,
        /// y in metres.
        y: f64,
    },
    /// There are too many, those of the application and those drawn together.
    #[error("there are more than {most} {what}s: clear what is drawn, or state fewer")]
    TooMany {
        /// "keep-out zone" or "lane".
        what: &'static str,
        /// How many there can be.
        most: usize,
    },
    /// The width of a lane is none.
    #[error("lane {number} is {width} m wide: expected more than 0, up to {MAX_COORDINATE} m")]
    Width {
        /// Its number, from 1 on.
        number: usize,
        /// The width in metres.
        width: f64,
    },
}

/// The zones and lanes that count.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct InForce {
    pub(crate) zones: Zones,
    pub(crate) lanes: Lanes,
}

/// What an operator has drawn.
#[derive(Debug)]
pub(crate) struct Drawn {
    /// The points of the zone or lane that is being drawn.
    pub(crate) points: Zone,
    /// The width of the next lane, m.
    pub(crate) width: f64,
    /// The zones that are complete.
    pub(crate) zones: Zones,
    /// The lanes that are complete.
    pub(crate) lanes: Lanes,
}

impl Default for Drawn {
    fn default() -> Self {
        Self {
            points: Zone::default(),
            // Wider than most robots, so that there is room beside small obstacles.
            width: 1.0,
            zones: Zones::EMPTY,
            lanes: Lanes::EMPTY,
        }
    }
}

impl Drawn {
    /// Returns what the application states, and what is drawn.
    pub(crate) fn over(&self, zones: &Zones, lanes: &Lanes) -> Result<InForce, DrawnError> {
        check_zones(zones)?;
        check_lanes(lanes)?;
        let too_many = |what| move |TooLong { capacity: most, .. }| DrawnError::TooMany { what, most };
        Ok(InForce {
            zones: Zones {
                zones: all(&zones.zones, &self.zones.zones).map_err(too_many("keep-out zone"))?,
            },
            lanes: Lanes {
                lanes: all(&lanes.lanes, &self.lanes.lanes).map_err(too_many("lane"))?,
            },
        })
    }

    /// Adds a point to what is being drawn. Returns whether there is room for it.
    pub(crate) fn add_point(&mut self, x: f64, y: f64) -> bool {
        x.abs().max(y.abs()) <= MAX_COORDINATE && self.points.corners.push(Point2D { x, y }).is_ok()
    }

    /// Makes a zone of the points, and returns it; `None` if they are too few, or there is no room for it beside
    /// those that the application states.
    pub(crate) fn complete_zone(&mut self, stated: &Zones) -> Option<Zone> {
        let zone = self.points;
        let is_added = zone.corners.len() >= 3 && add(&stated.zones, &mut self.zones.zones, zone);
        self.taken(is_added).then_some(zone)
    }

    /// Makes a lane of the points, and returns its strip; `None` if they are too few, or there is no room for it
    /// beside those that the application states.
    pub(crate) fn complete_strip(&mut self, stated: &Lanes) -> Option<Strip> {
        let lane = Strip {
            width: self.width,
            points: self.points.corners,
        };
        let is_added = lane.points.len() >= 2 && add(&stated.lanes, &mut self.lanes.lanes, lane);
        self.taken(is_added).then_some(lane)
    }

    fn taken(&mut self, is_added: bool) -> bool {
        if is_added {
            self.points.corners.clear();
        }
        is_added
    }
}

impl InForce {
    /// Returns the drawing of it. The zones are `margin` metres wider; `lanes` has the prices, if there are lanes.
    pub(crate) fn drawing(&self, margin: f64, lanes: DrawnLanes) -> Drawing {
        let zones = self.zones.zones.iter();
        let lines = self.lanes.lanes.iter();
        let lines: Vec<_> = lines.map(|lane| (pairs(&lane.points), lane.width)).collect();
        Drawing {
            zones: zones.map(|zone| pairs(&zone.corners)).collect(),
            margin,
            lanes: (!lines.is_empty()).then_some(DrawnLanes { lines, ..lanes }),
        }
    }
}

fn all<T: Part, const N: usize>(stated: &Seq<T, N>, drawn: &[T]) -> Result<Seq<T, N>, TooLong> {
    let mut all = *stated;
    all.extend_from_slice(drawn)?;
    Ok(all)
}

/// Adds to what is drawn. Returns whether there is room for it beside what is stated.
fn add<T: Part, const N: usize>(stated: &Seq<T, N>, drawn: &mut Seq<T, N>, new: T) -> bool {
    all(stated, drawn).is_ok_and(|mut all| all.push(new).is_ok()) && drawn.push(new).is_ok()
}

/// Checks zones that a file or an operator states.
pub(crate) fn check_zones(zones: &Zones) -> Result<(), DrawnError> {
    let mut zones = zones.zones.iter().enumerate();
    zones.try_for_each(|(index, zone)| check(("keep-out zone", index + 1), &zone.corners, 3))
}

/// Checks lanes that a file or an operator states.
pub(crate) fn check_lanes(lanes: &Lanes) -> Result<(), DrawnError> {
    for (index, &Strip { width, ref points }) in lanes.lanes.iter().enumerate() {
        let number = index + 1;
        check(("lane", number), points, 2)?;
        if width <= 0.0 || width > MAX_COORDINATE {
            return Err(DrawnError::Width { number, width });
        }
    }
    Ok(())
}

fn check((what, number): (&'static str, usize), points: &[Point2D], least: usize) -> Result<(), DrawnError> {
    if points.len() < least {
        return Err(DrawnError::Points {
            what,
            number,
            given: points.len(),
            least,
        });
    }
    let is_far = |point: &&Point2D| point.x.abs().max(point.y.abs()) > MAX_COORDINATE;
    match points.iter().find(is_far) {
        Some(&Point2D { x, y }) => Err(DrawnError::Far { what, number, x, y }),
        None => Ok(()),
    }
}

/// The points as pairs, in metres.
fn pairs(points: &[Point2D]) -> Vec<(f64, f64)> {
    points.iter().map(|point| (point.x, point.y)).collect()
}
