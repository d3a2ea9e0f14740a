//! Following a line on the floor: the position of the line is the mean of the cells' places, weighted by their
//! darkness, as in the Pololu 3pi Robot User's Guide (2008), "Advanced line following"; a PD controller over it
//! turns the robot, as for the line of Corke, *Robotics, Vision and Control* (2017), chapter 4. The cells ahead
//! of the wheels see the heading, too.

use jde_schema::prelude::*;
use jde_schema::types::normalize_angle;

use crate::body::{Body, HOLD, Permit, measured};
use crate::ports::RobotBase;

/// The darkest cell must be at least so dark, from 0 for the floor to 1 for the line.
const SEEN_DARKNESS: f64 = 0.5;
/// Line and floor must differ by so much in brightness.
const CONTRAST: f64 = 0.05;
/// What is less dark than this is dirt and noise.
const NOISE_DARKNESS: f64 = 0.2;
/// The part of the bar's half width from which on a line that is lost was lost to the side.
const EDGE: f64 = 0.5;
/// How far it turns to a line that it lost to the side, rad.
const SWEEP: f64 = 100_f64.to_radians();
/// The part of `vx_max` that is left while it turns at full rate, or searches.
const TURNING_SPEED: f64 = 0.3;
/// The part of `wz_max` with which it turns to a line that it lost.
const SWEEP_RATE: f64 = 0.5;
/// Two measurements farther apart than this have no rate, s.
const MAX_RATE_INTERVAL: f64 = 0.3;

/// Follows a line on the floor.
///
/// It is ready while its cells see the line, and while it searches for a line that it lost: ahead, as at a gap, or on
/// the side of the loss. If the import of the laser is bound, it stops before obstacles.
#[derive(Describe)]
#[schema(motor, period = "50ms", budget = "20ms")]
pub struct Line {
    /// The brightness of the floor below the cells.
    #[import(trigger)]
    line_sensor: Import<LineSensor>,
    /// The estimated pose and velocity of the robot.
    #[import]
    pose: Import<Odometry>,
    /// The scan of the laser.
    #[import(optional)]
    laser: Import<LaserScan>,
    /// Brightness of the line. It may be brighter than the floor.
    #[modulation(default = 0.0, min = 0.0, max = 1.0)]
    line: Modulation<f64>,
    /// Brightness of the floor beside the line.
    #[modulation(default = 0.5, min = 0.0, max = 1.0)]
    floor: Modulation<f64>,
    /// Turn rate for each metre that the line is to the side: the P of the controller.
    #[modulation(default = 65.0, unit = "rad/s/m", min = 0.0)]
    gain: Modulation<f64>,
    /// Turn rate for each m/s by which the line moves to the side: the D of the controller.
    #[modulation(default = 15.0, unit = "rad/m", min = 0.0)]
    damping: Modulation<f64>,
    /// How far it goes ahead to find the line again.
    #[modulation(default = 0.15, unit = "m", min = 0.0)]
    search: Modulation<f64>,
    #[ports]
    robot: RobotBase,
    /// Distance to keep from everything that the laser sees.
    #[modulation(default = 0.05, unit = "m", min = 0.0, margin)]
    margin: Modulation<f64>,
    /// Greatest speed.
    #[modulation(default = 0.2, unit = "m/s", min = 0.0, limit, was = "fast")]
    vx_max: Modulation<f64>,
    /// Greatest turn rate.
    #[modulation(default = 2.0, unit = "rad/s", min = 0.01, limit, was = "turn")]
    wz_max: Modulation<f64>,
    /// How far the line is to the left of the middle of the base, where the cells see it; none while they do
    /// not.
    #[export(unit = "m")]
    offset: Export<f64>,
    body: Option<Body>,
    gait: Gait,
    /// Where the line was seen last.
    position: Option<Position>,
    permit: Option<Permit>,
}

/// What the robot does.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Gait {
    /// It has seen no line, or searched in vain.
    #[default]
    Lost,
    /// It sees the line.
    Following,
    /// It lost the line at this pose.
    Searching(Pose2D),
}

/// The line as the cells saw it.
#[derive(Clone, Copy, Debug)]
struct Position {
    /// To the left, m.
    offset: f64,
    /// The change of the offset, m/s.
    rate: f64,
    /// How far the cells reach to the side, m.
    reach: f64,
    time: Duration,
}

impl Schema for Line {
    fn awake(&mut self, cx: &Context) -> Result {
        self.body = Some(self.robot.body(cx)?);
        self.gait = Gait::Lost;
        self.position = None;
        Ok(())
    }

    fn check(&mut self, cx: &Context) -> Result<Precondition> {
        let observed = self.observe(cx);
        Ok((observed.is_some() && self.gait != Gait::Lost).into())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        self.permit = self.drive(cx);
        let command = match self.permit {
            Some(Permit::Go(twist)) => twist,
            // It does not turn away from the line to get around something.
            Some(Permit::Turn(..) | Permit::Stay(_) | Permit::Unknown) | None => Twist::ZERO,
        };
        self.robot.base.command(cx, command);
        match (self.gait, self.position) {
            (Gait::Following, Some(position)) => self.offset.write(cx, position.offset),
            _ => self.offset.retract(cx),
        }
        Ok(())
    }
}

