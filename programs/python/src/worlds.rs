//! Worlds and robots of the simulator's files, for drivers of other simulators: what stands there, what moves by itself,
//! and what a robot is made of. The robot itself is moved by the other simulator.

use std::path::PathBuf;

use jde_sim::{
    Delivery, Edits, Footprint, Kinematics, LaserConfig, LaserModel, NoReturn, Outline, Physics, Pose2,
    RobotId, RobotModel, Shape,
};
use parking_lot::Mutex;
use pyo3::prelude::*;
use serde_json::{Value, json};

use crate::{error, json};

/// A world with one robot, which another simulator moves.
#[pyclass(frozen, module = "jde.worlds", name = "World")]
pub(crate) struct OtherWorld(Mutex<Inner>);

struct Inner {
    world: jde_sim::World,
    robot: RobotId,
    /// The number of the last edit that had one.
    edited: u64,
}

#[pymethods]
impl OtherWorld {
    /// Reads a world file and adds a robot of a model: at its start in the file, or at `start`, its place in metres
    /// and its heading in radians. `seed` is that of what moves by itself.
    #[new]
    #[pyo3(signature = (file, robot, model, start=None, seed=0))]
    fn new(file: PathBuf, robot: &str, model: &str, start: Option<[f64; 3]>, seed: u64) -> PyResult<Self> {
        let config = RobotModel::find(model).map_err(error)?.config;
        let mut world = jde_sim::World::load(&file, seed).map_err(error)?;
        let robot = match start {
            Some([x, y, heading]) => world.add_robot_at(robot, Pose2::new(x, y, heading), config),
            None => world.add_robot(robot, config),
        };
        let robot = robot.map_err(error)?;
        Ok(Self(Mutex::new(Inner {
            world,
            robot,
            edited: 0,
        })))
    }

    /// The name of the world.
    #[getter]
    fn name(&self) -> String {
        self.0.lock().world.name().to_owned()
    }

    /// How often the things that stand have changed.
    #[getter]
    fn changes(&self) -> u64 {
        self.0.lock().world.changes()
    }

    /// Where the robot is for what moves by itself: place in metres, heading in radians.
    #[getter]
    fn pose(&self) -> [f64; 3] {
        let inner = self.0.lock();
        let Pose2 { x, y, heading } = inner.world.truth(inner.robot).pose;
        [x, y, heading]
    }

    /// Says where the robot is now. Where it overlaps a thing it stays at its last place.
    fn set_pose(&self, pose: [f64; 3]) {
        let Inner { world, robot, .. } = &mut *self.0.lock();
        let [x, y, heading] = pose;
        // A body that presses on a thing reaches a little into it.
        let _ = world.place(*robot, Pose2::new(x, y, heading));
    }

    /// Lets what moves by itself move until a time, in nanoseconds.
    fn advance(&self, time: u64) {
        self.0.lock().world.advance_to(time);
    }

    /// Makes changes of the world, as of the modulation `edit` of `sim/robot`. Returns how many were made, how many
    /// refused, and why the last was.
    fn edit(&self, text: &str) -> (u64, u64, String) {
        let Inner { world, robot, edited } = &mut *self.0.lock();
        let edits = match Edits::parse(text) {
            Ok(edits) => edits,
            Err(error) => return (0, 1, error.to_string()),
        };
        let (mut done, mut refused, mut note) = (0, 0, String::new());
        for (number, edit) in (edits.number.unwrap_or(0)..).zip(&edits.edits) {
            if edits.number.is_some() && number <= *edited {
                continue;
            }
            if edits.number.is_some() {
                *edited = number;
            }
            match world.edit(*robot, edit) {
                Ok(()) => done += 1,
                Err(error) => {
                    refused += 1;
                    note = error.to_string();
                }
            }
        }
        (done, refused, note)
    }

    /// The things, each a dictionary: those that stand, or those that move or may be pushed.
    fn things<'py>(&self, py: Python<'py>, moving: bool) -> PyResult<Bound<'py, PyAny>> {
        let inner = self.0.lock();
        let things = inner.world.shapes().filter(|shape| shape.moving == moving);
        json(py, &things.map(|shape| thing(&shape)).collect::<Vec<_>>())
    }

    /// The poses of the things that move or may be pushed, in their order.
    fn moved(&self) -> Vec<[f64; 3]> {
        let inner = self.0.lock();
        let moving = inner.world.shapes().filter(|shape| shape.moving);
        let poses = moving.map(|shape| shape.outline.placed().0);
        poses.map(|pose| [pose.x, pose.y, pose.heading]).collect()
    }
}

