//! Exports the robot's reports in the standard interfaces: SI units, REP-103 axes. A quantity that is not
//! measured is NaN or not published.

use core::time::Duration;

use jde_motion::BaseDynamics;
use jde_p2os::{Beams, Config, Event, Model, Reading, Sip};
use jde_schema::prelude::*;
use jde_schema::types::{Body, Footprint, Mount};

use crate::Pioneer;
use crate::robot::RobotConnection;

/// The reported temperature if none is measured, °C.
const NO_TEMPERATURE: i8 = -127;

/// The state kept between packets.
#[derive(Default)]
pub(crate) struct SensorState {
    /// The last range of each sonar, m; a packet reports only some of them.
    ranges: Vec<f32>,
    /// The last position of the head, and its time.
    head: Option<(Duration, f64, f64)>,
    /// The time of the last sweep.
    sweep: Option<Duration>,
    /// Whether there are exports to retract.
    has_exports: bool,
    /// Whether the body is exported.
    has_body: bool,
}

impl SensorState {
    /// Discards the state. Returns whether there were exports to retract.
    pub(crate) fn reset(&mut self) -> bool {
        core::mem::take(self).has_exports
    }
}

impl Pioneer {
    /// Publishes the robot's events.
    pub(crate) fn sense(&mut self, cx: &Context, robot: &mut RobotConnection) -> Result {
        while let Some(event) = robot.next_event() {
            self.senses.has_exports = true;
            let Some(model) = robot.session().model() else {
                break;
            };
            if !core::mem::replace(&mut self.senses.has_body, true) {
                self.body.write(cx, body(cx.now(), model));
                self.dynamics.write(cx, dynamics(robot.session().config()));
            }
            if let Event::Config(config) = &event {
                self.dynamics.write(cx, dynamics(Some(config)));
            }
            match event {
                Event::Sip(sip) => self.state(cx, robot, model, &sip)?,
                Event::Laser(sweep) => self.scan(cx, robot.beams(), &sweep)?,
                Event::Encoders { left, right } => {
                    let reported = robot.session().config().map_or(0, |config| config.ticks_per_mm);
                    let ticks = if reported > 0 {
                        f64::from(reported)
                    } else {
                        model.encoders.per_mm
                    };
                    let encoders = WheelEncoders {
                        header: Header::new(cx.now(), "base_link"),
                        left,
                        right,
                        ticks_per_meter: 1000.0 * ticks,
                    };
                    self.encoders.write(cx, encoders);
                }
                Event::Head { pan, tilt } => self.publish_pan_tilt(cx, pan, tilt),
                Event::Warning(message) => warn!(cx, "{message}"),
                Event::Config(config) if config.watchdog == 0 => {
                    warn!(
                        cx,
                        "its watchdog is off: it would drive on without this program; set its WatchDog to 2000"
                    );
                }
                Event::Config(config) => {
                    debug!(
                        cx,
                        "firmware {}, watchdog {} ms", config.firmware, config.watchdog
                    );
                }
            }
        }
        Ok(())
    }

    fn state(&mut self, cx: &Context, robot: &RobotConnection, model: &Model, sip: &Sip) -> Result {
        let now = cx.now();
        let pose = robot.session().pose();
        let pose = Pose2D::new(pose.x, pose.y, pose.heading);
        self.odometry
            .write(cx, Odometry::planar(now, pose, twist(model, sip)));
        self.bumpers
            .write(cx, bumpers(now, model, robot.session().config(), sip)?);
        self.battery.write(cx, battery(now, model, sip));
        if !sip.sonars.is_empty() {
            self.ring(cx, model, sip);
        }
        Ok(())
    }

    fn ring(&mut self, cx: &Context, model: &Model, sip: &Sip) {
        let count = model.sonar.mounts.len();
        let ranges = &mut self.senses.ranges;
        ranges.resize(count, f32::NAN);
        for sonar in &sip.sonars {
            let Some(range) = ranges.get_mut(usize::from(sonar.index)) else {
                continue;
            };
            let mm = f64::from(sonar.range) * model.units.range_mm;
            *range = if mm >= model.sonar.max_mm {
                f32::INFINITY
            } else if mm < model.sonar.min_mm {
                f32::NEG_INFINITY
            } else {
                (mm / 1000.0) as f32
            };
        }
        let mut ring = self.sonars.loan(cx);
        ring.header = Header::new(cx.now(), "base_link");
        ring.radiation_type = 0;
        ring.padding = Padding::ZERO;
        ring.field_of_view = model.sonar.cone_deg.to_radians() as f32;
        ring.min_range = (model.sonar.min_mm / 1000.0) as f32;
        ring.max_range = (model.sonar.max_mm / 1000.0) as f32;
        for (pose, [x, y, angle]) in ring.poses.resize(count).iter_mut().zip(&model.sonar.mounts) {
            *pose = Pose2D::new(x / 1000.0, y / 1000.0, angle.to_radians());
        }
        ring.ranges.resize(count).copy_from_slice(ranges);
        ring.publish();
    }

