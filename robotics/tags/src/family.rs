//! The families of tags: which cells of each tag are white, and which tag a reading shows.
//!
//! It knows no pictures.

use crate::codes::{self, Codes};

/// A family of tags. The name has the number of bits, and in how many of them two tags differ at least.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Family {
    /// 587 tags of 6 × 6 bits.
    Tag36h11,
    /// 35 tags of 5 × 5 bits.
    Tag25h9,
    /// 30 tags of 4 × 4 bits. A few bits agree with a tag by chance: expect some that are none.
    Tag16h5,
}

/// A tag that a reading shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Match {
    pub(crate) id: u32,
    /// Bits that differ.
    pub(crate) hamming: u32,
    /// How many quarters of a turn, counter-clockwise as one sees the tag, bring the reading upright.
    pub(crate) turns: usize,
}

impl Family {
    /// All families.
    pub const ALL: [Self; 3] = [Self::Tag36h11, Self::Tag25h9, Self::Tag16h5];

    /// Returns the name, as "tag36h11".
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Tag36h11 => "tag36h11",
            Self::Tag25h9 => "tag25h9",
            Self::Tag16h5 => "tag16h5",
        }
    }

    /// Returns the family of a name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|family| family.name() == name)
    }

    /// Returns how many tags it has: their numbers are smaller.
    #[must_use]
    pub fn count(self) -> usize {
        self.codes().count()
    }

    /// Returns the cells of a tag, row by row from the upper left, true for white: the bits, the black border
    /// around them, and the white margin around that. There are [`width`](Self::width) + 2 in each row.
    #[must_use]
    pub fn cells(self, id: u32) -> Option<Vec<bool>> {
        let code = self.codes().nth(id as usize)?;
        let side = self.width() + 2;
        let is_white = |index: usize| {
            let [row, column] = [index / side, index % side];
            let around = [row, column, side - 1 - row, side - 1 - column].into_iter().min();
            match around {
                Some(0) => true,
                Some(1) => false,
                _ => code >> (self.bits() - 1 - (row - 2) * self.side() - (column - 2)) & 1 == 1,
            }
        };
        Some((0..side * side).map(is_white).collect())
    }

    /// Returns the cells along a side, from one outer edge of the black border to the other: the size of a tag
    /// is measured there.
    #[must_use]
    pub fn width(self) -> usize {
        self.side() + 2
    }

    /// Returns the bits along a side.
    pub(crate) fn side(self) -> usize {
        match self {
            Self::Tag36h11 => 6,
            Self::Tag25h9 => 5,
            Self::Tag16h5 => 4,
        }
    }

    /// Returns the codes of all tags, their bits row by row from the upper left.
    pub(crate) fn codes(self) -> impl Iterator<Item = u64> {
        let codes: Codes = match self {
            Self::Tag36h11 => codes::TAG36H11,
            Self::Tag25h9 => codes::TAG25H9,
            Self::Tag16h5 => codes::TAG16H5,
        };
        codes.all(self.bits() as u32)
    }

    fn bits(self) -> usize {
        self.side() * self.side()
    }

    /// Returns a reading turned by a quarter counter-clockwise.
    pub(crate) fn turned(self, reading: u64) -> u64 {
        let side = self.side();
        (0..self.bits()).fold(0, |turned, index| {
            let from = index % side * side + side - 1 - index / side;
            turned << 1 | reading >> (self.bits() - 1 - from) & 1
        })
    }

    /// Returns the tag among `codes`, those of this family, that differs least from a reading, if it differs in
    /// at most `hamming` bits.
    pub(crate) fn nearest(self, codes: &[u64], reading: u64, hamming: u32) -> Option<Match> {
        let mut upright = reading;
        let mut best: Option<Match> = None;
        for turns in 0..4 {
            for (id, code) in codes.iter().enumerate() {
                let differing = (code ^ upright).count_ones();
                if differing <= hamming && best.is_none_or(|best| differing < best.hamming) {
                    best = Some(Match {
                        id: id as u32,
                        hamming: differing,
                        turns,
                    });
                }
            }
            upright = self.turned(upright);
        }
        best
    }
}
