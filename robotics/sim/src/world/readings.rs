//! Measurements of a world, and the ground truth.
//!
//! Measuring does not change the world.

use std::time::Duration;

use super::{RobotId, World};
use crate::battery::Battery;
use crate::cone::Cone;
use crate::error::{WorldError, check};
use crate::head::Head;
use crate::loose::LooseBody;
use crate::mover::Mover;
use crate::odometer::{Encoders, Odometry, OdometryCovariance};
use crate::random::{Noise, Purpose};
use crate::robot::{CONTACT, SimulatedRobot, Truth};
use crate::sensor::{
    self, Bumpers, Delivery, ImuConfig, ImuReading, LaserConfig, LineSensorConfig, PositionConfig,
    SonarConfig,
};
use crate::solid;
use crate::sweep::Echo;

impl World {
    /// Fills `ranges` with metres, one value a beam from right to left; +∞ is no return, -∞ is too near
    /// (REP-117), unless the laser reads otherwise by its [`crate::NoReturn`].
    ///
    /// # Errors
    /// A buffer whose length is not `beams`, an invalid number in the configuration.
    pub fn laser(&self, robot: RobotId, laser: &LaserConfig, ranges: &mut [f32]) -> Result<(), WorldError> {
        self.scan(robot, laser, (ranges, &mut []))
    }

    /// Fills `ranges` as [`World::laser`] does, and `intensities` with [`LaserConfig::intensity`] times the reflectivity
    /// of what each beam meets, with normal noise of 5 %; 0 without a return.
    ///
    /// # Errors
    /// A buffer whose length is not `beams`, an invalid number in the configuration.
    pub fn laser_with_intensities(
        &self,
        robot: RobotId,
        laser: &LaserConfig,
        (ranges, intensities): (&mut [f32], &mut [f32]),
    ) -> Result<(), WorldError> {
        check_buffer("laser intensities", intensities.len(), laser.beams)?;
        self.scan(robot, laser, (ranges, intensities))
    }

    fn scan(
        &self,
        robot: RobotId,
        laser: &LaserConfig,
        (ranges, intensities): (&mut [f32], &mut [f32]),
    ) -> Result<(), WorldError> {
        laser.check()?;
        check_buffer("laser", ranges.len(), laser.beams)?;
        let echoes = match laser.turn {
            None => {
                let mut sweep = laser.sweep(self.truth(robot).pose);
                self.scene.sweep(&mut sweep);
                self.for_each_movable(RayKind::Light, Some(robot), |solid| sweep.meet(solid));
                sweep.into_echoes()
            }
            Some(turn) => {
                let trail = self.config(robot).trail;
                check(
                    "laser turn",
                    turn.period,
                    "at most the `trail` of the robot",
                    |period| period <= trail,
                )?;
                self.turned_echoes(robot, laser)
            }
        };
        let noise = self.noise(robot, Purpose::Laser, laser.stream);
        let drops = self.noise(robot, Purpose::DroppedBeams, laser.stream);
        laser.scan(&echoes, (&noise, &drops), (ranges, intensities));
        Ok(())
    }

    /// Returns what the beams of a turning laser met, each from where the robot was at its time.
    fn turned_echoes(&self, robot: RobotId, laser: &LaserConfig) -> Vec<Option<Echo>> {
        let body = self.robot(robot);
        let max = laser.range_max;
        let echo = |beam| {
            let ray = laser.ray(body.pose_ago(laser.age(beam)), beam);
            let mut nearest = self.scene.light(&ray, max, laser.height);
            self.for_each_movable(RayKind::Light, Some(robot), |solid| {
                let limit = nearest.map_or(max, |echo| echo.distance);
                if let Some(distance) = solid.cast_light(&ray, limit, laser.height) {
                    nearest = Some(Echo::of(solid, distance));
                }
            });
            nearest
        };
        (0..laser.beams).map(echo).collect()
    }

