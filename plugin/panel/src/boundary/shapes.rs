//! Reads shapes from their table: of a canvas, of a scene, or curves of a plot, depending on the open widget.

use jde_abi::raw;

use super::{array, codes, text};
use crate::builder::Holds;
use crate::limits::{MOST_POINTS, wrong};
use crate::{Broken, Color, Place, Shape, Solid, Stroke, Trace};

/// The shape in the form of the open widget.
pub(super) enum Drawn {
    Shape(Shape),
    Solid(Solid),
    Trace(Trace),
}

/// Reads a shape for a widget of this name, in the form that the widget holds.
///
/// # Safety
/// The pointers of the table follow the rules of `raw`.
pub(super) unsafe fn read(widget: &str, holds: Holds, shape: &raw::Shape) -> Result<Drawn, Broken> {
    if shape.point_count as usize > MOST_POINTS {
        return Err(Broken::Points);
    }
    let color = codes::color(widget, shape.color)?;
    // SAFETY: the caller's contract.
    let text = unsafe { text(widget, shape.text) }?;
    match holds {
        Holds::Shapes => {
            // SAFETY: the caller's contract.
            let points = unsafe { points::<2>(widget, shape) }?;
            flat(widget, shape, points, color, text).map(Drawn::Shape)
        }
        Holds::Solids => {
            // SAFETY: the caller's contract.
            let points = unsafe { points::<3>(widget, shape) }?;
            solid(widget, shape, points, color, text).map(Drawn::Solid)
        }
        Holds::Traces if shape.kind == raw::SHAPE_LINE => Ok(Drawn::Trace(Trace {
            name: text,
            color,
            // SAFETY: the caller's contract.
            points: unsafe { points::<2>(widget, shape) }?,
        })),
        Holds::Traces => wrong(widget, "a plot holds nothing but lines"),
        Holds::Widgets => wrong(widget, "a shape outside of a plot, canvas or scene"),
    }
}

fn flat(
    widget: &str,
    shape: &raw::Shape,
    points: Vec<[f64; 2]>,
    color: Color,
    text: String,
) -> Result<Shape, Broken> {
    let stroke = Stroke {
        color,
        width: width(shape),
    };
    Ok(match shape.kind {
        raw::SHAPE_LINE => Shape::Line {
            points,
            closed: shape.flags & raw::CLOSED != 0,
            stroke,
        },
        raw::SHAPE_POINTS => Shape::Points { points, stroke },
        raw::SHAPE_ARROW => {
            let [from, to] = exactly(widget, points)?;
            Shape::Arrow { from, to, stroke }
        }
        raw::SHAPE_LABEL => {
            let [at] = exactly(widget, points)?;
            Shape::Label { at, text, color }
        }
        raw::SHAPE_CIRCLE => {
            let [center] = exactly(widget, points)?;
            Shape::Circle {
                center,
                radius: shape.radius,
                filled: shape.flags & raw::FILLED != 0,
                stroke,
            }
        }
        raw::SHAPE_POLYGON => Shape::Polygon { points, color },
        raw::SHAPE_ROBOT => {
            let [[x, y]] = exactly(widget, points)?;
            Shape::Robot {
                pose: [x, y, shape.turned[2]],
            }
        }
        other => return wrong(widget, format!("a canvas has no shape of kind {other}")),
    })
}

fn solid(
    widget: &str,
    shape: &raw::Shape,
    points: Vec<[f64; 3]>,
    color: Color,
    text: String,
) -> Result<Solid, Broken> {
    let place = |points| -> Result<Place, Broken> {
        let [at] = exactly(widget, points)?;
        Ok(Place {
            at,
            turned: shape.turned,
        })
    };
    let (radius, width) = (shape.radius, width(shape));
    Ok(match shape.kind {
        raw::SHAPE_LINE => {
            let mut points = points;
            if shape.flags & raw::CLOSED != 0 {
                points.extend(points.first().copied());
            }
            Solid::Line { points, color, width }
        }
        raw::SHAPE_POINTS => Solid::Points { points, color, width },
        raw::SHAPE_ARROW => {
            let [from, to] = exactly(widget, points)?;
            Solid::Arrow { from, to, color }
        }
        raw::SHAPE_LABEL => {
            let [at] = exactly(widget, points)?;
            Solid::Label { at, text, color }
        }
        raw::SHAPE_BOX => Solid::Box {
            place: place(points)?,
            size: shape.extent,
            color,
        },
        raw::SHAPE_SPHERE => {
            let [center] = exactly(widget, points)?;
            Solid::Sphere {
                center,
                radius,
                color,
            }
        }
        raw::SHAPE_CYLINDER => Solid::Cylinder {
            place: place(points)?,
            radius,
            height: shape.extent[2],
            color,
        },
        raw::SHAPE_MESH => Solid::Mesh {
            corners: points,
            color,
        },
        other => return wrong(widget, format!("a scene has no shape of kind {other}")),
    })
}

/// # Safety
/// As [`read`].
unsafe fn points<const N: usize>(widget: &str, shape: &raw::Shape) -> Result<Vec<[f64; N]>, Broken> {
    // SAFETY: the caller's contract.
    let numbers = unsafe { array(widget, shape.points, shape.point_count as usize * N) }?;
    Ok(numbers.as_chunks().0.to_vec())
}

fn exactly<const N: usize, const M: usize>(
    widget: &str,
    points: Vec<[f64; N]>,
) -> Result<[[f64; N]; M], Broken> {
    let count = points.len();
    points.try_into().or_else(|_| {
        wrong(
            widget,
            format!("a shape has {count} points, and its kind has {M}"),
        )
    })
}

fn width(shape: &raw::Shape) -> f32 {
    if shape.width == 0.0 {
        Stroke::default().width
    } else {
        shape.width as f32
    }
}
