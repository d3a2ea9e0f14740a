//! Reads the data of the scene from the session. It requests only the data that is shown.

use std::collections::{HashMap, HashSet, VecDeque};
use std::sync::Arc;

use glam::Vec3;
use jde_link::Rate;
use jde_panel::Item;
use jde_types::{
    Flag, LaserScan, Mission, Movers, Odometry, PanTilt, Path, Pose2D, RangeRing, Route, Scenery, Target,
    Text, Truth, Value,
};

use super::draw_list::Pixels;
use super::entities::Entities;
use super::items::Items;
use super::scene_data::{Camera, RobotData, RouteData, SceneData, frame};
use crate::picture::Picture;
use crate::session::WindowSession;

/// Rate of data that moves with a robot: smooth to the eye.
const MOTION_RATE: Rate = Rate::Hz(20);
/// Rate of images and scenes, which are large.
const IMAGE_RATE: Rate = Rate::Hz(10);
/// Rate of data that changes rarely.
const SLOW_RATE: Rate = Rate::Hz(5);
/// Field of view of a camera that does not declare it, in rad: that of a Canon VC-C4.
const DEFAULT_FIELD_OF_VIEW: f64 = 0.829;
/// Maximum number of poses kept to be compared with the true pose of the same time.
const MAX_POSES: usize = 40;

/// State kept from frame to frame.
#[derive(Default)]
pub(crate) struct Sampler {
    entities: Entities,
    poses: VecDeque<(u64, Pose2D)>,
    pixels: HashMap<String, Arc<Pixels>>,
    /// Schemas whose panels have had scenes.
    scenes: HashSet<String>,
}

impl Sampler {
    /// Updates `seen` with the newest data of the shown items.
    pub(crate) fn update(&mut self, seen: &mut SceneData, session: &WindowSession, items: &Items) {
        if self.entities.made_of != session.variables().len() {
            self.entities = Entities::of(session);
            *seen = SceneData::default();
        }
        self.robots(seen, session, items);
        self.goals(seen, session, items);
        self.cameras(seen, session, items);
        self.world(seen, session, items);
        self.panels(seen, session, items);
    }

    fn robots(&mut self, seen: &mut SceneData, session: &WindowSession, items: &Items) {
        seen.robots
            .resize_with(self.entities.robots.len(), RobotData::default);
        for (number, (robot, [odometry, owner])) in
            seen.robots.iter_mut().zip(&self.entities.robots).enumerate()
        {
            robot.name.clone_from(owner);
            robot.lasers.clear();
            robot.sonars.clear();
            robot.body = session.body(owner);
            let mounts = robot.body.iter().flat_map(|body| body.lasers.iter());
            robot.carries.lasers = mounts.map(|mount| mount.pose).collect();
            for sample in session.values(odometry, MOTION_RATE, "space") {
                let Some(odometry_value) = sample.bytes.as_deref().and_then(Odometry::from_bytes) else {
                    continue;
                };
                let pose = odometry_value.pose2d();
                robot.trail.add(sample.time, [pose.x, pose.y]);
                if number == 0 {
                    self.poses.push_back((sample.time, pose));
                    let surplus = self.poses.len().saturating_sub(MAX_POSES);
                    self.poses.drain(..surplus);
                }
            }
            robot.pose = session
                .read::<Odometry>(odometry, MOTION_RATE)
                .map(|(odometry_value, _)| odometry_value.pose2d());
        }
        let entities = &self.entities;
        for [name, owner] in &entities.lasers {
            let Some(robot) = seen.robots.get_mut(entities.robot(owner)) else {
                continue;
            };
            if items.laser
                && let Some((scan, _)) = session.read::<LaserScan>(name, MOTION_RATE)
            {
                robot.lasers.push((name.clone(), Box::new(scan)));
            }
        }
        for [name, owner] in &entities.sonars {
            let Some(robot) = seen.robots.get_mut(entities.robot(owner)) else {
                continue;
            };
            if items.sonars
                && let Some((ring, _)) = session.read::<RangeRing>(name, MOTION_RATE)
            {
                robot.sonars.push((name.clone(), Box::new(ring)));
            }
        }
        for [name, owner] in &entities.heads {
            if let Some(robot) = seen.robots.get_mut(entities.robot(owner)) {
                let head = session.read::<PanTilt>(name, MOTION_RATE);
                let angles = head.map(|(head, _)| [head.pan, head.tilt].map(|angle| angle as f32));
                robot.carries.head = angles.filter(|angles| angles.iter().all(|angle| angle.is_finite()));
            }
        }
    }

