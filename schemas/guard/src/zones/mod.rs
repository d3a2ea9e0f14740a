//! The guard of zones around the robot: while something is in one, commands are slowed or refused. It judges by the newest
//! scan alone; it knows no motion, and remembers nothing.

use jde_motion::{Outline, ScanPoints};
use jde_schema::prelude::*;
use jde_schema::types;

/// What rounding may do to a speed: a limited command is judged again.
const ROUNDING_ERROR: f64 = 1e-9;

/// Slows commands while something is near the robot, and refuses them while something is nearer.
///
/// Both zones are areas around the base, as a collision monitor has them. A zone is occupied while at least `min_points`
/// points of the newest scan are in it. A scan without a measurement, and a missing or old one leave the guard without a
/// state, and every command is refused.
#[derive(Describe)]
#[schema(perceptive, period = "50ms", budget = "10ms")]
pub struct Zones {
    /// The scan of the laser. It judges by each at once.
    #[import(trigger)]
    laser: Import<LaserScan>,
    /// The pose of the laser on the base.
    #[modulation(default = Pose2D::ORIGIN, fixed, mount)]
    mount: Modulation<Pose2D>,
    /// Where nothing may be while the robot moves; a radius of 0 is no zone.
    #[modulation(default = types::Footprint::circle(0.0), fixed, margin)]
    stop: Modulation<types::Footprint>,
    /// Where nothing may be while the robot moves faster than `slow_speed` and `slow_turn`; a radius of 0 is no zone.
    #[modulation(default = types::Footprint::circle(0.0), fixed, margin)]
    slow: Modulation<types::Footprint>,
    /// The greatest speed while something is in `slow`.
    #[modulation(default = 0.2, unit = "m/s", min = 0.01)]
    slow_speed: Modulation<f64>,
    /// The greatest turn rate while something is in `slow`.
    #[modulation(default = 0.5, unit = "rad/s", min = 0.01)]
    slow_turn: Modulation<f64>,
    /// How many points occupy a zone: more than one, if single beams of the laser err.
    #[modulation(default = 1, min = 1.0, max = 1000.0)]
    min_points: Modulation<u32>,
    /// Greatest age of a scan.
    #[modulation(default = 0.5, unit = "s", min = 0.0, max = 3600.0)]
    stale: Modulation<f64>,
    /// The state by which it judges.
    #[export]
    occupied: Export<Occupied>,
    stop_zone: Option<Outline>,
    slow_zone: Option<Outline>,
    scan_points: ScanPoints,
}

/// What is in the zones, and what then counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/OccupiedZones")]
pub struct Occupied {
    /// The points in the zone in which the robot stands.
    pub stop: u32,
    /// The points in the zone in which it is slow.
    pub slow: u32,
    /// How many occupy a zone.
    pub min_points: u32,
    /// Unused bytes.
    pub padding: Padding<4>,
    /// The greatest speed while `slow` is occupied.
    #[value(unit = "m/s")]
    pub slow_speed: f64,
    /// The greatest turn rate while `slow` is occupied.
    #[value(unit = "rad/s")]
    pub slow_turn: f64,
}

impl Schema for Zones {
    fn awake(&mut self, cx: &Context) -> Result {
        self.stop_zone = outline(&self.stop.get(cx))?;
        self.slow_zone = outline(&self.slow.get(cx))?;
        Ok(())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        if self.observe(cx).is_none() {
            self.occupied.retract(cx);
        }
        Ok(())
    }
}

impl Guard for Zones {
    type State = Occupied;
    type Command = Twist;
    const STATE_EXPORT: &'static str = "occupied";

    fn judge(state: &Occupied, _: Duration, command: &Twist) -> Result<(), String> {
        state.judge(command)
    }

    fn limit(state: &Occupied, _: Duration, command: &Twist) -> Option<Twist> {
        state.limit(command)
    }
}

impl Inspect for Zones {
    fn inspect(&self, cx: &Context, problems: &mut Problems) {
        for zone in [&self.stop, &self.slow] {
            problems.expect(zone, outline(&zone.get(cx)));
        }
    }
}

impl Zones {
    /// Exports what is in the zones; none without a scan that measures.
    fn observe(&mut self, cx: &Context) -> Option<()> {
        let laser = self.laser.get(cx)?;
        let is_stale = cx.now().saturating_sub(laser.time()).as_secs_f64() > self.stale.get(cx);
        let mount = self.mount.get(cx);
        self.scan_points.update(&laser, |_| mount).ok()?;
        if is_stale {
            return None;
        }
        let points = self.scan_points.as_slice();
        let inside = |zone: &Option<Outline>| {
            zone.as_ref().map_or(0, |zone| {
                let is_inside = |point: &&types::Point2D| zone.clearance(&Pose2D::ORIGIN, &[**point]) <= 0.0;
                points.iter().filter(is_inside).count() as u32
            })
        };
        let occupied = Occupied {
            stop: inside(&self.stop_zone),
            slow: inside(&self.slow_zone),
            min_points: self.min_points.get(cx),
            padding: Padding::default(),
            slow_speed: self.slow_speed.get(cx),
            slow_turn: self.slow_turn.get(cx),
        };
        self.occupied.write(cx, occupied);
        Some(())
    }
}

impl Occupied {
    /// Judges a command. To stand is accepted always.
    fn judge(&self, command: &Twist) -> Result<(), String> {
        let part = self.part(command);
        if part >= 1.0 - ROUNDING_ERROR {
            return Ok(());
        }
        match part > 0.0 {
            true => Err(format!("{} points are in the zone `slow`", self.slow)),
            false => Err(format!("{} points are in the zone `stop`", self.stop)),
        }
    }

    /// Returns the part of a command that it accepts, on the same curve; none while the robot must stand.
    fn limit(&self, command: &Twist) -> Option<Twist> {
        let part = self.part(command);
        let scaled = |Vector3 { x, y, z }| Vector3 {
            x: x * part,
            y: y * part,
            z: z * part,
        };
        (part > 0.0).then(|| Twist {
            linear: scaled(command.linear),
            angular: scaled(command.angular),
        })
    }

    /// The part of a command's speed that is accepted.
    fn part(&self, command: &Twist) -> f64 {
        let speed = libm::hypot(command.linear.x, command.linear.y);
        let turn = command.angular.z.abs();
        if speed == 0.0 && turn == 0.0 {
            return 1.0;
        }
        if self.stop >= self.min_points {
            return 0.0;
        }
        if self.slow >= self.min_points {
            return (self.slow_speed / speed).min(self.slow_turn / turn).min(1.0);
        }
        1.0
    }
}

/// The area of a zone; none for a circle without a radius.
fn outline(zone: &types::Footprint) -> Result<Option<Outline>> {
    if zone.points.is_empty() && zone.radius == 0.0 {
        return Ok(None);
    }
    Ok(Some(Outline::try_from(zone)?))
}

#[cfg(test)]
mod tests;
