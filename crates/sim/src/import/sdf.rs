//! Worlds in SDF, the format of Gazebo: the boxes, cylinders and spheres of the models of a world, seen from
//! above (specification of SDFormat 1.10, `world`, `model`, `link`, `collision`, `geometry`).
//!
//! It fetches no model from elsewhere, and it converts no mesh.

use jde_files::LeftOut;
use roxmltree::{Document, Node};

use super::pose::Pose;
use super::writer::{Draft, DraftBox};
use super::{Faults, ImportedWorld, OVERHEAD};

/// The least height of a thing, m: less is a mark on the floor.
const FLAT: f64 = 0.005;
/// The greatest tilt that counts as upright, rad: the rounding of saved states.
const UPRIGHT: f64 = 1e-3;

#[derive(Default)]
struct Reader {
    draft: Draft,
    notes: Vec<String>,
    faults: Faults,
}

pub(super) fn read(text: &str, stem: String) -> Result<ImportedWorld, Faults> {
    let document =
        Document::parse(text).map_err(|error| vec![(error.pos().row as usize, error.to_string())])?;
    let root = document.root_element();
    if !root.has_tag_name("sdf") && !root.has_tag_name("gazebo") {
        let message = format!("`{}` is no SDF: expected <sdf>", root.tag_name().name());
        return Err(vec![(line(root), message)]);
    }
    let world = child(root, "world").unwrap_or(root);
    let mut reader = Reader::default();
    reader.models(world, Pose::ORIGIN, child(world, "state"), "");
    let name = world.attribute("name").unwrap_or(&stem).to_owned();
    if reader.faults.is_empty() && reader.draft.is_empty() {
        let message = "has no box, cylinder or sphere that stands on the floor";
        reader.faults.push((line(world), message.to_owned()));
    }
    if !reader.faults.is_empty() {
        return Err(reader.faults);
    }
    let comment = format!("Converted from the SDF world {name}. Metres, degrees.");
    Ok(ImportedWorld {
        text: reader.draft.write(&comment.replace(char::is_control, " "), &name),
        files: Vec::new(),
        left_out: LeftOut::default(),
        notes: reader.notes,
        name: stem,
    })
}

impl Reader {
    /// Reads the models of a world or a model. `state` has the poses that a saved world has instead.
    fn models(&mut self, parent: Node<'_, '_>, frame: Pose, state: Option<Node<'_, '_>>, prefix: &str) {
        for include in children(parent, "include") {
            let uri = child(include, "uri").and_then(|uri| uri.text()).unwrap_or("?");
            self.notes
                .push(format!("{} is another file and is left out.", uri.trim()));
        }
        for model in children(parent, "model") {
            let own = model.attribute("name").unwrap_or("model");
            let name = format!("{prefix}{own}");
            let saved = state.and_then(|state| {
                children(state, "model").find(|saved| saved.attribute("name") == Some(own))
            });
            let placed = saved
                .filter(|saved| child(*saved, "pose").is_some())
                .unwrap_or(model);
            let Some(pose) = self.pose(placed, &name) else {
                continue;
            };
            let pose = frame.compose(pose);
            self.models(model, pose, saved, &format!("{name}::"));
            for link in children(model, "link") {
                let Some(link_pose) = self.pose(link, &name) else {
                    continue;
                };
                for collision in children(link, "collision") {
                    if let Some(at) = self.pose(collision, &name) {
                        self.collision(collision, pose.compose(link_pose).compose(at), &name);
                    }
                }
            }
        }
    }

    fn collision(&mut self, collision: Node<'_, '_>, pose: Pose, name: &str) {
        let Some(geometry) = child(collision, "geometry") else {
            return;
        };
        for shape in geometry.children().filter(Node::is_element) {
            let side = |key, count| child(shape, key).map(|node| self.sizes(node, count, name));
            let kind = shape.tag_name().name();
            let sizes = match kind {
                "box" => side("size", 3),
                "sphere" => side("radius", 1),
                "cylinder" => side("radius", 1)
                    .zip(side("length", 1))
                    .map(|(radius, length)| Ok([radius?, length?].concat())),
                // A floor, or nothing.
                "plane" | "empty" => continue,
                _ => {
                    self.notes
                        .push(format!("`{name}` has a {kind}, which is left out."));
                    continue;
                }
            };
            let fault = |message| (line(shape), message);
            match sizes.unwrap_or_else(|| Err(fault(format!("the {kind} of `{name}` has no size")))) {
                Ok(sizes) => self.add(kind, &sizes, pose, name),
                Err(fault) => self.faults.push(fault),
            }
        }
    }