    fn goals(&self, seen: &mut SceneData, session: &WindowSession, items: &Items) {
        seen.targets.clear();
        seen.missions.clear();
        seen.routes.clear();
        if !items.targets {
            return;
        }
        let entities = &self.entities;
        for [name, owner] in &entities.missions {
            if let Some((mission, _)) = session.read::<Mission>(name, SLOW_RATE) {
                seen.missions.push((owner.clone(), mission));
            }
        }
        for [name, owner] in &entities.targets {
            if let Some((target, _)) = session.read::<Target>(name, SLOW_RATE) {
                seen.targets.push((owner.clone(), target));
            }
        }
        for [name, owner] in &entities.routes {
            if let Some((route, _)) = session.read::<Route>(name, Rate::Hz(1)) {
                let mission = seen.missions.iter().find(|(whose, _)| whose == owner);
                let reached = mission.map_or(0, |(_, mission)| mission.reached as usize);
                seen.routes.push(RouteData::route(name, &route, reached));
            }
        }
        for [name, _] in &entities.paths {
            if let Some((path, _)) = session.read::<Path>(name, SLOW_RATE) {
                seen.routes.push(RouteData::path(name, &path));
            }
        }
    }

    fn cameras(&mut self, seen: &mut SceneData, session: &WindowSession, items: &Items) {
        seen.cameras.clear();
        seen.troubles.clear();
        if !items.cameras {
            self.pixels.clear();
            return;
        }
        for [name, owner] in &self.entities.images {
            let Some(sample) = session.value(name, IMAGE_RATE) else {
                continue;
            };
            let known = self
                .pixels
                .get(name)
                .filter(|known| known.stamp == sample.sequence);
            let pixels = match known {
                Some(known) => Arc::clone(known),
                None => {
                    self.pixels.remove(name);
                    // No image is not an error: the camera may be SLEPT.
                    if sample.bytes.is_none() {
                        continue;
                    }
                    let picture = match Picture::read(&sample) {
                        Ok(picture) => picture,
                        Err(reason) => {
                            seen.troubles.push(format!("{name}: {reason}"));
                            continue;
                        }
                    };
                    let stamp = sample.sequence;
                    let pixels = Arc::new(Pixels { picture, stamp });
                    self.pixels.insert(name.clone(), Arc::clone(&pixels));
                    pixels
                }
            };
            let number = |modulation: &str| newest_value::<f64>(session, owner, modulation);
            let robot = newest_value::<Text<60>>(session, owner, "robot");
            let robot = self
                .entities
                .robot(robot.as_ref().map_or(owner.as_str(), Text::as_str));
            let on_head = newest_value::<Flag>(session, owner, "on_head").map_or_else(
                || {
                    seen.robots
                        .get(robot)
                        .is_some_and(|robot| robot.carries.head.is_some())
                },
                Flag::get,
            );
            let at = [number("x"), number("y"), number("z")].map(|part| part.unwrap_or(0.0) as f32);
            seen.cameras.push(Camera {
                name: name.clone(),
                robot,
                on_head,
                at: Vec3::from_array(at),
                yaw: number("yaw").unwrap_or(0.0) as f32,
                field: number("field_of_view")
                    .unwrap_or(DEFAULT_FIELD_OF_VIEW)
                    .clamp(0.01, 3.0) as f32,
                pixels,
            });
        }
    }

    /// Reads the panels with scenes. A panel without a scene so far is requested only once a second, because
    /// its schema draws it for this request.
    fn panels(&mut self, seen: &mut SceneData, session: &WindowSession, items: &Items) {
        seen.panels.clear();
        if !items.panels {
            return;
        }
        let all = session.schemas().schemas.iter().filter(|schema| schema.panel);
        for schema in all {
            let rate = if self.scenes.contains(&schema.name) {
                IMAGE_RATE
            } else {
                Rate::Hz(1)
            };
            if let Some(Ok(list)) = session.panel(&schema.name, rate)
                && list.walk().any(|item| matches!(item, Item::Scene { .. }))
            {
                self.scenes.insert(schema.name.clone());
                seen.panels.push((schema.name.clone(), list));
            }
        }
    }

    fn world(&mut self, seen: &mut SceneData, session: &WindowSession, items: &Items) {
        let entities = &self.entities;
        (seen.world.scenery, seen.world.movers) = (None, None);
        if !items.walls && !items.movers {
            return;
        }
        if let Some([name, _]) = &entities.scenery
            && items.walls
        {
            seen.world.scenery = session
                .read::<Scenery>(name, Rate::Hz(1))
                .map(|(scenery, _)| Box::new(scenery));
        }
        if let Some(name) = &entities.movers
            && items.movers
        {
            seen.world.movers = session
                .read::<Movers>(name, MOTION_RATE)
                .map(|(movers, _)| Box::new(movers));
        }
        if let Some(name) = &entities.truth
            && let Some((truth, sample)) = session.read::<Truth>(name, MOTION_RATE)
        {
            // Only poses of the same instant show the error of the odometry.
            let same = self.poses.iter().find(|(time, _)| *time == sample.time);
            if let Some((_, pose)) = same {
                seen.world.frame = frame(*pose) * frame(truth.pose).inverse();
            }
        }
    }
}

/// The value of a schema's modulation, if the schema has it.
fn newest_value<T: Value>(session: &WindowSession, owner: &str, modulation: &str) -> Option<T> {
    let schema = session.schema(owner)?;
    schema
        .ports
        .iter()
        .any(|port| port.name == modulation && port.role == "modulation")
        .then(|| session.read::<T>(&format!("{owner}.{modulation}"), Rate::Hz(1)))?
        .map(|(value, _)| value)
}