/// The robot of a robot file, or the shipped one of that name, as a dictionary.
#[pyfunction]
pub(crate) fn robot_model<'py>(py: Python<'py>, model: &str) -> PyResult<Bound<'py, PyAny>> {
    let RobotModel {
        name,
        config,
        odometry,
        lasers,
        bumpers,
        physics,
        ..
    } = RobotModel::find(model).map_err(error)?;
    let kinematics = match config.kinematics {
        Kinematics::Differential => "differential",
        Kinematics::Omnidirectional { .. } => "omnidirectional",
        Kinematics::Car { .. } => "car",
    };
    let corners: Vec<[f64; 2]> = config.footprint.corners().collect();
    let radius = match config.footprint {
        Footprint::Circle { radius } => Some(radius),
        Footprint::Polygon(_) => None,
    };
    let value = json!({
        "name": name,
        "kinematics": kinematics,
        "radius": radius,
        "corners": corners,
        "max_speed": config.max_linear,
        "acceleration": config.linear_acceleration,
        "deceleration": config.linear_deceleration,
        "max_turn": config.max_angular,
        "turn_acceleration": config.angular_acceleration,
        "turn_deceleration": config.angular_deceleration,
        "lag": config.lag,
        "dead_band": config.dead_band,
        "turn_dead_band": config.turn_dead_band,
        "track": config.track,
        "ticks_per_meter": config.ticks_per_meter,
        "wheel_error": config.wheel_scale_sigma,
        "slip": config.slip_sigma,
        "odometry": delivery(&odometry),
        "lasers": lasers.iter().map(laser).collect::<Vec<_>>(),
        "bumpers": bumpers,
        "physics": physics.as_ref().map(self::physics),
    });
    json(py, &value)
}

fn physics(physics: &Physics) -> Value {
    let Physics {
        mass,
        height,
        center,
        wheel_radius,
        wheel_width,
        wheels,
        casters,
        torque,
        friction,
        track_multiplier,
    } = physics;
    json!({
        "mass": mass,
        "height": height,
        "center": center,
        "wheel_radius": wheel_radius,
        "wheel_width": wheel_width,
        "wheels": wheels,
        "casters": casters,
        "torque": torque,
        "friction": friction,
        "track_multiplier": track_multiplier,
    })
}

fn laser(model: &LaserModel) -> Value {
    let LaserConfig {
        mount,
        height,
        beams,
        range_min,
        range_max,
        sigma,
        intensity,
        turn,
        dropped_beams,
        no_return,
        ..
    } = model.config;
    let no_return = match no_return {
        NoReturn::Infinity => "inf",
        NoReturn::Max => "max",
        NoReturn::Zero => "zero",
        NoReturn::Nan => "nan",
    };
    json!({
        "name": model.name,
        "mount": [mount.x, mount.y, mount.heading],
        "height": height,
        "beams": beams,
        "angle_min": model.config.angle_min(),
        "angle_max": model.config.angle_max(),
        "angle_increment": model.config.angle_increment(),
        "range_min": range_min,
        "range_max": range_max,
        "noise": sigma,
        "intensity": intensity,
        "turn": turn.map(|turn| turn.period),
        "time_increment": model.config.time_increment(),
        "dropped_beams": dropped_beams,
        "no_return": no_return,
        "period": model.period.map(|period| period.as_secs_f64()),
        "delivery": delivery(&model.delivery),
    })
}

fn delivery(delivery: &Delivery) -> Value {
    json!({ "latency": delivery.latency, "jitter": delivery.jitter, "dropped": delivery.dropped })
}

fn thing(shape: &Shape<'_>) -> Value {
    let (pose, size) = shape.outline.placed();
    let form = match shape.outline {
        Outline::Segment { .. } => "wall",
        Outline::Box { .. } => "box",
        Outline::Circle { .. } => "circle",
    };
    json!({
        "name": shape.name,
        "form": form,
        "pose": [pose.x, pose.y, pose.heading],
        "size": size,
        "height": shape.height,
        "color": [shape.color.r, shape.color.g, shape.color.b],
    })
}
