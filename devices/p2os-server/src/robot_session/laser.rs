//! The laser that a client configures and switches on: its beams, and its sweeps as packets.

use core::f64::consts::PI;

use jde_p2os::{LaserForm, LaserPacket, READINGS, Reading};
use jde_sim::{LaserConfig, Pose2, RobotId, World};

/// Most readings in a sweep: 272 degrees at a quarter of a degree.
const MAX_BEAMS: i32 = 1088;
/// The reading of a beam without a return, mm: the range of a SICK LMS-200.
const NO_ECHO: u16 = 32_000;

/// The client's settings of the laser.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Laser {
    mode: Mode,
    /// Degrees.
    start: i32,
    end: i32,
    /// 0.01 degrees.
    step: i32,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Mode {
    Off,
    Plain,
    Extended,
}

impl Laser {
    /// Off; half a turn, with one beam a degree.
    pub(crate) fn new() -> Self {
        Self {
            mode: Mode::Off,
            start: -90,
            end: 90,
            step: 100,
        }
    }

    /// Sets the mode: 0 off, 1 on, 2 on with reflectances.
    pub(crate) fn set_mode(&mut self, mode: i32) -> Result<(), String> {
        self.mode = match mode {
            0 => Mode::Off,
            1 => Mode::Plain,
            2 => Mode::Extended,
            other => return Err(format!("the laser has no mode {other}, only 0, 1 and 2")),
        };
        Ok(())
    }

    pub(crate) fn set_start(&mut self, degrees: i32) -> Result<(), String> {
        self.set_config(Self {
            start: degrees,
            ..*self
        })
    }

    pub(crate) fn set_end(&mut self, degrees: i32) -> Result<(), String> {
        self.set_config(Self {
            end: degrees,
            ..*self
        })
    }

    pub(crate) fn set_step(&mut self, hundredths: i32) -> Result<(), String> {
        self.set_config(Self {
            step: hundredths,
            ..*self
        })
    }

    /// Returns the present sweep in packets; none while the laser is off.
    pub(crate) fn sweep(&self, world: &World, robot: RobotId, pose: Pose2) -> Vec<LaserPacket> {
        let form = match self.mode {
            Mode::Off => return Vec::new(),
            Mode::Plain => LaserForm::Plain {
                x: (pose.x * 1000.0).round() as i16,
                y: (pose.y * 1000.0).round() as i16,
                th: pose.heading.to_degrees().round() as i16,
            },
            Mode::Extended => LaserForm::Extended { device: 0, flags: 0 },
        };
        let config = self.config();
        let mut ranges = vec![0.0; config.beams];
        if world.laser(robot, &config, &mut ranges).is_err() {
            // This cannot happen: `set_config` accepts only what the world accepts.
            return Vec::new();
        }
        let readings: Vec<Reading> = ranges.iter().map(|range| reading(*range)).collect();
        let total = readings.len() as u16;
        let packets = readings.chunks(READINGS).enumerate();
        packets
            .map(|(number, readings)| LaserPacket {
                form,
                total,
                first: (number * READINGS) as u16,
                readings: readings.to_vec(),
            })
            .collect()
    }

    fn set_config(&mut self, config: Self) -> Result<(), String> {
        let turn = (config.end - config.start) * 100;
        if config.step < 1 || !(1..=36_000).contains(&turn.abs()) || turn.abs() / config.step >= MAX_BEAMS {
            return Err(format!(
                "a laser from {} to {} degrees by {:.2} is not possible: it has 1 to {MAX_BEAMS} beams over at most one turn",
                config.start,
                config.end,
                f64::from(config.step) / 100.0
            ));
        }
        *self = config;
        Ok(())
    }

    /// Returns the beams from right to left. Both ends are included, but a full turn repeats no beam.
    fn config(&self) -> LaserConfig {
        let (right, left) = (self.start.min(self.end), self.start.max(self.end));
        let beams = ((left - right) * 100 / self.step + 1).min(36_000 / self.step) as usize;
        let step = f64::from(self.step) / 100.0 * PI / 180.0;
        let view = step * beams as f64;
        let mount = LaserConfig::default().mount;
        LaserConfig {
            mount: Pose2::new(
                mount.x,
                mount.y,
                mount.heading + f64::from(right).to_radians() + view / 2.0,
            ),
            beams,
            field_of_view: view,
            range_max: f64::from(NO_ECHO) / 1000.0,
            ..LaserConfig::default()
        }
    }
}

fn reading(range: f32) -> Reading {
    let millimetres = if range == f32::INFINITY {
        NO_ECHO
    } else {
        // Negative infinity, too near to measure, becomes 0.
        (range * 1000.0).round() as u16
    };
    Reading {
        range: millimetres,
        reflectance: 0,
    }
}

#[cfg(test)]
mod tests {
    use jde_sim::RobotConfig;

    use super::*;

    const ROOM: &str = r#"
        walls  = [{ name = "room", points = [[0, 0], [6, 0], [6, 4], [0, 4]], closed = true }]
        robots = { pioneer = { start = { x = 2, y = 1 } } }
    "#;

    fn room() -> (World, RobotId) {
        let mut world = World::parse(ROOM, "room.toml", 1).expect("a world");
        let robot = world
            .add_robot("pioneer", RobotConfig::default())
            .expect("a robot");
        (world, robot)
    }

    fn readings(laser: &Laser) -> Vec<u16> {
        let (world, robot) = room();
        let packets = laser.sweep(&world, robot, Pose2::default());
        assert!(packets.iter().all(|packet| packet.to_packet().is_ok()));
        packets
            .iter()
            .flat_map(|packet| packet.readings.iter().map(|reading| reading.range))
            .collect()
    }

    #[track_caller]
    fn assert_near(actual: u16, expected: u16) {
        assert!(actual.abs_diff(expected) < 30, "{actual} mm is not {expected} mm");
    }

    #[test]
    fn half_a_turn_in_steps_of_a_degree_has_181_readings_from_the_right() {
        let mut laser = Laser::new();
        laser.set_mode(1).expect("a mode");
        let readings = readings(&laser);
        assert_eq!(readings.len(), 181);
        assert_near(readings[0], 1000);
        assert_near(readings[90], 3982);
        assert_near(readings[180], 3000);
    }

    #[test]
    fn a_sector_on_the_left_measures_to_the_left() {
        let mut laser = Laser::new();
        laser.set_mode(2).expect("a mode");
        laser.set_end(90).expect("an angle");
        laser.set_start(80).expect("an angle");
        laser.set_step(50).expect("a step");
        let readings = readings(&laser);
        assert_eq!(readings.len(), 21);
        assert_near(readings[20], 3000);
    }

    #[test]
    fn a_laser_that_is_off_sends_nothing() {
        assert!(readings(&Laser::new()).is_empty());
    }

    #[test]
    fn invalid_settings_are_refused_and_change_nothing() {
        let mut laser = Laser::new();
        let before = laser;
        laser.set_mode(7).expect_err("no mode");
        laser.set_start(90).expect_err("no beam");
        laser.set_start(-500).expect_err("more than a turn");
        laser.set_step(0).expect_err("no step");
        laser.set_step(-100).expect_err("no step");
        laser.set_step(1).expect_err("too many beams");
        assert_eq!(laser, before);
    }

    #[test]
    fn a_whole_turn_repeats_no_beam() {
        let mut laser = Laser::new();
        laser.set_start(-180).expect("an angle");
        laser.set_end(180).expect("an angle");
        assert_eq!(laser.config().beams, 360);
    }
}
