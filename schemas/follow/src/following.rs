//! Whom the robot follows, the way that the person went, and when the person counts as lost. No port, no clock.

use std::collections::VecDeque;

use jde_schema::types::{Person, Point2D, Pose2D};

/// Distance from one point of a trail to the next, m.
const STEP: f64 = 0.1;
/// The most points of a trail: 25 m.
const MAX_TRAIL_POINTS: usize = 250;
/// How long a person may be hidden and is not lost, s.
const MAX_HIDDEN_TIME: f64 = 0.5;
/// The speed up to which a person stands, m/s.
const STANDING_SPEED: f64 = 0.2;
/// How far beyond the distance to keep a person counts as near, m: who was not near before, and who was. For a person who
/// stands, and for one who walks.
const STANDING_MARGIN: [f64; 2] = [0.35, 0.5];
const WALKING_MARGIN: [f64; 2] = [-0.2, 0.0];
/// The growth of the robot's speed with each metre that the person is too far away, 1/s, and its least speed, m/s.
const PACE: f64 = 0.8;
const MIN_SPEED: f64 = 0.3;
/// How far beyond the place where a lost person was last the robot goes on in the same direction, m.
const SEARCH_DISTANCE: f64 = 1.5;
/// How near the robot must have been to where a lost person was last before it goes on, m.
const ARRIVAL_DISTANCE: f64 = 0.5;
/// Where a person may be who was not seen: so far from the last place, m, so much farther for each second, m/s, and at most
/// so far, m.
const SEARCH_RADIUS: [f64; 3] = [1.0, 1.0, 4.0];
/// How long persons who may be the lost one are compared, s.
const COMPARISON_TIME: f64 = 0.5;
/// The angle to either side of straight ahead in which the robot chooses somebody, rad.
const CHOICE_ANGLE: f64 = core::f64::consts::FRAC_PI_3;

/// What the robot keeps to.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Terms {
    /// The number of the person; 0 for the nearest one ahead.
    pub(crate) id: u32,
    /// How near that one must be, m.
    pub(crate) choose: f64,
    /// The distance to keep, m.
    pub(crate) distance: f64,
    /// How long it searches a lost person, s.
    pub(crate) patience: f64,
    /// How long it stands near a person until it has arrived, s; 0 for never.
    pub(crate) arrival: f64,
}

/// What the robot does.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) enum State {
    /// There is nobody to follow.
    #[default]
    Nobody,
    /// The person is this far away, m.
    Follows(f64),
    /// It stands near the person, for so long, s.
    Near(f64),
    /// The person has been lost for so long, s.
    Searches(f64),
    /// It stood near the person for long enough.
    Arrived,
    /// It has given the person up.
    GaveUp,
}

/// A person who is followed.
#[derive(Clone, Debug, Default)]
pub(crate) struct Following {
    /// Whom it follows; 0 for nobody.
    id: u32,
    /// The number that was asked for when it chose.
    asked: u32,
    /// Where the person was last.
    place: Option<Point2D>,
    /// Where the person was, from long ago to now; and where a lost one may be.
    trail: VecDeque<Point2D>,
    /// The velocity when the person was last seen, m/s.
    velocity: [f64; 2],
    /// The greatest number of all persons so far.
    newest: u32,
    /// The same when the person was lost.
    known: u32,
    /// How long the person has not been seen, s, and how long the robot has searched.
    unseen: f64,
    searched: f64,
    /// For how long there has been somebody who may be the lost person, s.
    compared: f64,
    state: State,
}

impl Following {
    /// Whom the robot follows; 0 for nobody.
    pub(crate) fn id(&self) -> u32 {
        self.id
    }

    /// Where the person was last.
    pub(crate) fn place(&self) -> Option<Point2D> {
        self.place
    }

