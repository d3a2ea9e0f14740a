//! Noise as a function of the seed and of what it disturbs, never of earlier readings.
//!
//! The generator is Philox4x32-10 (Salmon, Moraes, Dror, Shaw, "Parallel random numbers: as easy as 1, 2, 3",
//! SC 2011). It has no state: reading one sensor cannot change another, and reading a sensor twice at one
//! instant gives the same values.

use std::f64::consts::TAU;

/// What a draw disturbs. The numbers are part of the recorded behaviour of a seed: never reuse one.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Purpose {
    Laser = 1,
    Sonar = 2,
    Slip = 3,
    WheelScale = 4,
    Line = 5,
    Imu = 6,
    ImuBias = 7,
    Position = 8,
    Outage = 9,
    Depth = 10,
    DroppedBeams = 11,
    Delivery = 12,
    Picture = 13,
}

/// The draws of one sensor of one robot at one step of the world.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Noise {
    key: [u32; 2],
    /// The last three words of the counter.
    source: [u32; 3],
}

/// Robots in one world: as many as fit in 32 bits beside the purpose and the stream.
pub(crate) const MAX_ROBOTS: usize = 1 << 12;

impl Noise {
    pub(crate) fn new(seed: u64, robot: usize, purpose: Purpose, stream: u16, step: u64) -> Self {
        Self {
            key: [seed as u32, (seed >> 32) as u32],
            source: source(purpose as u8, robot, stream, step),
        }
    }

    /// Returns a draw from 0 to less than 1.
    pub(crate) fn uniform(&self, index: u32) -> f64 {
        let bits = self.bits(index);
        unit(bits[0], bits[1]) / (1u64 << 53) as f64
    }

    /// Returns two independent draws of the standard normal distribution (Box and Muller).
    pub(crate) fn normals(&self, index: u32) -> [f64; 2] {
        let bits = self.bits(index);
        // In (0, 1], so that the logarithm is finite.
        let first = (unit(bits[0], bits[1]) + 1.0) / (1u64 << 53) as f64;
        let second = unit(bits[2], bits[3]) / (1u64 << 53) as f64;
        let radius = (-2.0 * libm::log(first)).sqrt();
        let (sin, cos) = libm::sincos(TAU * second);
        [radius * cos, radius * sin]
    }

    /// Returns sixteen independent draws from 0 to 255.
    pub(crate) fn bytes(&self, index: u32) -> [u8; 16] {
        let bits = self.bits(index).map(u32::to_le_bytes);
        std::array::from_fn(|byte| bits[byte / 4][byte % 4])
    }

    fn bits(&self, index: u32) -> [u32; 4] {
        let [source, low, high] = self.source;
        philox([index, source, low, high], self.key)
    }
}

/// Returns the last three words of a counter. The lower half of the purpose shares a word with the robot, the
/// upper half one with the step.
fn source(purpose: u8, robot: usize, stream: u16, step: u64) -> [u32; 3] {
    debug_assert!(robot < MAX_ROBOTS && step >> 60 == 0);
    let [low, high] = [purpose & 0xF, purpose >> 4].map(|half| u32::from(half) << 28);
    [
        low | (robot as u32) << 16 | u32::from(stream),
        step as u32,
        high | (step >> 32) as u32,
    ]
}

/// Returns the upper 53 of 64 bits: a float holds no more.
fn unit(low: u32, high: u32) -> f64 {
    ((u64::from(high) << 32 | u64::from(low)) >> 11) as f64
}

fn philox(mut counter: [u32; 4], mut key: [u32; 2]) -> [u32; 4] {
    const MULTIPLIERS: [u32; 2] = [0xD251_1F53, 0xCD9E_8D57];
    const WEYL: [u32; 2] = [0x9E37_79B9, 0xBB67_AE85];
    for _ in 0..10 {
        let a = u64::from(MULTIPLIERS[0]) * u64::from(counter[0]);
        let b = u64::from(MULTIPLIERS[1]) * u64::from(counter[2]);
        counter = [
            (b >> 32) as u32 ^ counter[1] ^ key[0],
            b as u32,
            (a >> 32) as u32 ^ counter[3] ^ key[1],
            a as u32,
        ];
        key = [key[0].wrapping_add(WEYL[0]), key[1].wrapping_add(WEYL[1])];
    }
    counter
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::{philox, source};

    #[test]
    fn every_purpose_has_streams_of_its_own() {
        let sources = (0..=u8::MAX).map(|purpose| source(purpose, 4095, u16::MAX, (1 << 60) - 1));
        assert_eq!(sources.collect::<BTreeSet<_>>().len(), 256);
        assert_eq!(source(10, 1, 2, 3 << 32 | 4), [10 << 28 | 1 << 16 | 2, 4, 3]);
    }

    #[test]
    fn philox_gives_the_published_test_vectors() {
        assert_eq!(
            philox([0; 4], [0; 2]),
            [0x6627_e8d5, 0xe169_c58d, 0xbc57_ac4c, 0x9b00_dbd8]
        );
        assert_eq!(
            philox([u32::MAX; 4], [u32::MAX; 2]),
            [0x408f_276d, 0x41c8_3b0e, 0xa20b_c7c6, 0x6d54_51fd]
        );
        assert_eq!(
            philox(
                [0x243f_6a88, 0x85a3_08d3, 0x1319_8a2e, 0x0370_7344],
                [0xa409_3822, 0x299f_31d0]
            ),
            [0xd16c_fe09, 0x94fd_cceb, 0x5001_e420, 0x2412_6ea1]
        );
    }
}
