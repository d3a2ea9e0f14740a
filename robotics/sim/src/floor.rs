//! The floor: its colour, and what is painted on it, the later over the earlier.
//!
//! Cameras and line sensors see it. Paint has no thickness and stops nothing.

use parry2d_f64::bounding_volume::Aabb;
use parry2d_f64::math::Vector;
use parry2d_f64::partitioning::{Bvh, BvhBuildStrategy};
use parry2d_f64::query::PointQuery;
use parry2d_f64::shape::Segment;

use crate::color::Color;
use crate::shape::{Figure, Outline, Shape};

/// The height that a painted shape has for each layer below it and itself, in metres: it only tells which
/// covers the other.
const LAYER: f64 = 0.001;

/// The floor of a world.
#[derive(Debug)]
pub(crate) struct Floor {
    pub(crate) color: Color,
    pub(crate) paints: Vec<Paint>,
}

/// One painted thing.
#[derive(Debug)]
pub(crate) struct Paint {
    pub(crate) name: String,
    pub(crate) color: Color,
    pub(crate) form: PaintForm,
}

/// What is painted.
#[derive(Debug)]
pub(crate) enum PaintForm {
    Line(PaintedLine),
    Area(PaintedArea),
}

/// A line with round joins and ends.
#[derive(Debug)]
pub(crate) struct PaintedLine {
    legs: Vec<Segment>,
    tree: Bvh,
    /// Metres.
    width: f64,
}

/// A rectangle of one colour, or of square tiles of two.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PaintedArea {
    pub(crate) center: [f64; 2],
    pub(crate) size: [f64; 2],
    /// Radians from the world's x axis.
    pub(crate) angle: f64,
    pub(crate) tiles: Option<Tiles>,
}

/// Tiles in turn of the paint's colour and of another one. The first has the paint's colour and lies in the
/// corner of least x and y of the area's own axes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tiles {
    /// The side of a tile in metres.
    pub(crate) side: f64,
    pub(crate) color: Color,
}

/// A small parallelogram of the floor: what a pixel of a camera or a cell of a line sensor sees.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Patch {
    pub(crate) center: [f64; 2],
    pub(crate) sides: [[f64; 2]; 2],
}

impl Floor {
    /// Returns the mean over a patch of what `tone` gives for each colour, where `bare` is that of the floor
    /// without paint.
    pub(crate) fn mean<const N: usize>(
        &self,
        patch: &Patch,
        bare: [f64; N],
        tone: impl Fn(Color) -> [f64; N],
    ) -> [f64; N] {
        let blend = |below: [f64; N], above: [f64; N], share: f64| {
            let mut mean = below;
            mean.iter_mut()
                .zip(above)
                .for_each(|(mean, above)| *mean += share * (above - *mean));
            mean
        };
        self.paints.iter().fold(bare, |below, paint| {
            let share = match &paint.form {
                PaintForm::Line(line) => line.share(patch),
                PaintForm::Area(area) => area.share(patch),
            };
            if share == 0.0 {
                return below;
            }
            let mut own = tone(paint.color);
            if let PaintForm::Area(
                area @ PaintedArea {
                    tiles: Some(tiles), ..
                },
            ) = &paint.form
            {
                own = blend(own, tone(tiles.color), area.second(patch, tiles.side));
            }
            blend(below, own, share)
        })
    }

    /// Returns what is painted, each as one shape or several.
    pub(crate) fn shapes(&self) -> impl Iterator<Item = Shape<'_>> {
        (1..).zip(&self.paints).flat_map(|(layer, paint)| {
            paint.outlines().into_iter().map(move |(outline, color)| Shape {
                name: &paint.name,
                outline,
                color,
                // The tiles of an area lie between it and what is painted later.
                height: LAYER * (f64::from(layer) + if color == paint.color { 0.0 } else { 0.5 }),
                moving: false,
                figure: Figure::Upright,
            })
        })
    }
}

impl PaintedLine {
    /// Creates a line through two or more points, each apart from the one before it.
    pub(crate) fn new(points: &[[f64; 2]], width: f64) -> Self {
        let legs: Vec<Segment> = points
            .windows(2)
            .map(|pair| Segment::new(Vector::from(pair[0]), Vector::from(pair[1])))
            .collect();
        let boxes = legs.iter().map(Segment::local_aabb).enumerate();
        let tree = Bvh::from_iter(BvhBuildStrategy::Ploc, boxes);
        Self { legs, tree, width }
    }

    /// Returns the part of a patch that it covers, from 0 to 1.
    fn share(&self, patch: &Patch) -> f64 {
        let center = Vector::from(patch.center);
        let project = |leg: &Segment| leg.project_local_point(center, true).point;
        let reach = self.width / 2.0 + patch.reach();
        let nearest = self.tree.find_best(
            reach,
            |node, _| node.aabb().distance_to_local_point(center, true),
            |leg, _| Some(project(&self.legs[leg as usize]).distance(center)),
        );
        let Some((leg, distance)) = nearest else {
            return 0.0;
        };
        let leg = &self.legs[leg as usize];
        let away = center - project(leg);
        // In the middle of the line no direction leads away from it: the one across takes its place.
        let across = if distance > 1e-9 {
            away
        } else {
            (leg.b - leg.a).perp()
        }
        .normalize();
        strip(distance, self.width / 2.0, patch.width(across.into()))
    }
}

