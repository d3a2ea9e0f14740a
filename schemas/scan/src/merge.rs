//! The schema that makes one scan of several sensors. It judges nothing and makes no map.

use jde_motion::{OdometryHistory, Outline, ScanPoints};
use jde_schema::Imports;
use jde_schema::prelude::*;
use jde_schema::types::{self, Point2D};

use crate::circle::Circle;
use crate::eye::Looks;
use crate::memory::Memory;
use crate::noticing::{Noticing, Robot};
use crate::sensor::{Kind, Mounting};
use crate::sonar::Silence;

/// Exports one scan around the base of what several lasers, sonars, bumpers and cliff sensors notice.
///
/// Each point is where it was measured, by the odometry, and the scan has the time of its oldest part. A direction is
/// free only where lasers have looked at the whole way, and otherwise unknown (NaN); no beam goes farther, so that it may end
/// before a thing that is up to 0.3 m behind what nobody looked at. While a sensor has no value, an old
/// one, or one of another clock, there is no scan.
#[derive(Describe)]
#[schema(perceptive, period = "50ms", budget = "40ms")]
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
    /// Time for which it remembers what a bumper or a cliff sensor noticed, what a sonar heard, and what a laser saw where it
    /// does not look now.
    #[modulation(default = 10.0, unit = "s", min = 0.0, max = 3600.0)]
    observation_persistence: Modulation<f64>,
    /// The scan, in the frame of the base.
    #[export]
    scan: Export<LaserScan>,
    circle: Option<Circle>,
    memory: Memory,
    looks: Looks,
    history: OdometryHistory,
    scan_points: ScanPoints,
    silence: Silence,
    /// The last pose of the base, and how often the history had begun anew by then.
    last: Option<(Pose2D, u64)>,
    /// Why there is no scan.
    lacks: Option<String>,
}

impl Schema for Merge {
    fn awake(&mut self, cx: &Context) -> Result {
        self.check_lasers()?;
        self.circle = Some(Circle::new(&Outline::try_from(&self.footprint.get(cx))?));
        self.memory.clear();
        self.looks.clear();
        self.silence = Silence::default();
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
        self.history.add(odometry.time(), &odometry);
        if pose.is_finite() {
            let jumps = self.history.jumps();
            match self.last.replace((pose, jumps)) {
                Some((last, before)) if before != jumps => {
                    self.memory.jump(&last, &pose);
                    self.looks.clear();
                }
                Some(_) | None => {}
            }
        }
        let mut noticing = Noticing::new(cx.now());
        // What lasers see explains what sonars hear.
        let (lasers, blind): (Vec<_>, Vec<_>) =
            (self.sensors.iter().enumerate()).partition(|(_, entry)| Kind::of(entry) == Ok(Kind::Laser));
        for entry in lasers {
            noticing.look(cx, entry, &self.history, &mut self.scan_points)?;
        }
        let circle = self.circle.as_mut().ok_or("it is not awake")?;
        let robot = Robot {
            history: &self.history,
            circle,
            max_drop: self.max_drop.get(cx),
        };
        let mut felt = Ok(());
        for entry in blind {
            // What the others touch is remembered also while one has no value.
            felt = felt.and(noticing.feel(cx, entry, &robot, &mut self.silence));
        }
        let base = self.history.base("values", noticing.oldest, cx.now())?;
        let age = Duration::from_secs_f64(self.observation_persistence.get(cx));
        self.memory
            .retain(&base, cx.now(), age, |noticed| noticing.is_gone(noticed));
        circle.clear();
        let local = |point: &Point2D| {
            let Pose2D { x, y, .. } = base.localize(&Pose2D::new(point.x, point.y, 0.0));
            Point2D { x, y }
        };
        let now = noticing.points.iter().map(|noticed| &noticed.point);
        now.chain(self.memory.points())
            .for_each(|point| circle.add(&local(point)));
        for noticed in &noticing.points {
            self.memory.add(*noticed);
        }
        felt?;
        let range_max = match self.range_max.get(cx) {
            0.0 => noticing.reach,
            stated => stated,
        };
        let mut scan = self.scan.loan(cx);
        scan.header = Header::new(noticing.oldest, "base_link");
        let world = |point: &Point2D| {
            let Pose2D { x, y, .. } = base.transform(&Pose2D::new(point.x, point.y, 0.0));
            Point2D { x, y }
        };
        let looks = &self.looks;
        let is_seen = |place: &Point2D| looks.is_seen(cx.now(), &noticing.eyes, &world(place));
        let is_known = circle.write(&mut scan, range_max, is_seen);
        self.looks.add(cx.now(), noticing.eyes);
        if !is_known {
            return Err("the lasers look nowhere around the robot".to_owned());
        }
        scan.publish_at(noticing.oldest);
        Ok(())
    }

    /// Why there is no scan; `None` if there is one.
    pub(crate) fn lacks(&self) -> Option<&str> {
        self.lacks.as_deref()
    }

    /// How many sonars have measured nothing for long.
    pub(crate) fn silent(&self) -> usize {
        self.silence.count()
    }

    /// What it exported last, if it is valid.
    pub(crate) fn points(&self) -> impl Iterator<Item = (f64, f64)> {
        let nearest = self.circle.as_ref().filter(|_| self.lacks.is_none());
        nearest.into_iter().flat_map(Circle::points)
    }
}
