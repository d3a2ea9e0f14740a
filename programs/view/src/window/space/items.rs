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
            (&mut self.grid, "Grid", "The floor with a grid of about one metre"),
            (
                &mut self.axes,
                "Axes",
                "The origin of the odometry: x ahead, y left, z up",
            ),
            (&mut self.robot, "Robot", "The pose by odometry"),
            (
                &mut self.laser,
                "Laser",
                "The hit of each beam and the free area in front of it",
            ),
            (&mut self.sonars, "Sonars", "The free distance of each sonar"),
            (
                &mut self.path,
                "Path",
                "The path of the robot since the window was opened",
            ),
            (
                &mut self.targets,
                "Targets",
                "The targets and routes of its schemas",
            ),
            (
                &mut self.cameras,
                "Cameras",
                "The image of each camera, in front of it",
            ),
            (&mut self.walls, "Walls", "The fixed things of a simulated world"),
            (
                &mut self.tall,
                "Full height",
                "Walls and furniture in full height, not cut off",
            ),
            (
                &mut self.movers,
                "Movers",
                "The people and things that move in a simulated world",
            ),
            (
                &mut self.panels,
                "Panels' shapes",
                "The shapes that panels of schemas draw in space",
            ),
            (&mut self.labels, "Names", "Names and distances"),
        ]
    }
}
