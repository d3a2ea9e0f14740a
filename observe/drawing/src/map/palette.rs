//! The colours of the schemas that won during a drive, in the order of the application.

use super::DriveMap;
use crate::ColorRole;
use crate::color_role::DISTINCT;

/// The colours of the schemas that won.
#[derive(Clone, Debug, Default)]
pub struct Palette {
    winners: Vec<usize>,
}

impl Palette {
    /// Assigns colours only to schemas that won for any time, so that the most distinct colours are not spent
    /// on others.
    #[must_use]
    pub fn of(drive: &DriveMap) -> Self {
        let mut winners: Vec<usize> = drive
            .winners
            .iter()
            .copied()
            .chain(drive.drawn_winners())
            .collect();
        winners.sort_unstable();
        winners.dedup();
        Self { winners }
    }

    /// The schemas with a colour.
    pub(crate) fn winners(&self) -> impl Iterator<Item = usize> {
        self.winners.iter().copied()
    }

    /// The colour of a winner; colours repeat from the eighth on.
    #[must_use]
    pub fn tone(&self, winner: Option<usize>) -> ColorRole {
        self.place(winner).map_or(ColorRole::Nobody, ColorRole::Of)
    }

    /// Whether an earlier winner has the same colour. Its path is dashed then.
    pub(crate) fn is_dashed(&self, winner: Option<usize>) -> bool {
        self.place(winner).is_some_and(|place| place >= DISTINCT)
    }

    fn place(&self, winner: Option<usize>) -> Option<usize> {
        self.winners.binary_search(&winner?).ok()
    }
}
