//! The measurements of a robot, in the numbers of the protocol.

use core::f64::consts::TAU;

use jde_p2os::{Config, Encoders, Flags, SimState, Sip, SonarReading};
use jde_sim::{Pose2, SonarConfig, World};

use super::{RobotSession, SIP_INTERVAL, WATCHDOG};

impl RobotSession {
    /// Returns the present server information packet.
    pub(super) fn sip(&self, world: &World, pose: Pose2) -> Sip {
        let (units, robot) = (&self.model.units, self.robot);
        let twist = world.odometry(robot).twist;
        let wheel = |side: f64| {
            let speed = twist.linear + side * twist.angular * self.config.track / 2.0;
            (speed * 1000.0 / units.velocity_mm_s).round() as i16
        };
        let count = |metres: f64| (metres * 1000.0 / units.distance_mm).round() as i64 as u16;
        let volts = (world.battery(robot).voltage * 10.0).round();
        let sonars = if self.sonars { Flags::SONARS } else { 0 };
        let motors = if self.motion.is_enabled() {
            Flags::MOTORS
        } else {
            0
        };
        Sip {
            moving: twist.linear != 0.0 || twist.angular != 0.0,
            x: count(pose.x),
            y: count(pose.y),
            th: (pose.heading / TAU * units.angle_per_turn)
                .round()
                .rem_euclid(units.angle_per_turn) as i16,
            left_velocity: wheel(-1.0),
            right_velocity: wheel(1.0),
            battery: volts as u8,
            stall_bumpers: self.stall_bumpers(world),
            control: self.motion.heading().unwrap_or(pose.heading).to_degrees().round() as i16,
            flags: motors | sonars,
            compass: 0,
            sonars: self.sonar_readings(world),
            gripper: Some(0),
            analog_port: Some(0),
            analog: Some(0),
            digital_in: Some(0),
            digital_out: Some(0),
            battery_tenths: Some(volts as u16),
            charge: Some(0),
            rotation: Some((twist.angular.to_degrees() * 10.0).round() as i16),
            faults: Some(0),
            lateral: Some(0),
            temperature: Some(-127),
            state_of_charge: Some((world.battery(robot).charge * 100.0).round() as u8),
        }
    }

    /// Returns the counts of the encoders; they wrap.
    pub(super) fn encoder_packet(&self, world: &World) -> Encoders {
        let ticks = world.encoders(self.robot);
        Encoders {
            left: ticks.left as i32,
            right: ticks.right as i32,
        }
    }

    /// Returns the true state of the robot.
    pub(super) fn true_state(&self, world: &World) -> SimState {
        let pose = world.truth(self.robot).pose;
        let step = (jde_sim::STEP_NS / 1_000_000) as u16;
        SimState {
            simulated_interval: step,
            real_interval: step,
            last_interval: step,
            x: (pose.x * 1000.0).round() as i32,
            y: (pose.y * 1000.0).round() as i32,
            th: pose.heading.to_degrees().round() as i32,
            gps: -1,
            ..SimState::default()
        }
    }

    /// Returns the robot's limits and settings.
    pub(super) fn configuration(&self, world: &World) -> Config {
        let mm = |metres: f64| (metres * 1000.0).round() as u16;
        let degrees = |radians: f64| radians.to_degrees().round() as u16;
        let config = &self.config;
        let [front, rear] = [self.model.bumpers.front, self.model.bumpers.rear].map(|count| count as u8);
        Config {
            class: self.model.class.clone(),
            subclass: super::subclass(&self.model),
            // The serial number identifies a simulator.
            serial: "SIM".to_owned(),
            name: world.robot_name(self.robot).to_owned(),
            rot_vel_top: degrees(config.max_angular),
            trans_vel_top: mm(config.max_linear),
            rot_acc_top: degrees(config.angular_acceleration),
            trans_acc_top: mm(config.linear_acceleration),
            pwm_max: 400,
            sip_cycle: SIP_INTERVAL.as_millis() as u8,
            front_sonar: 1,
            rear_sonar: u8::from(self.model.sonar.mounts.len() > 8),
            low_battery: 110,
            watchdog: WATCHDOG.as_millis() as u16,
            stall_value: 200,
            stall_count: 100,
            rot_vel_max: degrees(config.max_angular),
            trans_vel_max: mm(config.max_linear),
            rot_acc: degrees(config.angular_acceleration),
            rot_dec: degrees(config.angular_deceleration),
            trans_acc: mm(config.linear_acceleration),
            trans_dec: mm(config.linear_deceleration),
            front_bumpers: front,
            rear_bumpers: rear,
            sonar_cycle: 40,
            ticks_per_mm: self.model.encoders.per_mm.round() as u16,
            shutdown_volts: 110,
            firmware: concat!("jde ", env!("CARGO_PKG_VERSION")).to_owned(),
            ..Config::default()
        }
    }

    fn sonar_readings(&self, world: &World) -> Vec<SonarReading> {
        if !self.sonars {
            return Vec::new();
        }
        let sonar_config = self.sonar_config();
        let mut ranges = vec![0.0; sonar_config.mounts.len()];
        if world.sonars(self.robot, &sonar_config, &mut ranges).is_err() {
            return Vec::new();
        }
        // A missing echo is sent as the greatest range, and one that is too near as 0.
        let echoes = ranges.iter().enumerate();
        echoes
            .map(|(index, range)| {
                let metres = f64::from(*range).clamp(0.0, sonar_config.range_max);
                SonarReading {
                    index: index as u8,
                    range: (metres * 1000.0 / self.model.units.range_mm)
                        .round()
                        .min(65_535.0) as u16,
                }
            })
            .collect()
    }

    /// Returns the model's sonars, for the world to measure.
    fn sonar_config(&self) -> SonarConfig {
        let sonar = &self.model.sonar;
        let mount = |&[x, y, heading]: &[f64; 3]| Pose2::new(x / 1000.0, y / 1000.0, heading.to_radians());
        SonarConfig {
            mounts: sonar.mounts.iter().map(mount).collect(),
            cone: sonar.cone_deg.to_radians(),
            range_min: sonar.min_mm / 1000.0,
            range_max: sonar.max_mm / 1000.0,
            ..SonarConfig::default()
        }
    }

    /// Returns the stalled wheels, and the pressed bumpers of those that the model has.
    fn stall_bumpers(&self, world: &World) -> u16 {
        let pressed = world.bumpers(self.robot);
        let counts = &self.model.bumpers;
        let bits = |bumpers: &[bool], count: usize| {
            bumpers
                .iter()
                .take(count.min(7))
                .enumerate()
                .fold(0u16, |bits, (number, on)| bits | u16::from(*on) << (number + 1))
        };
        let mut flags = bits(&pressed.rear, counts.rear) | bits(&pressed.front, counts.front) << 8;
        if world.truth(self.robot).stalled {
            flags |= 0x0101;
        }
        flags
    }
}
