//! Edges between pixels: the sides of a quadrilateral, where the picture itself changes most.

use crate::line::{FittedLine, Moments, corners};
use crate::{Gray, Point};

/// Moves the corners of a quadrilateral, bright around dark and clockwise in the picture, onto the edges that are
/// within `reach` px of its sides. Keeps those between sides without an edge.
pub(crate) fn refine(picture: &Gray<'_>, quad: &mut [Point; 4], reach: f64) {
    let mut sides = [FittedLine::default(); 4];
    for (index, side) in sides.iter_mut().enumerate() {
        match edge(picture, [quad[index], quad[(index + 1) % 4]], reach) {
            Some(line) => *side = line,
            None => return,
        }
    }
    if let Some([second, third, fourth, first]) = corners(&sides) {
        *quad = [first, second, third, fourth];
    }
}

/// Returns the line along the edge near a side.
fn edge(picture: &Gray<'_>, [from, to]: [Point; 2], reach: f64) -> Option<FittedLine> {
    /// Steps across the side in each pixel.
    const STEPS: f64 = 4.0;
    /// How far apart two values of a difference are, px: twice this.
    const HALF: f64 = 1.0;
    let along = [to[0] - from[0], to[1] - from[1]];
    let length = (along[0] * along[0] + along[1] * along[1]).sqrt();
    let outward = [along[1] / length, -along[0] / length];
    let samples = (length / 8.0).max(16.0) as usize;
    let mut moments = Moments::default();
    let mut found = 0;
    for sample in 0..samples {
        let part = (sample + 1) as f64 / (samples + 1) as f64;
        let base = [0, 1].map(|axis| from[axis] + part * along[axis]);
        let at = |offset: f64| [0, 1].map(|axis| base[axis] + offset * outward[axis]);
        let (mut sum, mut weights) = (0.0, 0.0);
        let steps = (reach * STEPS) as i32;
        for step in -steps..=steps {
            let offset = f64::from(step) / STEPS;
            let values = [offset + HALF, offset - HALF].map(|offset| picture.between(at(offset)));
            let [Some(outside), Some(inside)] = values else {
                continue;
            };
            // A change the other way is a different edge.
            let change = (outside - inside).max(0.0);
            sum += change * change * offset;
            weights += change * change;
        }
        if weights > 0.0 {
            moments.add(at(sum / weights), 1.0);
            found += 1;
        }
    }
    (found >= 2).then(|| moments.line())
}
