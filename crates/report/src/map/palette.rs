//! Who has which colour: the schemas that won during a drive, in the order of the application.

use super::Drive;
use crate::drawing::ColorRole;
use crate::drawing::color_role::TOLD_APART;

/// The colours of the schemas that won.
#[derive(Clone, Debug, Default)]
pub(crate) struct Palette {
    winners: Vec<usize>,
}

impl Palette {
    /// Gives colours to those that won for any time, so that the most telling ones are not spent on others.
    pub(crate) fn of(drive: &Drive) -> Self {
        let mut winners: Vec<usize> = drive.winners.iter().copied().chain(drive.seen()).collect();
        winners.sort_unstable();
        winners.dedup();
        Self { winners }
    }

    /// Gives those that have a colour.
    pub(crate) fn winners(&self) -> impl Iterator<Item = usize> {
        self.winners.iter().copied()
    }

    /// Gives the colour of a winner; from the eighth on they repeat.
    pub(crate) fn tone(&self, winner: Option<usize>) -> ColorRole {
        self.place(winner).map_or(ColorRole::Nobody, ColorRole::Of)
    }

    /// Whether a winner shares its colour with one before it: its way is dashed.
    pub(crate) fn is_dashed(&self, winner: Option<usize>) -> bool {
        self.place(winner).is_some_and(|place| place >= TOLD_APART)
    }

    fn place(&self, winner: Option<usize>) -> Option<usize> {
        self.winners.binary_search(&winner?).ok()
    }
}
