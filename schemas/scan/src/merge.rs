//! The schema that makes one scan of several sensors. It judges nothing and makes no map.

use jde_motion::{OdometryHistory, Outline, ScanPoints, is_jump};
use jde_schema::prelude::*;
use jde_schema::types::{self, Point2D};
use jde_schema::{Imports, ListedImport};

use crate::circle::Circle;
use crate::eye::Eye;
use crate::memory::{Memory, Sense};
use crate::sensor::{Kind, Measured, Mounting, pressed};

/// Least step of the odometry that is a jump and no motion, m.
const JUMP: f64 = 1.0;

/// Exports one scan around the base of what several lasers, sonars, bumpers and cliff sensors notice.
///
/// Each point is where it was measured, by the odometry, and the scan has the time of its oldest part. A direction is
/// free only where lasers have looked at the whole way, and otherwise unknown (NaN). While a sensor has no value, an old
/// one, or one of another clock, there is no scan.
#[derive(Describe)]
#[schema(perceptive, period = "50ms", budget = "20ms")]
pub struct Merge {
    /// The sensors: LaserScan, RangeRing, Range or Bumpers, at least one laser.
    #[imports(default = Mounting::DEFAULT)]
    sensors: Imports<Mounting>,
    /// Pose and velocity of the robot by the odometry.
    #[import]
    pose: Import<Odometry>,
    /// The outline of the robot, on which its bumpers are.
    #[modulation(default = types::Footprint::circle(0.25), fixed)]
    footprint: Modulation<types::Footprint>,
    /// How far the scan reaches. 0 is as far as the laser of the least range sees from the centre of the base.
    #[modulation(default = 0.0, unit = "m", min = 0.0, max = 1000.0)]
    range_max: Modulation<f64>,
    /// How much deeper than the floor is a cliff, for sensors that look down.
    #[modulation(default = 0.03, unit = "m", min = 0.001, max = 1.0)]
    max_drop: Modulation<f64>,
    /// Time for which it remembers what a bumper or a cliff sensor noticed, and what a laser saw where none looks now.
    #[modulation(default = 10.0, unit = "s", min = 0.0, max = 3600.0)]
    observation_persistence: Modulation<f64>,
    /// The scan, in the frame of the base.
    #[export]
    scan: Export<LaserScan>,
    circle: Option<Circle>,
    memory: Memory,
    history: OdometryHistory,
    scan_points: ScanPoints,
    /// The last pose of the base.
    last: Option<Pose2D>,
    /// Why there is no scan.
    lacks: Option<String>,
}

/// What the sensors notice now, in the frame of the odometry.
#[derive(Default)]
struct Noticed {
    eyes: Vec<Eye>,
    light: Vec<Point2D>,
    /// What no laser sees.
    others: Vec<Point2D>,
    /// How far the lasers see from the centre of the base, m.
    reach: f64,
    /// The time of the oldest part.
    oldest: Duration,
}

impl Schema for Merge {
    fn awake(&mut self, cx: &Context) -> Result {
        self.check_lasers()?;
        self.circle = Some(Circle::new(&Outline::try_from(&self.footprint.get(cx))?));
        self.memory.clear();
        self.last = None;
        Ok(())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let before = self.lacks.take();
        if let Err(words) = self.merge(cx) {
            if before.is_none() {
                warn!(cx, "no scan: {words}");
            }
            self.lacks = Some(words);
            self.scan.retract(cx);
        }
        Ok(())
    }
}

impl Inspect for Merge {
    fn inspect(&self, cx: &Context, problems: &mut Problems) {
        problems.expect(&self.footprint, Outline::try_from(&self.footprint.get(cx)));
        let mut are_sensors = true;
        for entry in self.sensors.iter() {
            are_sensors &= problems.expect(entry, Kind::check(entry)).is_some();
        }
        match self.sensors.first() {
            Some(first) if are_sensors => drop(problems.expect(first, self.check_lasers())),
            Some(_) => {}
            None => drop(problems.expect(&self.footprint, self.check_lasers())),
        }
    }
}

impl Merge {
    /// Checks the entries, and that there is a laser.
    fn check_lasers(&self) -> Result<(), String> {
        let kinds: Result<Vec<Kind>, String> = self.sensors.iter().map(Kind::check).collect();
        if kinds?.contains(&Kind::Laser) {
            return Ok(());
        }
        Err("none of `sensors` is a laser, and nothing else shows what is free".to_owned())
    }

