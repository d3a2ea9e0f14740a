//! Measurements on the wire: checked, and found again after any garbage. This module knows no turns and does no I/O.
//!
//! From SLAMTEC's "RPLIDAR Interface Protocol":
//! - 0x81, five bytes: a bit that is set where a turn begins, its inverse and a quality of six bits; a bit that is 1 and
//!   an angle in 1/64 degree; a distance in 1/4 mm.
//! - 0x82 and 0x85, capsules of 84 bytes: the digits 0xA and 0x5 with the two halves of a checksum, the exclusive or of
//!   the bytes after them; a bit that is set after a start and an angle in 1/64 degree; distances. The angles of the
//!   samples lie between that of their capsule and that of the next one.
//! - Distances of 0x82 come in pairs of five bytes: twice 14 bits in mm and two bits of a correction of the angle, and
//!   four more bits of each correction, in 1/8 degree. Those of 0x85 are 40 words in mm.

/// Bytes of a node.
const NODE: usize = 5;
/// Nodes that must follow each other to be believed, because their check has two bits.
const BELIEVED: usize = 4;
/// Greatest angle between two nodes that follow each other, degrees.
const MAX_STEP: f64 = 30.0;
/// Bytes of a capsule.
const CAPSULE: usize = 84;
/// Greatest angle of a capsule, degrees. The slowest lidars measure 2000 times and turn 10 times a second.
const MAX_SPAN: f64 = 90.0;
/// How much greater the angle of a capsule may be than that of the one before: twice as great if one is missing.
const MAX_GROWTH: f64 = 1.5;

/// How measurements are sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Format {
    /// 0x81.
    Nodes,
    /// 0x82.
    Express,
    /// 0x85.
    Dense,
}

/// One measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sample {
    /// Clockwise, degrees.
    pub(crate) angle: f64,
    /// Distance, mm; 0 if nothing was measured.
    pub(crate) distance: f32,
    /// 0 to 63; 0 if the format has none.
    pub(crate) quality: u8,
    /// How far the head has turned since the measurement when the last of these bytes was sent, degrees.
    pub(crate) lag: f64,
}

/// What was found in the bytes.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Found {
    /// So many bytes are right, and gave these samples.
    Samples(usize, Vec<Sample>),
    /// A byte is part of no measurement.
    Corrupt,
}

/// Finds measurements in the received bytes, however they are split and whatever lies between them.
#[derive(Debug)]
pub(crate) struct Decoder {
    format: Format,
    bytes: Vec<u8>,
    start: usize,
    /// The capsule before.
    previous: Option<[u8; CAPSULE]>,
    /// The angle of the last whole capsule, degrees.
    span: f64,
}

impl Format {
    /// Returns the format of a type of reply.
    pub(crate) fn of_kind(kind: u8) -> Option<Self> {
        match kind {
            0x81 => Some(Self::Nodes),
            0x82 => Some(Self::Express),
            0x85 => Some(Self::Dense),
            _ => None,
        }
    }

    /// The greatest distance that the format has a number for, mm. It stands for no measurement.
    pub(crate) fn greatest(self) -> f32 {
        match self {
            Self::Nodes => 65_535.0 / 4.0,
            Self::Express => 16_383.0,
            Self::Dense => 65_535.0,
        }
    }

    /// Whether samples of the format have a quality.
    pub(crate) fn has_quality(self) -> bool {
        self == Self::Nodes
    }
}

impl Decoder {
    pub(crate) fn new(format: Format) -> Self {
        Self {
            format,
            bytes: Vec::new(),
            start: 0,
            previous: None,
            span: MAX_SPAN,
        }
    }

    /// Discards what was received.
    pub(crate) fn clear(&mut self) {
        *self = Self::new(self.format);
    }

    /// Appends received bytes.
    pub(crate) fn receive(&mut self, bytes: &[u8]) {
        self.bytes.drain(..self.start);
        self.start = 0;
        self.bytes.extend_from_slice(bytes);
    }

