//! The text of a world file with boxes and groups of equal circles. It decides nothing.

use std::collections::BTreeMap;
use std::fmt::Write as _;

/// A world to write.
#[derive(Debug, Default)]
pub(super) struct Draft {
    pub(super) boxes: Vec<DraftBox>,
    /// The centres of circles of one radius and height, in micrometres.
    pub(super) circles: BTreeMap<(i64, i64), Vec<[f64; 2]>>,
    /// Where a robot called `robot` starts: m, m, degrees.
    pub(super) start: Option<[f64; 3]>,
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
        self.boxes.is_empty() && self.circles.is_empty()
    }

    /// Returns the text. `comment` is its first line.
    pub(super) fn write(&self, comment: &str, name: &str) -> String {
        let mut text = format!("# {comment}\nname = {}\n", quoted(name));
        if let Some([x, y, heading]) = self.start {
            let [x, y, heading] = [x, y, heading].map(number);
            text += &format!("\n[robots.robot]\nstart = {{ x = {x}, y = {y}, heading_deg = {heading} }}\n");
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

/// Returns a name as a text of TOML. World files refuse an empty one.
fn quoted(name: &str) -> String {
    let visible: String = name.chars().filter(|letter| !letter.is_control()).collect();
    let visible = Some(visible.trim())
        .filter(|name| !name.is_empty())
        .unwrap_or("unnamed");
    format!("\"{}\"", visible.replace('\\', "\\\\").replace('"', "\\\""))
}
