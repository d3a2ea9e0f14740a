//! The appearance of people and robots.
//!
//! Only pictures contain these parts: no other sensor detects them. Windows draw figures of their own
//! (`window/space/figures.rs` of `programs/view`).

use super::renderer::Renderer;
use crate::color::Color;
use crate::config::RobotConfig;
use crate::footprint::Footprint;
use crate::geometry::Pose2;
use crate::person::Person;
use crate::shape::Outline;

const SKIN: Color = Color::new(222, 178, 146);
const HAIR: Color = Color::new(66, 48, 38);
const TROUSERS: Color = Color::new(58, 62, 76);
const SHELL: Color = Color::new(200, 34, 30);
const DARK_PARTS: Color = Color::new(38, 40, 44);
const LASER: Color = Color::new(70, 96, 150);
const LENS: Color = Color::new(205, 206, 210);

impl Renderer<'_> {
    /// Adds a person: swinging legs and arms, the body in the clothing, the head.
    pub(crate) fn add_person(&mut self, person: &Person) {
        let Person {
            pose,
            stride,
            radius,
            height,
            color,
            raises,
            ..
        } = *person;
        let (feet, leg) = person.feet();
        let (hip, shoulder) = (0.48 * height, 0.83 * height);
        for center in feet {
            self.add_outline(Outline::Circle { center, radius: leg }, [0.0, hip], TROUSERS);
        }
        self.add_outline(disc(pose, [0.0, 0.0], 0.62 * radius), [hip, shoulder], color);
        for side in [1.0, -1.0] {
            // An arm swings with the leg of the other side.
            let at = [-side * stride * 0.3 * radius, side * 0.8 * radius];
            self.add_outline(
                disc(pose, at, 0.19 * radius),
                [0.46 * height, 0.81 * height],
                color,
            );
        }
        // A ball in either hand, so that one is seen from every side.
        if let Some(signal) = raises {
            for side in [1.0, -1.0] {
                let at = pose.compose(Pose2::new(0.0, side * 1.3 * radius, 0.0));
                self.add_ball([at.x, at.y, 0.62 * height], 0.06 * height, signal);
            }
        }
        self.add_outline(
            disc(pose, [0.0, 0.0], 0.22 * radius),
            [shoulder, 0.88 * height],
            SKIN,
        );
        let skull = 0.066 * height;
        let part = |ahead: f64, up: f64| {
            let at = pose.compose(Pose2::new(ahead, 0.0, 0.0));
            [at.x, at.y, 0.93 * height + up]
        };
        self.add_ball(part(0.0, 0.0), skull, SKIN);
        self.add_ball(part(-0.22 * skull, 0.12 * skull), 0.98 * skull, HAIR);
    }

    /// Adds a robot: a red shell on dark wheels under a dark plate, with its laser ahead and its head on top.
    pub(crate) fn add_robot(&mut self, pose: Pose2, config: &RobotConfig) {
        let radius = config.footprint.radius();
        match config.footprint {
            Footprint::Circle { .. } => {
                self.add_outline(disc(pose, [0.0, 0.0], 0.8 * radius), [0.0, 0.06], DARK_PARTS);
                self.add_outline(disc(pose, [0.0, 0.0], radius), [0.06, 0.22], SHELL);
                self.add_outline(disc(pose, [0.0, 0.0], 0.97 * radius), [0.22, 0.24], DARK_PARTS);
            }
            Footprint::Polygon(_) => {
                let corners = config.footprint.corners().map(|[x, y]| {
                    let corner = pose.compose(Pose2::new(x, y, 0.0));
                    [corner.x, corner.y]
                });
                self.add_prism(&Vec::from_iter(corners), [0.0, 0.24], SHELL);
            }
        }
        let laser = pose.compose(Pose2::new(0.5 * radius, 0.0, 0.0));
        let block = Outline::Box {
            center: [laser.x, laser.y],
            size: [0.6 * radius, 0.6 * radius],
            angle: pose.heading,
        };
        self.add_outline(block, [0.24, 0.24 + 0.7 * radius], LASER);
        let [x, y, z] = config.head.mount;
        self.add_outline(disc(pose, [x, y], 0.18 * radius), [0.24, z], DARK_PARTS);
        let head = pose.compose(Pose2::new(x, y, 0.0));
        self.add_ball([head.x, head.y, z], 0.24 * radius, LENS);
    }
}

fn disc(pose: Pose2, [ahead, left]: [f64; 2], radius: f64) -> Outline {
    let at = pose.compose(Pose2::new(ahead, left, 0.0));
    Outline::Circle {
        center: [at.x, at.y],
        radius,
    }
}
