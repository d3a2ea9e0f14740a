//! Exports the simulated sensors in the standard interfaces.

use jde_schema::prelude::*;
use jde_schema::types::Point2D;
use jde_sim::{
    Delivery, ImuConfig, LineSensorConfig, Pose2, PositionConfig, RobotId, RobotModel, SampledSensor,
    SonarConfig, Twist2, World,
};

use crate::entry::Due;
use crate::output::{Measurement, Output};
use crate::{Robot, laser};

/// The draws of the deliveries of each sensor, beside those of the lasers, which have the numbers from 0.
const WHEELS: u16 = u16::MAX;
const SONARS: u16 = u16::MAX - 1;
const LINE: u16 = u16::MAX - 2;
const IMU: u16 = u16::MAX - 3;
const POSITION: u16 = u16::MAX - 4;

/// Values of `BatteryState` for a battery in good health.
const STATUS_CHARGING: u8 = 1;
const STATUS_DISCHARGING: u8 = 2;
const STATUS_FULL: u8 = 4;
const HEALTH_GOOD: u8 = 1;

impl Robot {
    /// Publishes the sensors that the robot has, those that are due.
    pub(crate) fn sense(
        &mut self,
        cx: &Context,
        world: &World,
        robot: RobotId,
        model: &RobotModel,
        due: &mut Due,
    ) -> Result {
        if let Some(first) = model.lasers.first() {
            let way = (&mut self.laser, &mut due.laser);
            laser::publish(way, cx, (world, robot), ("laser", first))?;
        }
        if let Some(sonars) = &model.sonars {
            self.publish_sonars(cx, (world, robot), sonars, &mut due.sonars)?;
        }
        if let Some(line) = &model.line_sensor {
            self.publish_line_sensor(cx, (world, robot), line, &mut due.line_sensor)?;
        }
        if let Some(imu) = &model.imu {
            self.publish_imu(cx, (world, robot), imu, &mut due.imu)?;
        }
        if let Some(position) = &model.position {
            self.publish_position(cx, (world, robot), position, &mut due.position)?;
        }
        self.publish_wheels(cx, (world, robot), &model.odometry, due)?;
        let truth = world.truth(robot);
        if model.bumpers {
            self.publish_bumpers(cx, world, robot)?;
        }
        if model.head {
            self.publish_head(cx, world, robot);
        }
        if model.battery {
            self.publish_battery(cx, world, robot);
        }
        self.truth.write(
            cx,
            Truth {
                pose: pose(truth.pose),
                twist: twist(truth.twist),
                clearance: truth.clearance,
                min_clearance: truth.min_clearance,
                collisions: truth.collisions,
            },
        );
        Ok(())
    }

    /// Publishes that the robot has been in its world since a time.
    pub(crate) fn publish_connection(&mut self, cx: &Context, world: &World, since: Duration) {
        self.connection.write(
            cx,
            Connection {
                header: Header::new(since, ""),
                state: Connection::CONNECTED,
                note: Text::truncated(world.name()),
                ..Connection::default()
            },
        );
    }

    fn publish_bumpers(&mut self, cx: &Context, world: &World, robot: RobotId) -> Result {
        let now = cx.now();
        let pressed = world.bumpers(robot);
        let mut bumpers = Bumpers {
            header: Header::new(now, "base_link"),
            stalled: world.truth(robot).stalled.into(),
            ..Bumpers::default()
        };
        bumpers.front.extend_from_slice(&pressed.front.map(Flag::from))?;
        // The simulator counts clockwise; the interface counts from left to right, facing ahead.
        let mut rear = pressed.rear.map(Flag::from);
        rear.reverse();
        bumpers.rear.extend_from_slice(&rear)?;
        self.bumpers.write(cx, bumpers);

        Ok(())
    }

    fn publish_head(&mut self, cx: &Context, world: &World, robot: RobotId) {
        let now = cx.now();
        let head = world.head(robot);
        self.pan_tilt.write(
            cx,
            PanTilt {
                header: Header::new(now, "base_link"),
                pan: head.pan,
                tilt: head.tilt,
                pan_velocity: head.pan_velocity,
                tilt_velocity: head.tilt_velocity,
            },
        );
    }

    fn publish_battery(&mut self, cx: &Context, world: &World, robot: RobotId) {
        let now = cx.now();
        let battery = world.battery(robot);
        self.battery.write(
            cx,
            BatteryState {
                header: Header::new(now, "base_link"),
                voltage: battery.voltage as f32,
                current: battery.current as f32,
                charge: (battery.charge * battery.capacity) as f32,
                capacity: battery.capacity as f32,
                design_capacity: battery.capacity as f32,
                percentage: battery.charge as f32,
                power_supply_status: if battery.current < 0.0 {
                    STATUS_DISCHARGING
                } else if battery.charge < 1.0 {
                    STATUS_CHARGING
                } else {
                    STATUS_FULL
                },
                power_supply_health: HEALTH_GOOD,
                present: true.into(),
                ..BatteryState::default()
            },
        );
    }