/// Refuses a footprint that is no convex area, and a line that is as bright as the floor.
impl Inspect for Line {
    fn inspect(&self, cx: &Context, problems: &mut Problems) {
        self.robot.inspect(cx, problems);
        let (line, floor) = (self.line.get(cx), self.floor.get(cx));
        if (line - floor).abs() < CONTRAST {
            problems.wrong(
                &self.line,
                format!("the floor is as bright, {floor}: expected a difference of at least {CONTRAST}"),
            );
        }
    }
}

impl Panel for Line {
    fn draw(&self, _: &Context, pen: &mut Pen) {
        pen.text(match self.gait {
            Gait::Lost => "sees no line",
            Gait::Following => "follows the line",
            Gait::Searching(_) if self.is_beside() => "turns to the line that it lost",
            Gait::Searching(_) => "goes ahead to find the line again",
        });
        if let Some(obstacle) = self.permit.and_then(|permit| permit.obstacle()) {
            pen.text(obstacle);
        }
        if let (Gait::Following, Some(position)) = (self.gait, self.position) {
            pen.value("offset to the left", position.offset, "m");
        }
    }
}

impl Line {
    /// Takes in what the sensors measure. Returns pose and velocity of the base; `None` if they or a scan that
    /// is bound are missing.
    fn observe(&mut self, cx: &Context) -> Option<(Pose2D, Twist)> {
        let odometry = self.pose.get(cx);
        let observed = if self.laser.is_bound(cx) {
            let laser = self.laser.get(cx);
            self.body
                .as_mut()?
                .observe(cx, laser.as_ref(), odometry.as_ref(), self.robot.motors(cx))
        } else {
            self.robot.motors(cx)?;
            measured(odometry.as_deref()?)
        };
        let (pose, velocity) = observed?;
        self.gait = self.next(cx, &pose);
        Some((pose, velocity))
    }

    fn next(&mut self, cx: &Context, pose: &Pose2D) -> Gait {
        let sensor = self.line_sensor.get(cx);
        let seen = sensor.and_then(|sensor| {
            let (offset, reach) = locate(&sensor, self.line.get(cx), self.floor.get(cx))?;
            Some((offset, reach, sensor.time()))
        });
        if let Some((offset, reach, time)) = seen {
            let before = self.position.filter(|_| self.gait == Gait::Following);
            let rate = before.map_or(0.0, |before| {
                let elapsed = time.saturating_sub(before.time).as_secs_f64();
                match elapsed {
                    0.0 => before.rate,
                    0.0..MAX_RATE_INTERVAL => (offset - before.offset) / elapsed,
                    _ => 0.0,
                }
            });
            self.position = Some(Position {
                offset,
                rate,
                reach,
                time,
            });
            return Gait::Following;
        }
        match self.gait {
            Gait::Following => Gait::Searching(*pose),
            Gait::Searching(lost)
                if pose.distance_to(&lost) < self.search.get(cx)
                    && normalize_angle(pose.theta - lost.theta).abs() < SWEEP =>
            {
                self.gait
            }
            Gait::Searching(_) | Gait::Lost => Gait::Lost,
        }
    }

    fn drive(&mut self, cx: &Context) -> Option<Permit> {
        self.observe(cx)?;
        let position = self.position?;
        let (fast, most) = (self.vx_max.get(cx), self.wz_max.get(cx));
        let (speed, turn) = match self.gait {
            Gait::Lost => return None,
            Gait::Following => {
                let turn = self.gain.get(cx) * position.offset + self.damping.get(cx) * position.rate;
                let turn = turn.clamp(-most, most);
                (fast * (1.0 - (1.0 - TURNING_SPEED) * turn.abs() / most), turn)
            }
            Gait::Searching(_) if self.is_beside() => (0.0, (SWEEP_RATE * most).copysign(position.offset)),
            Gait::Searching(_) => (TURNING_SPEED * fast, 0.0),
        };
        let ability = self.robot.ability(cx, self.margin.get(cx), HOLD);
        let body = self.body.as_ref()?;
        // The part of the speed from which it still stops before what is ahead.
        let ahead = body.free_ahead(ability.margin).max(0.0);
        let part = (ability.dynamics.arrival(ahead) / speed).min(1.0);
        let wanted = if speed > 0.0 {
            Twist::planar(part * speed, part * turn)
        } else {
            Twist::planar(0.0, turn)
        };
        Some(body.permit(wanted, &ability))
    }

    /// Whether the line was last seen near an end of the bar.
    fn is_beside(&self) -> bool {
        self.position
            .is_some_and(|position| position.offset.abs() > EDGE * position.reach)
    }
}

/// Returns how far the line is to the left, m, and how far the cells reach to the side, m; `None` if no cell
/// sees it.
fn locate(sensor: &LineSensor, line: f64, floor: f64) -> Option<(f64, f64)> {
    let contrast = floor - line;
    if contrast.abs() < CONTRAST {
        return None;
    }
    let (mut sum, mut weights, mut darkest, mut reach) = (0.0, 0.0, 0.0_f64, 0.0_f64);
    for (cell, brightness) in sensor.cells.iter().zip(&sensor.brightness) {
        let dark = ((floor - f64::from(*brightness)) / contrast).clamp(0.0, 1.0);
        darkest = darkest.max(dark);
        reach = reach.max(cell.y.abs());
        if dark >= NOISE_DARKNESS {
            sum += dark * cell.y;
            weights += dark;
        }
    }
    let offset = sum / weights;
    (darkest >= SEEN_DARKNESS && offset.is_finite()).then_some((offset, reach))
}

#[cfg(test)]
mod tests;
