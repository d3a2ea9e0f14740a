//! How numbers in SI units become those that a network was trained with.

/// Limits in SI units, a normalisation, and limits after it, in this order.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Scale {
    pub(crate) limit: Option<(f64, f64)>,
    pub(crate) normal: Normal,
    pub(crate) clip: Option<(f64, f64)>,
}

/// A normalisation.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) enum Normal {
    /// The numbers as they are.
    #[default]
    None,
    /// These become −1 and 1.
    Range(f64, f64),
    /// The mean becomes 0 and the deviation 1; one of each, or one for each number.
    Deviation { mean: Vec<f64>, std: Vec<f64> },
}

impl Scale {
    /// Returns the scale of so many numbers for each channel, from 0 to `white` unless it states other limits.
    pub(crate) fn of_channels(self, numbers: usize, white: f64) -> Self {
        let each = |list: Vec<f64>| match list.len() {
            1 => list,
            _ => list.iter().flat_map(|of| vec![*of; numbers]).collect(),
        };
        let normal = match self.normal {
            Normal::None => Normal::None,
            Normal::Range(low, high) => Normal::Range(low, high),
            Normal::Deviation { mean, std } => Normal::Deviation {
                mean: each(mean),
                std: each(std),
            },
        };
        Self {
            limit: self.limit.or(Some((0.0, white))),
            normal,
            clip: self.clip,
        }
    }

    /// Returns the scaled number at a place of its source.
    pub(crate) fn apply(&self, place: usize, number: f64) -> f32 {
        let limited = limit(number, self.limit);
        let of = |list: &[f64]| if list.len() == 1 { list[0] } else { list[place] };
        let normal = match &self.normal {
            Normal::None => limited,
            Normal::Range(low, high) => 2.0 * (limited - low) / (high - low) - 1.0,
            Normal::Deviation { mean, std } => (limited - of(mean)) / of(std),
        };
        limit(normal, self.clip) as f32
    }

    /// Returns the least and the greatest number that it gives.
    pub(crate) fn bounds(&self) -> (f32, f32) {
        match (self.clip, &self.normal, self.limit) {
            (Some((low, high)), ..) => (low as f32, high as f32),
            (None, Normal::Deviation { .. }, _) | (None, _, None) => (f32::NEG_INFINITY, f32::INFINITY),
            (None, Normal::None | Normal::Range(..), Some((low, high))) => {
                (self.apply(0, low), self.apply(0, high))
            }
        }
    }
}

/// NaN stays NaN.
fn limit(number: f64, limits: Option<(f64, f64)>) -> f64 {
    limits.map_or(number, |(low, high)| number.clamp(low, high))
}
