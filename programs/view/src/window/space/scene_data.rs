//! The data that the 3D view shows: the newest values of an application, in the form that the view needs. It
//! does not draw.

use std::sync::Arc;

use glam::{Affine3A, Vec3};
use jde_panel::List;
use jde_types::{Body, LaserScan, Mission, Movers, Path, Pose2D, RangeRing, Route, Scenery, Target, Thing};

use super::super::trail::Trail;
use super::draw_list::{Pixels, placed};
use super::models::{HEAD, LASER_HEIGHT, Payload};

/// All data of the scene.
#[derive(Debug, Default)]
pub(crate) struct SceneData {
    pub(crate) robots: Vec<RobotData>,
    pub(crate) cameras: Vec<Camera>,
    /// The targets, each with the schema that it belongs to.
    pub(crate) targets: Vec<(String, Target)>,
    pub(crate) missions: Vec<(String, Mission)>,
    pub(crate) routes: Vec<RouteData>,
    pub(crate) world: WorldData,
    /// Panels with scenes, by schema.
    pub(crate) panels: Vec<(String, Arc<List>)>,
    /// What cannot be shown, as messages.
    pub(crate) troubles: Vec<String>,
}

/// A robot and the data that moves with it.
#[derive(Debug, Default)]
pub(crate) struct RobotData {
    pub(crate) name: String,
    /// The pose by odometry. `None` until a value arrives.
    pub(crate) pose: Option<Pose2D>,
    /// Its outline, and where its lasers are. `None` until it is published.
    pub(crate) body: Option<Body>,
    pub(crate) lasers: Vec<(String, Box<LaserScan>)>,
    pub(crate) sonars: Vec<(String, Box<RangeRing>)>,
    /// The devices of the robot, whether their data is shown or not.
    pub(crate) carries: Payload,
    pub(crate) trail: Trail,
}

/// A camera on a robot, and its newest image.
#[derive(Clone, Debug)]
pub(crate) struct Camera {
    pub(crate) name: String,
    /// The index of its robot.
    pub(crate) robot: usize,
    pub(crate) on_head: bool,
    /// The position on the head, or on the body if it is not on a head, in m.
    pub(crate) at: Vec3,
    pub(crate) yaw: f32,
    /// Horizontal field of view, in rad.
    pub(crate) field: f32,
    pub(crate) pixels: Arc<Pixels>,
}

/// A route or path.
#[derive(Clone, Debug)]
pub(crate) struct RouteData {
    pub(crate) name: String,
    pub(crate) points: Vec<Pose2D>,
    /// Number of points that the robot has passed.
    pub(crate) reached: usize,
}

/// The world that a simulator exports.
#[derive(Debug, Default)]
pub(crate) struct WorldData {
    /// The world's frame in that of the odometry: the identity except for the error of the odometry.
    pub(crate) frame: Affine3A,
    pub(crate) scenery: Option<Box<Scenery>>,
    pub(crate) movers: Option<Box<Movers>>,
}

impl RobotData {
    /// The base in the frame of the odometry. `None` without a finite pose.
    pub(crate) fn place(&self) -> Option<Affine3A> {
        let pose = self.pose?;
        let finite = pose.x.is_finite() && pose.y.is_finite() && pose.theta.is_finite();
        finite.then(|| frame(pose))
    }

    /// The laser of a frame, in the frame of the odometry.
    pub(crate) fn laser(&self, name: &str) -> Option<Affine3A> {
        let mount = self.body.map_or(Pose2D::ORIGIN, |body| body.laser(name));
        Some(self.place()? * frame(mount) * Affine3A::from_translation(Vec3::Z * LASER_HEIGHT))
    }
}

impl Camera {
    /// The camera in the frame of the odometry. It looks along x.
    pub(crate) fn place(&self, robots: &[RobotData]) -> Option<Affine3A> {
        let robot = robots.get(self.robot)?;
        let on = if self.on_head {
            let [pan, tilt] = robot.carries.head.unwrap_or_default();
            robot.place()? * placed(HEAD, [0.0, tilt, pan])
        } else {
            robot.place()?
        };
        Some(on * placed(self.at, [0.0, 0.0, self.yaw]))
    }
}

impl RouteData {
    pub(crate) fn route(name: &str, route: &Route, reached: usize) -> Self {
        Self {
            name: name.to_owned(),
            points: route.poses.to_vec(),
            reached,
        }
    }

    pub(crate) fn path(name: &str, path: &Path) -> Self {
        Self {
            name: name.to_owned(),
            points: path.poses.iter().map(|pose| pose.pose.into()).collect(),
            reached: 0,
        }
    }
}

impl SceneData {
    /// A frame of REP 105 in that of the odometry. `None` if it is not known.
    pub(crate) fn frame(&self, name: &str) -> Option<Affine3A> {
        let first = self.robots.first();
        match name {
            "odom" | "" => Some(Affine3A::IDENTITY),
            "map" => Some(self.world.frame),
            "base_link" => first?.place(),
            "laser" => first?.laser(name),
            _ => None,
        }
    }

    /// The movers that are not shown as robots.
    pub(crate) fn movers(&self) -> impl Iterator<Item = &Thing> {
        let movers = self.world.movers.iter().flat_map(|movers| movers.things.iter());
        movers.filter(|thing| {
            thing.form != Thing::ROBOT || !self.robots.iter().any(|robot| thing.name.as_str() == robot.name)
        })
    }

    /// Whether there is nothing to show.
    pub(crate) fn is_empty(&self) -> bool {
        self.robots.iter().all(|robot| robot.pose.is_none()) && self.world.scenery.is_none()
    }
}

/// A planar pose as a transform.
pub(crate) fn frame(pose: Pose2D) -> Affine3A {
    let at = Vec3::new(pose.x as f32, pose.y as f32, 0.0);
    placed(at, [0.0, 0.0, pose.theta as f32])
}
