//! Room for new keyframes when there are as many as there may be: those that stand closest to others leave.

use super::{Anchor, Settings, Slam};

/// The part of all keyframes that leaves at once, so that the map is seldom drawn anew.
const LEAVING: usize = 16;
/// A keyframe is not missed that is nearer to one of its neighbours than so many times the distance of keyframes: a scan is
/// matched with those within 6 m.
const SPARSE: f64 = 3.0;

impl Slam {
    /// How far from every keyframe a scan becomes one, m: as far as keyframes are apart since some had to leave.
    pub(super) fn spacing(&self, settings: &Settings) -> f64 {
        settings.keyframe.0.max(self.spacing)
    }

    /// Lets keyframes leave that have others near them, if there are as many as there may be. Those of a map that is continued
    /// stay, and those without which an area would have none.
    pub(super) fn make_room(&mut self, settings: &Settings) {
        let count = self.scans.len();
        if count < settings.most {
            return;
        }
        let mut crowded: Vec<(f64, usize, usize)> = (self.given.max(1)..count)
            .filter(|&at| self.anchor.is_none_or(|anchor| anchor.keyframe != at))
            .filter_map(|at| {
                let pose = &self.graph.poses()[at];
                let nearest = (self.near[at].iter())
                    .map(|&other| (self.distance(other, pose), other))
                    .min_by(|a, b| a.0.total_cmp(&b.0))?;
                Some((nearest.0, at, nearest.1))
            })
            .filter(|&(distance, ..)| distance < SPARSE * settings.keyframe.0)
            .collect();
        crowded.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let most = count - settings.most + (settings.most / LEAVING).max(1);
        let mut is_leaving = vec![false; count];
        let mut left = 0;
        for (distance, at, nearest) in crowded {
            if left < most && !is_leaving[nearest] {
                is_leaving[at] = true;
                left += 1;
                self.spacing = self.spacing.max(distance);
            }
        }
        if left > 0 {
            self.leave(&is_leaving);
        }
    }

    fn leave(&mut self, is_leaving: &[bool]) {
        let numbers = self.graph.remove(is_leaving);
        let (mut scans, mut covariances) = (numbers.iter(), numbers.iter());
        self.scans.retain(|_| scans.next().is_some_and(Option::is_some));
        self.keyframe_covariance
            .retain(|_| covariances.next().is_some_and(Option::is_some));
        self.near = vec![Vec::new(); self.scans.len()];
        for edge in self.graph.edges() {
            self.near[edge.from].push(edge.to);
            self.near[edge.to].push(edge.from);
        }
        self.anchor = self
            .anchor
            .and_then(|anchor| numbers[anchor.keyframe].map(|keyframe| Anchor { keyframe, ..anchor }));
        self.loops.renumber(&numbers);
        self.renumbered += 1;
        self.surface = None;
    }

    /// Returns how often keyframes left, so that those after them got other numbers.
    #[must_use]
    pub const fn renumbered(&self) -> u64 {
        self.renumbered
    }
}
