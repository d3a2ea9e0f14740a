//! The collisions of a world, drawn where their frames put them.

use jde_document::Fault;

use super::super::writer::{DraftBox, DraftWall};
use super::pose3::Pose3;
use super::shapes::{FAR, Plan, Primitive};
use super::xml::Node;
use super::{SdfReader, Solid, unused, values};

impl SdfReader<'_> {
    /// Places a collision in the world.
    pub(super) fn place(&mut self, solid: &Solid) -> Result<(), Fault> {
        let Solid { node, stated, .. } = solid;
        let base = match stated.relative_to.as_str() {
            "" => self.frames.pose(solid.link),
            frame => self.frames.named(solid.scope, frame),
        };
        let pose =
            base.and_then(|base| Ok(self.frames.scope(solid.scope)?.compose(base).compose(stated.pose)));
        let pose = match pose {
            Ok(pose) => pose,
            Err(reason) => {
                self.leave(node, format_args!("`{}`", solid.name), reason);
                return Ok(());
            }
        };
        for part in node.children() {
            self.work(&part)?;
            match part.name() {
                "geometry" => {
                    for shape in part.children() {
                        self.shape(&shape, pose, solid)?;
                    }
                }
                "pose" => {}
                _ => self.leave_unused(&part),
            }
        }
        Ok(())
    }

    fn shape(&mut self, node: &Node, pose: Pose3, solid: &Solid) -> Result<(), Fault> {
        let name = &solid.name;
        let read = match node.name() {
            "box" => self.size(node, "size", [1.0; 3], name).map(Primitive::Box),
            "sphere" => self
                .size(node, "radius", [1.0], name)
                .map(|[radius]| Primitive::Sphere(radius)),
            "ellipsoid" => self.size(node, "radii", [1.0; 3], name).map(Primitive::Ellipsoid),
            "cylinder" | "capsule" | "cone" => {
                let default = if node.name() == "cylinder" { 1.0 } else { 0.5 };
                let length = self.size(node, "length", [1.0], name);
                self.size(node, "radius", [default], name)
                    .zip(length)
                    .map(|([radius], [length])| match node.name() {
                        "cylinder" => Primitive::Cylinder { radius, length },
                        "capsule" => Primitive::Capsule { radius, length },
                        _ => Primitive::Cone { radius, length },
                    })
            }
            "polyline" => self.polyline(node, name)?,
            "empty" => None,
            "plane" => {
                let normal = node.child("normal").and_then(|node| values::numbers(&node));
                let up = pose.turned(normal.unwrap_or([0.0, 0.0, 1.0]))[2];
                // A plane that is level is the floor.
                let length = normal.map_or(1.0, |[x, y, z]: [f64; 3]| libm::hypot(libm::hypot(x, y), z));
                if up < 0.99 * length {
                    self.leave(node, format_args!("a plane of `{name}`"), "it is not level");
                }
                None
            }
            kind => {
                let reason = unused::shape(kind);
                let [x, y, _] = pose.at;
                if x.abs().max(y.abs()) < FAR {
                    self.marks.push([x, y]);
                }
                self.leave(node, format_args!("a {kind} of `{name}`"), reason);
                None
            }
        };
        let Some(shape) = read else { return Ok(()) };
        match shape.seen(pose) {
            Ok((plan, height)) => {
                if !solid.is_static {
                    self.movable.add(name);
                }
                self.draw(node, plan, height, name)?;
            }
            Err(reason) => self.leave(node, format_args!("a {} of `{name}`", node.name()), reason),
        }
        Ok(())
    }

    fn draw(&mut self, node: &Node, plan: Plan, height: f64, name: &str) -> Result<(), Fault> {
        let points = match &plan {
            Plan::Outline(points) => points.len(),
            Plan::Box { .. } | Plan::Circle { .. } => 1,
        };
        let held = self.budget.hold(size_of::<DraftBox>() + name.len() + 64 * points);
        held.map_err(|error| self.fault(&node.place(), error))?;
        let name = name.to_owned();
        match plan {
            Plan::Box { center, size, angle } => self.draft.boxes.push(DraftBox {
                name,
                center,
                size,
                angle: angle.to_degrees(),
                height,
            }),
            Plan::Circle { center, radius } => self.draft.add_circle(center, radius, height),
            Plan::Outline(points) => {
                if node.name() != "polyline" {
                    self.tilted.add(&name);
                }
                self.draft.walls.push(DraftWall { name, points, height });
            }
        }
        Ok(())
    }

    /// Returns the sizes of a shape, or what libsdformat takes instead of one that is missing.
    fn size<const COUNT: usize>(
        &mut self,
        node: &Node,
        key: &str,
        default: [f64; COUNT],
        name: &str,
    ) -> Option<[f64; COUNT]> {
        let Some(size) = node.child(key) else {
            let meters = default.map(|length| length.to_string()).join(" x ");
            self.notes.push(format!(
                "A {} of `{name}` has no {key} ({}): {meters} m is taken, as SDF states.",
                node.name(),
                node.place()
            ));
            return Some(default);
        };
        let numbers = values::numbers(&size);
        if numbers.is_none() {
            let message = format!("the {key} of `{name}` is wrong: expected {COUNT} numbers, in metres");
            let fault = self.fault(&size.place(), message);
            self.faults.push(fault);
        }
        numbers
    }

    fn polyline(&mut self, node: &Node, name: &str) -> Result<Option<Primitive>, Fault> {
        let mut points = Vec::new();
        for point in node.children_named("point") {
            self.work(&point)?;
            match values::numbers(&point) {
                Some(numbers) => points.push(numbers),
                None => {
                    let message = format!("a point of `{name}` is wrong: expected x y");
                    let fault = self.fault(&point.place(), message);
                    self.faults.push(fault);
                    return Ok(None);
                }
            }
        }
        let height = self.size(node, "height", [1.0], name);
        Ok(height.map(|[height]| Primitive::Prism { points, height }))
    }
}
