//! The contents of a measurement: distances, and values that are not distances. This module does not know the
//! wire format.

use core::fmt;

/// The beams: the angle covered, centred ahead, and the step between beams.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Beams {
    /// Degrees, 180 or 100.
    pub(crate) view: u16,
    /// Hundredths of a degree: 100, 50 or 25.
    pub(crate) step: u16,
}

/// Greatest distance and unit: the measuring mode of the manual.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Reach {
    /// Byte of the configuration.
    pub(crate) mode: u8,
    /// Byte of the configuration: 0 for cm, 1 for mm.
    pub(crate) unit: u8,
    /// Low bits of a value that hold the distance. The bits above report monitored fields.
    bits: u32,
}

/// The reason for rejecting a measurement.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Unusable {
    /// It is shorter than its count of beams requires.
    Short,
    /// It contains only a part of the turn, which was not requested.
    Partial,
    /// The number of beams differs from the request.
    Count(usize),
    /// The unit is unknown.
    Unit,
}

impl Beams {
    /// All combinations that the scanner supports.
    const ALL: [Self; 5] = [
        Self::new(180, 100),
        Self::new(180, 50),
        Self::new(100, 100),
        Self::new(100, 50),
        Self::new(100, 25),
    ];

    const fn new(view: u16, step: u16) -> Self {
        Self { view, step }
    }

    /// Returns the beams with this count, if the scanner supports it.
    pub(crate) fn with_count(count: u32) -> Option<Self> {
        Self::ALL
            .into_iter()
            .find(|beams| beams.count() == count as usize)
    }

    pub(crate) fn count(self) -> usize {
        usize::from(self.view) * 100 / usize::from(self.step) + 1
    }

    /// Angle of the first beam, the rightmost one, rad.
    pub(crate) fn angle_min(self) -> f32 {
        -(f32::from(self.view) / 2.0).to_radians()
    }

    /// Angle between beams, rad.
    pub(crate) fn increment(self) -> f32 {
        (f32::from(self.step) / 100.0).to_radians()
    }
}

impl Reach {
    /// Returns the mode for this many metres, if there is one.
    pub(crate) fn metres(metres: u32) -> Option<Self> {
        let (mode, unit, bits) = match metres {
            8 => (0x00, 1, 13),
            16 => (0x04, 1, 14),
            32 => (0x06, 1, 15),
            80 => (0x00, 0, 13),
            _ => return None,
        };
        Some(Self { mode, unit, bits })
    }

    /// Greatest distance, m.
    pub(crate) fn range_max(self) -> f32 {
        (self.beyond() - 1) as f32 / per_metre(self.unit).unwrap_or(f32::INFINITY)
    }

    /// The smallest value that is not a distance; it means beyond the range. The eight values above it are
    /// errors.
    fn beyond(self) -> u32 {
        (1 << self.bits) - 9
    }

    /// Decodes the distances of a measurement, m, by REP-117.
    pub(crate) fn decode(self, beams: Beams, data: &[u8]) -> Result<Vec<f32>, Unusable> {
        let &[low, high, ref values @ ..] = data else {
            return Err(Unusable::Short);
        };
        let head = u16::from_le_bytes([low, high]);
        let count = usize::from(head & 0x03ff);
        if head & 0x2000 != 0 {
            return Err(Unusable::Partial);
        }
        if values.len() < count * 2 {
            return Err(Unusable::Short);
        }
        if count != beams.count() {
            return Err(Unusable::Count(count));
        }
        let per_metre = per_metre((head >> 14) as u8).ok_or(Unusable::Unit)?;
        let values = values[..count * 2].chunks_exact(2);
        let values = values.map(|value| u32::from(u16::from_le_bytes([value[0], value[1]])));
        Ok(values.map(|value| self.range(value, per_metre)).collect())
    }

    fn range(self, value: u32, per_metre: f32) -> f32 {
        match value & ((1 << self.bits) - 1) {
            value if value < self.beyond() => value as f32 / per_metre,
            value if value == self.beyond() => f32::INFINITY,
            // Glare, a weak echo, no measurement or a fault of a channel: the distance is unknown.
            _ => f32::NAN,
        }
    }
}

