//! What is there to be seen: the newest values of what an application has, as the view needs them. It knows nothing of drawing.

use std::sync::Arc;

use glam::{Affine3A, Vec3};
use jde_panel::List;
use jde_types::{
    LaserScan, Mission, Movers, Path, Pose2D, RangeRing, Route, Scenery, Target, Thing, WheelEncoders,
};

use super::super::trail::Trail;
use super::draw_list::{Pixels, placed};
use super::models::{HEAD, LASER_AHEAD, LASER_HEIGHT, Payload};

/// Radius of a Pioneer's wheels, m.
const WHEEL: f64 = 0.0975;

/// All there is.
#[derive(Debug, Default)]
pub(crate) struct SceneData {
    pub(crate) robots: Vec<RobotData>,
    pub(crate) cameras: Vec<Camera>,
    /// With the names of those who have them.
    pub(crate) targets: Vec<(String, Target)>,
    pub(crate) missions: Vec<(String, Mission)>,
    pub(crate) routes: Vec<RouteData>,
    pub(crate) world: WorldData,
    /// Panels with scenes in them, by schema.
    pub(crate) panels: Vec<(String, Arc<List>)>,
    /// What cannot be shown, in words.
    pub(crate) troubles: Vec<String>,
}

/// A robot and what moves along with it.
#[derive(Debug, Default)]
pub(crate) struct RobotData {
    pub(crate) name: String,
    /// Where its wheels say it is; none while nothing says so.
    pub(crate) pose: Option<Pose2D>,
    pub(crate) lasers: Vec<(String, Box<LaserScan>)>,
    pub(crate) sonars: Vec<(String, Box<RangeRing>)>,
    /// Whether it has them, be they heard or not.
    pub(crate) carries: Payload,
    pub(crate) trail: Trail,
}

/// A camera on a robot, and what it saw last.
#[derive(Clone, Debug)]
pub(crate) struct Camera {
    pub(crate) name: String,
    /// The place of its robot among all.
    pub(crate) robot: usize,
    pub(crate) on_head: bool,
    /// On the head or, if it is not on one, on the body.
    pub(crate) at: Vec3,
    pub(crate) yaw: f32,
    /// From the left edge of the picture to the right one, rad.
    pub(crate) field: f32,
    pub(crate) pixels: Arc<Pixels>,
}

/// Places to go through.
#[derive(Clone, Debug)]
pub(crate) struct RouteData {
    pub(crate) name: String,
    pub(crate) points: Vec<Pose2D>,
    /// How many of them are behind the robot.
    pub(crate) reached: usize,
}

/// What a simulator tells of its world.
#[derive(Debug, Default)]
pub(crate) struct WorldData {
    /// The world's frame in that of the odometry: the identity but for what the wheels got wrong.
    pub(crate) frame: Affine3A,
    pub(crate) scenery: Option<Box<Scenery>>,
    pub(crate) movers: Option<Box<Movers>>,
}

impl RobotData {
    /// Its base in the frame of the odometry.
    pub(crate) fn place(&self) -> Option<Affine3A> {
        let pose = self.pose?;
        let finite = pose.x.is_finite() && pose.y.is_finite() && pose.theta.is_finite();
        finite.then(|| frame(pose))
    }

    /// Its laser there.
    pub(crate) fn laser(&self) -> Option<Affine3A> {
        let mount = Affine3A::from_translation(Vec3::new(LASER_AHEAD, 0.0, LASER_HEIGHT));
        Some(self.place()? * mount)
    }

    /// Takes its wheels' angles from what they counted.
    pub(crate) fn roll(&mut self, encoders: &WheelEncoders) {
        if encoders.ticks_per_meter > 0.0 {
            let angle = |ticks: i64| {
                let turned = ticks as f64 / encoders.ticks_per_meter / WHEEL;
                turned.rem_euclid(std::f64::consts::TAU) as f32
            };
            self.carries.wheels = [angle(encoders.left), angle(encoders.right)];
        }
    }
}

impl Camera {
    /// Where it is and looks (along x), in the frame of the odometry.
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
    /// A frame of REP-105 in that of the odometry.
    pub(crate) fn frame(&self, name: &str) -> Option<Affine3A> {
        let first = self.robots.first();
        match name {
            "odom" | "" => Some(Affine3A::IDENTITY),
            "map" => Some(self.world.frame),
            "base_link" => first?.place(),
            "laser" => first?.laser(),
            _ => None,
        }
    }

    /// What moves and is not shown as a robot of its own.
    pub(crate) fn movers(&self) -> impl Iterator<Item = &Thing> {
        let movers = self.world.movers.iter().flat_map(|movers| movers.things.iter());
        movers.filter(|thing| {
            thing.form != Thing::ROBOT || !self.robots.iter().any(|robot| thing.name.as_str() == robot.name)
        })
    }

    /// Whether nothing at all is there to be seen.
    pub(crate) fn is_empty(&self) -> bool {
        self.robots.iter().all(|robot| robot.pose.is_none()) && self.world.scenery.is_none()
    }
}

/// A pose of the plane as a frame.
pub(crate) fn frame(pose: Pose2D) -> Affine3A {
    let at = Vec3::new(pose.x as f32, pose.y as f32, 0.0);
    placed(at, [0.0, 0.0, pose.theta as f32])
}
