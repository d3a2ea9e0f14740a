//! Where a way begins and ends, when the robot or the target is too close to an obstacle or in a keep-out zone.

use jde_grid::costmap::LETHAL;
use jde_grid::{Cell, Costmap, PlanError, Prices, nearest_open, nearest_reachable, way_out};

use crate::followed::Followed;
use crate::situation::Situation;

/// What decides about the ends.
pub(crate) struct Ends<'a> {
    pub(crate) followed: &'a Followed,
    pub(crate) prices: &'a Prices,
}

impl Ends<'_> {
    /// Returns the cell of the target in metres; the error is why the robot cannot be there.
    pub(crate) fn goal(&self, target: (f64, f64)) -> Result<Cell, Situation> {
        let costs = self.followed.costs();
        let goal = costs.geometry().cell_at(target).ok_or(PlanError::GoalOutside)?;
        match self.is_open(costs, goal) {
            true => Ok(goal),
            false if self.followed.is_in_zone(goal) && self.is_open(self.followed.obstacles(), goal) => {
                Err(Situation::TargetInZone)
            }
            false => Err(PlanError::GoalClosed.into()),
        }
    }

    /// Returns the cell nearest to the target to which a way leads, at most `tolerance` metres away.
    pub(crate) fn reachable(&self, start: Cell, target: (f64, f64), tolerance: f64) -> Option<Cell> {
        let costs = self.followed.costs();
        let geometry = costs.geometry();
        let goal = geometry.cell_at(target)?;
        nearest_reachable(costs, self.prices, start, goal, tolerance / geometry.resolution())
    }

    /// Returns the cell to plan from, and the points in columns and rows over which the robot gets there.
    /// From an obstacle it is led at most `reach` metres away, from a zone at any distance.
    pub(crate) fn start(&self, robot: (f64, f64), reach: f64) -> Result<(Vec<(f64, f64)>, Cell), Situation> {
        let (costs, obstacles) = (self.followed.costs(), self.followed.obstacles());
        let robot = costs.geometry().cell_at(robot).ok_or(PlanError::StartOutside)?;
        // A robot whose centre is in an obstacle does not know to which side it belongs.
        let away = |costs: &Costmap| match costs.get(robot) {
            LETHAL => robot,
            _ => self.nearest(costs, robot, reach),
        };
        let mut points = Vec::new();
        let mut start = away(costs);
        if start != robot {
            points.push(center(robot));
        }
        let within = away(obstacles);
        if !self.is_open(costs, start) && self.is_open(obstacles, within) {
            let way = way_out(obstacles, costs, self.prices, within).ok_or(Situation::NoWayOut)?;
            if within != robot {
                points.push(center(robot));
            }
            if let Some(&(x, y)) = way.points.last() {
                start = Cell::new(x as u32, y as u32);
            }
            points.extend(way.points);
            // The way from there begins with it.
            points.pop();
        }
        Ok((points, start))
    }

    fn nearest(&self, costs: &Costmap, cell: Cell, distance: f64) -> Cell {
        let reach = distance / costs.geometry().resolution();
        nearest_open(costs, self.prices, cell, reach).unwrap_or(cell)
    }

    fn is_open(&self, costs: &Costmap, cell: Cell) -> bool {
        self.prices.of(costs.get(cell)) > 0
    }
}

pub(crate) fn center(cell: Cell) -> (f64, f64) {
    (f64::from(cell.x) + 0.5, f64::from(cell.y) + 0.5)
}
