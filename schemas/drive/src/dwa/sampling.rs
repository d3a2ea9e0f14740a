//! The velocities that the base can reach, what the arc of each leads to, and the best one. Formulas only.

use jde_grid::costmap::MAX_PASSABLE;
use jde_motion::{BaseDynamics, Travel};
use jde_schema::types::{Pose2D, Twist};

use super::window::{Perimeter, Window};
use crate::track::Track;

/// Distance of the point ahead of the base that decides between two turns on the spot, m: that of ROS's
/// `base_local_planner`.
const NOSE: f64 = 0.325;

/// The velocities to try.
#[derive(Clone, Copy, Debug)]
pub(super) struct Samples {
    /// How many speeds and turn rates.
    pub(super) count: (u32, u32),
    /// Least and greatest speed ahead, m/s.
    pub(super) speed: (f64, f64),
    /// Least turn rate on the spot and greatest turn rate, rad/s.
    pub(super) turn: (f64, f64),
    pub(super) dynamics: BaseDynamics,
    /// How long the base accelerates before the next choice, s.
    pub(super) period: f64,
    /// How long a velocity is simulated, s.
    pub(super) horizon: f64,
    /// The side to which it turns on the spot, +1 for the left: a turn goes on until the way ahead is free. 0 for
    /// either.
    pub(super) spin: f64,
}

/// What the end of an arc costs.
#[derive(Clone, Copy, Debug)]
pub(super) struct Weights {
    /// For each metre from the path.
    pub(super) path: f64,
    /// For each metre from the point of the path to reach.
    pub(super) goal: f64,
    /// For the greatest cost of the map.
    pub(super) obstacle: f64,
}

/// What the robot is among.
pub(super) struct Scene<'scene> {
    pub(super) window: &'scene Window,
    pub(super) perimeter: &'scene Perimeter,
    pub(super) track: &'scene Track,
    /// How many points of the outline are on an obstacle now. An arc may not touch more, so that a robot that is
    /// too close can leave.
    pub(super) touching: u32,
    /// The way along the track to the point to reach, m.
    pub(super) goal: f64,
    pub(super) weights: Weights,
}

/// A velocity, and what its arc costs.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Choice {
    pub(super) twist: Twist,
    cost: f64,
    /// Decides among turns on the spot, which all end where they begin.
    nose: f64,
    /// The end of its arc.
    pub(super) end: Pose2D,
}

impl Samples {
    /// Returns the cheapest velocity whose arc touches nothing; `None` if all touch something.
    pub(super) fn best(&self, now: &Travel, scene: &Scene<'_>) -> Option<Choice> {
        let mut best: Option<Choice> = None;
        for twist in self.twists(now) {
            let Some(choice) = self.choice(now, twist, scene) else {
                continue;
            };
            let is_better = best
                .as_ref()
                .is_none_or(|best| (choice.cost, choice.nose) < (best.cost, best.nose));
            if is_better {
                best = Some(choice);
            }
        }
        best
    }

    /// Returns what the arc of a velocity costs; `None` if it touches something.
    pub(super) fn choice(&self, now: &Travel, twist: Twist, scene: &Scene<'_>) -> Option<Choice> {
        let spacing = scene.perimeter.spacing();
        // Neither the base nor what is ahead of it moves farther than a cell in a step.
        let (velocity, lead) = (&now.velocity, &now.lead);
        let ahead = [
            twist.linear.x,
            velocity.linear.x,
            velocity.linear.x + lead.linear.x,
        ];
        let turns = [
            twist.angular.z,
            velocity.angular.z,
            velocity.angular.z + lead.angular.z,
        ];
        let fastest = |of: [f64; 3]| of.into_iter().fold(0.0, |most: f64, speed| most.max(speed.abs()));
        let way = fastest(ahead).max(fastest(turns) * NOSE) * self.horizon;
        let steps = (way / spacing).ceil().max(1.0);
        let step = self.horizon / steps;
        let mut travel = *now;
        let mut obstacle = 0;
        for _ in 0..steps as u32 {
            travel = travel.after(step, &twist, &self.dynamics);
            let contact = scene.window.contact(&travel.pose, scene.perimeter);
            if contact.touching > scene.touching {
                return None;
            }
            obstacle = obstacle.max(contact.cost);
        }
        let end = travel.pose;
        let nose = end.transform(&Pose2D::new(NOSE, 0.0, 0.0));
        Some(Choice {
            twist,
            cost: scene.cost(&end) + scene.weights.obstacle * f64::from(obstacle) / f64::from(MAX_PASSABLE),
            nose: scene.cost(&nose),
            end,
        })
    }

    /// The dynamic window: what the base can strive for within the period, and always a turn on the spot. A lagging base
    /// would accelerate by its lag alone within a window around its velocity.
    pub(super) fn twists(&self, now: &Travel) -> impl Iterator<Item = Twist> + use<> {
        let Self {
            count: (speeds, turns),
            speed: (slow, fast),
            turn: (least_turn, turn),
            dynamics,
            period,
            spin,
            ..
        } = *self;
        let window = |now: f64, low: f64, high: f64, (up, down): (f64, f64)| {
            let less = if now > 0.0 { down } else { up };
            let more = if now < 0.0 { down } else { up };
            (
                (now - less * period).clamp(low, high),
                (now + more * period).clamp(low, high),
            )
        };
        let (speed_rates, turn_rates) = (
            (dynamics.acceleration, dynamics.deceleration),
            (dynamics.turn_acceleration, dynamics.turn_deceleration),
        );
        let (ahead, turns_by) = (
            now.velocity.linear.x + now.lead.linear.x,
            now.velocity.angular.z + now.lead.angular.z,
        );
        let speed_window = window(ahead, slow, fast, speed_rates);
        let turn_window = window(turns_by, -turn, turn, turn_rates);
        let ahead = values(speed_window, speeds).flat_map(move |speed| {
            let straight =
                core::iter::once(0.0).filter(move |_| turn_window.0 <= 0.0 && turn_window.1 >= 0.0);
            let rates = straight.chain(values(turn_window, turns));
            rates.map(move |turn| Twist::planar(speed, turn))
        });
        let spot =
            values((-turn, turn), turns).filter(move |rate| rate.abs() >= least_turn && rate * spin >= 0.0);
        ahead.chain(spot.map(|turn| Twist::planar(0.0, turn)))
    }
}

impl Scene<'_> {
    /// What it costs to be at a place.
    fn cost(&self, place: &Pose2D) -> f64 {
        let way = self.track.nearest(place, None);
        let aside = self.track.at(way).distance_to(place);
        self.weights.path * aside + self.weights.goal * (aside + (self.goal - way).abs())
    }
}

/// `count` values from one end to the other.
fn values((low, high): (f64, f64), count: u32) -> impl Iterator<Item = f64> {
    let steps = f64::from(count.max(2) - 1);
    (0..count.max(2)).map(move |step| low + (high - low) * f64::from(step) / steps)
}
