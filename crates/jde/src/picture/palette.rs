//! The colours of the picture: Okabe and Ito's for the schemas, which people who see colours differently tell apart, and
//! greys for the rest.

use tiny_skia::ColorU8;

use super::Drive;

/// Paper.
pub(super) const WHITE: ColorU8 = grey(0xff);
/// Title, walls, targets.
pub(super) const INK: ColorU8 = grey(0x22);
/// Labels and numbers.
pub(super) const SOFT: ColorU8 = grey(0x66);
/// Edges of furniture.
pub(super) const EDGE: ColorU8 = grey(0x9a);
/// Furniture.
pub(super) const FURNITURE: ColorU8 = grey(0xd4);
/// Lines every so many metres.
pub(super) const GRID: ColorU8 = grey(0xec);
/// Where a way goes on while nobody wins.
pub(super) const NOBODY: ColorU8 = grey(0x80);

/// Without black, which is the walls', and the most alike last.
const OKABE_ITO: [ColorU8; 7] = [
    rgb(0x00, 0x72, 0xb2),
    rgb(0xe6, 0x9f, 0x00),
    rgb(0xd5, 0x5e, 0x00),
    rgb(0x00, 0x9e, 0x73),
    rgb(0xcc, 0x79, 0xa7),
    rgb(0x56, 0xb4, 0xe9),
    rgb(0xf0, 0xe4, 0x42),
];

/// The colours of the schemas that won during a drive, in the order of the application.
pub(super) struct Palette {
    winners: Vec<usize>,
}

impl Palette {
    /// Gives colours to those that won for any time, so that the most telling ones are not spent on others.
    pub(super) fn of(drive: &Drive) -> Self {
        let path = drive.path.iter().filter_map(|at| at.winner);
        let mut winners: Vec<usize> = path
            .chain(drive.takeovers.iter().map(|takeover| takeover.to))
            .collect();
        winners.sort_unstable();
        winners.dedup();
        Self { winners }
    }

    /// Gives those that have a colour.
    pub(super) fn winners(&self) -> impl Iterator<Item = usize> {
        self.winners.iter().copied()
    }

    /// Gives the colour of a winner; from the eighth on they repeat.
    pub(super) fn color(&self, winner: Option<usize>) -> ColorU8 {
        let place = winner.and_then(|winner| self.winners.binary_search(&winner).ok());
        place.map_or(NOBODY, |place| OKABE_ITO[place % OKABE_ITO.len()])
    }

    /// Whether a winner shares its colour with one before it: its way is dashed.
    pub(super) fn is_dashed(&self, winner: Option<usize>) -> bool {
        let place = winner.and_then(|winner| self.winners.binary_search(&winner).ok());
        place.is_some_and(|place| place >= OKABE_ITO.len())
    }
}

/// Makes a colour let through what is below.
pub(super) fn faded(color: ColorU8, opacity: f32) -> ColorU8 {
    let alpha = (opacity.clamp(0.0, 1.0) * 255.0).round() as u8;
    ColorU8::from_rgba(color.red(), color.green(), color.blue(), alpha)
}

const fn grey(level: u8) -> ColorU8 {
    rgb(level, level, level)
}

const fn rgb(red: u8, green: u8, blue: u8) -> ColorU8 {
    ColorU8::from_rgba(red, green, blue, 255)
}
