//! The scanner's parameters, and the contents of its scans: steps, distances, and values that are not
//! distances.

use core::f32::consts::TAU;
use core::fmt;

use crate::message::{Message, checked, number};

/// Most beams of a scan, by the capacity of the exported type.
const MAX_BEAMS: u32 = 1088;

/// The scanner's parameters, from the reply to `PP`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Parameters {
    /// Range of the distances that it measures, mm.
    nearest: u32,
    farthest: u32,
    /// Steps per turn.
    turn: u32,
    /// The first step, the last, and the one straight ahead, counter-clockwise.
    first: u32,
    last: u32,
    ahead: u32,
    /// Turns per minute.
    speed: u32,
}

/// The encoding of distances.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Letters {
    /// Up to 4095 mm.
    Two,
    /// Up to 262 m.
    Three,
}

/// The beams to request from a scanner.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Beams {
    parameters: Parameters,
    first: u32,
    last: u32,
    /// Steps combined into one beam, of which the nearest distance counts.
    cluster: u32,
    /// Turns skipped between two scans.
    skip: u32,
    letters: Letters,
}

/// A scan.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Scan {
    /// The scanner's clock, ms; it has 24 bits.
    pub(crate) stamp: u32,
    /// Distances from right to left, m, by REP-117.
    pub(crate) ranges: Vec<f32>,
}

/// The reason for rejecting a scan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Unusable {
    /// The checksum of a line is invalid.
    Checksum,
    /// The number of letters differs from the request.
    Length(usize),
}

impl Parameters {
    /// Reads the reply to `PP`.
    pub(crate) fn read(message: &Message) -> Result<Self, String> {
        let value = |key: &str| {
            let text = message
                .value(key)
                .ok_or_else(|| format!("it does not report its {key}"))?;
            let number = text.trim().parse::<u32>().ok().filter(|number| *number < 1 << 18);
            number.ok_or_else(|| {
                format!(
                    "its {key} is `{}`, which is no such number",
                    text.escape_default()
                )
            })
        };
        let parameters = Self {
            nearest: value("DMIN")?,
            farthest: value("DMAX")?,
            turn: value("ARES")?,
            first: value("AMIN")?,
            last: value("AMAX")?,
            ahead: value("AFRT")?,
            speed: value("SCAN")?,
        };
        let Self {
            first, last, turn, ..
        } = parameters;
        // A request has four digits for a step.
        if turn == 0 || parameters.speed == 0 || first > last || last > 9999 || last - first >= turn {
            return Err(format!(
                "steps {first} to {last} of {turn} at {} turns a minute cannot be",
                parameters.speed
            ));
        }
        Ok(parameters)
    }
}

impl Letters {
    fn count(self) -> usize {
        match self {
            Self::Two => 2,
            Self::Three => 3,
        }
    }

    fn command(self) -> &'static str {
        match self {
            Self::Two => "MS",
            Self::Three => "MD",
        }
    }
}

impl Beams {
    /// The beams within an angle centred ahead, rad. Combines neighbouring steps if they exceed the capacity
    /// of a scan.
    pub(crate) fn new(parameters: Parameters, view: f64, skip: u32, letters: Letters) -> Self {
        // The small addend includes steps that rounding would exclude.
        let half = (view / core::f64::consts::TAU * f64::from(parameters.turn) / 2.0 + 1e-6).floor() as u32;
        let first = parameters
            .first
            .max(parameters.ahead.saturating_sub(half))
            .min(parameters.last);
        let last = parameters
            .last
            .min(parameters.ahead.saturating_add(half))
            .max(first);
        Self {
            parameters,
            first,
            last,
            cluster: (last - first + 1).div_ceil(MAX_BEAMS),
            skip: skip.min(9),
            letters,
        }
    }

    /// The request for continuous scans, without the remaining count, which changes in the echoes.
    pub(crate) fn request(self) -> String {
        let Self {
            first,
            last,
            cluster,
            skip,
            ..
        } = self;
        format!("{}{first:04}{last:04}{cluster:02}{skip}", self.letters.command())
    }

    pub(crate) fn count(self) -> usize {
        // A remainder smaller than a cluster is a beam too.
        ((self.last - self.first) / self.cluster + 1) as usize
    }

    /// Angle of the first beam, rad: the middle of its steps.
    pub(crate) fn angle_min(self) -> f32 {
        let middle = self.first as f32 + (self.cluster - 1) as f32 / 2.0;
        (middle - self.parameters.ahead as f32) * TAU / self.parameters.turn as f32
    }

