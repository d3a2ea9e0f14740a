//! The elements of SDF that no world file has, and why they are left out.

use super::xml::Node;

/// Why joints are left out.
pub(super) const JOINT: &str = "nothing moves at a joint";

/// Why what is beside the world of a file is left out.
pub(super) const BESIDE: &str = "a file becomes one world, the first in it";

/// Returns how a report names an element: things that a user names with their names.
pub(super) fn named(node: &Node) -> String {
    let tag = node.name();
    match node.attribute("name") {
        Some(name) if matches!(tag, "actor" | "model" | "population" | "road" | "world") => {
            format!("<{tag}> `{name}`")
        }
        _ => format!("<{tag}>"),
    }
}

/// Returns why an element is left out.
pub(super) fn reason(tag: &str) -> &'static str {
    match tag {
        "actor" => "a conversion makes nothing that moves: add it as one of `[[people]]` or `[[movers]]`",
        "plugin" => "it is a program of Gazebo",
        "visual" | "light" | "scene" | "road" | "projector" | "particle_emitter" | "material" => {
            "it is only seen, and stops nothing"
        }
        "gui" => "it is about the windows of Gazebo",
        "sensor" | "gripper" | "battery" | "audio_sink" | "audio_source" | "audio" => {
            "an application chooses its robots and their sensors"
        }
        "physics"
        | "gravity"
        | "magnetic_field"
        | "wind"
        | "atmosphere"
        | "inertial"
        | "surface"
        | "self_collide"
        | "enable_wind"
        | "kinematic"
        | "must_be_base_link"
        | "velocity_decay"
        | "allow_auto_disable"
        | "max_contacts"
        | "density"
        | "auto_inertia_params"
        | "laser_retro" => "the simulator has its own physics",
        "spherical_coordinates" => "a world has no place on the earth",
        "joint" => JOINT,
        _ if tag.contains(':') => "it is an extension of another program",
        _ => "it is not known",
    }
}

/// Returns why a shape is left out.
pub(super) fn shape(kind: &str) -> &'static str {
    match kind {
        "mesh" => "meshes are not converted: draw what a robot meets of it as `[[walls]]` or `[[boxes]]`",
        "heightmap" | "image" => "a floor is level",
        _ => "it is not known",
    }
}
