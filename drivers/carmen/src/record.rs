//! Parses one line of a CARMEN log. It knows no file and no clock except that of the line.
//!
//! The format, from the headers of CARMEN's logs (carmen.sourceforge.net): `FLASER n r0 .. rn-1 x y theta
//! odom_x odom_y odom_theta ipc_timestamp host logger_timestamp` and `ODOM x y theta tv rv accel
//! ipc_timestamp host logger_timestamp`.

use core::f64::consts::{FRAC_PI_2, PI};

use jde_schema::types::Pose2D;

/// Most beams of a scan, by the capacity of the exported type.
const MAX_BEAMS: usize = 1088;

/// The contents of a line.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Line {
    /// The robot's pose: that of the scan in a line with one, otherwise that of the wheels.
    pub(crate) pose: Pose2D,
    /// The logger's clock, s.
    pub(crate) clock: f64,
    /// The scan, if the line has one.
    pub(crate) scan: Option<Scan>,
}

/// A scan over half a turn, from right to left.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Scan {
    /// Distances, m.
    pub(crate) ranges: Vec<f32>,
}

impl Scan {
    /// Angle of the first beam, rad.
    pub(crate) fn angle_min(&self) -> f64 {
        -FRAC_PI_2
    }

    /// Angle between beams, rad. 181 and 361 beams include both ends of the half turn; 180 and 360 do not.
    pub(crate) fn angle_increment(&self) -> f64 {
        let beams = self.ranges.len();
        let gaps = if beams.is_multiple_of(2) { beams } else { beams - 1 };
        PI / gaps.max(1) as f64
    }
}

/// Parses a line; `None` for a line of another kind.
pub(crate) fn parse(line: &str) -> Option<Result<Line, String>> {
    let mut fields = line.split_ascii_whitespace();
    match fields.next()? {
        "FLASER" => Some(laser(&mut fields)),
        "ODOM" => Some(odometry(&mut fields)),
        _ => None,
    }
}

fn laser<'a>(fields: &mut impl Iterator<Item = &'a str>) -> Result<Line, String> {
    let count = number(fields, "the number of beams")?;
    if count.fract() != 0.0 || !(1.0..=MAX_BEAMS as f64).contains(&count) {
        return Err(format!("{count} beams; a scan has 1 to {MAX_BEAMS}"));
    }
    let ranges = (0..count as usize)
        .map(|_| match number(fields, "a range")? {
            range if range >= 0.0 => Ok(range as f32),
            range => Err(format!("a range of {range} m")),
        })
        .collect::<Result<_, String>>()?;
    let pose = pose(fields)?;
    let _odometry = self::pose(fields)?;
    Ok(Line {
        pose,
        clock: clock(fields)?,
        scan: Some(Scan { ranges }),
    })
}

fn odometry<'a>(fields: &mut impl Iterator<Item = &'a str>) -> Result<Line, String> {
    let pose = pose(fields)?;
    for what in ["a speed", "a turn rate", "an acceleration"] {
        number(fields, what)?;
    }
    Ok(Line {
        pose,
        clock: clock(fields)?,
        scan: None,
    })
}

fn pose<'a>(fields: &mut impl Iterator<Item = &'a str>) -> Result<Pose2D, String> {
    Ok(Pose2D::new(
        number(fields, "x")?,
        number(fields, "y")?,
        number(fields, "theta")?,
    ))
}

/// Reads the two clocks of a line and returns the second, which is that of the logger.
fn clock<'a>(fields: &mut impl Iterator<Item = &'a str>) -> Result<f64, String> {
    number(fields, "a time")?;
    fields.next().ok_or("it ends before the host's name")?;
    number(fields, "the logger's time")
}

fn number<'a>(fields: &mut impl Iterator<Item = &'a str>, what: &str) -> Result<f64, String> {
    let field = fields.next().ok_or_else(|| format!("it ends before {what}"))?;
    match field.parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        _ => Err(format!("`{}` is not {what}", field.escape_default())),
    }
}
