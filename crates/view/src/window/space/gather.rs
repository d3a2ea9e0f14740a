//! Asks the session for what is to be seen, and for nothing that nobody looks at.

use std::collections::{HashMap, HashSet, VecDeque};
use std::mem::{offset_of, size_of};
use std::sync::Arc;

use glam::Vec3;
use jde_link::Rate;
use jde_panel::Item;
use jde_types::{
    Flag, Image, LaserScan, Mission, Movers, Odometry, PanTilt, Path, Pose2D, RangeRing, Route, Scenery,
    Target, Text, Truth, Value, WheelEncoders,
};

use super::items::Items;
use super::seen::{Camera, Robot, Seen, Way, frame};
use super::stage::Pixels;
use crate::session::Session;

/// What moves with a robot is asked for so often: people see it flow.
const FLOWING: Rate = Rate::Hz(20);
/// Pictures are large.
const PICTURES: Rate = Rate::Hz(10);
/// What changes now and then.
const SELDOM: Rate = Rate::Hz(5);
/// The angle of a camera that does not tell: that of a Canon VC-C4.
const FIELD: f64 = 0.829;
/// Poses that wait for what is true at their time.
const POSES: usize = 40;

/// What is remembered from frame to frame.
#[derive(Default)]
pub(crate) struct Gather {
    cast: Cast,
    poses: VecDeque<(u64, Pose2D)>,
    pixels: HashMap<String, Arc<Pixels>>,
    /// Schemas whose panels have had scenes in them.
    scenes: HashSet<String>,
}

/// Who has what: full names, and owners. Made anew when the application's variables change.
#[derive(Default)]
struct Cast {
    /// Of how many variables it was made.
    made_of: usize,
    robots: Vec<[String; 2]>,
    lasers: Vec<[String; 2]>,
    sonars: Vec<[String; 2]>,
    heads: Vec<[String; 2]>,
    wheels: Vec<[String; 2]>,
    images: Vec<[String; 2]>,
    missions: Vec<[String; 2]>,
    targets: Vec<[String; 2]>,
    routes: Vec<[String; 2]>,
    paths: Vec<[String; 2]>,
    scenery: Option<[String; 2]>,
    movers: Option<String>,
    truth: Option<String>,
}

impl Cast {
    fn of(session: &Session) -> Self {
        fn exports<T: Value>(session: &Session) -> Vec<[String; 2]> {
            let names = session.exports::<T>();
            names.map(|it| [it.name.clone(), it.owner.clone()]).collect()
        }
        fn inputs<T: Value>(session: &Session) -> Vec<[String; 2]> {
            let name = T::describe().name;
            let fits = session.variables().iter().filter(|it| it.type_name == name);
            fits.map(|it| [it.name.clone(), it.owner.clone()]).collect()
        }
        let scenery = exports::<Scenery>(session).into_iter().next();
        let of_world = |all: Vec<[String; 2]>| {
            let [_, world] = scenery.as_ref()?;
            all.into_iter()
                .find(|[_, owner]| owner == world)
                .map(|[name, _]| name)
        };
        Self {
            made_of: session.variables().len(),
            robots: exports::<Odometry>(session),
            lasers: exports::<LaserScan>(session),
            sonars: exports::<RangeRing>(session),
            heads: exports::<PanTilt>(session),
            wheels: exports::<WheelEncoders>(session),
            images: exports::<Image>(session),
            missions: exports::<Mission>(session),
            targets: inputs::<Target>(session),
            routes: inputs::<Route>(session),
            paths: exports::<Path>(session),
            movers: of_world(exports::<Movers>(session)),
            truth: of_world(exports::<Truth>(session)),
            scenery,
        }
    }

    /// The robot that something belongs to: its owner, or the first.
    fn robot(&self, owner: &str) -> usize {
        self.robots
            .iter()
            .position(|[_, robot]| robot == owner)
            .unwrap_or(0)
    }
}

impl Gather {
    /// Brings `seen` up to now, as far as people want to see it.
    pub(crate) fn update(&mut self, seen: &mut Seen, session: &Session, items: &Items) {
        if self.cast.made_of != session.variables().len() {
            self.cast = Cast::of(session);
            *seen = Seen::default();
        }
        self.robots(seen, session, items);
        self.goals(seen, session, items);
        self.cameras(seen, session, items);
        self.world(seen, session, items);
        self.panels(seen, session, items);
    }

