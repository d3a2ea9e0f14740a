//! Parses one line of a CARMEN log. It knows no file, no other line and no clock.
//!
//! The formats, from the header that CARMEN's logger writes and from its reader (carmen.sourceforge.net, `writelog.c` and
//! `readlog.c`); every message ends with `ipc_timestamp host logger_timestamp`:
//! - `FLASER n r0 .. x y theta odom_x odom_y odom_theta` and `RLASER`, of the laser in front and in the rear: the first
//!   pose is that of the laser, the second one that of the robot.
//! - `ROBOTLASER1 laser_type start_angle field_of_view angular_resolution maximum_range accuracy remission_mode n r0 ..
//!   m s0 .. laser_x laser_y laser_theta robot_x robot_y robot_theta tv rv forward side turn_axis`.
//! - `RAWLASER1`, the same up to the remissions, without poses.
//! - `ODOM x y theta tv rv accel`, `PARAM name value`.

use jde_schema::types::Pose2D;

/// Most beams of a scan, of any laser that there is.
const MAX_BEAMS: usize = 16_384;
/// Most characters of a message's name that are repeated.
const MAX_NAME: usize = 32;

/// What a line says.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Line<'a> {
    /// Nothing: a comment, a mark, or no words.
    Empty,
    /// A parameter, of which the first word of the value counts.
    Param(&'a str, &'a str),
    /// The pose of the robot by its wheels.
    Odometry(Reading),
    /// A scan.
    Scan(Source, Sweep, Reading),
    /// Another message, by its name.
    Other(String),
}

/// Where and when the robot was.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Reading {
    /// The pose of the robot.
    pub(crate) robot: Option<Pose2D>,
    /// The pose of the laser.
    pub(crate) laser: Option<Pose2D>,
    /// The clock of the message's sender and that of the logger, s.
    pub(crate) stamps: [Option<f64>; 2],
}

/// The message that a scan is in. Of several in one log, the first in this order is played, those in front before others.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Source {
    /// `ROBOTLASER` and its number, 1 for the laser in front.
    Robot(u8),
    /// `FLASER`: the laser in front.
    Front,
    /// `RAWLASER` and its number, as above.
    Raw(u8),
    /// `RLASER`: the laser in the rear.
    Rear,
}

impl Source {
    /// Whether it is the laser in front.
    pub(crate) fn is_front(self) -> bool {
        matches!(self, Self::Front | Self::Robot(1) | Self::Raw(1))
    }

    /// Whether it is the laser in the rear, which looks back.
    pub(crate) fn is_rear(self) -> bool {
        matches!(self, Self::Rear | Self::Robot(2) | Self::Raw(2))
    }
}

impl core::fmt::Display for Source {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Front => f.write_str("FLASER"),
            Self::Robot(number) => write!(f, "ROBOTLASER{number}"),
            Self::Raw(number) => write!(f, "RAWLASER{number}"),
            Self::Rear => f.write_str("RLASER"),
        }
    }
}

/// The beams of a scan, from right to left.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Sweep {
    /// Distances, m; NaN of a beam that measured none.
    pub(crate) ranges: Vec<f32>,
    /// What the message states of its laser.
    pub(crate) config: Option<Config>,
}

/// What a message states of its laser, as it is written there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Config {
    pub(crate) start: f64,
    pub(crate) view: f64,
    pub(crate) increment: f64,
    pub(crate) max_range: f64,
}

/// The words of a line.
struct Words<'a>(core::str::SplitAsciiWhitespace<'a>);

/// Parses a line.
///
/// # Errors
/// What is wrong with a message that would be played.
pub(crate) fn parse(line: &str) -> Result<Line<'_>, String> {
    let mut words = Words(line.split_ascii_whitespace());
    let Some(name) = words.0.next() else {
        return Ok(Line::Empty);
    };
    let source = |number: &str, of: fn(u8) -> Source| number.parse().ok().map(of);
    let source = match name {
        "ODOM" => return words.odometry(),
        "PARAM" => return Ok(words.param()),
        "SYNC" | "COMMENT" => return Ok(Line::Empty),
        _ if name.starts_with('#') => return Ok(Line::Empty),
        "FLASER" => Some(Source::Front),
        "RLASER" => Some(Source::Rear),
        _ => (name.strip_prefix("ROBOTLASER"))
            .and_then(|number| source(number, Source::Robot))
            .or_else(|| (name.strip_prefix("RAWLASER")).and_then(|number| source(number, Source::Raw))),
    };
    match source {
        Some(source) => words.scan(source),
        None => Ok(Line::Other(other(name))),
    }
}

