//! A further laser of a simulated robot. It scans the world of a robot's driver in the same application. It
//! moves nothing and opens no world itself.

use core::time::Duration;

use jde_schema::prelude::*;
use jde_sim::{LaserConfig, LaserModel, RobotId, World};

use crate::camera::find_robot;
use crate::output::{Measurement, Output};
use crate::worlds;

/// A laser on a robot of a simulated world: one that the robot's file names.
///
/// While the robot is not in the world it publishes nothing.
#[derive(Describe)]
#[schema(driver, period = "50ms", budget = "50ms")]
pub struct Laser {
    /// The world file, the same as that of the robot's driver.
    #[modulation(default = "", unit = "file", fixed)]
    world: Modulation<Text<1024>>,
    /// The name in the world file of the robot that carries it.
    #[modulation(default = "", fixed)]
    robot: Modulation<Text<60>>,
    /// The name of the laser in the robot's file.
    #[modulation(default = "", fixed)]
    sensor: Modulation<Text<60>>,
    /// The scan, in the frame of the laser, which has the laser's name. Its time is that of its first beam.
    #[export(validity = "1s")]
    laser: Export<LaserScan>,
    output: Output<LaserScan>,
}

impl Schema for Laser {
    fn awake(&mut self, cx: &Context) -> Result {
        self.output = Output::default();
        self.check_names(cx)
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let key = worlds::Key::new(cx.application(), self.world.get(cx).as_str());
        let open = worlds::find(&key);
        let Some(shared) = &open else {
            return self.wait(cx);
        };
        let mut world = shared.lock();
        // As for a camera, the result does not depend on which driver advances the world.
        world.advance_to(cx.now().as_nanos() as u64);
        let Some(robot) = find_robot(&world, self.robot.get(cx).as_str())? else {
            return self.wait(cx);
        };
        let lasers = shared.lasers(robot);
        let name = self.sensor.get(cx);
        let Some(laser) = lasers.iter().find(|laser| laser.name == name.as_str()) else {
            let known: Vec<&str> = lasers.iter().map(|laser| laser.name.as_str()).collect();
            return Err(format!("the robot has no laser `{name}`: it has `{}`", known.join("`, `")).into());
        };
        publish(
            (&mut self.laser, &mut self.output),
            cx,
            (&world, robot),
            (name.as_str(), laser),
        )
    }
}

impl Laser {
    fn check_names(&self, cx: &Context) -> Result {
        if self.world.get(cx).is_empty() || self.robot.get(cx).is_empty() || self.sensor.get(cx).is_empty() {
            return Err(
                "it has no world, robot or sensor; give it all: world = \"worlds/hall.toml\", robot = \"base\", \
                 sensor = \"rear\""
                    .into(),
            );
        }
        Ok(())
    }

    fn wait(&mut self, cx: &Context) -> Result {
        self.laser.retract(cx);
        self.output = Output::default();
        Ok(())
    }
}

impl Inspect for Laser {
    fn inspect(&self, cx: &Context, problems: &mut Problems) {
        let world = self
            .check_names(cx)
            .and_then(|()| Ok(worlds::load(self.world.get(cx).as_str(), cx.seed())?));
        if let Some(world) = problems.expect(&self.world, world) {
            problems.expect(&self.robot, find_robot(&world, self.robot.get(cx).as_str()));
        }
    }
}

/// Publishes a scan of a robot's laser, in the frame of that name, if one is due.
pub(crate) fn publish(
    (export, output): (&mut Export<LaserScan>, &mut Output<LaserScan>),
    cx: &Context,
    (world, robot): (&World, RobotId),
    (frame, model): (&str, &LaserModel),
) -> Result {
    output.deliver(cx, export);
    if !output.is_due(cx.now(), model.period) {
        return Ok(());
    }
    let laser = &model.config;
    let Some(time) = first_beam(cx.now(), world, laser) else {
        return Ok(());
    };
    let measurement = Measurement::new(time, (world, robot), (&model.delivery, laser.stream))?;
    output.measure(cx, export, measurement, |scan| {
        scan.header = Header::new(time, frame);
        scan.angle_min = laser.angle_min() as f32;
        scan.angle_max = laser.angle_max() as f32;
        scan.angle_increment = laser.angle_increment() as f32;
        scan.time_increment = laser.time_increment() as f32;
        scan.scan_time = laser.turn.map_or(0.0, |turn| turn.period as f32);
        scan.range_min = laser.range_min as f32;
        scan.range_max = laser.range_max as f32;
        let LaserScan {
            ranges, intensities, ..
        } = scan;
        let ranges = ranges.resize(laser.beams);
        if laser.intensity > 0.0 {
            let intensities = intensities.resize(laser.beams);
            world.laser_with_intensities(robot, laser, (ranges, intensities))?;
        } else {
            intensities.clear();
            world.laser(robot, laser, ranges)?;
        }
        Ok(())
    })
}

/// Returns the time of the first beam of a scan that ends now; `None` if a turning laser has not completed one.
fn first_beam(now: Duration, world: &World, laser: &LaserConfig) -> Option<Duration> {
    if laser.turn.is_none() {
        return Some(now);
    }
    Duration::from_nanos(world.now()).checked_sub(Duration::from_secs_f64(laser.age(0)))
}
