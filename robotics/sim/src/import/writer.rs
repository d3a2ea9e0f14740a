//! The text of a world file with boxes, outlines and groups of equal circles. It decides nothing.

use std::collections::BTreeMap;
use std::fmt::Write as _;

/// A world to write.
#[derive(Debug, Default)]
pub(super) struct Draft {
    pub(super) boxes: Vec<DraftBox>,
    /// The centres of circles of one radius and height, in micrometres.
    pub(super) circles: BTreeMap<(i64, i64), Vec<[f64; 2]>>,
    /// Closed outlines.
    pub(super) walls: Vec<DraftWall>,
    /// The file of a map.
    pub(super) map: Option<String>,
    /// The least and the greatest coordinates that robots may have.
    pub(super) bounds: Option<[[f64; 2]; 2]>,
    /// The robots, and where they start: m, m, degrees.
    pub(super) starts: Vec<(String, [f64; 3])>,
}

/// A box of a world to write.
#[derive(Debug)]
pub(super) struct DraftBox {
    pub(super) name: String,
    pub(super) center: [f64; 2],
    pub(super) size: [f64; 2],
    /// Degrees.
    pub(super) angle: f64,
    pub(super) height: f64,
}

/// An outline of a world to write.
#[derive(Debug)]
pub(super) struct DraftWall {
    pub(super) name: String,
    pub(super) points: Vec<[f64; 2]>,
    pub(super) height: f64,
}

/// Micrometres in a metre: the resolution of what is written.
const RESOLUTION: f64 = 1e6;
/// Centres on one line.
const PER_LINE: usize = 6;

impl Draft {
    pub(super) fn add_circle(&mut self, center: [f64; 2], radius: f64, height: f64) {
        let [radius, height] = [radius, height].map(|length| (length * RESOLUTION).round() as i64);
        self.circles.entry((radius, height)).or_default().push(center);
    }

    pub(super) fn is_empty(&self) -> bool {
        self.boxes.is_empty() && self.circles.is_empty() && self.walls.is_empty() && self.map.is_none()
    }

    /// Returns points around which everything is: the corners of boxes and outlines, and of squares around circles.
    pub(super) fn points(&self) -> impl Iterator<Item = [f64; 2]> {
        let square = |[x, y]: [f64; 2], half: f64| [[x - half, y - half], [x + half, y + half]];
        let boxes = self.boxes.iter().flat_map(move |block| {
            let (sin, cos) = libm::sincos(block.angle.to_radians());
            let [along, across] = block.size.map(|side| side / 2.0);
            let half = [
                (along * cos).abs() + (across * sin).abs(),
                (along * sin).abs() + (across * cos).abs(),
            ];
            let [x, y] = block.center;
            [[x - half[0], y - half[1]], [x + half[0], y + half[1]]]
        });
        let circles = self.circles.iter().flat_map(move |(&(radius, _), centers)| {
            centers
                .iter()
                .flat_map(move |center| square(*center, radius as f64 / RESOLUTION))
        });
        let walls = self.walls.iter().flat_map(|wall| wall.points.iter().copied());
        boxes.chain(circles).chain(walls)
    }

    /// Returns the text. `comment` is its first line.
    pub(super) fn write(&self, comment: &str, name: &str) -> String {
        let mut text = format!("# {comment}\nname = {}\n", quoted(name));
        if let Some(map) = &self.map {
            text += &format!("map = {}\n", quoted(map));
        }
        if let Some([min, max]) = &self.bounds {
            text += &format!("bounds = {{ min = {}, max = {} }}\n", pair(min), pair(max));
        }
        for (name, start) in &self.starts {
            let (name, [x, y, heading]) = (key(name), start.map(number));
            text += &format!("\n[robots.{name}]\nstart = {{ x = {x}, y = {y}, heading_deg = {heading} }}\n");
        }
        for DraftWall { name, points, height } in &self.walls {
            let (name, height) = (quoted(name), number(*height));
            let points: Vec<_> = points.iter().map(pair).collect();
            let points = points.join(", ");
            text += &format!(
                "\n[[walls]]\nname = {name}\npoints = [{points}]\nclosed = true\nheight = {height}\n"
            );
        }
        for DraftBox {
            name,
            center,
            size,
            angle,
            height,
        } in &self.boxes
        {
            let (name, angle, height) = (quoted(name), number(*angle), number(*height));
            let (center, size) = (pair(center), pair(size));
            text += &format!("\n[[boxes]]\nname = {name}\ncenter = {center}\nsize = {size}\n");
            text += &format!("angle_deg = {angle}\nheight = {height}\n");
        }
        for (&(radius, height), centers) in &self.circles {
            let [radius, height] = [radius, height].map(|length| number(length as f64 / RESOLUTION));
            text += &format!("\n[[circles]]\nradius = {radius}\nheight = {height}\ncenters = [\n");
            for line in centers.chunks(PER_LINE) {
                let points: Vec<_> = line.iter().map(pair).collect();
                // Writing to a string never fails.
                let _ = writeln!(text, "  {},", points.join(", "));
            }
            text += "]\n";
        }
        text
    }
}

/// Returns a number to the micrometre or microdegree, without zeros at its end.
fn number(value: f64) -> String {
    let rounded = (value * RESOLUTION).round() / RESOLUTION;
    // A zero has no sign.
    format!("{}", rounded + 0.0)
}

fn pair([x, y]: &[f64; 2]) -> String {
    format!("[{}, {}]", number(*x), number(*y))
}

/// Returns a name as a key of TOML.
fn key(name: &str) -> String {
    let is_bare = |letter: char| letter.is_ascii_alphanumeric() || matches!(letter, '_' | '-');
    if !name.is_empty() && name.chars().all(is_bare) {
        name.to_owned()
    } else {
        quoted(name)
    }
}

/// Returns a name as a text of TOML. World files refuse an empty one.
fn quoted(name: &str) -> String {
    let visible: String = name.chars().filter(|letter| !letter.is_control()).collect();
    let visible = Some(visible.trim())
        .filter(|name| !name.is_empty())
        .unwrap_or("unnamed");
    format!("\"{}\"", visible.replace('\\', "\\\\").replace('"', "\\\""))
}
