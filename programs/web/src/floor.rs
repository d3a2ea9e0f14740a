//! The robots from above: bodies, paths, scans, targets, ways, and the walls of a simulated world, as a canvas of a panel. The
//! robots and their frame are those of [`DriveTimeline`], and the shapes those that the windows show.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use jde_abi::describe::Type;
use jde_link::{Rate, Sample, Subscription};
use jde_panel::{Ink, Item, List, Shape, Stroke, Wants};
use jde_timeline::{DriveTimeline, Export, RobotSources, RobotTimeline, is_placed, outline};
use jde_types::{
    Body, LaserScan, Movers, Odometry, Path, Pose2D, Route, Scenery, Target, Thing, Truth, Value,
};
use parking_lot::Mutex;
use serde_json::json;

use crate::feeds::Parts;
use crate::model::Model;
use crate::panel;

/// How often values are read that move with a robot, and all others.
const MOTION: Rate = Rate::Hz(10);
const SLOW: Rate = Rate::Hz(2);
/// How often a page gets a picture.
const INTERVAL: Duration = Duration::from_millis(200);
/// Poses of one instant arrive within this time, ns.
const SAME_TIME: u64 = 1_000_000_000;
/// Points of a path, and of a scan: a phone has not many more columns.
const MAX_POINTS: usize = 360;

/// What is seen from above.
pub(crate) struct Floor {
    drive: DriveTimeline,
    /// The newest scan of each robot, in its own frame.
    scans: Vec<(u64, Vec<[f64; 2]>)>,
    /// By variable.
    targets: BTreeMap<String, [f64; 2]>,
    ways: BTreeMap<String, Vec<[f64; 2]>>,
    things: BTreeMap<String, Vec<Thing>>,
    /// The time of the newest pose, ns.
    time: u64,
    /// Whether a value has arrived that no picture shows.
    is_new: bool,
    drawn: Option<Instant>,
}

/// Returns whether an application has robots to look at.
pub(crate) fn exists(model: &Model) -> bool {
    !robots(model).is_empty()
}

fn robots(model: &Model) -> Vec<RobotSources> {
    let exports = |value_type: &Type| -> Vec<Export> {
        let exports = model.variables.iter();
        let exports = exports.filter(|one| one.access == "export" && one.type_name == value_type.name);
        let export = exports.map(|one| Export {
            owner: one.owner.clone(),
            key: one.name.clone(),
        });
        export.collect()
    };
    let is_commanded = |owner: &str| {
        let mut variables = model.variables.iter();
        variables.any(|one| one.access == "command" && one.owner == owner)
    };
    RobotSources::find(exports, is_commanded).0
}

/// Subscribes to what is seen from above. Waits for the link.
///
/// # Errors
/// There is no robot, or no connection.
pub(crate) fn open(model: &Model) -> Result<(Vec<Subscription>, Arc<Mutex<Floor>>), String> {
    let robots = robots(model);
    if robots.is_empty() {
        return Err("the application has no robot with a pose or a laser".to_owned());
    }
    let floor = Arc::new(Mutex::new(Floor {
        drive: DriveTimeline::new(robots.clone(), None, 0),
        scans: vec![(0, Vec::new()); robots.len()],
        targets: BTreeMap::new(),
        ways: BTreeMap::new(),
        things: BTreeMap::new(),
        time: 0,
        is_new: false,
        drawn: None,
    }));
    let mut opening = Opening {
        model,
        floor,
        all: Vec::new(),
    };
    for (place, robot) in robots.iter().enumerate() {
        opening.watch(
            &robot.truth,
            MOTION,
            move |floor, sample, truth: Option<Truth>| {
                if let Some(truth) = truth {
                    floor.advance(sample.time);
                    floor.drive.robots[place].add_truth(sample.time, truth, false, || None);
                }
            },
        )?;
        opening.watch(
            &robot.odometry,
            MOTION,
            move |floor, sample, odometry: Option<Odometry>| {
                if let Some(odometry) = odometry {
                    floor.advance(sample.time);
                    floor.drive.robots[place].add_odometry(sample.time, &odometry, || None);
                }
            },
        )?;
        opening.watch(&robot.body, SLOW, move |floor, _, body: Option<Body>| {
            floor.drive.robots[place].body = body;
        })?;
        opening.watch(
            &robot.laser,
            MOTION,
            move |floor, sample, scan: Option<LaserScan>| {
                let body = floor.drive.robots[place].body;
                floor.advance(sample.time);
                let points = scan.map_or_else(Vec::new, |scan| {
                    let mount = body.map_or(Pose2D::ORIGIN, |body| body.laser(scan.header.frame_id.as_str()));
                    let mut points: Vec<_> = scan
                        .points()
                        .map(|point| on(&mount, [point.x, point.y]))
                        .collect();
                    let step = points.len().div_ceil(MAX_POINTS).max(1);
                    panel::thin(&mut points, step);
                    points
                });
                floor.scans[place] = (sample.time, points);
            },
        )?;
    }
    opening.each("", |floor, name, target: Option<Target>| {
        let target = target.filter(|target| target.set.get());
        set(
            &mut floor.targets,
            name,
            target.map(|target| [target.pose.x, target.pose.y]),
        );
    })?;
    opening.each("", |floor, name, route: Option<Route>| {
        let way = route.map(|route| route.poses.iter().map(|pose| [pose.x, pose.y]).collect());
        set(&mut floor.ways, name, way);
    })?;
    opening.each("export", |floor, name, path: Option<Path>| {
        let place = |pose: Pose2D| [pose.x, pose.y];
        let way = path.map(|path| path.poses.iter().map(|pose| place(pose.pose.into())).collect());
        set(&mut floor.ways, name, way);
    })?;
    opening.each("export", |floor, name, scenery: Option<Scenery>| {
        set(
            &mut floor.things,
            name,
            scenery.map(|scenery| scenery.things.to_vec()),
        );
    })?;
    opening.each("export", |floor, name, movers: Option<Movers>| {
        set(
            &mut floor.things,
            name,
            movers.map(|movers| movers.things.to_vec()),
        );
    })?;
    Ok((opening.all, opening.floor))
}

