//! The robots of a world: adding, removing, commanding and placing them.
//!
//! These functions take no simulated time.

use super::{RobotSlot, World};
use crate::config::RobotConfig;
use crate::error::WorldError;
use crate::file::Start;
use crate::footprint::Footprint;
use crate::geometry::{Pose2, Twist2};
use crate::head::HeadCommand;
use crate::random::{MAX_ROBOTS, Noise, Purpose};
use crate::robot::SimulatedRobot;

/// A robot of a world. It is valid in the world that returned it, while the robot is in that world.
///
/// A robot that is added again gets its earlier id.
///
/// # Panics
/// Functions that command, place or measure a robot, or return its configuration, panic after it has been
/// removed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct RobotId(pub(super) usize);

impl World {
    /// Returns the names of the robots that have a start in the file, whether or not they have been added.
    pub fn robot_names(&self) -> impl Iterator<Item = &str> {
        self.robot_slots.iter().map(|slot| slot.start.robot.as_str())
    }

    /// Returns the robots that have been added, in the order of the file.
    pub fn robots(&self) -> impl Iterator<Item = (RobotId, &str)> {
        let added = self
            .robot_slots
            .iter()
            .enumerate()
            .filter(|(_, slot)| slot.robot.is_some());
        added.map(|(index, slot)| (RobotId(index), slot.start.robot.as_str()))
    }

    /// Adds a robot at its start, at rest. The order in which robots are added makes no difference.
    ///
    /// # Errors
    /// A name without a start, a robot that is in the world already, an invalid number in `config`, a
    /// start that is not free.
    pub fn add_robot(&mut self, name: &str, config: RobotConfig) -> Result<RobotId, WorldError> {
        config.check()?;
        let index = self.free_slot(name)?;
        let start = &self.robot_slots[index].start;
        let (by, gap) = self.placement_clearance(index, &config.footprint.at(start.pose));
        if gap < 0.0 {
            return Err(WorldError::StartBlocked {
                place: start.source.clone(),
                robot: name.to_owned(),
                radius: config.footprint.radius(),
                by: by.to_owned(),
                need: -gap,
            });
        }
        let pose = start.pose;
        Ok(self.enter(index, pose, config))
    }

    /// Adds a robot at a pose, at rest, instead of its start in the file. A robot without a start in the file
    /// has this one from now on; its noise depends on the order in which such robots are added.
    ///
    /// # Errors
    /// A robot that is in the world already, an invalid number in `config`, a pose that is not free, or
    /// outside the world's bounds, too many robots.
    pub fn add_robot_at(
        &mut self,
        name: &str,
        pose: Pose2,
        config: RobotConfig,
    ) -> Result<RobotId, WorldError> {
        config.check()?;
        let index = match self.free_slot(name) {
            Err(WorldError::UnknownRobot { .. }) if self.robot_slots.len() < MAX_ROBOTS => {
                self.robot_slots.len()
            }
            found => found?,
        };
        self.check_place(index, name, pose, &config.footprint)?;
        if index == self.robot_slots.len() {
            let start = Start {
                robot: name.to_owned(),
                pose,
                source: "the pose at which it was added".to_owned(),
            };
            self.robot_slots.push(RobotSlot { start, robot: None });
        }
        Ok(self.enter(index, Pose2::new(pose.x, pose.y, pose.heading), config))
    }

    /// Returns the place in the list of a robot that is not in the world.
    fn free_slot(&self, name: &str) -> Result<usize, WorldError> {
        let index = self
            .robot_slots
            .iter()
            .position(|slot| slot.start.robot == name)
            .ok_or_else(|| {
                let known: Vec<String> = self.robot_names().map(str::to_owned).collect();
                let nearest = jde_nearest::nearest(name, known.iter().map(String::as_str)).map(str::to_owned);
                WorldError::UnknownRobot {
                    world: self.name.clone(),
                    robot: name.to_owned(),
                    known,
                    nearest,
                }
            })?;
        if self.robot_slots[index].robot.is_some() {
            return Err(WorldError::AlreadyAdded {
                robot: name.to_owned(),
            });
        }
        Ok(index)
    }

