//! What the sensors notice at one time: each value is checked, and is where the base was when it was measured.

use jde_motion::{OdometryHistory, ScanPoints};
use jde_schema::ListedImport;
use jde_schema::prelude::*;
use jde_schema::types::Point2D;

use crate::circle::Circle;
use crate::eye::{Eye, Look};
use crate::memory::{Noticed, Sense};
use crate::sensor::{Kind, Measured, Mounting, pressed};
use crate::sonar::{Cone, Silence};

/// What the sensors notice now, in the frame of the odometry.
#[derive(Debug)]
pub(crate) struct Noticing {
    pub(crate) eyes: Vec<Eye>,
    /// The cones of the sonars that have an echo.
    pub(crate) cones: Vec<(Sense, Cone)>,
    /// Of lasers first.
    pub(crate) points: Vec<Noticed>,
    /// How far the lasers see from the centre of the base, m.
    pub(crate) reach: f64,
    /// The time of the oldest part.
    pub(crate) oldest: Duration,
}

/// What is known of the robot.
pub(crate) struct Robot<'a> {
    pub(crate) history: &'a OdometryHistory,
    pub(crate) circle: &'a Circle,
    /// How much deeper than the floor is a cliff, m.
    pub(crate) max_drop: f64,
}

impl Noticing {
    /// Nothing is noticed at a time.
    pub(crate) const fn new(now: Duration) -> Self {
        Self {
            eyes: Vec::new(),
            cones: Vec::new(),
            points: Vec::new(),
            reach: f64::INFINITY,
            oldest: now,
        }
    }

    /// Whether the sensor that noticed a point shows that it is gone.
    pub(crate) fn is_gone(&self, noticed: &Noticed) -> bool {
        match noticed.sense {
            Sense::Light(sensor) => {
                let mut eyes = self.eyes.iter().filter(|eye| eye.sensor == sensor);
                eyes.any(|eye| matches!(eye.look(&noticed.point), Look::Sees | Look::SeesEnd))
            }
            Sense::Sound(..) => {
                let mut cones = self.cones.iter();
                cones.any(|(sonar, cone)| *sonar == noticed.sense && cone.passes(&noticed.point))
            }
            Sense::Touch => false,
        }
    }

    /// Adds what the laser of a number in the list sees.
    pub(crate) fn look(
        &mut self,
        cx: &Context,
        (number, entry): (usize, &ListedImport<Mounting>),
        history: &OdometryHistory,
        points: &mut ScanPoints,
    ) -> Result<(), String> {
        let value = newest(cx, entry)?;
        let of = |words: String| format!("`{}`: {words}", entry.label());
        let scan = LaserScan::view(&value).ok_or_else(|| of("it is no scan".to_owned()))?;
        let mount = entry.settings().mount;
        let sweep = history.sweep(scan, value.time(), cx.now()).map_err(of)?;
        points
            .update(scan, sweep.seen_from(&Pose2D::ORIGIN, &mount))
            .map_err(|error| of(error.to_string()))?;
        let (time, sense) = (value.time(), Sense::Light(number));
        let points = points.as_slice().iter();
        self.points
            .extend(points.map(|&point| Noticed { point, time, sense }));
        self.eyes.push(Eye::new(number, scan, &sweep, &mount));
        let reach = f64::from(scan.range_max) - libm::hypot(mount.x, mount.y);
        self.reach = self.reach.min(reach);
        self.oldest = self.oldest.min(value.time());
        Ok(())
    }

    /// Adds what the sonars, bumpers or cliff sensors of a number in the list notice.
    pub(crate) fn feel(
        &mut self,
        cx: &Context,
        (number, entry): (usize, &ListedImport<Mounting>),
        robot: &Robot,
        silence: &mut Silence,
    ) -> Result<(), String> {
        let value = newest(cx, entry)?;
        let label = entry.label();
        let of = |words: String| format!("`{label}`: {words}");
        let none = || of("it is no value of its type".to_owned());
        let time = value.time();
        let base = robot
            .history
            .base(&format!("values of `{label}`"), time, cx.now())?;
        self.oldest = self.oldest.min(time);
        let settings = entry.settings();
        let mut measured = |(index, one): (usize, Measured)| {
            if settings.floor != 0.0 {
                let Pose2D { x, y, .. } = one.sensor;
                if one.is_cliff(settings.floor, robot.max_drop).map_err(of)? {
                    self.touch(&base, robot.circle.outward(Point2D { x, y }), time);
                }
                return Ok(());
            }
            if silence.begins((number, index), one.echo, cx.now()) {
                warn!(cx, "sonar {index} of `{label}` measures nothing");
            }
            if let Some(cone) = Cone::new(&one, &base) {
                self.add_echo(
                    cone,
                    Sense::Sound(number, index),
                    settings.obstacle_max_range,
                    time,
                );
            }
            Ok(())
        };
        match Kind::of(entry)? {
            Kind::Laser => Ok(()),
            Kind::Range => {
                let range = Range::view(&value).ok_or_else(none)?;
                measured((0, Measured::of_range(range, settings.mount).map_err(of)?))
            }
            Kind::Ring => {
                let ring = RangeRing::view(&value).ok_or_else(none)?;
                let all = Measured::of_ring(ring).map_err(of)?;
                all.enumerate().try_for_each(measured)
            }
            Kind::Bumpers => {
                let bumpers = Bumpers::view(&value).ok_or_else(none)?;
                for (from, to) in pressed(bumpers, settings.field_of_view) {
                    let edge = robot.circle.edge(from, to);
                    edge.for_each(|point| self.touch(&base, point, time));
                }
                Ok(())
            }
        }
    }

    /// Adds a point that a base at `base` touches.
    fn touch(&mut self, base: &Pose2D, point: Point2D, time: Duration) {
        let Pose2D { x, y, .. } = base.transform(&Pose2D::new(point.x, point.y, 0.0));
        self.points.push(Noticed {
            point: Point2D { x, y },
            time,
            sense: Sense::Touch,
        });
    }

    /// Adds the echo of a sonar.
    fn add_echo(&mut self, cone: Cone, sense: Sense, most: f64, time: Duration) {
        let seen = self.points.iter();
        let seen = seen.filter(|noticed| matches!(noticed.sense, Sense::Light(_)));
        let arc = cone.arc(most, seen.map(|noticed| noticed.point));
        let points = arc.into_iter().map(|point| Noticed { point, time, sense });
        self.points.extend(points);
        self.cones.push((sense, cone));
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
