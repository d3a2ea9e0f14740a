//! The effect of each command of a client on the robot. A command for a device that the robot does not have
//! does nothing. A command that cannot be executed is recorded as an event.

use core::time::Duration;

use jde_p2os::{Command, SimPose};
use jde_sim::{Pose2, World};

use super::laser::Laser;
use super::{ClientProgress, RobotSession, SIP_INTERVAL, Subscription};
use crate::event::EventKind;

impl RobotSession {
    /// Executes a command.
    pub(super) fn execute(&mut self, world: &mut World, command: Command, now: Duration) {
        match command {
            Command::Open(_) => {
                if self.phase == ClientProgress::Ready {
                    self.phase = ClientProgress::Open;
                    // A robot counts from the pose at which its servers are opened.
                    self.set_client_pose(world, Pose2::default());
                    self.next_sip = now + SIP_INTERVAL;
                }
            }
            Command::Close(_) => {
                let output = self.take_bytes();
                self.reset();
                self.output = output;
                self.push_event(EventKind::Closed);
            }
            Command::Config(_) => self.send(self.configuration(world).to_packet()),
            Command::Enable(on) => self.motion.enable(on),
            Command::Velocity(speed) => self.motion.set_speed(millimetres(speed)),
            Command::RotVelocity(speed) | Command::Rotate(speed) => self.motion.set_turn_rate(degrees(speed)),
            Command::Velocities2(wheels) => {
                let [left, right] = [wheels.left, wheels.right].map(|speed| f64::from(speed) * 0.02);
                self.motion.set_speed((left + right) / 2.0);
                self.motion.set_turn_rate((right - left) / self.config.track);
            }
            Command::Move(distance) => self.motion.move_by(millimetres(distance)),
            Command::Heading(heading) => self.motion.turn_to(degrees(heading)),
            Command::DeltaHeading(turn) => self.motion.turn_to(self.pose(world).heading + degrees(turn)),
            Command::CompassHeading(turn) => {
                let from = self.motion.heading().unwrap_or(self.pose(world).heading);
                self.motion.turn_to(from + degrees(turn));
            }
            Command::Stop | Command::EStop | Command::QStop => self.motion.stop(),
            Command::MaxVelocity(speed) => self.motion.limit(f64::from(speed) / 1000.0),
            Command::MaxRotVelocity(speed) => self.motion.limit_turns(f64::from(speed).to_radians()),
            Command::SetOrigin(pose) => {
                let [x, y, th] = pose.unwrap_or_default();
                self.set_client_pose(world, Pose2::new(millimetres(x), millimetres(y), degrees(th)));
            }
            Command::Sonar(arrays) => self.sonars = arrays & 1 != 0,
            Command::Encoder(mode) => self.encoders = Subscription::of(mode),
            Command::SimStat(mode) => self.state = Subscription::of(mode),
            Command::Tty2(bytes) => self.camera.receive(&bytes, world.head(self.robot)),
            Command::GetAux(count) => self.camera.request(count),
            Command::LaserOn35(mode) => self.configure_laser(|laser| laser.set_mode(mode.into())),
            Command::LaserStart36(angle) => self.configure_laser(|laser| laser.set_start(angle.into())),
            Command::LaserEnd37(angle) => self.configure_laser(|laser| laser.set_end(angle.into())),
            Command::LaserIncrement38(step) => self.configure_laser(|laser| laser.set_step(step.into())),
            Command::LrfEnable(mode) if mode.laser == 0 => {
                self.configure_laser(|laser| laser.set_mode(mode.value.into()))
            }
            Command::LrfStart(angle) if angle.laser == 0 => {
                self.configure_laser(|laser| laser.set_start(angle.value.into()))
            }
            Command::LrfEnd(angle) if angle.laser == 0 => {
                self.configure_laser(|laser| laser.set_end(angle.value.into()))
            }
            Command::LrfResolution(step) if step.laser == 0 => {
                self.configure_laser(|laser| laser.set_step(step.value.into()))
            }
            Command::LrfEnable(command)
            | Command::LrfStart(command)
            | Command::LrfEnd(command)
            | Command::LrfResolution(command) => {
                self.refuse(format!(
                    "the robot has one laser, and none with number {}",
                    command.laser
                ));
            }
            Command::SetOriginX(x) => {
                self.move_robot(world, |pose| pose.x = millimetres(x));
            }
            Command::SetOriginY(y) => {
                self.move_robot(world, |pose| pose.y = millimetres(y));
            }
            Command::SetOriginTh(th) => {
                self.move_robot(world, |pose| pose.heading = degrees(th));
            }
            Command::SimSetPose(SimPose { x, y, th }) => {
                self.move_robot(world, |pose| {
                    (pose.x, pose.y) = (f64::from(x) / 1000.0, f64::from(y) / 1000.0);
                    pose.heading = f64::from(th).to_radians();
                });
            }
            Command::Reset69 | Command::SimReset => {
                let start = self.start;
                if self.move_robot(world, |pose| *pose = start) {
                    self.set_client_pose(world, Pose2::default());
                }
            }
            Command::Message(text) => {
                let text = String::from_utf8_lossy(&text).into_owned();
                // Escaped, so that a terminal does not interpret control sequences.
                self.push_event(EventKind::Message(text.escape_debug().to_string()));
            }
            Command::Exit(_) => self.refuse("clients cannot end this server".to_owned()),
            // These have no effect on a simulated robot: it has no such device, or no such setting.
            Command::Pulse
            | Command::Polling(_)
            | Command::Acceleration(_)
            | Command::RotAcceleration(_)
            | Command::Say(_)
            | Command::DigitalOut(_)
            | Command::Gripper(_)
            | Command::IoRequest(_)
            | Command::ServoPosition(_)
            | Command::BumpStall(_)
            | Command::Compass(_)
            | Command::JoyDrive(_)
            | Command::HostBaud(_)
            | Command::Gyro(_)
            | Command::Tty3(_)
            | Command::Tty4(_)
            | Command::GetAux3(_)
            | Command::BatteryInfo(_)
            | Command::Sound(_)
            | Command::PlayList(_)
            | Command::SoundToggle(_)
            | Command::LatVelocity(_)
            | Command::LatAcceleration(_)
            | Command::SimCtrl(_)
            | Command::Other { .. } => {}
        }
    }

    /// Changes the settings of the laser.
    fn configure_laser(&mut self, change: impl FnOnce(&mut Laser) -> Result<(), String>) {
        if let Err(reason) = change(&mut self.laser) {
            self.refuse(reason);
        }
    }

    /// Moves the robot to another pose in the world. Returns whether there was room.
    fn move_robot(&mut self, world: &mut World, change: impl FnOnce(&mut Pose2)) -> bool {
        let mut pose = world.truth(self.robot).pose;
        change(&mut pose);
        let placed = world.place(self.robot, pose);
        match &placed {
            Ok(()) => {
                self.motion.stop();
                self.push_event(EventKind::Placed);
            }
            Err(error) => self.refuse(error.to_string()),
        }
        placed.is_ok()
    }

    fn refuse(&mut self, reason: String) {
        self.push_event(EventKind::Refused(reason));
    }
}

fn millimetres(value: i16) -> f64 {
    f64::from(value) / 1000.0
}

fn degrees(value: i16) -> f64 {
    f64::from(value).to_radians()
}
