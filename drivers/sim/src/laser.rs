//! A further laser of a simulated robot. It scans the world of a robot's driver in the same application. It
//! moves nothing and opens no world itself.

use core::time::Duration;

use jde_schema::prelude::*;
use jde_sim::{LaserConfig, RobotId, World};

use crate::camera::find_robot;
use crate::{scenery, worlds};

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
    /// The scan, in the frame of the laser, which has the laser's name. Stamped with the world's time.
    #[export(validity = "1s")]
    laser: Export<LaserScan>,
    /// Time at which the next scan is due.
    due: Option<Duration>,
}

impl Schema for Laser {
    fn awake(&mut self, cx: &Context) -> Result {
        self.due = None;
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
        if laser
            .period
            .is_none_or(|period| scenery::is_time(&mut self.due, cx.now(), period))
        {
            publish(
                &mut self.laser,
                cx,
                (&world, robot),
                (name.as_str(), &laser.config),
            )?;
        }
        Ok(())
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
        self.due = None;
        Ok(())
    }
}

impl Inspect for Laser {
    fn inspect(&self, cx: &Context, problems: &mut Problems) {
        let world = self
            .check_names(cx)
            .and_then(|()| Ok(World::load(self.world.get(cx).as_str(), cx.seed())?));
        if let Some(world) = problems.expect(&self.world, world) {
            problems.expect(&self.robot, find_robot(&world, self.robot.get(cx).as_str()));
        }
    }
}

/// Publishes a scan of a robot's laser, in the frame of that name.
pub(crate) fn publish(
    export: &mut Export<LaserScan>,
    cx: &Context,
    (world, robot): (&World, RobotId),
    (frame, laser): (&str, &LaserConfig),
) -> Result {
    let mut scan = export.loan(cx);
    scan.header = Header::new(cx.now(), frame);
    scan.angle_min = laser.angle_min() as f32;
    scan.angle_max = laser.angle_max() as f32;
    scan.angle_increment = laser.angle_increment() as f32;
    scan.time_increment = 0.0;
    scan.scan_time = 0.0;
    scan.range_min = laser.range_min as f32;
    scan.range_max = laser.range_max as f32;
    let LaserScan {
        ranges, intensities, ..
    } = &mut *scan;
    let ranges = ranges.resize(laser.beams);
    if laser.intensity > 0.0 {
        let intensities = intensities.resize(laser.beams);
        world.laser_with_intensities(robot, laser, (ranges, intensities))?;
    } else {
        intensities.clear();
        world.laser(robot, laser, ranges)?;
    }
    scan.publish();
    Ok(())
}