    fn robots(&mut self, seen: &mut Seen, session: &Session, items: &Items) {
        seen.robots.resize_with(self.cast.robots.len(), Robot::default);
        for (number, (robot, [odometry, owner])) in seen.robots.iter_mut().zip(&self.cast.robots).enumerate()
        {
            robot.name.clone_from(owner);
            robot.lasers.clear();
            robot.sonars.clear();
            robot.carries.laser = false;
            robot.carries.sonars = false;
            for sample in session.values(odometry, FLOWING, "space") {
                let Some(told) = sample.bytes.as_deref().and_then(Odometry::from_bytes) else {
                    continue;
                };
                let pose = told.pose2d();
                robot.trail.add(pose, sample.time);
                if number == 0 {
                    self.poses.push_back((sample.time, pose));
                    let surplus = self.poses.len().saturating_sub(POSES);
                    self.poses.drain(..surplus);
                }
            }
            robot.pose = session
                .read::<Odometry>(odometry, FLOWING)
                .map(|(told, _)| told.pose2d());
        }
        let cast = &self.cast;
        for [name, owner] in &cast.lasers {
            let Some(robot) = seen.robots.get_mut(cast.robot(owner)) else {
                continue;
            };
            robot.carries.laser = true;
            if items.laser
                && let Some((scan, _)) = session.read::<LaserScan>(name, FLOWING)
            {
                robot.lasers.push((name.clone(), Box::new(scan)));
            }
        }
        for [name, owner] in &cast.sonars {
            let Some(robot) = seen.robots.get_mut(cast.robot(owner)) else {
                continue;
            };
            robot.carries.sonars = true;
            if items.sonars
                && let Some((ring, _)) = session.read::<RangeRing>(name, FLOWING)
            {
                robot.sonars.push((name.clone(), Box::new(ring)));
            }
        }
        for [name, owner] in &cast.heads {
            if let Some(robot) = seen.robots.get_mut(cast.robot(owner)) {
                let head = session.read::<PanTilt>(name, FLOWING);
                let angles = head.map(|(head, _)| [head.pan, head.tilt].map(|angle| angle as f32));
                robot.carries.head = angles.filter(|angles| angles.iter().all(|angle| angle.is_finite()));
            }
        }
        for [name, owner] in &cast.wheels {
            if let Some(robot) = seen.robots.get_mut(cast.robot(owner))
                && let Some((encoders, _)) = session.read::<WheelEncoders>(name, FLOWING)
            {
                robot.roll(&encoders);
            }
        }
    }

    fn goals(&self, seen: &mut Seen, session: &Session, items: &Items) {
        seen.targets.clear();
        seen.missions.clear();
        seen.routes.clear();
        if !items.targets {
            return;
        }
        let cast = &self.cast;
        for [name, owner] in &cast.missions {
            if let Some((mission, _)) = session.read::<Mission>(name, SELDOM) {
                seen.missions.push((owner.clone(), mission));
            }
        }
        for [name, owner] in &cast.targets {
            if let Some((target, _)) = session.read::<Target>(name, SELDOM) {
                seen.targets.push((owner.clone(), target));
            }
        }
        for [name, owner] in &cast.routes {
            if let Some((route, _)) = session.read::<Route>(name, Rate::Hz(1)) {
                let mission = seen.missions.iter().find(|(whose, _)| whose == owner);
                let reached = mission.map_or(0, |(_, mission)| mission.reached as usize);
                seen.routes.push(Way::route(name, &route, reached));
            }
        }
        for [name, _] in &cast.paths {
            if let Some((path, _)) = session.read::<Path>(name, SELDOM) {
                seen.routes.push(Way::path(name, &path));
            }
        }
    }