    /// Adds a box, a cylinder or a sphere with its sizes.
    fn add(&mut self, kind: &str, sizes: &[f64], pose: Pose, name: &str) {
        let half = match *sizes {
            [_, _, height] => height / 2.0,
            [_, length] => length / 2.0,
            [radius] => radius,
            _ => return,
        };
        let (bottom, top) = (pose.z - half, pose.z + half);
        if bottom > OVERHEAD {
            self.notes.push(format!(
                "a {kind} of `{name}` is {bottom:.2} m above the floor and is left out."
            ));
        } else if top > FLAT {
            let center = [pose.x, pose.y];
            match *sizes {
                [x, y, _] => self.draft.boxes.push(DraftBox {
                    name: name.to_owned(),
                    center,
                    size: [x, y],
                    angle: pose.yaw.to_degrees(),
                    height: top,
                }),
                [radius, ..] => self.draft.add_circle(center, radius, top),
                [] => {}
            }
        }
    }

    /// Returns lengths above 0.
    fn sizes(&self, node: Node<'_, '_>, count: usize, name: &str) -> Result<Vec<f64>, (usize, String)> {
        numbers(node)
            .filter(|numbers| numbers.len() == count && numbers.iter().all(|length| *length > 0.0))
            .ok_or_else(|| {
                let tag = node.tag_name().name();
                let message = format!("the {tag} of `{name}` is wrong: expected {count} above 0, in metres");
                (line(node), message)
            })
    }

    /// Returns the pose of a model, a link or a collision; `None` if it is left out.
    fn pose(&mut self, node: Node<'_, '_>, name: &str) -> Option<Pose> {
        let Some(pose) = child(node, "pose") else {
            return Some(Pose::ORIGIN);
        };
        let frame = pose.attribute("relative_to").filter(|frame| !frame.is_empty());
        let in_degrees = pose.attribute("degrees") == Some("true");
        let angle = |value: f64| if in_degrees { value.to_radians() } else { value };
        match numbers(pose).as_deref() {
            _ if frame.is_some() => {
                let frame = frame.unwrap_or_default();
                self.notes.push(format!(
                    "`{name}` has a pose relative to `{frame}` and is left out."
                ));
                None
            }
            Some([]) => Some(Pose::ORIGIN),
            Some(&[x, y, z, roll, pitch, yaw]) => {
                if angle(roll).abs().max(angle(pitch).abs()) > UPRIGHT {
                    self.notes.push(format!("`{name}` is tilted and is left out."));
                    return None;
                }
                let yaw = angle(yaw);
                Some(Pose { x, y, z, yaw })
            }
            _ => {
                let message = format!("the pose of `{name}` is wrong: expected x y z roll pitch yaw");
                self.faults.push((line(pose), message));
                None
            }
        }
    }
}

fn children<'a, 'i>(node: Node<'a, 'i>, tag: &str) -> impl Iterator<Item = Node<'a, 'i>> {
    node.children().filter(move |child| child.has_tag_name(tag))
}

fn child<'a, 'i>(node: Node<'a, 'i>, tag: &str) -> Option<Node<'a, 'i>> {
    children(node, tag).next()
}

/// Returns the finite numbers of a text; `None` if a word is none.
fn numbers(node: Node<'_, '_>) -> Option<Vec<f64>> {
    let words = node.text().unwrap_or_default().split_whitespace();
    words
        .map(|word| word.parse().ok().filter(|value: &f64| value.is_finite()))
        .collect()
}

fn line(node: Node<'_, '_>) -> usize {
    node.document().text_pos_at(node.range().start).row as usize
}
