//! The colours of drawings by their meaning: the palette of Okabe and Ito for schemas, which is
//! distinguishable with colour-vision deficiencies, and greys for the rest. Each has a value for light and
//! for dark paper.

use std::fmt::{self, Write as _};

use tiny_skia::ColorU8;

/// The meaning of a colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ColorRole {
    /// The background.
    Paper,
    /// Titles, walls, targets.
    Ink,
    /// Labels and numbers.
    Soft,
    /// Edges of furniture.
    Edge,
    /// Furniture.
    Furniture,
    /// Grid lines in metres or seconds.
    Grid,
    /// No winner, or a winner without a colour of its own.
    Nobody,
    /// What went as it should.
    Good,
    /// A fault.
    Bad,
    /// One of several distinguished things; the colours repeat from the eighth on.
    Of(usize),
}

/// The number of distinct [`ColorRole::Of`].
pub(crate) const DISTINCT: usize = 7;

/// Light and dark values. Without black, which walls use; the most similar colour is last.
const OKABE_ITO: [(u32, u32); DISTINCT] = [
    (0x0072b2, 0x4aa3df),
    (0xe69f00, 0xe9a820),
    (0xd55e00, 0xe8743b),
    (0x009e73, 0x22b58c),
    (0xcc79a7, 0xd68fb6),
    (0x56b4e9, 0x86cdf2),
    (0xf0e442, 0xe6dc5a),
];

impl ColorRole {
    /// All distinct roles.
    fn all() -> impl Iterator<Item = Self> {
        [
            Self::Paper,
            Self::Ink,
            Self::Soft,
            Self::Edge,
            Self::Furniture,
            Self::Grid,
            Self::Nobody,
            Self::Good,
            Self::Bad,
        ]
        .into_iter()
        .chain((0..DISTINCT).map(Self::Of))
    }

    /// The colours on light and on dark paper, 0xrrggbb.
    fn values(self) -> (u32, u32) {
        match self {
            Self::Paper => (0xff_ffff, 0x15_181c),
            Self::Ink => (0x22_2222, 0xe4_e6e8),
            Self::Soft => (0x66_6666, 0x9b_a1a8),
            Self::Edge => (0x9a_9a9a, 0x6d_747c),
            Self::Furniture => (0xd4_d4d4, 0x3a_4048),
            Self::Grid => (0xec_ecec, 0x25_2a30),
            Self::Nobody => (0x80_8080, 0x80_868d),
            Self::Good => (0x26_7a3a, 0x74_c98a),
            Self::Bad => (0xc0_1c28, 0xff_6b6b),
            Self::Of(place) => OKABE_ITO[place % DISTINCT],
        }
    }

    /// The colour on light paper.
    #[must_use]
    pub fn light(self) -> ColorU8 {
        let [_, red, green, blue] = self.values().0.to_be_bytes();
        ColorU8::from_rgba(red, green, blue, 255)
    }
}

/// The name of the colour's CSS variable: `--ink`, `--of3`.
impl fmt::Display for ColorRole {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Paper => f.write_str("--paper"),
            Self::Ink => f.write_str("--ink"),
            Self::Soft => f.write_str("--soft"),
            Self::Edge => f.write_str("--edge"),
            Self::Furniture => f.write_str("--furniture"),
            Self::Grid => f.write_str("--grid"),
            Self::Nobody => f.write_str("--nobody"),
            Self::Good => f.write_str("--good"),
            Self::Bad => f.write_str("--bad"),
            Self::Of(place) => write!(f, "--of{}", place % DISTINCT),
        }
    }
}

/// The CSS rules that define the colours: dark ones where the reader prefers them, but never in print.
#[must_use]
pub fn style() -> String {
    let mut light = String::new();
    let mut dark = String::new();
    for tone in ColorRole::all() {
        let values = tone.values();
        // Writing to a string cannot fail.
        let _ = write!(light, "{tone}:#{:06x};", values.0);
        let _ = write!(dark, "{tone}:#{:06x};", values.1);
    }
    format!(
        ":root{{color-scheme:light;{light}}}@media screen and (prefers-color-scheme:dark){{:root{{color-scheme:dark;{dark}}}}}"
    )
}