    /// Returns what was found next; `None` until more bytes arrive.
    pub(crate) fn next(&mut self) -> Option<Found> {
        let rest = &self.bytes[self.start..];
        let (size, samples) = match self.format {
            Format::Nodes => {
                let rest = rest.first_chunk::<{ NODE * BELIEVED }>()?;
                (NODE, node(rest).map(|sample| vec![sample]))
            }
            Format::Express | Format::Dense => {
                let capsule = *rest.first_chunk::<CAPSULE>()?;
                let is_right = is_right(&capsule);
                let before = core::mem::replace(&mut self.previous, is_right.then_some(capsule));
                // A capsule that begins a scan does not follow the one before.
                let before = before.filter(|_| word(&capsule, 2) & 0x8000 == 0);
                let samples = before
                    .filter(|_| is_right)
                    .and_then(|before| self.samples(&before, &capsule));
                (CAPSULE, is_right.then(|| samples.unwrap_or_default()))
            }
        };
        self.start += if samples.is_some() { size } else { 1 };
        let greatest = self.format.greatest();
        Some(samples.map_or(Found::Corrupt, |mut samples| {
            for sample in samples.iter_mut().filter(|sample| sample.distance >= greatest) {
                sample.distance = 0.0;
            }
            Found::Samples(size, samples)
        }))
    }

    /// Returns the samples of a capsule, which the one after completes. There are none if that is not the next one.
    fn samples(&mut self, capsule: &[u8; CAPSULE], after: &[u8; CAPSULE]) -> Option<Vec<Sample>> {
        let start = |capsule: &[u8]| f64::from(word(capsule, 2) & 0x7fff) / 64.0;
        let span = (start(after) - start(capsule)).rem_euclid(360.0);
        let before = core::mem::replace(&mut self.span, span);
        (span <= MAX_SPAN.min(MAX_GROWTH * before))
            .then(|| samples(self.format, capsule, start(capsule), span))
    }
}

fn word(bytes: &[u8], at: usize) -> u16 {
    u16::from_le_bytes([bytes[at], bytes[at + 1]])
}

/// Reads the first of several nodes, if all of them are right.
fn node(bytes: &[u8; NODE * BELIEVED]) -> Option<Sample> {
    let mut angles = bytes.chunks_exact(NODE).map(|node| {
        let is_checked = (node[0] ^ node[0] >> 1) & 1 == 1 && node[1] & 1 == 1;
        let angle = f64::from(word(node, 1) >> 1) / 64.0;
        (is_checked && angle <= 360.0).then_some(angle)
    });
    let angle = angles.next()??;
    angles.try_fold(angle, |before, angle| {
        let step = (angle? - before + 180.0).rem_euclid(360.0) - 180.0;
        (step.abs() <= MAX_STEP).then_some(before + step)
    })?;
    Some(Sample {
        angle: angle.rem_euclid(360.0),
        distance: f32::from(word(bytes, 3)) / 4.0,
        quality: bytes[0] >> 2,
        lag: 0.0,
    })
}

fn is_right(capsule: &[u8; CAPSULE]) -> bool {
    let sum = capsule[2..].iter().fold(0, |sum, byte| sum ^ byte);
    capsule[0] >> 4 == 0xa && capsule[1] >> 4 == 0x5 && sum == (capsule[0] & 0xf | capsule[1] << 4)
}

/// Returns the samples of a capsule from one angle on over another, degrees.
fn samples(format: Format, capsule: &[u8; CAPSULE], start: f64, span: f64) -> Vec<Sample> {
    let content = &capsule[4..];
    let distances: Vec<(u16, f64)> = if format == Format::Dense {
        let words = (0..40).map(|index| (word(content, 2 * index), 0.0));
        words.collect()
    } else {
        let pairs = content.chunks_exact(5).flat_map(|pair| {
            let words = [word(pair, 0), word(pair, 2)];
            let corrections = [pair[4] & 0xf, pair[4] >> 4];
            [0, 1].map(|side| {
                let eighths = u16::from(corrections[side]) | (words[side] & 3) << 4;
                (words[side] >> 2, f64::from(eighths) / 8.0)
            })
        });
        pairs.collect()
    };
    let step = span / distances.len() as f64;
    let sample = |(index, (distance, correction)): (usize, (u16, f64))| Sample {
        angle: (start + step * index as f64 - correction).rem_euclid(360.0),
        distance: f32::from(distance),
        quality: 0,
        lag: 2.0 * span - step * index as f64,
    };
    distances.into_iter().enumerate().map(sample).collect()
}

#[cfg(test)]
mod tests;