    /// Returns how long a measurement of the present time takes to arrive; `None` if it never does. `stream` separates the
    /// sensors of one robot.
    ///
    /// # Errors
    /// An invalid number in the configuration.
    pub fn delay(
        &self,
        robot: RobotId,
        delivery: &Delivery,
        stream: u16,
    ) -> Result<Option<Duration>, WorldError> {
        delivery.check()?;
        Ok(delivery.delay(&self.noise(robot, Purpose::Delivery, stream)))
    }

    /// Fills `ranges` with metres, one value a sonar in the order of its mounts; +∞ is no echo, -∞ is too
    /// near.
    ///
    /// # Errors
    /// A buffer whose length is not the number of mounts, an invalid number in the configuration.
    pub fn sonars(&self, robot: RobotId, ring: &SonarConfig, ranges: &mut [f32]) -> Result<(), WorldError> {
        ring.check()?;
        check_buffer("sonars", ranges.len(), ring.mounts.len())?;
        let noise = self.noise(robot, Purpose::Sonar, ring.stream);
        let drops = self.noise(robot, Purpose::DroppedBeams, !ring.stream);
        ring.measure(
            self.truth(robot).pose,
            (&noise, &drops),
            ranges,
            |origin, heading| self.cast_cone(origin, heading, ring.cone, ring.range_max, Some(robot)),
        );
        Ok(())
    }

    /// Fills `brightness` with one value a cell in the order of its mounts, from 0 for a black floor to 1 for a
    /// white one.
    ///
    /// # Errors
    /// A buffer whose length is not the number of mounts, an invalid number in the configuration.
    pub fn line_sensor(
        &self,
        robot: RobotId,
        sensor: &LineSensorConfig,
        brightness: &mut [f32],
    ) -> Result<(), WorldError> {
        sensor.check()?;
        check_buffer("line sensor", brightness.len(), sensor.mounts.len())?;
        let noise = self.noise(robot, Purpose::Line, sensor.stream);
        sensor.measure(self.truth(robot).pose, &self.floor, &noise, brightness);
        Ok(())
    }

    /// Returns what an inertial measurement unit measures over the last step of the world.
    ///
    /// # Errors
    /// An invalid number in the configuration.
    pub fn imu(&self, robot: RobotId, imu: &ImuConfig) -> Result<ImuReading, WorldError> {
        imu.check()?;
        let noise = self.noise(robot, Purpose::Imu, imu.stream);
        let bias = Noise::new(self.seed, robot.0, Purpose::ImuBias, imu.stream, 0);
        let SimulatedRobot { truth, change, .. } = self.robot(robot);
        Ok(imu.measure(truth.twist, *change, &noise, &bias))
    }

    /// Returns what a position sensor measures, in metres in the frame of the world; `None` in an outage.
    ///
    /// # Errors
    /// An invalid number in the configuration.
    pub fn position(&self, robot: RobotId, sensor: &PositionConfig) -> Result<Option<[f64; 2]>, WorldError> {
        sensor.check()?;
        let noise = self.noise(robot, Purpose::Position, sensor.stream);
        let span = sensor.span(self.now() as f64 * 1e-9);
        let span = Noise::new(self.seed, robot.0, Purpose::Outage, sensor.stream, span);
        Ok(sensor.measure(self.truth(robot).pose, &noise, &span))
    }

    /// Returns the pose and twist that the wheels measured.
    pub fn odometry(&self, robot: RobotId) -> Odometry {
        self.robot(robot).odometer.odometry
    }

    /// Returns how far that odometry may be from the true motion.
    pub fn odometry_covariance(&self, robot: RobotId) -> OdometryCovariance {
        let robot = self.robot(robot);
        robot.odometer.covariance(&robot.config)
    }

    /// Returns the ticks that the wheels counted.
    pub fn encoders(&self, robot: RobotId) -> Encoders {
        self.robot(robot).odometer.encoders
    }

    /// Returns the direction and the turn rates of a robot's head.
    pub fn head(&self, robot: RobotId) -> Head {
        self.robot(robot).head
    }