    /// Angle between beams, rad.
    pub(crate) fn increment(self) -> f32 {
        self.cluster as f32 * TAU / self.parameters.turn as f32
    }

    /// Time of a turn, s.
    fn turn(self) -> f32 {
        60.0 / self.parameters.speed as f32
    }

    /// Time between beams, s.
    pub(crate) fn time_increment(self) -> f32 {
        self.turn() * self.cluster as f32 / self.parameters.turn as f32
    }

    /// Time between scans, s.
    pub(crate) fn scan_time(self) -> f32 {
        self.turn() * (self.skip + 1) as f32
    }

    /// Smallest distance, m.
    pub(crate) fn range_min(self) -> f32 {
        self.parameters.nearest as f32 / 1000.0
    }

    /// Greatest distance, m.
    pub(crate) fn range_max(self) -> f32 {
        self.farthest() as f32 / 1000.0
    }

    fn farthest(self) -> u32 {
        match self.letters {
            // 4095 means all greater distances.
            Letters::Two => self.parameters.farthest.min(4094),
            Letters::Three => self.parameters.farthest,
        }
    }

    /// Decodes a scan.
    pub(crate) fn decode(self, message: &Message) -> Result<Scan, Unusable> {
        let mut lines = message
            .lines
            .iter()
            .map(|line| checked(line).ok_or(Unusable::Checksum));
        let stamp = lines.next().ok_or(Unusable::Length(0))??;
        let stamp = number(stamp)
            .filter(|_| stamp.len() == 4)
            .ok_or(Unusable::Checksum)?;
        let mut letters = Vec::with_capacity(self.count() * self.letters.count());
        for line in lines {
            letters.extend_from_slice(line?);
        }
        if letters.len() != self.count() * self.letters.count() {
            return Err(Unusable::Length(letters.len()));
        }
        let values = letters.chunks_exact(self.letters.count());
        let ranges = values.map(|letters| Some(self.range(number(letters)?)));
        Ok(Scan {
            stamp,
            ranges: ranges.collect::<Option<_>>().ok_or(Unusable::Checksum)?,
        })
    }

    fn range(self, millimetres: u32) -> f32 {
        match millimetres {
            // No echo.
            0 => f32::INFINITY,
            // Codes for a weak echo, glare or a fault of a neighbour. Their meanings differ between models.
            code if code < self.parameters.nearest => f32::NAN,
            far if far > self.farthest() => f32::INFINITY,
            distance => distance as f32 / 1000.0,
        }
    }
}