/// Units per metre.
fn per_metre(unit: u8) -> Option<f32> {
    match unit {
        0 => Some(100.0),
        1 => Some(1000.0),
        _ => None,
    }
}

impl fmt::Display for Unusable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Short => f.write_str("a measurement is shorter than its count of beams requires"),
            Self::Partial => f.write_str("a measurement is a part of a turn"),
            Self::Count(count) => write!(f, "a measurement has {count} beams, which were not asked for"),
            Self::Unit => f.write_str("a measurement has an unknown unit"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn measurement(head: u16, values: &[u16]) -> Vec<u8> {
        [&[head][..], values]
            .concat()
            .iter()
            .flat_map(|word| word.to_le_bytes())
            .collect()
    }

    const MILLIMETRES: u16 = 0x4000;

    #[test]
    fn the_beams_go_from_right_to_left_about_straight_ahead() {
        for (count, view, step) in [
            (181, 180.0, 1.0),
            (361, 180.0, 0.5),
            (101, 100.0, 1.0),
            (201, 100.0, 0.5),
            (401, 100.0, 0.25),
        ] {
            let beams = Beams::with_count(count).expect("the scanner supports it");
            assert!((beams.angle_min() + f32::to_radians(view / 2.0)).abs() < 1e-6);
            assert!((beams.increment() - f32::to_radians(step)).abs() < 1e-6);
            let last = beams.angle_min() + beams.increment() * (count - 1) as f32;
            assert!(
                (last + beams.angle_min()).abs() < 1e-4,
                "the angles are symmetric"
            );
        }
        assert_eq!(Beams::with_count(180), None);
    }

    #[test]
    fn values_that_are_not_distances_follow_rep_117() {
        for (metres, top) in [(8, 8191_u16), (16, 16383), (32, 32767)] {
            let reach = Reach::metres(metres).expect("the scanner supports it");
            let mut values = [1234; 101];
            // Beyond the range, then the errors of the manual up to the invalid value.
            for (index, value) in (top - 8..=top).enumerate() {
                values[index] = value;
            }
            values[9] = top - 9;
            let beams = Beams::with_count(101).expect("the scanner supports it");
            let ranges = reach
                .decode(beams, &measurement(MILLIMETRES | 101, &values))
                .expect("a scan");
            assert_eq!(ranges[0], f32::INFINITY);
            assert!(
                ranges[1..9].iter().all(|range| range.is_nan()),
                "{:?}",
                &ranges[..9]
            );
            assert_eq!(ranges[9], reach.range_max());
            assert_eq!(ranges[10], 1.234);
        }
    }

    #[test]
    fn field_bits_are_ignored_and_the_measurement_states_its_unit() {
        let beams = Beams::with_count(101).expect("the scanner supports it");
        let reach = Reach::metres(80).expect("the scanner supports it");
        let ranges = reach
            .decode(beams, &measurement(101, &[0xe000 | 1234; 101]))
            .expect("a scan");
        assert_eq!(ranges[50], 12.34);
        assert!((reach.range_max() - 81.82).abs() < 1e-3);
        assert_eq!(Reach::metres(10), None);
    }

    #[test]
    fn a_measurement_that_was_not_requested_is_rejected() {
        let (beams, reach) = (
            Beams::with_count(101).expect("the scanner supports it"),
            Reach::metres(8).expect("the scanner supports it"),
        );
        let decode = |head, count| reach.decode(beams, &measurement(head, &vec![0; count]));
        assert_eq!(reach.decode(beams, &[1]), Err(Unusable::Short));
        assert_eq!(decode(MILLIMETRES | 101, 100), Err(Unusable::Short));
        assert_eq!(decode(MILLIMETRES | 181, 181), Err(Unusable::Count(181)));
        assert_eq!(decode(MILLIMETRES | 0x2000 | 101, 101), Err(Unusable::Partial));
        assert_eq!(decode(0x8000 | 101, 101), Err(Unusable::Unit));
    }
}