    /// Returns the state of a robot's battery.
    pub fn battery(&self, robot: RobotId) -> Battery {
        self.robot(robot).battery
    }

    /// Returns the bumpers that touch something now.
    pub fn bumpers(&self, robot: RobotId) -> Bumpers {
        let body = self.robot(robot).body();
        // A ball is too light to press a bumper.
        let boxes = self
            .loose
            .bodies()
            .iter()
            .filter(|body| !body.is_ball())
            .map(LooseBody::solid);
        let solids = self
            .scene
            .around(body.center(), body.radius() + CONTACT)
            .chain(self.movers.iter().map(Mover::solid))
            .chain(boxes);
        let things = solids.filter_map(|solid| body.contact(solid, CONTACT));
        let robots = self
            .others(robot.0)
            .filter_map(|(_, other)| body.contact(&other.solid(), CONTACT));
        sensor::from_contacts(self.truth(robot).pose, things.chain(robots).map(Into::into))
    }

    /// Returns the name of what is nearest to a robot, loose things excluded.
    pub fn nearest_name(&self, robot: RobotId) -> &str {
        self.clearance(robot.0, &self.robot(robot).body()).0
    }

    /// Returns the ground truth of a robot.
    pub fn truth(&self, robot: RobotId) -> Truth {
        self.robot(robot).truth
    }

    /// Returns the distance in metres along a ray to the first thing, mover or robot except `except`, or
    /// `None` if there is none within `max` metres. As for a sonar, a person is a round body; a laser would
    /// hit the legs.
    pub fn cast_ray(&self, origin: [f64; 2], angle: f64, max: f64, except: Option<RobotId>) -> Option<f64> {
        let ray = solid::ray(origin, angle);
        let mut nearest = self.scene.cast_ray(&ray, max);
        self.for_each_movable(RayKind::Sound, except, |solid| {
            nearest = solid.cast_ray(&ray, nearest.unwrap_or(max)).or(nearest);
        });
        nearest
    }

    /// Returns the distance in metres to the nearest thing, mover or robot except `except` in a cone, or
    /// `None` if there is none within `max` metres. `cone` is the whole angle in radians around `heading`, at
    /// most π. The cone misses nothing, however thin. A person is a round body.
    pub fn cast_cone(
        &self,
        origin: [f64; 2],
        heading: f64,
        cone: f64,
        max: f64,
        except: Option<RobotId>,
    ) -> Option<f64> {
        let cone = Cone::new(origin, heading - cone / 2.0, heading + cone / 2.0);
        let mut nearest = self.scene.nearest_in(&cone, max);
        self.for_each_movable(RayKind::Sound, except, |solid| {
            nearest = cone.range_to(solid, nearest.unwrap_or(max)).or(nearest);
        });
        nearest
    }

    /// Calls `action` with every solid that is not fixed, except one robot.
    fn for_each_movable(
        &self,
        kind: RayKind,
        except: Option<RobotId>,
        mut action: impl FnMut(&solid::Solid),
    ) {
        for mover in &self.movers {
            match kind {
                RayKind::Light => mover.feet().iter().for_each(&mut action),
                RayKind::Sound => action(mover.solid()),
            }
        }
        self.loose.bodies().iter().for_each(|body| action(body.solid()));
        for (_, body) in self.others(except.map_or(usize::MAX, |robot| robot.0)) {
            action(&body.solid());
        }
    }

    pub(crate) fn noise(&self, robot: RobotId, purpose: Purpose, stream: u16) -> Noise {
        Noise::new(self.seed, robot.0, purpose, stream, self.steps)
    }
}

/// The kind of a ray. It determines which part of a person the ray hits.
#[derive(Clone, Copy, Debug)]
enum RayKind {
    /// A thin ray near the floor, which hits legs.
    Light,
    /// A wide lobe, which hits the whole body.
    Sound,
}

pub(super) fn check_buffer(sensor: &'static str, given: usize, expected: usize) -> Result<(), WorldError> {
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
