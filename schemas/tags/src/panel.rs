//! The panel: the live picture with the outlines of the tags, and a table of them.

use jde_schema::prelude::*;
use jde_schema::types::TagDetection;

use crate::Tags;

/// Green; the lower side, from the first corner to the second, is red.
const SIDES: [[u8; 3]; 4] = [[255, 40, 40], [40, 255, 40], [40, 255, 40], [40, 255, 40]];

impl Panel for Tags {
    fn draw(&self, cx: &Context, pen: &mut Pen) {
        let Some(image) = self.image.get(cx) else {
            pen.text("No picture");
            return;
        };
        let mut shown = Box::new(*image.value());
        self.found.iter().for_each(|tag| outline(&mut shown, tag));
        pen.image("picture", &shown);
        pen.table(
            "tags",
            ["tag", "distance, m", "margin", "error, px", "ambiguity"],
            self.found.iter().map(cells),
        );
    }
}

fn cells(tag: &TagDetection) -> [String; 5] {
    let [x, y, z] = [tag.pose.position.x, tag.pose.position.y, tag.pose.position.z];
    [
        tag.id.to_string(),
        format!("{:.2}", (x * x + y * y + z * z).sqrt()),
        format!("{:.0}", tag.margin),
        format!("{:.2}", tag.error),
        format!("{:.2}", tag.ambiguity),
    ]
}

/// Draws the sides of a tag, two pixels wide.
fn outline(image: &mut Image, tag: &TagDetection) {
    let (corners, _) = tag.corners.as_chunks::<2>();
    for (index, color) in SIDES.iter().enumerate() {
        let (from, to) = (corners[index], corners[(index + 1) % 4]);
        let along = [to[0] - from[0], to[1] - from[1]];
        let steps = along[0].abs().max(along[1].abs()).ceil().max(1.0);
        for step in 0..=steps as usize {
            let [x, y] = [0, 1].map(|axis| from[axis] + along[axis] * step as f64 / steps);
            for [right, down] in [[-1.0, -1.0], [0.0, -1.0], [-1.0, 0.0], [0.0, 0.0]] {
                paint(image, [x + right, y + down], *color);
            }
        }
    }
}

/// Sets the pixel at a place, if the picture has it. The corners lie in the picture, up to rounding.
fn paint(image: &mut Image, [x, y]: [f64; 2], [r, g, b]: [u8; 3]) {
    let color: &[u8] = match image.encoding.as_str() {
        "rgb8" => &[r, g, b],
        "bgr8" => &[b, g, r],
        // The outline of a tag in grey is white.
        _ => &[u8::MAX],
    };
    let (width, step) = (image.width as usize, image.step as usize);
    let [column, row] = [x, y].map(|part| part.max(0.0) as usize);
    if column < width
        && let Some(pixel) = image
            .data
            .as_mut_slice()
            .get_mut(row * step + column * color.len()..)
        && pixel.len() >= color.len()
    {
        pixel[..color.len()].copy_from_slice(color);
    }
}
