//! A robot window with constant data, for pictures; tests only.

use std::f32::consts::PI;

use eframe::egui::{self, Panel, Ui};
use jde_types::{
    BatteryState, Bumpers, Flag, Imu, LaserScan, LineSensor, Odometry, Point2D, Pose2D, PositionFix,
    RangeRing, Time, Twist, WheelEncoders,
};

use super::plane::Plane;
use super::reading::{Freshness, NoReading, VariableState};
use super::sensors::Sensors;
use super::table;
use crate::style::Style;

/// A robot between a wall and a box.
pub(crate) struct FixedRobot {
    senses: Sensors,
    plane: Plane,
}

impl FixedRobot {
    pub(crate) fn new() -> Self {
        let pose = Pose2D::new(3.2, 1.5, 0.4);
        let mut senses = Sensors {
            body: "pioneer".to_owned(),
            outline: vec![[0.3, 0.2], [-0.2, 0.2], [-0.2, -0.2], [0.3, -0.2]],
            mount: Pose2D::new(0.2, 0.0, 0.0),
            odometry: reading(
                "odometry",
                Odometry::planar(Time::default(), pose, Twist::planar(0.3, 0.35)),
            ),
            laser: reading("laser", Box::new(scan())),
            sonars: reading("sonars", sonars()),
            bumpers: reading("bumpers", bumpers()),
            battery: reading(
                "battery",
                BatteryState {
                    voltage: 12.3,
                    percentage: 0.24,
                    ..BatteryState::default()
                },
            ),
            encoders: reading(
                "encoders",
                WheelEncoders {
                    left: 41_230,
                    right: 39_876,
                    ..WheelEncoders::default()
                },
            ),
            head: VariableState::None(
                "pioneer.pan_tilt".to_owned(),
                NoReading::Silent("pioneer".to_owned()),
            ),
            line: reading("line_sensor", line()),
            imu: reading("imu", imu()),
            position: reading(
                "position",
                PositionFix {
                    x: pose.x - 0.4,
                    y: pose.y + 0.5,
                    covariance: [0.04, 0.01, 0.01, 0.01],
                    ..PositionFix::default()
                },
            ),
            commanded: reading("velocity", Twist::planar(0.4, 0.5)),
            target: Some(Pose2D::new(5.5, 3.6, 0.0)),
            ..Sensors::default()
        };
        for step in 0..60_u32 {
            let turn = 0.4 - 0.02 * f64::from(60 - step);
            let distance = 0.05 * f64::from(60 - step);
            let place = [pose.x - distance * turn.cos(), pose.y - distance * turn.sin()];
            senses.trail.add(u64::from(step), place);
        }
        if let VariableState::Present(_, fresh) = &mut senses.sonars {
            (fresh.age, fresh.stale) = (3.4, true);
        }
        Self {
            senses,
            plane: Plane::default(),
        }
    }

    pub(crate) fn show(&mut self, ui: &mut Ui, style: &Style) {
        Panel::right("numbers")
            .exact_size(330.0)
            .show(ui, |ui| table::show(ui, &self.senses, None, style));
        egui::CentralPanel::no_frame().show(ui, |ui| self.plane.show(ui, &self.senses, style));
    }
}

/// A scan of a wall 1 m to the left and a box ahead on the right.
pub(crate) fn scan() -> LaserScan {
    let mut scan = LaserScan {
        angle_min: -PI / 2.0,
        angle_max: PI / 2.0,
        angle_increment: PI / 179.0,
        range_min: 0.05,
        range_max: 8.0,
        ..LaserScan::default()
    };
    let beams = scan.ranges.resize(180);
    for (beam, range) in beams.iter_mut().enumerate() {
        let angle = -PI / 2.0 + beam as f32 * PI / 179.0;
        *range = match angle.to_degrees() {
            degrees if degrees > 12.0 => (1.0 / angle.sin()).min(8.0),
            degrees if (-40.0..-22.0).contains(&degrees) => 1.8 / angle.cos(),
            _ => f32::INFINITY,
        };
    }
    scan
}

fn sonars() -> RangeRing {
    let mut ring = RangeRing {
        field_of_view: 0.4,
        min_range: 0.1,
        max_range: 5.0,
        ..RangeRing::default()
    };
    for (degrees, range) in [(90.0, 0.8), (50.0, 1.1), (-30.0, 1.9), (0.0, f32::INFINITY)] {
        let theta = f64::to_radians(degrees);
        let mount = Pose2D::new(0.16 * theta.cos(), 0.16 * theta.sin(), theta);
        ring.poses.push(mount).expect("the sequence has room");
        ring.ranges.push(range).expect("the sequence has room");
    }
    ring
}

/// A line under two of eight cells.
fn line() -> LineSensor {
    let mut line = LineSensor::default();
    for cell in 0..8_u8 {
        let y = 0.14 - 0.04 * f64::from(cell);
        line.cells
            .push(Point2D { x: 0.25, y })
            .expect("the sequence has room");
        let brightness = if [2, 3].contains(&cell) { 0.1 } else { 0.9 };
        line.brightness.push(brightness).expect("the sequence has room");
    }
    line
}

fn imu() -> Imu {
    let mut imu = Imu::default();
    imu.angular_velocity.z = 0.35;
    imu.linear_acceleration.z = 9.81;
    imu
}

fn bumpers() -> Bumpers {
    let mut bumpers = Bumpers::default();
    for number in 0..5 {
        bumpers
            .front
            .push(Flag::new(number == 1))
            .expect("the sequence has room");
        bumpers.rear.push(Flag::FALSE).expect("the sequence has room");
    }
    bumpers
}

fn reading<T>(variable: &str, value: T) -> VariableState<T> {
    let fresh = Freshness {
        name: format!("pioneer.{variable}"),
        age: 0.1,
        stale: false,
        asleep: None,
    };
    VariableState::Present(value, fresh)
}