/// Returns the name of a message that is not read, as it may be shown.
fn other(name: &str) -> String {
    let is_name = |c: char| c.is_ascii_uppercase() || c.is_ascii_digit() || c == '_';
    match name.len() <= MAX_NAME && name.chars().all(is_name) {
        true => name.to_owned(),
        false => "a line without the name of a message".to_owned(),
    }
}

impl<'a> Words<'a> {
    fn param(&mut self) -> Line<'a> {
        match (self.0.next(), self.0.next()) {
            (Some(name), Some(value)) => Line::Param(name, value),
            _ => Line::Empty,
        }
    }

    fn odometry(&mut self) -> Result<Line<'a>, String> {
        let robot = Some(self.pose()?);
        for what in ["a speed", "a turn rate", "an acceleration"] {
            self.number(what)?;
        }
        let stamps = self.stamps();
        Ok(Line::Odometry(Reading {
            robot,
            laser: None,
            stamps,
        }))
    }

    fn scan(&mut self, source: Source) -> Result<Line<'a>, String> {
        let has_config = matches!(source, Source::Robot(_) | Source::Raw(_));
        let config = if has_config { Some(self.config()?) } else { None };
        let count = self.count("beams")?;
        let ranges = (0..count).map(|_| self.range()).collect::<Result<Vec<_>, _>>()?;
        if ranges.is_empty() {
            return Err("it has no beams".to_owned());
        }
        if has_config {
            for _ in 0..self.count("remissions")? {
                self.word("a remission")?;
            }
        }
        let (mut laser, mut robot) = (None, None);
        if !matches!(source, Source::Raw(_)) {
            (laser, robot) = (Some(self.pose()?), Some(self.pose()?));
        }
        if matches!(source, Source::Robot(_)) {
            for what in [
                "a speed",
                "a turn rate",
                "a distance ahead",
                "a distance beside",
                "an axis",
            ] {
                self.word(what)?;
            }
        }
        let stamps = self.stamps();
        let reading = Reading { robot, laser, stamps };
        Ok(Line::Scan(source, Sweep { ranges, config }, reading))
    }

    fn config(&mut self) -> Result<Config, String> {
        self.word("the type of the laser")?;
        let config = Config {
            start: self.any("the first angle")?,
            view: self.any("the angle of view")?,
            increment: self.any("the angle between beams")?,
            max_range: self.any("the greatest range")?,
        };
        self.word("the accuracy")?;
        self.word("the mode of remissions")?;
        Ok(config)
    }

    fn pose(&mut self) -> Result<Pose2D, String> {
        Ok(Pose2D::new(
            self.number("x")?,
            self.number("y")?,
            self.number("theta")?,
        ))
    }

    /// Reads the two clocks. A line without one of them is still where the robot was.
    fn stamps(&mut self) -> [Option<f64>; 2] {
        let stamp = |word: Option<&str>| word?.parse().ok().filter(|stamp: &f64| stamp.is_finite());
        let sent = stamp(self.0.next());
        let _host = self.0.next();
        [sent, stamp(self.0.next())]
    }

    /// Reads the distance of a beam. What is no distance is a beam that measured nothing.
    fn range(&mut self) -> Result<f32, String> {
        let range = self.any("a range")?;
        Ok(if range >= 0.0 { range as f32 } else { f32::NAN })
    }

    fn count(&mut self, what: &str) -> Result<usize, String> {
        let count = self.number(&format!("the number of {what}"))?;
        if count.fract() == 0.0 && (0.0..=MAX_BEAMS as f64).contains(&count) {
            return Ok(count as usize);
        }
        Err(format!("{count} {what}; a scan has at most {MAX_BEAMS}"))
    }

    fn number(&mut self, what: &str) -> Result<f64, String> {
        match self.any(what)? {
            number if number.is_finite() => Ok(number),
            number => Err(format!("`{number}` is not {what}")),
        }
    }

    /// Reads a number, which may be none or without an end.
    fn any(&mut self, what: &str) -> Result<f64, String> {
        let word = self.word(what)?;
        // The start of a long word tells enough.
        (word.parse()).map_err(|_| {
            let start: String = word.chars().take(MAX_NAME).collect();
            format!("`{}` is not {what}", start.escape_default())
        })
    }

    fn word(&mut self, what: &str) -> Result<&'a str, String> {
        self.0.next().ok_or_else(|| format!("it ends before {what}"))
    }
}