impl fmt::Display for Unusable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Checksum => f.write_str("scans come with wrong checksums: is the cable near a motor's?"),
            Self::Length(letters) => write!(f, "scans come with {letters} letters, which were not asked for"),
        }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use jde_device::emulate::Emulator;

    use super::*;
    use crate::emulator::{EmulatedScanner, letters};

    pub(crate) fn parameters(emulator: &EmulatedScanner) -> Parameters {
        let mut receiver = crate::message::Receiver::default();
        let mut emulator = EmulatedScanner {
            scip1: false,
            ..emulator.clone()
        };
        receiver.receive(&emulator.receive(b"PP\n", emulator.baud));
        Parameters::read(&receiver.next().expect("the emulator replies")).expect("parameters")
    }

    fn scan(beams: Beams, stamp: u32, values: &[u32]) -> Message {
        Message {
            echo: beams.request() + "00",
            status: *b"99",
            lines: crate::emulator::scan_lines(stamp, values, beams.letters.count()),
        }
    }

    #[test]
    fn the_beams_of_a_small_scanner_agree_with_its_data_sheet() {
        let beams = Beams::new(
            parameters(&EmulatedScanner::urg()),
            f64::from(TAU),
            0,
            Letters::Three,
        );
        assert_eq!(
            (beams.request(), beams.count()),
            ("MD00440725010".to_owned(), 682)
        );
        // Steps of 0.35 degrees, 340 to the right of straight ahead.
        assert!((beams.angle_min() + 340.0 * TAU / 1024.0).abs() < 1e-6);
        assert!((beams.increment() - TAU / 1024.0).abs() < 1e-9);
        assert_eq!(
            (beams.range_min(), beams.range_max(), beams.scan_time()),
            (0.02, 5.6, 0.1)
        );
        assert!((beams.time_increment() * 1024.0 - 0.1).abs() < 1e-6);
    }

    #[test]
    fn a_view_is_centred_ahead_and_limited_by_the_scanner() {
        let parameters = parameters(&EmulatedScanner::utm());
        let request = |view: f64| Beams::new(parameters, view, 2, Letters::Three).request();
        assert_eq!(request(f64::from(TAU)), "MD00001080012");
        assert_eq!(request(core::f64::consts::PI), "MD01800900012");
        assert_eq!(request(0.0), "MD05400540012");
    }

    #[test]
    fn steps_beyond_the_capacity_are_combined() {
        let parameters = Parameters {
            turn: 2880,
            first: 0,
            last: 2160,
            ahead: 1080,
            ..parameters(&EmulatedScanner::utm())
        };
        let beams = Beams::new(parameters, f64::from(TAU), 0, Letters::Three);
        assert_eq!((beams.cluster, beams.count()), (2, 1081));
        let last = beams.angle_min() + beams.increment() * 1080.0;
        assert!((last - 0.75 * core::f32::consts::PI).abs() < 2.0 * beams.increment());
    }

    #[test]
    fn values_that_are_not_distances_follow_rep_117() {
        let parameters = Parameters {
            first: 384,
            last: 389,
            ..parameters(&EmulatedScanner::urg())
        };
        let beams = Beams::new(parameters, f64::from(TAU), 0, Letters::Three);
        let Scan { stamp, ranges } = beams
            .decode(&scan(beams, 77, &[0, 7, 20, 5600, 5601, 1]))
            .expect("a scan");
        assert_eq!(
            (stamp, ranges[0], ranges[2], ranges[3], ranges[4]),
            (77, f32::INFINITY, 0.02, 5.6, f32::INFINITY)
        );
        assert!(ranges[1].is_nan() && ranges[5].is_nan());

        let beams = Beams {
            letters: Letters::Two,
            ..beams
        };
        let ranges = beams
            .decode(&scan(beams, 0, &[4095, 4094, 20, 19, 0, 1000]))
            .expect("a scan")
            .ranges;
        assert_eq!((ranges[0], ranges[1], ranges[5]), (f32::INFINITY, 4.094, 1.0));
    }

    #[test]
    fn ten_thousand_scans_with_wrong_bytes_are_rejected() {
        let beams = Beams::new(
            parameters(&EmulatedScanner::urg()),
            f64::from(TAU),
            0,
            Letters::Three,
        );
        let good = scan(beams, 5, &[1234; 682]);
        let mut seed = 3_u32;
        let mut random = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (seed >> 16) as usize
        };
        for _ in 0..10_000 {
            let mut invalid = good.clone();
            let line = random() % invalid.lines.len();
            let index = random() % invalid.lines[line].len();
            // One of the six checked bits.
            invalid.lines[line][index] ^= 1 << (random() % 6);
            assert_eq!(beams.decode(&invalid), Err(Unusable::Checksum));
            invalid.lines.remove(line);
            assert!(beams.decode(&invalid).is_err());
        }
        assert_eq!(
            letters(1234, 2),
            b"CB",
            "the emulator encodes as the specification does"
        );
    }

    #[test]
    fn invalid_parameters_are_refused_with_a_message() {
        let read = |change: (&str, &str)| {
            let text =
                "DMIN:20 DMAX:5600 ARES:1024 AMIN:44 AMAX:725 AFRT:384 SCAN:600".replace(change.0, change.1);
            let line = |text: &str| {
                format!("{text};{}", char::from(crate::message::checksum(text.as_bytes()))).into()
            };
            Parameters::read(&Message {
                echo: "PP".to_owned(),
                status: *b"00",
                lines: text.split(' ').map(line).collect(),
            })
        };
        assert!(read(("", "")).is_ok());
        assert_eq!(
            read(("DMAX", "DMUX")),
            Err("it does not report its DMAX".to_owned())
        );
        assert_eq!(
            read(("5600", "far")),
            Err("its DMAX is `far`, which is no such number".to_owned())
        );
        for invalid in [
            ("1024", "0"),
            ("SCAN:600", "SCAN:0"),
            ("AMIN:44", "AMIN:800"),
            ("AMAX:725", "AMAX:10000"),
        ] {
            assert!(
                read(invalid)
                    .expect_err("the parameters are invalid")
                    .ends_with("cannot be")
            );
        }
    }
}
