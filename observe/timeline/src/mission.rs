//! The progress of a mission, and its targets as far as they are known.

use std::collections::BTreeMap;

use jde_types::{Mission, Route};

/// Most targets stored.
const MAX_TARGETS: usize = 1000;

/// What happened to a mission. Places are in the frame of the odometry.
#[derive(Clone, Debug, Default)]
pub struct MissionTimeline {
    newest: Option<Mission>,
    has_places: bool,
    route: Vec<(f64, f64)>,
    /// Targets from its progress, by the number of targets reached before. The first are missing if they were reached
    /// before it was watched.
    found: BTreeMap<usize, (f64, f64)>,
}

impl MissionTimeline {
    /// Adds its progress; `None` if it has no value any more.
    pub fn add(&mut self, mission: Option<Mission>) {
        self.newest = mission;
        let (Some(mission), Some(place)) = (self.newest, self.target()) else {
            return;
        };
        self.has_places = true;
        if mission.reached < mission.total && self.found.len() < MAX_TARGETS {
            self.found.entry(mission.reached as usize).or_insert(place);
        }
    }

    /// Sets the targets that it names in advance.
    pub fn set_route(&mut self, route: &Route) {
        self.route = route.poses.iter().map(|pose| (pose.x, pose.y)).collect();
    }

    /// Returns its progress.
    #[must_use]
    pub fn newest(&self) -> Option<&Mission> {
        self.newest.as_ref()
    }

    /// Returns the present target; `None` if there is none, or if it is not a place.
    #[must_use]
    pub fn target(&self) -> Option<(f64, f64)> {
        let mission = self.newest.as_ref()?;
        // A robot that has still to travel is at a distance above 0, so (0, 0) at a distance of 0 means no target.
        let target = (mission.target.x, mission.target.y);
        (target != (0.0, 0.0) || mission.distance > 0.0).then_some(target)
    }

    /// Whether any target so far was a place; if not, the note of the mission names what it counts.
    #[must_use]
    pub fn has_places(&self) -> bool {
        self.has_places
    }

    /// Returns the targets, each with the number of those before it: those of the route if there is one. A mission without
    /// any place has none.
    #[must_use]
    pub fn targets(&self) -> Vec<(usize, (f64, f64))> {
        if self.found.is_empty() {
            Vec::new()
        } else if self.route.is_empty() {
            self.found
                .iter()
                .map(|(before, place)| (*before, *place))
                .collect()
        } else {
            self.route.iter().copied().enumerate().collect()
        }
    }
}