    fn enter(&mut self, index: usize, pose: Pose2, config: RobotConfig) -> RobotId {
        let (_, clearance) = self.clearance(index, &config.footprint.at(pose));
        let scale = Noise::new(self.seed, index, Purpose::WheelScale, 0, 0);
        self.robot_slots[index].robot = Some(SimulatedRobot::new(config, pose, clearance, &scale));
        self.update_contacts();
        RobotId(index)
    }

    /// Sets a robot's motion from the next step until the next command, within the limits of its motors.
    ///
    /// # Errors
    /// A number that is not finite. The robot then keeps its earlier command.
    pub fn command(&mut self, robot: RobotId, twist: Twist2) -> Result<(), WorldError> {
        if !twist.is_finite() {
            let robot = self.robot_name(robot).to_owned();
            return Err(WorldError::BadCommand { robot, twist });
        }
        self.robot_mut(robot).command(twist);
        Ok(())
    }

    /// Returns the configuration with which the robot was added.
    pub fn config(&self, robot: RobotId) -> &RobotConfig {
        &self.robot(robot).config
    }

    /// Returns the robot's name.
    pub fn robot_name(&self, robot: RobotId) -> &str {
        &self.robot_slots[robot.0].start.robot
    }

    /// Sets the direction of a robot's head from the next step, within its limits.
    ///
    /// # Errors
    /// A number that is not finite. The head then keeps its earlier command.
    pub fn command_head(&mut self, robot: RobotId, command: HeadCommand) -> Result<(), WorldError> {
        if !command.is_finite() {
            let robot = self.robot_name(robot).to_owned();
            return Err(WorldError::BadHeadCommand { robot, command });
        }
        self.robot_mut(robot).command_head(command);
        Ok(())
    }

    /// Moves a robot to another pose, at rest. It stays there until the next command.
    ///
    /// Its odometry does not jump, like that of a real robot that is lifted.
    ///
    /// # Errors
    /// A place that is not free, or outside the world's bounds. The robot then stays where it is.
    pub fn place(&mut self, robot: RobotId, pose: Pose2) -> Result<(), WorldError> {
        let footprint = &self.config(robot).footprint;
        self.check_place(robot.0, self.robot_name(robot), pose, footprint)?;
        let pose = Pose2::new(pose.x, pose.y, pose.heading);
        let (_, clearance) = self.clearance(robot.0, &footprint.at(pose));
        self.robot_mut(robot).place(pose, clearance);
        self.update_contacts();
        Ok(())
    }

    /// Removes a robot from the world. Its id becomes invalid until the robot is added again, at its start.
    pub fn remove_robot(&mut self, robot: RobotId) {
        self.robot_slots[robot.0].robot = None;
        self.update_contacts();
    }

    /// Sets a robot's odometry to zero at its present pose. Its encoders keep their counts.
    pub fn reset_odometry(&mut self, robot: RobotId) {
        self.robot_mut(robot).odometer.reset();
    }

    /// Checks that a robot can be put at a pose.
    fn check_place(
        &self,
        index: usize,
        robot: &str,
        pose: Pose2,
        footprint: &Footprint,
    ) -> Result<(), WorldError> {
        let robot = robot.to_owned();
        if !pose.is_finite() || !self.bounds.contains([pose.x, pose.y]) {
            let bounds = self.bounds;
            return Err(WorldError::BadPlace { robot, pose, bounds });
        }
        let (by, gap) = self.placement_clearance(index, &footprint.at(pose));
        if gap < 0.0 {
            return Err(WorldError::PlaceBlocked {
                robot,
                radius: footprint.radius(),
                pose,
                by: by.to_owned(),
                need: -gap,
            });
        }
        Ok(())
    }

    pub(super) fn robot(&self, robot: RobotId) -> &SimulatedRobot {
        self.robot_slots[robot.0].robot.as_ref().expect(UNKNOWN_ROBOT)
    }

    fn robot_mut(&mut self, robot: RobotId) -> &mut SimulatedRobot {
        self.robot_slots[robot.0].robot.as_mut().expect(UNKNOWN_ROBOT)
    }
}

const UNKNOWN_ROBOT: &str = "an id is used while its robot is in the world";
