//! Writes the ROS map of a world: what stands still is occupied at its outline and unknown within, all else is free.
//!
//! `cargo run -p jde-sim --example map -- worlds/office.toml worlds/map/office 0.05` writes `office.yaml` and
//! `office.png` with cells of 5 cm. Whole numbers of cells in the world are the middles of cells of the map.

use std::error::Error;
use std::fs::File;
use std::io::BufWriter;

use jde_sim::{Outline, Pose2, World};

/// The shades of ROS's map server.
const OCCUPIED: u8 = 0;
const UNKNOWN: u8 = 205;
const FREE: u8 = 254;
/// The cells of a map of 200 x 200 m at 5 cm.
const MOST_CELLS: usize = 16_000_000;
/// The free cells around the bounds of the world.
const BORDER: f64 = 4.0;

struct Map {
    origin: [f64; 2],
    cell: f64,
    width: usize,
    shades: Vec<u8>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [world_file, stem, cell] = arguments.as_slice() else {
        return Err("map WORLD STEM RESOLUTION".into());
    };
    let world = World::load(world_file, 1)?;
    let map = Map::new(&world, cell.parse()?)
        .ok_or_else(|| format!("{cell} m is not a resolution: the map must have 1 to {MOST_CELLS} cells"))?;
    let height = map.shades.len() / map.width;
    let file = BufWriter::new(File::create(format!("{stem}.png"))?);
    let mut png = png::Encoder::new(file, map.width as u32, height as u32);
    png.set_color(png::ColorType::Grayscale);
    // The image begins at the top, the map at the bottom.
    let rows: Vec<u8> = map
        .shades
        .chunks_exact(map.width)
        .rev()
        .flatten()
        .copied()
        .collect();
    png.write_header()?.write_image_data(&rows)?;
    let name = std::path::Path::new(stem).file_name().ok_or("no name")?.display();
    let [x, y] = map.origin;
    let text = format!(
        "# The world `{}`, {} m a cell, by the example `map` of jde-sim.\nimage: {name}.png\nmode: trinary\nresolution: {}\n\
         origin: [{x:.4}, {y:.4}, 0.0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n",
        world.name(),
        map.cell,
        map.cell
    );
    std::fs::write(format!("{stem}.yaml"), text)?;
    Ok(())
}

impl Map {
    /// Returns `None` if the cells have no size, or are too many.
    fn new(world: &World, cell: f64) -> Option<Self> {
        let bounds = world.bounds();
        let side =
            |axis: usize| ((bounds.max[axis] - bounds.min[axis]) / cell + 2.0 * BORDER + 1.0).ceil() as usize;
        let cells = side(0).saturating_mul(side(1));
        if !cell.is_normal() || cell < 0.0 || cells > MOST_CELLS {
            return None;
        }
        let mut map = Self {
            origin: bounds.min.map(|least| least - (BORDER + 0.5) * cell),
            cell,
            width: side(0),
            shades: vec![FREE; cells],
        };
        let shapes = || world.shapes().filter(|shape| !shape.moving);
        for shape in shapes() {
            map.fill(&shape.outline);
        }
        for shape in shapes() {
            map.trace(&shape.outline);
        }
        Some(map)
    }

    /// What is within is unknown.
    fn fill(&mut self, outline: &Outline) {
        let (pose, size) = outline.placed();
        for index in 0..self.shades.len() {
            let at = |number: usize, axis: usize| self.origin[axis] + (number as f64 + 0.5) * self.cell;
            let (dx, dy) = (
                at(index % self.width, 0) - pose.x,
                at(index / self.width, 1) - pose.y,
            );
            let (sin, cos) = pose.heading.sin_cos();
            let (along, across) = (cos * dx + sin * dy, cos * dy - sin * dx);
            let is_within = match *outline {
                Outline::Circle { radius, .. } => along.hypot(across) < radius,
                Outline::Box { .. } | Outline::Segment { .. } => {
                    along.abs() < size[0] / 2.0 && across.abs() < size[1] / 2.0
                }
            };
            if is_within {
                self.shades[index] = UNKNOWN;
            }
        }
    }

    /// What the outline passes is occupied.
    fn trace(&mut self, outline: &Outline) {
        let (pose, size) = outline.placed();
        let half = size.map(|side| side / 2.0);
        match *outline {
            Outline::Circle { radius, .. } => {
                let steps = (8.0 * core::f64::consts::TAU * radius / self.cell).ceil();
                for step in 0..steps as usize {
                    let (sin, cos) = (core::f64::consts::TAU * step as f64 / steps).sin_cos();
                    self.occupy(pose, [radius * cos, radius * sin]);
                }
            }
            Outline::Box { .. } | Outline::Segment { .. } => {
                for axis in 0..2 {
                    let steps = (8.0 * size[axis] / self.cell).ceil().max(1.0);
                    for step in 0..=steps as usize {
                        for side in [-1.0, 1.0] {
                            let mut place = half.map(|half| side * half);
                            place[axis] = half[axis] * (2.0 * step as f64 / steps - 1.0);
                            self.occupy(pose, place);
                        }
                    }
                }
            }
        }
    }

    fn occupy(&mut self, pose: Pose2, [along, across]: [f64; 2]) {
        let place = pose.compose(Pose2::new(along, across, 0.0));
        let cell = |at: f64, axis: usize| ((at - self.origin[axis]) / self.cell).floor();
        let (column, row) = (cell(place.x, 0), cell(place.y, 1));
        // Nothing is outside the bounds but what a file states outside of them.
        if (0.0..self.width as f64).contains(&column)
            && row >= 0.0
            && let Some(shade) = self.shades.get_mut(row as usize * self.width + column as usize)
        {
            *shade = OCCUPIED;
        }
    }
}
