//! When the robot counts as stuck, and which action of the recovery is next. It moves nothing.

use core::time::Duration;

use jde_schema::types::Pose2D;

/// How far the robot must move to make progress, m.
const PROGRESS: f64 = 0.25;

/// What can be done about a robot that is stuck, in this order.
const ACTIONS: [Action; 4] = [Action::Back, Action::Turn, Action::Clear, Action::Wait];

/// An action of the recovery.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Action {
    /// It goes back the way it came.
    Back,
    /// It turns on the spot.
    Turn,
    /// It has the map cleared.
    Clear,
    /// It lets the others wait.
    Wait,
}

/// The times and distances of an attempt.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Terms {
    /// Time without progress after which the robot counts as stuck, and the next action begins.
    pub(crate) patience: Duration,
    /// Time of the last action.
    pub(crate) wait: Duration,
    /// Distance from the place where it was stuck at which that is over, m.
    pub(crate) away: f64,
}

/// What is due.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Due {
    /// Nothing: the others drive.
    Nothing,
    /// This action begins.
    Begin(Action),
    /// Every action was in vain; in words, what was done.
    GiveUp(String),
}

/// The way to one target: the progress, and the actions that were tried.
#[derive(Clone, Debug)]
pub(crate) struct Attempt {
    target: Pose2D,
    /// Where progress was made last.
    place: Pose2D,
    /// When the next action begins if there is no progress.
    due_at: Duration,
    /// Where the first action began.
    stuck_at: Option<Pose2D>,
    next: usize,
    done: Vec<Action>,
}

impl Attempt {
    /// Begins at `pose`.
    pub(crate) fn new(target: Pose2D, pose: Pose2D, now: Duration, terms: &Terms) -> Self {
        Self {
            target,
            place: pose,
            due_at: now.saturating_add(terms.patience),
            stuck_at: None,
            next: 0,
            done: Vec::new(),
        }
    }

    /// Whether this is the way to `target`.
    pub(crate) fn is_to(&self, target: &Pose2D) -> bool {
        self.target == *target
    }

    /// Whether the robot is at the place where it was stuck.
    pub(crate) fn is_stuck(&self) -> bool {
        self.stuck_at.is_some()
    }

    /// Takes the pose while no action is under way, and returns what is due.
    pub(crate) fn advance(&mut self, pose: &Pose2D, now: Duration, terms: &Terms) -> Due {
        if self.stuck_at.is_some_and(|at| at.distance_to(pose) > terms.away) {
            *self = Self::new(self.target, *pose, now, terms);
        }
        if self.place.distance_to(pose) > PROGRESS {
            self.place = *pose;
            self.due_at = self.due_at.max(now.saturating_add(terms.patience));
        }
        if now < self.due_at {
            return Due::Nothing;
        }
        let Some(&action) = ACTIONS.get(self.next) else {
            let words = self.words();
            *self = Self::new(self.target, *pose, now, terms);
            return Due::GiveUp(words);
        };
        self.next += 1;
        self.stuck_at.get_or_insert(*pose);
        if action == Action::Wait {
            self.done.push(action);
            self.due_at = now.saturating_add(terms.wait);
        }
        Due::Begin(action)
    }

    /// Ends an action. If it was `possible`, the others drive next; otherwise the next action begins at once.
    pub(crate) fn end(
        &mut self,
        action: Action,
        possible: bool,
        pose: &Pose2D,
        now: Duration,
        terms: &Terms,
    ) {
        self.place = *pose;
        if possible {
            self.done.push(action);
            self.due_at = now.saturating_add(terms.patience);
        }
    }

    fn words(&self) -> String {
        let words: Vec<&str> = self.done.iter().map(|action| action.done()).collect();
        format!("in vain: {}", words.join(", "))
    }
}

impl Action {
    /// What it does, in words.
    pub(crate) const fn does(self) -> &'static str {
        match self {
            Self::Back => "goes back the way it came",
            Self::Turn => "turns on the spot",
            Self::Clear => "has the map cleared around it",
            Self::Wait => "waits",
        }
    }

    /// What it did, in words.
    const fn done(self) -> &'static str {
        match self {
            Self::Back => "went back",
            Self::Turn => "turned",
            Self::Clear => "asked to clear the map",
            Self::Wait => "waited",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TERMS: Terms = Terms {
        patience: Duration::from_secs(10),
        wait: Duration::from_secs(20),
        away: 1.0,
    };

    fn at(x: f64) -> Pose2D {
        Pose2D::new(x, 0.0, 0.0)
    }

    fn seconds(seconds: u64) -> Duration {
        Duration::from_secs(seconds)
    }

    fn attempt() -> Attempt {
        Attempt::new(at(9.0), at(0.0), Duration::ZERO, &TERMS)
    }

    #[test]
    fn a_robot_that_moves_is_not_stuck() {
        let mut attempt = attempt();
        for second in 0..100 {
            let pose = at(second as f64 * 0.03);
            assert_eq!(attempt.advance(&pose, seconds(second), &TERMS), Due::Nothing);
        }
        assert_eq!(
            attempt.advance(&at(3.0), seconds(120), &TERMS),
            Due::Begin(Action::Back)
        );
    }

    #[test]
    fn every_action_is_tried_and_then_it_gives_up_in_words() {
        let mut attempt = attempt();
        let mut advance = |second, end: Option<(Action, bool)>| {
            let due = attempt.advance(&at(0.0), seconds(second), &TERMS);
            if let Some((action, possible)) = end {
                attempt.end(action, possible, &at(0.0), seconds(second + 2), &TERMS);
            }
            due
        };
        assert_eq!(advance(9, None), Due::Nothing);
        assert_eq!(advance(10, Some((Action::Back, false))), Due::Begin(Action::Back));
        assert_eq!(
            advance(12, Some((Action::Turn, true))),
            Due::Begin(Action::Turn),
            "at once"
        );
        assert_eq!(advance(23, None), Due::Nothing, "the others drive");
        assert_eq!(
            advance(24, Some((Action::Clear, true))),
            Due::Begin(Action::Clear)
        );
        assert_eq!(advance(36, None), Due::Begin(Action::Wait));
        assert_eq!(advance(55, None), Due::Nothing);
        let words = "in vain: turned, asked to clear the map, waited";
        assert_eq!(advance(56, None), Due::GiveUp(words.into()));
        assert_eq!(advance(57, None), Due::Nothing, "it begins anew");
    }

    #[test]
    fn the_actions_go_on_at_the_same_place_and_begin_anew_at_another() {
        let mut attempt = attempt();
        assert_eq!(
            attempt.advance(&at(0.0), seconds(10), &TERMS),
            Due::Begin(Action::Back)
        );
        attempt.end(Action::Back, true, &at(-0.3), seconds(12), &TERMS);
        attempt.advance(&at(0.0), seconds(14), &TERMS);
        assert_eq!(
            attempt.advance(&at(0.0), seconds(24), &TERMS),
            Due::Begin(Action::Turn)
        );
        attempt.end(Action::Turn, true, &at(0.0), seconds(26), &TERMS);
        attempt.advance(&at(2.0), seconds(30), &TERMS);
        assert!(!attempt.is_stuck());
        assert_eq!(
            attempt.advance(&at(2.0), seconds(40), &TERMS),
            Due::Begin(Action::Back)
        );
    }
}
