//! The items that the user shows in the 3D view.

use serde::{Deserialize, Serialize};

/// Whether each item is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, rename_all = "kebab-case")]
pub(crate) struct Items {
    pub(crate) grid: bool,
    pub(crate) axes: bool,
    pub(crate) robot: bool,
    pub(crate) laser: bool,
    pub(crate) sonars: bool,
    pub(crate) path: bool,
    pub(crate) targets: bool,
    pub(crate) cameras: bool,
    pub(crate) walls: bool,
    /// Walls and furniture in full height, not cut off.
    pub(crate) tall: bool,
    pub(crate) movers: bool,
    pub(crate) panels: bool,
    pub(crate) labels: bool,
}

impl Default for Items {
    fn default() -> Self {
        Self {
            grid: true,
            axes: true,
            robot: true,
            laser: true,
            sonars: false,
            path: true,
            targets: true,
            cameras: true,
            walls: true,
            tall: false,
            movers: true,
            panels: true,
            labels: true,
        }
    }
}

impl Items {
    /// The items, each with its label and description.
    pub(crate) fn each(&mut self) -> [(&mut bool, &'static str, &'static str); 13] {
        [
            (&mut self.grid, "Grid", "The floor, with a line every metre or so"),
            (
                &mut self.axes,
                "Axes",
                "The origin of the odometry: x ahead, y left, z up",
            ),
            (&mut self.robot, "Robot", "Where the wheels say it is"),
            (
                &mut self.laser,
                "Laser",
                "What each beam met, and what is free before it",
            ),
            (&mut self.sonars, "Sonars", "How far each sonar heard nothing"),
            (
                &mut self.path,
                "Path",
                "Where the robot has been since this window looks",
            ),
            (
                &mut self.targets,
                "Targets",
                "Where it is to go: targets and routes of its schemas",
            ),
            (&mut self.cameras, "Cameras", "What each camera sees, before it"),
            (
                &mut self.walls,
                "Walls",
                "What stands in the world, where a simulator tells it",
            ),
            (
                &mut self.tall,
                "Full height",
                "Walls and furniture as tall as they are, not cut off",
            ),
            (
                &mut self.movers,
                "Movers",
                "Who and what moves in the world, where a simulator tells it",
            ),
            (
                &mut self.panels,
                "Panels' shapes",
                "What the panels of schemas draw in space",
            ),
            (&mut self.labels, "Names", "Names and distances"),
        ]
    }
}
