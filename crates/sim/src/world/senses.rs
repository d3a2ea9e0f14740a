//! What can be measured in a world, and what is true of it.
//!
//! Nothing here changes the world.

use parry2d_f64::math::Vector;

use super::{RobotId, World};
use crate::battery::Battery;
use crate::cone::Cone;
use crate::error::WorldError;
use crate::head::Head;
use crate::loose::Body;
use crate::mover::Mover;
use crate::odometer::{Encoders, Odometry};
use crate::random::{Noise, Purpose};
use crate::robot::{CONTACT, Robot, Truth};
use crate::sensor::{self, Bumpers, LaserConfig, SonarConfig};
use crate::shape::Outline;
use crate::solid;

impl World {
    /// Fills `ranges`, one a beam from right to left, with metres; +∞ for no return, -∞ for too near (REP-117).
    ///
    /// Errors: a buffer of another length than `beams`, numbers that cannot work.
    pub fn laser(&self, robot: RobotId, laser: &LaserConfig, ranges: &mut [f32]) -> Result<(), WorldError> {
        laser.check()?;
        buffer("laser", ranges.len(), laser.beams)?;
        let noise = self.noise(robot, Purpose::Laser, laser.stream);
        laser.scan(self.truth(robot).pose, &noise, ranges, |origin, angle| {
            self.cast(Echo::Light, origin, angle, laser.range_max, Some(robot))
        });
        Ok(())
    }

    /// Fills `ranges`, one a sonar in the order of its mounts, with metres; +∞ for no echo, -∞ for too near.
    ///
    /// Errors: a buffer of another length than the mounts, numbers that cannot work.
    pub fn sonars(&self, robot: RobotId, ring: &SonarConfig, ranges: &mut [f32]) -> Result<(), WorldError> {
        ring.check()?;
        buffer("sonars", ranges.len(), ring.mounts.len())?;
        let noise = self.noise(robot, Purpose::Sonar, ring.stream);
        ring.measure(self.truth(robot).pose, &noise, ranges, |origin, heading| {
            self.cast_cone(origin, heading, ring.cone, ring.range_max, Some(robot))
        });
        Ok(())
    }

    /// Gives the pose and twist that the wheels measured.
    pub fn odometry(&self, robot: RobotId) -> Odometry {
        self.robot(robot).odometer.odometry
    }

    /// Gives the ticks that the wheels counted.
    pub fn encoders(&self, robot: RobotId) -> Encoders {
        self.robot(robot).odometer.encoders
    }

    /// Gives where a robot's head looks, and how it turns.
    pub fn head(&self, robot: RobotId) -> Head {
        self.robot(robot).head
    }

    /// Gives the state of a robot's battery.
    pub fn battery(&self, robot: RobotId) -> Battery {
        self.robot(robot).battery
    }

    /// Gives the bumpers that touch something now.
    pub fn bumpers(&self, robot: RobotId) -> Bumpers {
        let Robot {
            truth: Truth { pose, .. },
            config,
            ..
        } = self.robot(robot);
        let center = Vector::new(pose.x, pose.y);
        let reach = config.radius + CONTACT;
        // A ball is too light to press a bumper.
        let boxes = self
            .loose
            .bodies()
            .iter()
            .filter(|body| !body.is_ball())
            .map(Body::solid);
        let solids = self
            .scene
            .around(center, reach)
            .chain(self.movers.iter().map(Mover::solid))
            .chain(boxes);
        let things = solids
            .map(|solid| solid.nearest(center))
            .filter(|point| point.distance(center) < reach);
        let robots = self
            .others(robot.0)
            .filter(|(_, disc)| center.distance(Vector::from(disc.center)) - disc.radius < reach);
        sensor::press(
            *pose,
            things.map(Into::into).chain(robots.map(|(_, disc)| disc.center)),
        )
    }

    /// Gives what is true of a robot.
    pub fn truth(&self, robot: RobotId) -> Truth {
        self.robot(robot).truth
    }

    /// Gives the distance along a ray to the first thing, mover or robot but `except`; nothing beyond `max` metres. A person is a
    /// round body to it, as to a sonar; a laser sees the legs.
    pub fn cast_ray(&self, origin: [f64; 2], angle: f64, max: f64, except: Option<RobotId>) -> Option<f64> {
        self.cast(Echo::Sound, origin, angle, max, except)
    }

    /// Gives the distance to the first thing, mover or robot but `except`, in a cone of so many radians around a direction, half a turn at
    /// most: nothing in it is missed, however thin it is. Nothing beyond `max` metres. A person is a round body to it.
    pub fn cast_cone(
        &self,
        origin: [f64; 2],
        heading: f64,
        cone: f64,
        max: f64,
        except: Option<RobotId>,
    ) -> Option<f64> {
        let edges = [heading - cone / 2.0, heading + cone / 2.0];
        let mut nearest = None;
        for edge in edges {
            let before = nearest.unwrap_or(max);
            nearest = self.cast(Echo::Sound, origin, edge, before, except).or(nearest);
        }
        let cone = Cone::new(origin, edges[0], edges[1]);
        nearest = self.scene.nearest_in(&cone, nearest.unwrap_or(max)).or(nearest);
        self.each_free(Echo::Sound, except, |solid| {
            nearest = cone.sees(solid, nearest.unwrap_or(max)).or(nearest);
        });
        nearest
    }

    fn cast(
        &self,
        echo: Echo,
        origin: [f64; 2],
        angle: f64,
        max: f64,
        except: Option<RobotId>,
    ) -> Option<f64> {
        let ray = solid::ray(origin, angle);
        let mut nearest = self.scene.cast(&ray, max);
        self.each_free(echo, except, |solid| {
            if let Some(distance) = solid.cast(&ray, nearest.unwrap_or(max)) {
                nearest = Some(distance);
            }
        });
        nearest
    }

    /// Looks at everything that does not stand where it is, but one robot.
    fn each_free(&self, echo: Echo, except: Option<RobotId>, mut look: impl FnMut(&solid::Solid)) {
        for mover in &self.movers {
            match echo {
                Echo::Light => mover.feet().iter().for_each(&mut look),
                Echo::Sound => look(mover.solid()),
            }
        }
        self.loose.bodies().iter().for_each(|body| look(body.solid()));
        for (_, disc) in self.others(except.map_or(usize::MAX, |robot| robot.0)) {
            look(&solid::Solid::new(&Outline::Circle {
                center: disc.center,
                radius: disc.radius,
            }));
        }
    }

    fn noise(&self, robot: RobotId, purpose: Purpose, stream: u16) -> Noise {
        Noise::new(self.seed, robot.0, purpose, stream, self.steps)
    }
}

/// What a ray is of, for it decides what a person is to it.
#[derive(Clone, Copy, Debug)]
enum Echo {
    /// A thin ray near the floor, which meets legs.
    Light,
    /// A wide lobe, which meets the whole body.
    Sound,
}

pub(super) fn buffer(sensor: &'static str, given: usize, expected: usize) -> Result<(), WorldError> {
    if given == expected {
        Ok(())
    } else {
        Err(WorldError::BadBuffer {
            sensor,
            given,
            expected,
        })
    }
}
