//! The robots of the project's `robots/`, as the texts of their files.

use std::path::Path;

use crate::error::WorldError;
use crate::model::RobotModel;

/// The names of the shipped robots and the texts of their files, in the order of the names.
pub const SHIPPED_ROBOTS: [(&str, &str); 7] = [
    ("jackal", include_str!("../../../robots/jackal.toml")),
    ("omni", include_str!("../../../robots/omni.toml")),
    ("pioneer-3dx", include_str!("../../../robots/pioneer-3dx.toml")),
    ("racecar", include_str!("../../../robots/racecar.toml")),
    (
        "turtlebot3-burger",
        include_str!("../../../robots/turtlebot3-burger.toml"),
    ),
    (
        "turtlebot3-line",
        include_str!("../../../robots/turtlebot3-line.toml"),
    ),
    ("turtlebot4", include_str!("../../../robots/turtlebot4.toml")),
];

impl RobotModel {
    /// Returns the robot of a file, if the text ends with `.toml`, or else the shipped one of that name. An
    /// application resolves paths, so only the last part of the text is the name.
    ///
    /// # Errors
    /// There is no such robot, or all faults of its file, each with its line.
    pub fn find(model: &str) -> Result<Self, WorldError> {
        let path = Path::new(model);
        if path.extension().is_some_and(|extension| extension == "toml") {
            return Self::load(path);
        }
        let name = path.file_name().unwrap_or_default();
        match SHIPPED_ROBOTS.iter().find(|(known, _)| name == *known) {
            Some((name, text)) => Self::parse(text, name),
            None => Err(WorldError::UnknownModel {
                name: name.display().to_string(),
                known: SHIPPED_ROBOTS.map(|(known, _)| known).join("`, `"),
            }),
        }
    }
}
