//! Draws the picture of a run: the world of its simulator, and the path of the robot in it.

use std::path::{Path, PathBuf};

use jde_abi::describe::Role;
use jde_app::{Application, Binding, InstanceConfig};
use jde_board::value::{self, Value};
use jde_drawing::map::DriveMap;
use jde_drawing::{Picture, PictureError};
use jde_sim::World;
use jde_timeline::{DriveTimeline, Timeline};

use crate::failure::Failure;

/// The modulation of a simulator's driver that names its world.
const WORLD: &str = "world";
/// The unit of a modulation that names a file which must exist.
const FILE: &str = "file";

/// Returns the world file of the application's simulator, if it has one.
pub fn world_file(application: &Application) -> Option<PathBuf> {
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
pub fn draw(
    application: &Application,
    drive: DriveTimeline,
    timeline: &Timeline,
    world: Option<&Path>,
    file: &Path,
) -> Result<(), Failure> {
    let mut drive = DriveMap {
        title: application.name.clone(),
        ..DriveMap::of(drive, timeline.hierarchy())
    };
    if let Some(path) = world {
        let world =
            World::load(path, application.seed).map_err(|error| Failure::Broken(error.to_string()))?;
        drive.set_world(&world);
    }
    Picture::of_drive(&drive).save(file).map_err(|error| match error {
        PictureError::Write { path, error } => Failure::File { path, error },
        PictureError::Encode(_) => Failure::Broken(error.to_string()),
    })
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