fn set<T>(all: &mut BTreeMap<String, T>, name: &str, value: Option<T>) {
    match value {
        Some(value) => _ = all.insert(name.to_owned(), value),
        None => _ = all.remove(name),
    }
}

/// Subscriptions under way.
struct Opening<'m> {
    model: &'m Model,
    floor: Arc<Mutex<Floor>>,
    all: Vec<Subscription>,
}

impl Opening<'_> {
    /// Watches a variable, if there is one.
    fn watch<T: Value>(
        &mut self,
        name: &Option<String>,
        rate: Rate,
        apply: impl Fn(&mut Floor, &Sample, Option<T>) + Send + Sync + 'static,
    ) -> Result<(), String> {
        let Some(name) = name else { return Ok(()) };
        let floor = Arc::clone(&self.floor);
        let watched = self.model.remote.watch(name, rate, move |sample| {
            let value = sample.bytes.as_deref().and_then(T::from_bytes);
            let mut floor = floor.lock();
            apply(&mut floor, &sample, value);
            floor.is_new = true;
        });
        self.all.push(watched.map_err(|error| error.to_string())?);
        Ok(())
    }

    /// Watches all variables of a type, or those with an access.
    fn each<T: Value>(
        &mut self,
        access: &str,
        apply: impl Fn(&mut Floor, &str, Option<T>) + Clone + Send + Sync + 'static,
    ) -> Result<(), String> {
        let wanted = T::describe().name;
        let fits = self.model.variables.iter();
        let fits = fits.filter(|one| one.type_name == wanted && (access.is_empty() || one.access == access));
        for variable in fits.take(MAX_OF_TYPE) {
            let (apply, name) = (apply.clone(), variable.name.clone());
            self.watch(&Some(variable.name.clone()), SLOW, move |floor, _, value| {
                apply(floor, &name, value)
            })?;
        }
        Ok(())
    }
}

/// Variables of one type that are shown, so that the topic has no more than others.
const MAX_OF_TYPE: usize = 8;

impl Floor {
    /// Takes the time of a pose. A recording that is played again begins another path.
    fn advance(&mut self, time: u64) {
        if time + SAME_TIME < self.time {
            let robots = std::mem::take(&mut self.drive.robots);
            let sources = robots.iter().map(|robot| robot.sources.clone()).collect();
            self.drive = DriveTimeline::new(sources, None, 0);
            for (new, old) in self.drive.robots.iter_mut().zip(robots) {
                new.body = old.body;
            }
            self.time = 0;
        }
        self.time = self.time.max(time);
    }

    /// Draws what is new, if the last picture is old enough.
    pub(crate) fn draw(&mut self, parts: &Parts) {
        if !self.is_new || self.drawn.is_some_and(|drawn| drawn.elapsed() < INTERVAL) {
            return;
        }
        (self.is_new, self.drawn) = (false, Some(Instant::now()));
        let canvas = Item::Canvas {
            id: "floor".to_owned(),
            area: None,
            forward_up: false,
            shapes: self.shapes(),
            wants: Wants::default(),
        };
        let mut view = panel::view(List {
            time: 0,
            items: vec![canvas],
        });
        view["text"] = json!(self.text());
        parts.set(0, &view);
    }