    fn publish_wheels(
        &mut self,
        cx: &Context,
        (world, robot): (&World, RobotId),
        delivery: &Delivery,
        due: &mut Due,
    ) -> Result {
        let now = cx.now();
        due.odometry.deliver(cx, &mut self.odometry);
        due.encoders.deliver(cx, &mut self.encoders);
        let measurement = || Measurement::new(now, (world, robot), (delivery, WHEELS));
        due.odometry
            .measure(cx, &mut self.odometry, measurement()?, |value| {
                let (odometry, covariance) = (world.odometry(robot), world.odometry_covariance(robot));
                *value = Odometry {
                    pose: PoseWithCovariance::planar(pose(odometry.pose), &covariance.pose),
                    twist: TwistWithCovariance::planar(twist(odometry.twist), &covariance.twist),
                    ..Odometry::planar(now, Pose2D::ORIGIN, Twist::ZERO)
                };
                Ok(())
            })?;
        due.encoders
            .measure(cx, &mut self.encoders, measurement()?, |value| {
                let encoders = world.encoders(robot);
                *value = WheelEncoders {
                    header: Header::new(now, "base_link"),
                    left: encoders.left,
                    right: encoders.right,
                    ticks_per_meter: world.config(robot).ticks_per_meter,
                };
                Ok(())
            })
    }

    fn publish_sonars(
        &mut self,
        cx: &Context,
        (world, robot): (&World, RobotId),
        SampledSensor {
            config: ring,
            period,
            delivery,
        }: &SampledSensor<SonarConfig>,
        output: &mut Output<RangeRing>,
    ) -> Result {
        output.deliver(cx, &mut self.sonars);
        if !output.is_due(cx.now(), *period) {
            return Ok(());
        }
        let measurement = Measurement::new(cx.now(), (world, robot), (delivery, SONARS))?;
        output.measure(cx, &mut self.sonars, measurement, |sonars| {
            sonars.header = Header::new(cx.now(), "base_link");
            sonars.radiation_type = 0;
            sonars.padding = Padding::ZERO;
            sonars.field_of_view = ring.cone as f32;
            sonars.min_range = ring.range_min as f32;
            sonars.max_range = ring.range_max as f32;
            let poses = sonars.poses.resize(ring.mounts.len());
            for (pose, mount) in poses.iter_mut().zip(&ring.mounts) {
                *pose = self::pose(*mount);
            }
            Ok(world.sonars(robot, ring, sonars.ranges.resize(ring.mounts.len()))?)
        })
    }

    fn publish_line_sensor(
        &mut self,
        cx: &Context,
        (world, robot): (&World, RobotId),
        SampledSensor {
            config,
            period,
            delivery,
        }: &SampledSensor<LineSensorConfig>,
        output: &mut Output<LineSensor>,
    ) -> Result {
        output.deliver(cx, &mut self.line_sensor);
        if !output.is_due(cx.now(), *period) {
            return Ok(());
        }
        let measurement = Measurement::new(cx.now(), (world, robot), (delivery, LINE))?;
        output.measure(cx, &mut self.line_sensor, measurement, |sensor| {
            sensor.header = Header::new(cx.now(), "base_link");
            let count = config.mounts.len();
            for (cell, &[x, y]) in sensor.cells.resize(count).iter_mut().zip(&config.mounts) {
                *cell = Point2D { x, y };
            }
            Ok(world.line_sensor(robot, config, sensor.brightness.resize(count))?)
        })
    }

    fn publish_imu(
        &mut self,
        cx: &Context,
        (world, robot): (&World, RobotId),
        SampledSensor {
            config,
            period,
            delivery,
        }: &SampledSensor<ImuConfig>,
        output: &mut Output<Imu>,
    ) -> Result {
        output.deliver(cx, &mut self.imu);
        if !output.is_due(cx.now(), *period) {
            return Ok(());
        }
        let reading = world.imu(robot, config)?;
        let vector = |[x, y, z]: [f64; 3]| Vector3 { x, y, z };
        // The bias is a part of the error that a reader must expect.
        let diagonal = |sigma: f64, bias: f64| {
            let variance = sigma * sigma + bias * bias;
            let mut covariance = [0.0; 9];
            for place in [0, 4, 8] {
                covariance[place] = variance;
            }
            covariance
        };
        let mut no_orientation = [0.0; 9];
        no_orientation[0] = -1.0;
        let measurement = Measurement::new(cx.now(), (world, robot), (delivery, IMU))?;
        output.measure(cx, &mut self.imu, measurement, |value| {
            *value = Imu {
                header: Header::new(cx.now(), "imu"),
                orientation: Quaternion::default(),
                orientation_covariance: no_orientation,
                angular_velocity: vector(reading.angular_velocity),
                angular_velocity_covariance: diagonal(config.gyro_sigma, config.gyro_bias),
                linear_acceleration: vector(reading.linear_acceleration),
                linear_acceleration_covariance: diagonal(
                    config.accelerometer_sigma,
                    config.accelerometer_bias,
                ),
            };
            Ok(())
        })
    }

    fn publish_position(
        &mut self,
        cx: &Context,
        (world, robot): (&World, RobotId),
        SampledSensor {
            config,
            period,
            delivery,
        }: &SampledSensor<PositionConfig>,
        output: &mut Output<PositionFix>,
    ) -> Result {
        output.deliver(cx, &mut self.position);
        if !output.is_due(cx.now(), *period) {
            return Ok(());
        }
        let Some([x, y]) = world.position(robot, config)? else {
            output.clear();
            self.position.retract(cx);
            return Ok(());
        };
        let variance = config.sigma * config.sigma;
        let measurement = Measurement::new(cx.now(), (world, robot), (delivery, POSITION))?;
        output.measure(cx, &mut self.position, measurement, |value| {
            *value = PositionFix {
                header: Header::new(cx.now(), "map"),
                x,
                y,
                covariance: [variance, 0.0, 0.0, variance],
            };
            Ok(())
        })
    }
}

pub(crate) fn pose(pose: Pose2) -> Pose2D {
    Pose2D::new(pose.x, pose.y, pose.heading)
}

fn twist(twist: Twist2) -> Twist {
    let mut planar = Twist::planar(twist.linear, twist.angular);
    planar.linear.y = twist.lateral;
    planar
}