    fn cameras(&mut self, seen: &mut Seen, session: &Session, items: &Items) {
        seen.cameras.clear();
        if !items.cameras {
            self.pixels.clear();
            return;
        }
        for [name, owner] in &self.cast.images {
            let Some(sample) = session.value(name, PICTURES) else {
                continue;
            };
            let known = self
                .pixels
                .get(name)
                .filter(|known| known.stamp == sample.sequence);
            let pixels = match known {
                Some(known) => Arc::clone(known),
                None => {
                    let Some(pixels) = sample
                        .bytes
                        .as_deref()
                        .and_then(|bytes| pixels(bytes, sample.sequence))
                    else {
                        self.pixels.remove(name);
                        continue;
                    };
                    let pixels = Arc::new(pixels);
                    self.pixels.insert(name.clone(), Arc::clone(&pixels));
                    pixels
                }
            };
            let number = |what: &str| told::<f64>(session, owner, what);
            let robot = told::<Text<60>>(session, owner, "robot");
            let robot = self
                .cast
                .robot(robot.as_ref().map_or(owner.as_str(), Text::as_str));
            let on_head = told::<Flag>(session, owner, "on_head").map_or_else(
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
                field: number("field_of_view").unwrap_or(FIELD).clamp(0.01, 3.0) as f32,
                pixels,
            });
        }
    }

    /// Panels that never had a scene are looked at once a second only: their schemas draw for whoever looks.
    fn panels(&mut self, seen: &mut Seen, session: &Session, items: &Items) {
        seen.panels.clear();
        if !items.panels {
            return;
        }
        let all = session.schemas().schemas.iter().filter(|schema| schema.panel);
        for schema in all {
            let rate = if self.scenes.contains(&schema.name) {
                PICTURES
            } else {
                Rate::Hz(1)
            };
            if let Some(Ok(list)) = session.panel(&schema.name, rate)
                && has_scene(&list.items)
            {
                self.scenes.insert(schema.name.clone());
                seen.panels.push((schema.name.clone(), list));
            }
        }
    }

    fn world(&mut self, seen: &mut Seen, session: &Session, items: &Items) {
        let cast = &self.cast;
        (seen.world.scenery, seen.world.movers) = (None, None);
        if !items.walls && !items.movers {
            return;
        }
        if let Some([name, _]) = &cast.scenery
            && items.walls
        {
            seen.world.scenery = session
                .read::<Scenery>(name, Rate::Hz(1))
                .map(|(scenery, _)| Box::new(scenery));
        }
        if let Some(name) = &cast.movers
            && items.movers
        {
            seen.world.movers = session
                .read::<Movers>(name, FLOWING)
                .map(|(movers, _)| Box::new(movers));
        }
        if let Some(name) = &cast.truth
            && let Some((truth, sample)) = session.read::<Truth>(name, FLOWING)
        {
            // Only what is of one instant tells by how much the wheels are wrong.
            let same = self.poses.iter().find(|(time, _)| *time == sample.time);
            if let Some((_, pose)) = same {
                seen.world.frame = frame(*pose) * frame(truth.pose).inverse();
            }
        }
    }
}

/// Whether there is anything to show in space.
fn has_scene(items: &[Item]) -> bool {
    items.iter().any(|item| match item {
        Item::Scene { .. } => true,
        Item::Row { items } | Item::Group { items, .. } => has_scene(items),
        Item::Text { .. }
        | Item::Value { .. }
        | Item::Button { .. }
        | Item::Toggle { .. }
        | Item::Slider { .. }
        | Item::Choice { .. }
        | Item::Image { .. }
        | Item::Plot { .. }
        | Item::Table { .. }
        | Item::Canvas { .. } => false,
    })
}

/// A modulation of a schema, if it has it.
fn told<T: Value>(session: &Session, owner: &str, what: &str) -> Option<T> {
    let schema = session.schema(owner)?;
    schema
        .ports
        .iter()
        .any(|port| port.name == what && port.role == "modulation")
        .then(|| session.read::<T>(&format!("{owner}.{what}"), Rate::Hz(1)))?
        .map(|(value, _)| value)
}

/// Pixels as the card takes them; none if the picture is broken, or of a kind that is not known.
///
/// Reads them where they lie: an [`Image`] is too large to be taken out.
fn pixels(bytes: &[u8], stamp: u64) -> Option<Pixels> {
    if bytes.len() != size_of::<Image>() {
        return None;
    }
    let number = |at: usize| u32::from_bytes(&bytes[at..at + 4]);
    let height = number(offset_of!(Image, height))?;
    let width = number(offset_of!(Image, width))?;
    let step = number(offset_of!(Image, step))? as usize;
    let encoding = offset_of!(Image, encoding);
    let encoding = Text::<28>::from_bytes(&bytes[encoding..encoding + size_of::<Text<28>>()])?;
    let channels = match encoding.as_str() {
        "rgb8" | "bgr8" => 3,
        "mono8" => 1,
        _ => return None,
    };
    // A sequence is its length, and what it holds begins after 8 bytes.
    let data = offset_of!(Image, data);
    let length = number(data)? as usize;
    let data = bytes.get(data + 8..)?.get(..length)?;
    let long = (width as usize).checked_mul(channels)?;
    if width == 0 || height == 0 || step < long || step.checked_mul(height as usize)? > data.len() {
        return None;
    }
    let mut rgba = Vec::with_capacity(4 * width as usize * height as usize);
    for row in data.chunks_exact(step).take(height as usize) {
        for pixel in row[..long].chunks_exact(channels) {
            rgba.extend_from_slice(&match (pixel, encoding.as_str()) {
                ([blue, green, red], "bgr8") => [*red, *green, *blue, 255],
                ([red, green, blue], _) => [*red, *green, *blue, 255],
                ([grey], _) => [*grey, *grey, *grey, 255],
                _ => return None,
            });
        }
    }
    Some(Pixels {
        size: [width, height],
        rgba,
        stamp,
    })
}