    fn shapes(&self) -> Vec<Shape> {
        let mut shapes: Vec<_> = self.things.values().flatten().filter_map(thing).collect();
        let first = &self.drive.robots[0];
        let moved = |points: &[[f64; 2]]| -> Vec<[f64; 2]> {
            let points = points
                .iter()
                .map(|[x, y]| <[f64; 2]>::from(first.to_path_frame((*x, *y))));
            points.filter(|point| is_placed(point)).collect()
        };
        for robot in &self.drive.robots {
            let mut path: Vec<_> = robot.path().iter().map(|point| [point.x, point.y]).collect();
            path.retain(|point| is_placed(point));
            let step = path.len().div_ceil(MAX_POINTS).max(1);
            panel::thin(&mut path, step);
            shapes.push(line(path, false, Ink::Accent, 1.5));
        }
        for way in self.ways.values() {
            shapes.push(line(moved(way), false, Ink::Goal, 1.5));
        }
        for target in self.targets.values() {
            for center in moved(&[*target]) {
                shapes.push(Shape::Circle {
                    center,
                    radius: 0.3,
                    filled: false,
                    stroke: stroke(Ink::Goal, 2.5),
                });
            }
        }
        for (robot, (at, scan)) in self.drive.robots.iter().zip(&self.scans) {
            let Some(pose) = robot.pose.filter(|pose| is_placed(&[pose.x, pose.y])) else {
                continue;
            };
            // An old scan does not go with the robot.
            let is_new = self.time.saturating_sub(*at) <= SAME_TIME;
            let seen = scan.iter().filter(|_| is_new);
            let points = seen.map(|point| on(&pose, *point)).collect();
            shapes.push(Shape::Points {
                points,
                stroke: stroke(Ink::Seen, 3.0),
            });
            let body = outline(robot.body.as_ref())
                .into_iter()
                .map(|corner| on(&pose, corner));
            shapes.push(line(body.collect(), true, Ink::Plain, 2.0));
            shapes.push(Shape::Arrow {
                from: [pose.x, pose.y],
                to: on(&pose, [0.45, 0.0]),
                stroke: stroke(Ink::Plain, 2.0),
            });
        }
        shapes
    }

    /// What the picture shows, for those who do not see it.
    fn text(&self) -> String {
        let about = |robot: &RobotTimeline| {
            let pose = robot.pose.filter(|pose| is_placed(&[pose.x, pose.y]))?;
            let (name, heading) = (&robot.sources.name, pose.theta.to_degrees());
            Some(format!(
                "{name} at {:.1}, {:.1} m, heading {heading:.0}°",
                pose.x, pose.y
            ))
        };
        let robots: Vec<_> = self.drive.robots.iter().filter_map(about).collect();
        if robots.is_empty() {
            "No pose is known.".to_owned()
        } else {
            robots.join("; ")
        }
    }
}

fn thing(thing: &Thing) -> Option<Shape> {
    let (pose, length, width) = (
        thing.pose,
        f64::from(thing.length) / 2.0,
        f64::from(thing.width) / 2.0,
    );
    if thing.form == Thing::PAINT || !is_placed(&[pose.x, pose.y, pose.theta, length, width]) {
        return None;
    }
    let corners = [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]];
    Some(if matches!(thing.form, Thing::BOX | Thing::ROBOT) {
        let corners = corners.map(|[x, y]| on(&pose, [x * length, y * width]));
        line(corners.to_vec(), true, Ink::Faint, 2.0)
    } else {
        Shape::Circle {
            center: [pose.x, pose.y],
            radius: length.abs(),
            filled: false,
            stroke: stroke(Ink::Faint, 2.0),
        }
    })
}

fn line(points: Vec<[f64; 2]>, closed: bool, ink: Ink, width: f32) -> Shape {
    Shape::Line {
        points,
        closed,
        stroke: stroke(ink, width),
    }
}

fn stroke(ink: Ink, width: f32) -> Stroke {
    Stroke {
        color: ink.into(),
        width,
    }
}

/// Converts a place in a frame to the frame in which that frame is given.
fn on(frame: &Pose2D, [x, y]: [f64; 2]) -> [f64; 2] {
    let at = frame.transform(&Pose2D::new(x, y, 0.0));
    [at.x, at.y]
}
