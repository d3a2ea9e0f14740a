//! The types and the properties that Stage reads and that mean nothing for the shape of a world.

use jde_files::LeftOut;

use super::syntax::Entity;

/// Types of models that sense or act, those of versions before 4 included.
pub(super) const INSTRUMENTS: [&str; 19] = [
    "actuator",
    "audio",
    "blinkenlight",
    "blobfinder",
    "bumper",
    "camera",
    "energy",
    "fiducial",
    "fiducialfinder",
    "gripper",
    "ir",
    "laser",
    "lightindicator",
    "loadcell",
    "ptz",
    "ranger",
    "sonar",
    "speech",
    "wifi",
];

/// Properties of the outermost entity: how Stage runs.
pub(super) const WORLD: &[&str] = &[
    "confirm_on_quit",
    "gui_disable",
    "gui_interval",
    "interval_real",
    "interval_sim",
    "name",
    "paused",
    "quit_time",
    "resolution",
    "show_clock",
    "show_clock_interval",
    "speedup",
    "test",
    "threads",
    "unit_angle",
    "unit_length",
];

/// Properties of a model: those that are read, and those of its look, its power, its window and what it is for sensors that
/// a world has not.
pub(super) const MODEL: &[&str] = &[
    "alwayson",
    "bitmap",
    "blob_return",
    "boundary",
    "color",
    "color_rgba",
    "debug",
    "event_queue",
    "fiducial_key",
    "fiducial_return",
    "friction",
    "give_watts",
    "gripper_return",
    "gui_boundary",
    "gui_grid",
    "gui_move",
    "gui_movemask",
    "gui_nose",
    "gui_outline",
    "joules",
    "joules_capacity",
    "kjoules",
    "kjoules_capacity",
    "laser_return",
    "map_resolution",
    "mass",
    "name",
    "noblocks",
    "obstacle_return",
    "origin",
    "origin3",
    "origin4",
    "pose",
    "pose3",
    "pose4",
    "ranger_return",
    "say",
    "size",
    "size3",
    "stack_children",
    "take_watts",
    "trail_interval",
    "trail_length",
    "update_interval",
    "watts",
];

/// Names the properties of an entity that are not among the known ones.
pub(super) fn report(entity: &Entity, known: &[&str], left_out: &mut LeftOut) {
    for (key, place) in entity.keys().filter(|(key, _)| !known.contains(key)) {
        let what = format!("the property `{}`", key.escape_debug());
        left_out.add(what, Some(place), "a world has no such thing");
    }
}