    /// The way that the person went and may have gone, as far as the robot has not gone it.
    pub(crate) fn trail(&self) -> impl Iterator<Item = Point2D> + '_ {
        self.trail.iter().copied()
    }

    /// Follows this person from now on.
    pub(crate) fn choose(&mut self, person: &Person) {
        *self = Self {
            id: person.id,
            asked: self.asked,
            newest: self.newest,
            known: self.newest,
            place: Some(person.position),
            trail: VecDeque::from([person.position]),
            state: State::Follows(0.0),
            ..Self::default()
        };
    }

    /// Takes the persons after `time` s with the robot at `pose`. Only while it `leads` the robot, it searches and arrives.
    pub(crate) fn step(
        &mut self,
        terms: &Terms,
        (time, leads): (f64, bool),
        pose: &Pose2D,
        persons: &[Person],
    ) -> State {
        self.newest = persons.iter().map(|person| person.id).fold(self.newest, u32::max);
        if self.state == State::GaveUp || self.state == State::Arrived {
            return self.state;
        }
        if self.id == 0 || terms.id != self.asked {
            let Some(person) = chosen(terms, pose, persons) else {
                (self.id, self.place) = (0, None);
                self.trail.clear();
                self.state = State::Nobody;
                return self.state;
            };
            self.asked = terms.id;
            self.choose(&person);
        }
        self.watch(time, persons);
        self.pass(pose);
        let own = if leads { time } else { 0.0 };
        self.searched = if self.unseen > 0.0 {
            self.searched + own
        } else {
            0.0
        };
        let away = self.place().map_or(0.0, |place| distance(pose, &place));
        let is_near = |state: State| {
            let [start, stay] = if self.speed() < STANDING_SPEED {
                STANDING_MARGIN
            } else {
                WALKING_MARGIN
            };
            away < terms.distance
                + if matches!(state, State::Near(_)) {
                    stay
                } else {
                    start
                }
        };
        self.state = match self.state {
            _ if self.searched > terms.patience => State::GaveUp,
            _ if self.unseen > MAX_HIDDEN_TIME => State::Searches(self.unseen),
            State::Near(stood) if terms.arrival > 0.0 && stood + own >= terms.arrival => State::Arrived,
            state if !is_near(state) => State::Follows(away),
            State::Near(stood) => State::Near(stood + own),
            _ => State::Near(0.0),
        };
        self.state
    }

    /// Takes the person's place, or that of somebody new who must be the same.
    fn watch(&mut self, time: f64, persons: &[Person]) {
        // Who has the number elsewhere is somebody else: whoever tracks the persons may have begun to count anew.
        let own = persons.iter().find(|person| {
            person.id == self.id && person.unseen == 0.0 && self.may_be_at(&person.position, time)
        });
        let found = own.or_else(|| self.same(time, persons));
        let was_lost = self.unseen > MAX_HIDDEN_TIME;
        let Some(person) = found else {
            self.unseen += time;
            if self.unseen > MAX_HIDDEN_TIME && !was_lost {
                self.trail.extend(self.beyond());
            }
            return;
        };
        if was_lost {
            self.trail.pop_back();
        }
        (self.id, self.velocity) = (person.id, person.velocity);
        (self.unseen, self.compared) = (0.0, 0.0);
        self.known = self.newest;
        self.place = Some(person.position);
        self.lead_to(person.position);
    }

    /// Leads the trail on to there, straight where the person was out of sight.
    fn lead_to(&mut self, there: Point2D) {
        let from = self.trail.back().copied();
        let steps = from.map_or(1.0, |from| {
            (between(&there, &from) / STEP)
                .floor()
                .min(MAX_TRAIL_POINTS as f64)
        });
        let from = from.unwrap_or(there);
        for step in 1..=steps as usize {
            let share = step as f64 / steps;
            self.trail.push_back(Point2D {
                x: from.x + share * (there.x - from.x),
                y: from.y + share * (there.y - from.y),
            });
        }
        while self.trail.len() > MAX_TRAIL_POINTS {
            self.trail.pop_front();
        }
    }

    /// Returns somebody new who must be the lost person: the one that fits best after some time, since others may come
    /// into view before.
    fn same<'a>(&mut self, time: f64, persons: &'a [Person]) -> Option<&'a Person> {
        let place = self.place.filter(|_| self.unseen > MAX_HIDDEN_TIME)?;
        let (expected, reach) = (self.expected()?, self.reach(0.0));
        let misfit = |person: &&Person| {
            let [ahead, left] = [0, 1].map(|axis| person.velocity[axis] - self.velocity[axis]);
            between(&person.position, &expected) + libm::hypot(ahead, left)
        };
        let fits = persons.iter().filter(|person| {
            let is_near = between(&person.position, &place) < reach;
            person.id > self.known && person.unseen == 0.0 && is_near
        });
        let best = fits.min_by(|a, b| misfit(a).total_cmp(&misfit(b)))?;
        self.compared += time;
        (self.compared >= COMPARISON_TIME).then_some(best)
    }

    /// How far from the last place the person may be in `time` s, m.
    fn reach(&self, time: f64) -> f64 {
        let [near, growth, most] = SEARCH_RADIUS;
        (near + growth * (self.unseen + time)).min(most)
    }

    /// Where the person is with the last velocity.
    fn expected(&self) -> Option<Point2D> {
        let [_, growth, most] = SEARCH_RADIUS;
        let (place, time) = (self.place?, self.unseen.min(most / growth));
        Some(Point2D {
            x: place.x + time * self.velocity[0],
            y: place.y + time * self.velocity[1],
        })
    }

    /// Whether the person may be there in `time` s: near the last place, or where the last velocity leads.
    fn may_be_at(&self, there: &Point2D, time: f64) -> bool {
        let mut from = [self.place, self.expected()].into_iter().flatten();
        from.any(|from| between(&from, there) < self.reach(time))
    }

    /// Where a person may be who is lost: on in the same direction.
    fn beyond(&self) -> Option<Point2D> {
        let (place, speed) = (self.place?, self.speed());
        let scale = if speed > STANDING_SPEED {
            SEARCH_DISTANCE / speed
        } else {
            0.0
        };
        Some(Point2D {
            x: place.x + scale * self.velocity[0],
            y: place.y + scale * self.velocity[1],
        })
    }

    /// Forgets what the robot has passed: all before the nearest point where the person was, and that one if the way leads
    /// on. Nobody was at the point of a search beyond the last place: it counts only once the robot is at that place.
    fn pass(&mut self, pose: &Pose2D) {
        let seen = self
            .trail
            .len()
            .saturating_sub(usize::from(self.unseen > MAX_HIDDEN_TIME));
        let nearest = (0..seen)
            .min_by(|&a, &b| distance(pose, &self.trail[a]).total_cmp(&distance(pose, &self.trail[b])));
        let mut passed = nearest.unwrap_or(0);
        if let (Some(from), Some(to)) = (self.trail.get(passed), self.trail.get(passed + 1))
            && (pose.x - from.x) * (to.x - from.x) + (pose.y - from.y) * (to.y - from.y) > 0.0
            && (passed + 1 < seen || distance(pose, from) < ARRIVAL_DISTANCE)
        {
            passed += 1;
        }
        self.trail.drain(..passed);
    }

    /// The speed of the person when last seen, m/s.
    fn speed(&self) -> f64 {
        libm::hypot(self.velocity[0], self.velocity[1])
    }

    /// How fast the robot shall go, m/s: as the person, and faster if the person is farther away.
    pub(crate) fn pace(&self, terms: &Terms) -> f64 {
        match self.state {
            State::Follows(away) => (self.speed() + PACE * (away - terms.distance)).max(MIN_SPEED),
            State::Searches(_) => self.speed().max(MIN_SPEED) + PACE,
            State::Nobody | State::Near(_) | State::Arrived | State::GaveUp => MIN_SPEED,
        }
    }

    /// The points of the way that the robot shall go now; none while it stands.
    pub(crate) fn way(&self, keep: f64) -> Vec<Point2D> {
        let Some(place) = self.place() else {
            return Vec::new();
        };
        match self.state {
            State::Follows(_) => {
                let is_before = |point: &Point2D| between(point, &place) >= keep;
                let mut way: Vec<Point2D> = self.trail().take_while(is_before).collect();
                if way.is_empty() {
                    // There is no trail yet: straight to the person, and `step` ends it in time.
                    way.push(place);
                }
                way
            }
            State::Searches(_) => self.trail().collect(),
            State::Nobody | State::Near(_) | State::Arrived | State::GaveUp => Vec::new(),
        }
    }
}

/// Returns whom to follow: the person with the number, or the nearest one ahead.
fn chosen(terms: &Terms, pose: &Pose2D, persons: &[Person]) -> Option<Person> {
    let seen = persons.iter().filter(|person| person.unseen == 0.0);
    let fits = seen.filter(|person| {
        let target = Pose2D::new(person.position.x, person.position.y, 0.0);
        let is_ahead =
            pose.bearing_to(&target).abs() < CHOICE_ANGLE && pose.distance_to(&target) < terms.choose;
        if terms.id == 0 {
            is_ahead
        } else {
            person.id == terms.id
        }
    });
    let away = |person: &&Person| distance(pose, &person.position);
    fits.min_by(|a, b| away(a).total_cmp(&away(b))).copied()
}

fn distance(pose: &Pose2D, point: &Point2D) -> f64 {
    libm::hypot(point.x - pose.x, point.y - pose.y)
}

fn between(a: &Point2D, b: &Point2D) -> f64 {
    libm::hypot(a.x - b.x, a.y - b.y)
}
