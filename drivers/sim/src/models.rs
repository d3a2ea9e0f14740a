//! What an application changes in a robot, and what fits into the exports of its sensors.

use jde_schema::prelude::*;
use jde_sim::{Kinematics, OdometryOrigin, RobotModel};

/// Beams that fit into a `LaserScan`, sonars that fit into a `RangeRing`, and cells that fit into a
/// `LineSensor`.
pub(crate) const MAX_BEAMS: usize = 1088;
const MAX_SONARS: usize = 32;
const MAX_CELLS: usize = 32;

/// Numbers that replace those of a robot's file; a negative one keeps it.
pub(crate) struct Overrides {
    /// Of the first laser, in metres.
    pub(crate) laser_range: f64,
    /// Metres above the floor.
    pub(crate) laser_height: f64,
    /// Metres.
    pub(crate) laser_noise: f64,
    /// Of a white surface, in units of the device.
    pub(crate) laser_intensity: f64,
    /// Metres.
    pub(crate) sonar_noise: f64,
    /// A fraction.
    pub(crate) wheel_error: f64,
    /// m/s², for driving and for braking.
    pub(crate) acceleration: f64,
    /// Seconds.
    pub(crate) lag: f64,
    /// Ampere hours.
    pub(crate) battery_capacity: f64,
}

impl Overrides {
    /// Returns the robot with these numbers, if its sensors then fit into their exports.
    pub(crate) fn over(self, mut model: RobotModel) -> Result<RobotModel> {
        let replace = |own: &mut f64, number: f64| {
            if number >= 0.0 {
                *own = number;
            }
        };
        if let Some(first) = model.lasers.first_mut() {
            replace(&mut first.config.range_max, self.laser_range);
        }
        for laser in &mut model.lasers {
            replace(&mut laser.config.height, self.laser_height);
            replace(&mut laser.config.sigma, self.laser_noise);
            replace(&mut laser.config.intensity, self.laser_intensity);
            laser.config.check()?;
            if laser.config.beams > MAX_BEAMS {
                let (name, beams) = (&laser.name, laser.config.beams);
                return Err(format!("laser `{name}` has {beams} beams: expected at most {MAX_BEAMS}").into());
            }
        }
        if let Some(sonars) = &mut model.sonars {
            replace(&mut sonars.config.sigma, self.sonar_noise);
            let count = sonars.config.mounts.len();
            if count > MAX_SONARS {
                return Err(format!("it has {count} sonars: expected at most {MAX_SONARS}").into());
            }
        }
        if let Some(line) = &model.line_sensor {
            let count = line.config.mounts.len();
            if count > MAX_CELLS {
                return Err(
                    format!("its line sensor has {count} cells: expected at most {MAX_CELLS}").into(),
                );
            }
        }
        let config = &mut model.config;
        replace(&mut config.wheel_scale_sigma, self.wheel_error);
        replace(&mut config.linear_acceleration, self.acceleration);
        replace(&mut config.linear_deceleration, self.acceleration);
        if let Kinematics::Omnidirectional {
            lateral_acceleration, ..
        } = &mut config.kinematics
        {
            replace(lateral_acceleration, self.acceleration);
        }
        replace(&mut config.lag, self.lag);
        replace(&mut config.battery_capacity, self.battery_capacity);
        model.battery |= self.battery_capacity > 0.0;
        config.odometry_origin = OdometryOrigin::StartPose;
        config.check()?;
        Ok(model)
    }
}