    fn scan(&mut self, cx: &Context, beams: Beams, sweep: &[Reading]) -> Result {
        let max_range = self.laser_range.get(cx) as f32;
        let start = f64::from(beams.start_deg).to_radians();
        let view = (f64::from(beams.end_deg) - f64::from(beams.start_deg)).to_radians();
        let increment = view / (sweep.len().saturating_sub(1).max(1)) as f64;
        let now = cx.now();
        let last = self.senses.sweep.replace(now);
        let mut laser = self.laser.loan(cx);
        laser.header = Header::new(now, "laser");
        laser.angle_min = start as f32;
        laser.angle_increment = increment as f32;
        laser.angle_max = (start + increment * sweep.len().saturating_sub(1) as f64) as f32;
        laser.time_increment = 0.0;
        laser.scan_time = last.map_or(0.0, |last| now.saturating_sub(last).as_secs_f32());
        laser.range_min = 0.0;
        laser.range_max = max_range;
        laser.ranges.clear();
        laser.intensities.clear();
        // A simulator may send more readings than requested, and more than fit; the surplus follows the
        // requested ones.
        let reflected = sweep.iter().any(|reading| reading.reflectance != 0);
        for reading in sweep.iter().take(1088) {
            let range = f32::from(reading.range) / 1000.0;
            let range = if range >= max_range { f32::INFINITY } else { range };
            laser.ranges.extend_from_slice(&[range])?;
            if reflected {
                laser
                    .intensities
                    .extend_from_slice(&[reading.reflectance.into()])?;
            }
        }
        laser.publish();
        Ok(())
    }

    fn publish_pan_tilt(&mut self, cx: &Context, pan: f64, tilt: f64) {
        let now = cx.now();
        let last = self.senses.head.replace((now, pan, tilt));
        let (mut pan_velocity, mut tilt_velocity) = (0.0, 0.0);
        if let Some((then, last_pan, last_tilt)) = last
            && now > then
        {
            let elapsed = (now - then).as_secs_f64();
            pan_velocity = (pan - last_pan) / elapsed;
            tilt_velocity = (tilt - last_tilt) / elapsed;
        }
        let header = Header::new(now, "base_link");
        self.pan_tilt.write(
            cx,
            PanTilt {
                header,
                pan,
                tilt,
                pan_velocity,
                tilt_velocity,
            },
        );
    }
}

/// Returns the circle in which a robot turns, with the usual place of its laser.
fn body(now: Duration, model: &Model) -> Body {
    let (x, y) = (model.laser.x_mm / 1000.0, model.laser.y_mm / 1000.0);
    let laser = Mount {
        frame: Text::new("laser"),
        pose: Pose2D::new(x, y, 0.0),
    };
    Body {
        header: Header::new(now, "base_link"),
        footprint: Footprint::circle(model.body.radius_mm / 1000.0),
        lasers: [laser].into_iter().collect(),
    }
}

/// Returns the accelerations of the robot's settings; 0, which is unknown, without them.
fn dynamics(config: Option<&Config>) -> BaseDynamics {
    let metres = |mm: u16| f64::from(mm) / 1000.0;
    let radians = |degrees: u16| f64::from(degrees).to_radians();
    config.map_or_else(BaseDynamics::default, |config| BaseDynamics {
        acceleration: metres(config.trans_acc),
        deceleration: metres(config.trans_dec),
        turn_acceleration: radians(config.rot_acc),
        turn_deceleration: radians(config.rot_dec),
        lag: 0.0,
    })
}

/// The speeds from the wheels. The turn rate comes from the firmware if it measures it, because that is more
/// accurate.
fn twist(model: &Model, sip: &Sip) -> Twist {
    let speed = |units: i16| f64::from(units) * model.units.velocity_mm_s;
    let (left, right) = (speed(sip.left_velocity), speed(sip.right_velocity));
    let turning = match sip.rotation {
        Some(0) | None => (right - left) / 2.0 * model.units.wheel_difference,
        Some(rotation) => (f64::from(rotation) / 10.0).to_radians(),
    };
    Twist::planar((left + right) / 2000.0, turning)
}

fn bumpers(now: Duration, model: &Model, config: Option<&Config>, sip: &Sip) -> Result<Bumpers> {
    let count = |reported: Option<u8>, known: usize| reported.map_or(known, usize::from).min(7);
    let reported = config.filter(|config| config.front_bumpers > 0 || config.rear_bumpers > 0);
    let front = count(reported.map(|config| config.front_bumpers), model.bumpers.front);
    let rear = count(reported.map(|config| config.rear_bumpers), model.bumpers.rear);
    let mut bumpers = Bumpers {
        header: Header::new(now, "base_link"),
        stalled: sip.stalled().into(),
        ..Bumpers::default()
    };
    for number in 0..front {
        bumpers
            .front
            .extend_from_slice(&[sip.front_bumper(number).into()])?;
    }
    // The robot counts clockwise; the interface counts from left to right, facing ahead.
    for number in (0..rear).rev() {
        bumpers
            .rear
            .extend_from_slice(&[sip.rear_bumper(number).into()])?;
    }
    Ok(bumpers)
}

fn battery(now: Duration, model: &Model, sip: &Sip) -> BatteryState {
    let volts = sip.volts();
    let by_voltage = (volts - model.battery.empty_v) / (model.battery.full_v - model.battery.empty_v);
    let charge = match sip.state_of_charge {
        Some(percent @ 1..) => f64::from(percent) / 100.0,
        Some(0) | None => by_voltage,
    };
    let temperature = sip.temperature.filter(|degrees| *degrees != NO_TEMPERATURE);
    BatteryState {
        header: Header::new(now, "base_link"),
        voltage: volts as f32,
        percentage: charge.clamp(0.0, 1.0) as f32,
        temperature: temperature.map_or(f32::NAN, f32::from),
        power_supply_status: match sip.charge {
            Some(0) => 2,
            Some(1 | 2) => 1,
            Some(3) => 4,
            Some(_) | None => 0,
        },
        present: Flag::TRUE,
        ..BatteryState::default()
    }
}
