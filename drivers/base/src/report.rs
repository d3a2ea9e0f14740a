//! A line of a board's state, `s`, read.

use crate::hello::Kind;
use crate::line::Fields;

/// What a board senses.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Report {
    /// Counts the lines.
    pub(crate) number: u16,
    /// The board's clock, ms. It wraps.
    pub(crate) time: u32,
    /// The command that is in force.
    pub(crate) acknowledged: Option<u16>,
    /// The lines that it received and refused, modulo 2³².
    pub(crate) bad: Option<u32>,
    pub(crate) motion: Motion,
    pub(crate) stalled: bool,
    /// Whether each bumper is pressed, from left to right.
    pub(crate) front: Option<Vec<bool>>,
    pub(crate) rear: Option<Vec<bool>>,
    /// V.
    pub(crate) battery: Option<f32>,
    /// rad/s, m/s².
    pub(crate) imu: Option<[[f64; 3]; 2]>,
}

/// What it measures of its motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Motion {
    /// The counts of the left and of the right wheel, modulo 2³².
    Counts([u32; 2]),
    /// The mean speeds since the last line: ahead, to the left, m/s; counter-clockwise, rad/s.
    Speeds([f64; 3]),
}

impl Report {
    /// Reads the words behind `s`.
    ///
    /// # Errors
    /// What is wrong with the line, in words.
    pub(crate) fn read<'a>(mut words: impl Iterator<Item = &'a str>, kind: Kind) -> Result<Self, String> {
        let number = words.next().and_then(|word| word.parse().ok());
        let fields = Fields::read(words).ok_or("a field has no value, or occurs twice")?;
        let missing = |key: &str| format!("`{key}` is missing");
        // Counts may be signed or not: they are the same modulo 2³².
        let count = |key: &str| -> Result<u32, String> {
            Ok(fields.number::<i64>(key)?.ok_or_else(|| missing(key))? as u32)
        };
        let speed = |key: &str| -> Result<f64, String> {
            Ok(f64::from(fields.number::<i32>(key)?.ok_or_else(|| missing(key))?) / 1000.0)
        };
        let motion = match kind {
            Kind::Differential { .. } => Motion::Counts([count("left")?, count("right")?]),
            Kind::Omnidirectional => Motion::Speeds([speed("vx")?, speed("vy")?, speed("wz")?]),
        };
        let [gyro, acceleration] = [vector(&fields, "gyro", 1e6)?, vector(&fields, "acc", 1e3)?];
        Ok(Self {
            number: number.ok_or("it has no number")?,
            time: fields.number("t")?.ok_or_else(|| missing("t"))?,
            acknowledged: fields.number("ack")?,
            bad: fields.number("bad")?,
            motion,
            stalled: fields.number::<u8>("stalled")?.is_some_and(|value| value > 0),
            front: bumpers(&fields, "front")?,
            rear: bumpers(&fields, "rear")?,
            battery: fields
                .number::<u32>("battery")?
                .map(|millivolts| millivolts as f32 / 1000.0),
            imu: gyro.zip(acceleration).map(<[_; 2]>::from),
        })
    }
}

fn bumpers(fields: &Fields, key: &str) -> Result<Option<Vec<bool>>, String> {
    let Some(text) = fields.text(key) else {
        return Ok(None);
    };
    if text.is_empty() || text.len() > 8 || !text.bytes().all(|byte| matches!(byte, b'0' | b'1')) {
        return Err(format!("`{key}={text}` is not 1 to 8 digits 0 or 1"));
    }
    Ok(Some(text.bytes().map(|byte| byte == b'1').collect()))
}

fn vector(fields: &Fields, key: &str, units: f64) -> Result<Option<[f64; 3]>, String> {
    let Some(text) = fields.text(key) else {
        return Ok(None);
    };
    let numbers: Result<Vec<i32>, _> = text.split(',').map(str::parse).collect();
    let numbers: Option<[i32; 3]> = numbers.ok().and_then(|numbers| numbers.try_into().ok());
    let numbers = numbers.ok_or_else(|| format!("`{key}={text}` is not three numbers"))?;
    Ok(Some(numbers.map(|number| f64::from(number) / units)))
}

#[cfg(test)]
mod tests {
    use super::*;

    const KIND: Kind = Kind::Differential {
        track: 0.2,
        ticks_per_metre: 1000.0,
        bits: 32,
    };

    fn read(text: &str, kind: Kind) -> Result<Report, String> {
        Report::read(text.split(' '), kind)
    }

    #[test]
    fn a_board_reports_what_it_has_and_nothing_else() {
        let little = read("7 t=40 left=-1 right=4294967295", KIND).expect("it is complete");
        assert_eq!(little.motion, Motion::Counts([u32::MAX; 2]));
        assert_eq!(
            (&little.front, little.battery, little.imu, little.acknowledged),
            (&None, None, None, None)
        );
        let half = read("7 t=40 left=1 right=1 gyro=1,2,3", KIND).expect("it is complete");
        assert_eq!((half.imu, half.bad), (None, None), "an inertial unit has both");
        let much = read(
            "7 t=40 ack=3 vx=100 vy=-50 wz=7 stalled=1 front=01 battery=11700 gyro=1000000,0,-500000 acc=0,0,9810",
            Kind::Omnidirectional,
        )
        .expect("it is complete");
        assert_eq!(much.motion, Motion::Speeds([0.1, -0.05, 0.007]));
        assert_eq!(much.imu, Some([[1.0, 0.0, -0.5], [0.0, 0.0, 9.81]]));
        assert_eq!(
            (much.front, much.battery, much.stalled),
            (Some(vec![false, true]), Some(11.7), true)
        );
    }

    #[test]
    fn a_line_that_says_too_little_or_nonsense_is_refused() {
        for (text, words) in [
            ("7 t=40 left=1", "`right` is missing"),
            ("7 left=1 right=1", "`t` is missing"),
            ("x t=40 left=1 right=1", "no number"),
            ("7 t=-40 left=1 right=1", "`t=-40`"),
            ("7 t=40 left=1 right=1 front=012", "`front=012`"),
            ("7 t=40 left=1 right=1 gyro=1,2 acc=1,2,3", "`gyro=1,2`"),
        ] {
            let reason = read(text, KIND).expect_err(text);
            assert!(reason.contains(words), "{reason}");
        }
    }
}
