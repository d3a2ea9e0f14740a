//! Pictures of what a program has in memory, as PNG.

use jde_core::Nanos;
use jde_drawing::Picture;
use jde_drawing::map::{DriveMap, PathPoint, RobotPath};
use jde_report::{SIDES, Size};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::error;

/// Draws numbers over time: their times, ns, and each a name and its values.
#[pyfunction]
pub(crate) fn draw_numbers<'py>(
    py: Python<'py>,
    title: &str,
    times: Vec<Nanos>,
    numbers: Vec<(String, Vec<f64>)>,
    size: (u32, u32),
) -> PyResult<Bound<'py, PyBytes>> {
    let size = valid_size(size)?;
    png(py, || {
        let numbers = numbers
            .into_iter()
            .map(|(name, values)| (name, times.iter().copied().zip(values).collect()))
            .collect();
        Ok(jde_report::draw_numbers(title, numbers, size))
    })
}

/// Draws the paths of robots from above: each a name and its poses, of which each is a time, s, a place, m, and a
/// heading, rad.
#[pyfunction]
pub(crate) fn draw_paths<'py>(
    py: Python<'py>,
    title: String,
    paths: Vec<(String, Vec<[f64; 4]>)>,
) -> PyResult<Bound<'py, PyBytes>> {
    png(py, || {
        let paths = paths.into_iter().map(|(robot, poses)| RobotPath {
            robot,
            distance: poses.windows(2).map(driven).sum(),
            points: poses.into_iter().map(point).collect(),
            ..RobotPath::default()
        });
        let drive = DriveMap {
            title,
            paths: paths.collect(),
            ..DriveMap::default()
        };
        Ok(Picture::of_drive(&drive))
    })
}

/// Returns the size of a picture, pixels.
pub(crate) fn valid_size((width, height): (u32, u32)) -> PyResult<Size> {
    if [width, height].iter().all(|side| SIDES.contains(side)) {
        return Ok(Size { width, height });
    }
    let (least, most) = (SIDES.start(), SIDES.end());
    Err(PyValueError::new_err(format!(
        "a picture has {least} to {most} pixels on each side"
    )))
}

/// Returns a picture as PNG. Other threads of Python run while it is drawn.
pub(crate) fn png<'py>(
    py: Python<'py>,
    draw: impl FnOnce() -> PyResult<Picture> + Send,
) -> PyResult<Bound<'py, PyBytes>> {
    let png = py.detach(|| draw()?.png().map_err(error))?;
    Ok(PyBytes::new(py, &png))
}

fn point([time, x, y, heading]: [f64; 4]) -> PathPoint {
    PathPoint {
        time,
        x,
        y,
        heading,
        winner: None,
    }
}

fn driven(poses: &[[f64; 4]]) -> f64 {
    match poses {
        [[_, x, y, _], [_, to_x, to_y, _]] => (to_x - x).hypot(to_y - y),
        _ => 0.0,
    }
}
