//! Draws the picture of a run: the world of its simulator, and the path of the robot in it.

use std::path::{Path, PathBuf};

use jde_abi::describe::Role;
use jde_app::{Application, Binding, InstanceConfig};
use jde_board::value::{self, Value};
use jde_host::Handle;
use jde_report::{Drive, Obstacle, Paint, PathPoint, Picture, PictureError, RobotPath, Takeover, Target};
use jde_sim::{Footprint, RobotModel, World};

use crate::failure::Failure;
use crate::session::{DriveTrace, PathSample, RunData};

/// The modulation of a simulator's driver that names its world.
const WORLD: &str = "world";
/// The unit of a modulation that names a file which must exist.
const FILE: &str = "file";

/// Returns the world file of the application's simulator, if it has one.
pub(crate) fn world_file(application: &Application) -> Option<PathBuf> {
    application
        .instances
        .iter()
        .find_map(|instance| match modulation(instance, WORLD, FILE)? {
            Value::Text(path) if !path.is_empty() => Some(PathBuf::from(path)),
            _ => None,
        })
}

/// Draws a drive.
///
/// # Errors
/// The world can no longer be read, or the picture cannot be written.
pub(crate) fn draw(
    handle: &Handle,
    data: &RunData,
    world: Option<&Path>,
    file: &Path,
) -> Result<(), Failure> {
    let Some(trace) = &data.trace else { return Ok(()) };
    let application = handle.application();
    let takeovers = takeovers(trace, data);
    let mut drive = Drive {
        title: application.name.clone(),
        schema_names: application
            .instances
            .iter()
            .map(|instance| instance.name.clone())
            .collect(),
        scans: trace.scans.clone().unwrap_or_default(),
        paths: trace
            .paths
            .iter()
            .map(|(robot, path)| robot_path(&application.instances[*robot], path))
            .collect(),
        targets: targets(trace),
        takeover_count: takeovers.len() as u64,
        takeovers,
        ..Drive::default()
    };
    if let Some(path) = world {
        let world =
            World::load(path, application.seed).map_err(|error| Failure::Broken(error.to_string()))?;
        drive.bounds = Some(world.bounds());
        drive.shapes = world.shapes().map(Obstacle::from).collect();
        drive.paint = world.paint().map(Paint::from).collect();
    }
    Picture::of_drive(&drive).save(file).map_err(|error| match error {
        PictureError::Write { path, error } => Failure::File { path, error },
        PictureError::Encode(_) => Failure::Broken(error.to_string()),
    })
}

fn robot_path(robot: &InstanceConfig, path: &[PathSample]) -> RobotPath {
    let steps = path.windows(2).map(|pair| [pair[0].pose, pair[1].pose]);
    let moment = |sample: &PathSample| PathPoint {
        time: sample.time as f64 / 1e9,
        x: sample.pose.x,
        y: sample.pose.y,
        heading: sample.pose.theta,
        winner: sample.acting,
    };
    RobotPath {
        robot: robot.name.clone(),
        body: body(robot),
        distance: steps.map(|[from, to]| (to.x - from.x).hypot(to.y - from.y)).sum(),
        points: path.iter().map(moment).collect(),
    }
}

fn targets(trace: &DriveTrace) -> Vec<Target> {
    let named = trace.targets.iter().enumerate();
    let target = |(before, (x, y)): (usize, &(f64, f64))| Target {
        number: before + 1,
        x: *x,
        y: *y,
        reached: before < trace.reached,
    };
    named.map(target).collect()
}

/// Returns the takeovers by schemas without motor children. A father takes over together with one of its
/// children.
fn takeovers(trace: &DriveTrace, data: &RunData) -> Vec<Takeover> {
    let actors: Vec<usize> = data.statistics.actors().collect();
    let acting = trace.takeovers.iter().filter(|(_, to, _)| actors.contains(to));
    acting
        .flat_map(|(time, to, robots)| robots.iter().map(move |robot| (time, to, robot)))
        .filter_map(|(time, to, robot)| {
            let pose = trace.pose_at(*robot, *time)?;
            Some(Takeover {
                x: pose.x,
                y: pose.y,
                to: *to,
            })
        })
        .collect()
}

/// Returns the body of a simulated robot, from its robot file.
fn body(robot: &InstanceConfig) -> Option<Footprint> {
    modulation(robot, WORLD, FILE)?;
    let Value::Text(model) = modulation(robot, "model", "model")? else {
        return None;
    };
    Some(RobotModel::find(&model).ok()?.config.footprint)
}

/// Returns the initial value of a modulation. A type of one field yields the value of that field.
fn modulation(instance: &InstanceConfig, name: &str, unit: &str) -> Option<Value> {
    let ports = instance.schema.ports.iter().zip(&instance.bindings);
    let mut named = ports.filter(|(port, _)| port.name == name && port.unit == unit);
    let (port, binding) = named.find(|(port, _)| matches!(port.role, Role::Modulation { .. }))?;
    let Binding::Modulation { initial, .. } = binding else {
        return None;
    };
    Some(value::decode(&port.value_type, initial).into_only_field())
}