impl PaintedArea {
    /// Returns the part of a patch that it covers, from 0 to 1.
    fn share(&self, patch: &Patch) -> f64 {
        let place = self.local(patch.center);
        let part = |axis: usize| {
            let width = patch.width(self.axis(axis));
            strip(place[axis].abs(), self.size[axis] / 2.0, width)
        };
        part(0) * part(1)
    }

    /// Returns the part of a patch that the tiles of the second colour cover, as if they had no end: the
    /// box-filtered checkerboard of Quilez, "Filtering the checkerboard pattern" (2009).
    fn second(&self, patch: &Patch, side: f64) -> f64 {
        let place = self.local(patch.center);
        let wave = |axis: usize| {
            let width = (patch.width(self.axis(axis)) / side).max(1e-9);
            let from = (place[axis] + self.size[axis] / 2.0) / side;
            let triangle = |at: f64| {
                let half = at / 2.0;
                (half - libm::floor(half) - 0.5).abs()
            };
            2.0 * (triangle(from - width / 2.0) - triangle(from + width / 2.0)) / width
        };
        0.5 - 0.5 * wave(0) * wave(1)
    }

    /// Returns one of its own axes.
    fn axis(&self, axis: usize) -> [f64; 2] {
        let (sin, cos) = libm::sincos(self.angle);
        if axis == 0 { [cos, sin] } else { [-sin, cos] }
    }

    /// Returns a point of the world in its own axes, from its middle.
    fn local(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let away = [x - self.center[0], y - self.center[1]];
        [0, 1].map(|axis| {
            let axis = self.axis(axis);
            away[0] * axis[0] + away[1] * axis[1]
        })
    }

    fn outline(&self) -> Outline {
        Outline::Box {
            center: self.center,
            size: self.size,
            angle: self.angle,
        }
    }

    /// Returns the tiles of the second colour, cut at the edge of the area.
    fn second_tiles(&self, side: f64) -> impl Iterator<Item = Outline> {
        // The tiles along each axis, those that are cut included.
        let count = self.size.map(|size| libm::ceil(size / side - 1e-9) as usize);
        let area = *self;
        let cells = (0..count[0]).flat_map(move |column| (0..count[1]).map(move |row| [column, row]));
        cells
            .filter(|[column, row]| (column + row) % 2 == 1)
            .map(move |cell| {
                let (mut middle, mut size) = ([0.0; 2], [0.0; 2]);
                for axis in 0..2 {
                    let from = cell[axis] as f64 * side;
                    let to = (from + side).min(area.size[axis]);
                    (middle[axis], size[axis]) = ((from + to - area.size[axis]) / 2.0, to - from);
                }
                let (ahead, left) = (area.axis(0), area.axis(1));
                Outline::Box {
                    center: [0, 1]
                        .map(|axis| area.center[axis] + middle[0] * ahead[axis] + middle[1] * left[axis]),
                    size,
                    angle: area.angle,
                }
            })
    }
}

impl Paint {
    /// Returns what it paints as rectangles with their colours: a line as one for each leg, without its round
    /// joins and ends.
    fn outlines(&self) -> Vec<(Outline, Color)> {
        match &self.form {
            PaintForm::Line(line) => {
                let leg = |leg: &Segment| {
                    let along = leg.b - leg.a;
                    Outline::Box {
                        center: ((leg.a + leg.b) / 2.0).into(),
                        size: [along.length(), line.width],
                        angle: libm::atan2(along.y, along.x),
                    }
                };
                line.legs.iter().map(|it| (leg(it), self.color)).collect()
            }
            PaintForm::Area(area) => {
                let second = area.tiles.iter().flat_map(|tiles| {
                    let outlines = area.second_tiles(tiles.side);
                    outlines.map(|outline| (outline, tiles.color))
                });
                std::iter::once((area.outline(), self.color))
                    .chain(second)
                    .collect()
            }
        }
    }

    /// Returns the corners of a box around it.
    pub(crate) fn corners(&self) -> [[f64; 2]; 2] {
        let around = match &self.form {
            PaintForm::Line(line) => line.tree.root_aabb(),
            PaintForm::Area(area) => {
                let (ahead, left) = (area.axis(0), area.axis(1));
                let half = [0, 1]
                    .map(|axis| (area.size[0] * ahead[axis].abs() + area.size[1] * left[axis].abs()) / 2.0);
                Aabb::from_half_extents(Vector::from(area.center), Vector::from(half))
            }
        };
        [around.mins.into(), around.maxs.into()]
    }
}

impl Patch {
    /// Returns its width along a unit direction, in metres.
    pub(crate) fn width(&self, [x, y]: [f64; 2]) -> f64 {
        self.sides
            .iter()
            .map(|side| (side[0] * x + side[1] * y).abs())
            .sum()
    }

    /// Returns the distance from its middle that no point of it exceeds, in metres.
    fn reach(&self) -> f64 {
        self.sides
            .iter()
            .map(|side| libm::hypot(side[0], side[1]))
            .sum::<f64>()
            / 2.0
    }
}

/// Returns the part of a patch `width` metres wide that lies within a strip of `half` metres to each side of
/// its middle line, from which the patch's middle is `distance` metres away.
pub(crate) fn strip(distance: f64, half: f64, width: f64) -> f64 {
    let width = width + 1e-9;
    ((half + width / 2.0 - distance) / width).clamp(0.0, (2.0 * half / width).min(1.0))
}