    /// Exports the scan.
    ///
    /// # Errors
    /// Why there is none.
    fn merge(&mut self, cx: &Context) -> Result<(), String> {
        let odometry = self.pose.get(cx).ok_or("there is no odometry")?;
        let pose = odometry.pose2d();
        if (self.last.replace(pose)).is_some_and(|last| is_jump(&last, &pose, JUMP)) {
            self.memory.clear();
        }
        self.history.add(odometry.time(), &odometry);
        let mut noticed = Noticed {
            reach: f64::INFINITY,
            oldest: cx.now(),
            ..Noticed::default()
        };
        // What lasers see explains what sonars hear.
        let (lasers, blind): (Vec<_>, Vec<_>) =
            (self.sensors.iter()).partition(|entry| Kind::of(entry) == Ok(Kind::Laser));
        for entry in lasers {
            look(&mut noticed, cx, entry, (&self.history, &mut self.scan_points))?;
        }
        let circle = self.circle.as_mut().ok_or("it is not awake")?;
        let deeper = self.max_drop.get(cx);
        for entry in blind {
            feel(
                &mut noticed,
                cx,
                entry,
                (&self.history, circle, deeper, &mut self.memory),
            )?;
        }
        let Noticed {
            eyes,
            light,
            others,
            reach,
            oldest,
        } = noticed;
        let base = self.history.base("values", oldest, cx.now())?;
        let is_seen = |place: &Point2D| eyes.iter().any(|eye| eye.sees(place));
        let age = Duration::from_secs_f64(self.observation_persistence.get(cx));
        self.memory.retain(&base, cx.now(), age, is_seen);
        circle.clear();
        let local = |point: &Point2D| {
            let Pose2D { x, y, .. } = base.localize(&Pose2D::new(point.x, point.y, 0.0));
            Point2D { x, y }
        };
        (light.iter().chain(&others).chain(self.memory.points())).for_each(|point| circle.add(&local(point)));
        for point in &light {
            self.memory.add(*point, cx.now(), Sense::Light);
        }
        let range_max = match self.range_max.get(cx) {
            0.0 => reach,
            stated => stated,
        };
        let mut scan = self.scan.loan(cx);
        scan.header = Header::new(oldest, "base_link");
        let world = |point: &Point2D| {
            let Pose2D { x, y, .. } = base.transform(&Pose2D::new(point.x, point.y, 0.0));
            Point2D { x, y }
        };
        if !circle.write(&mut scan, range_max, |place| is_seen(&world(place))) {
            return Err("the lasers look nowhere around the robot".to_owned());
        }
        scan.publish_at(oldest);
        Ok(())
    }

    /// Why there is no scan; `None` if there is one.
    pub(crate) fn lacks(&self) -> Option<&str> {
        self.lacks.as_deref()
    }

    /// What it exported last, if it is valid.
    pub(crate) fn points(&self) -> impl Iterator<Item = (f64, f64)> {
        let nearest = self.circle.as_ref().filter(|_| self.lacks.is_none());
        nearest.into_iter().flat_map(Circle::points)
    }
}

/// Returns the newest value of a sensor.
fn newest<'call>(
    cx: &'call Context<'_>,
    entry: &ListedImport<Mounting>,
) -> Result<Sample<'call, [u8]>, String> {
    entry
        .get(cx)
        .ok_or_else(|| format!("`{}` has no value", entry.label()))
}

/// Adds what a laser sees.
fn look(
    noticed: &mut Noticed,
    cx: &Context,
    entry: &ListedImport<Mounting>,
    (history, points): (&OdometryHistory, &mut ScanPoints),
) -> Result<(), String> {
    let value = newest(cx, entry)?;
    let of = |words: String| format!("`{}`: {words}", entry.label());
    let scan = LaserScan::view(&value).ok_or_else(|| of("it is no scan".to_owned()))?;
    let mount = entry.settings().mount;
    let sweep = history.sweep(scan, value.time(), cx.now()).map_err(of)?;
    points
        .update(scan, sweep.seen_from(&Pose2D::ORIGIN, &mount))
        .map_err(|error| of(error.to_string()))?;
    noticed.light.extend_from_slice(points.as_slice());
    noticed.eyes.push(Eye::new(scan, &sweep, &mount));
    let reach = f64::from(scan.range_max) - mount.x.hypot(mount.y);
    noticed.reach = noticed.reach.min(reach);
    noticed.oldest = noticed.oldest.min(value.time());
    Ok(())
}

/// Adds what a sonar, a bumper or a cliff sensor notices.
fn feel(
    noticed: &mut Noticed,
    cx: &Context,
    entry: &ListedImport<Mounting>,
    (history, circle, deeper, memory): (&OdometryHistory, &Circle, f64, &mut Memory),
) -> Result<(), String> {
    let value = newest(cx, entry)?;
    let label = entry.label();
    let base = history.base(&format!("values of `{label}`"), value.time(), cx.now())?;
    noticed.oldest = noticed.oldest.min(value.time());
    let settings = entry.settings();
    let Noticed { light, others, .. } = noticed;
    let touch = |others: &mut Vec<Point2D>, memory: &mut Memory, point: Point2D| {
        let Pose2D { x, y, .. } = base.transform(&Pose2D::new(point.x, point.y, 0.0));
        others.push(Point2D { x, y });
        memory.add(Point2D { x, y }, value.time(), Sense::Touch);
    };
    let mut measured = |one: Measured| {
        if settings.floor == 0.0 {
            others.extend(one.arc(settings.obstacle_max_range, &base, &*light));
            return Ok(());
        }
        let Pose2D { x, y, .. } = one.sensor;
        match one.is_cliff(settings.floor + deeper) {
            Some(true) => touch(others, memory, Point2D { x, y }),
            Some(false) => {}
            None => return Err(format!("`{label}` does not measure the floor")),
        }
        Ok(())
    };
    match Kind::of(entry)? {
        Kind::Laser => Ok(()),
        Kind::Range => Range::view(&value).map_or(Ok(()), |range| {
            measured(Measured::of_range(range, settings.mount))
        }),
        Kind::Ring => {
            RangeRing::view(&value).map_or(Ok(()), |ring| Measured::of_ring(ring).try_for_each(measured))
        }
        Kind::Bumpers => {
            let sectors = Bumpers::view(&value).into_iter();
            for (from, to) in sectors.flat_map(|bumpers| pressed(bumpers, settings.field_of_view)) {
                circle
                    .edge(from, to)
                    .for_each(|point| touch(others, memory, point));
            }
            Ok(())
        }
    }
}
