//! The drawing of a drive from its timeline.

use jde_sim::Footprint;
use jde_timeline::{DriveTimeline, Hierarchy};
use jde_types::Body;

use super::{DriveMap, RobotPath};

impl DriveMap {
    /// Returns the robots, the takeovers and the targets of a run, without its title and its world.
    #[must_use]
    pub fn of(drive: DriveTimeline, hierarchy: &Hierarchy) -> Self {
        let (targets, takeover_count) = (drive.targets(hierarchy), drive.takeover_count);
        let (robots, takeovers) = drive.into_parts();
        let mut scans = Vec::new();
        let paths = robots.into_iter().map(|robot| {
            let (name, distance) = (robot.sources.name.clone(), robot.distance);
            let body = robot.body.as_ref().and_then(footprint);
            let (points, seen) = robot.into_path();
            scans.extend(seen);
            RobotPath {
                robot: name,
                body,
                points,
                distance,
            }
        });
        let paths = paths.filter(|path| !path.points.is_empty()).collect();
        let names = hierarchy.schemas().iter().map(|schema| schema.name.clone());
        Self {
            scans,
            paths,
            schema_names: names.collect(),
            targets,
            takeovers,
            takeover_count,
            ..Self::default()
        }
    }
}

/// The outline of a body; none if it is unknown or not that of a robot.
fn footprint(body: &Body) -> Option<Footprint> {
    let corners: Vec<_> = body
        .footprint
        .points
        .iter()
        .map(|point| [point.x, point.y])
        .collect();
    let radius = body.footprint.radius;
    if corners.is_empty() {
        (radius.is_finite() && radius > 0.0).then_some(Footprint::Circle { radius })
    } else {
        Footprint::polygon(&corners).ok()
    }
}
