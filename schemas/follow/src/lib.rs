//! Following: the father that leads a robot after a person. It commands no actuator; a child drives along the way that it
//! exports.

mod following;
mod panel;

use jde_motion::{is_finite, is_jump};
use jde_schema::prelude::*;
use jde_schema::types::{Person as Tracked, Persons, Point2D};

use following::{Following, State, Terms};

/// A step of the pose beyond which it is a jump, and no motion, m.
const JUMP: f64 = 1.0;
/// Persons who are older than this are not seen.
const MAX_AGE: Duration = Duration::from_millis(500);

/// Leads the robot after a person, along the way of that person.
///
/// It exports the way up to `distance` before the person, and wakes the schemas that drive along it. While the person
/// is near, or the way is not free, the robot stands. A lost person is searched for at the end of the trail and
/// beyond, and a person who is new there is taken for the same. It is READY until it gives up.
#[derive(Describe)]
#[schema(motor, period = "100ms", budget = "20ms")]
pub struct Person {
    /// The persons, from `people`.
    #[import]
    persons: Import<Persons>,
    /// The pose of the robot, in the frame of the persons. One that is not finite counts as none.
    #[import]
    pose: Import<Odometry>,
    /// The number of the person to follow; 0 for the nearest one ahead.
    #[modulation(default = 0)]
    id: Modulation<u32>,
    /// Greatest distance at which a person is chosen without a number.
    #[modulation(default = 4.0, unit = "m", min = 0.1)]
    choose: Modulation<f64>,
    /// Distance to keep from the middle of the person to that of the robot.
    #[modulation(default = 1.2, unit = "m", min = 0.3, max = 10.0)]
    distance: Modulation<f64>,
    /// Greatest speed of the robot.
    #[modulation(default = 1.0, unit = "m/s", min = 0.05)]
    speed: Modulation<f64>,
    /// How long a lost person is searched.
    #[modulation(default = 20.0, unit = "s", min = 0.0, max = 3600.0)]
    patience: Modulation<f64>,
    /// Time for which the robot stands near the person until the mission is done; 0 for never.
    #[modulation(default = 0.0, unit = "s", min = 0.0, max = 3600.0)]
    arrival: Modulation<f64>,
    /// The present activity in words, the last place of the person and the distance to it. FAILED once the person is
    /// given up.
    #[export(lasting)]
    mission: Export<Mission>,
    /// The way to go, in the frame of the pose. Retracted while the robot stands.
    #[export]
    path: Export<Path>,
    /// Drives along the way.
    #[child(group = "base")]
    drive: Child,
    /// The greatest speed of that child: that of the person, and more while the person is farther away.
    #[modulates(child = "drive", name = "vx_max", optional)]
    fast: Modulates<f64>,
    following: Following,
    state: State,
    /// When the last step was, and where the robot was.
    last: Option<Duration>,
    from: Option<Pose2D>,
    /// When the pose has jumped. Older persons are where they were by the pose before.
    jumped: Option<Duration>,
    /// Whether it has led the robot since the last step.
    leads: bool,
    /// Why the persons cannot be used.
    trouble: Option<&'static str>,
}

impl Schema for Person {
    fn awake(&mut self, _: &Context) -> Result {
        self.following = Following::default();
        (self.state, self.last, self.from) = (State::Nobody, None, None);
        self.leads = false;
        Ok(())
    }

    fn check(&mut self, cx: &Context) -> Result<Precondition> {
        self.step(cx);
        Ok((!matches!(self.state, State::Nobody | State::GaveUp)).into())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        // The check of the same turn has taken the persons.
        self.leads = true;
        self.drive.wake(cx);
        self.fast
            .set(cx, self.following.pace(&self.terms(cx)).min(self.speed.get(cx)));
        Ok(())
    }
}

impl Person {
    fn step(&mut self, cx: &Context) {
        let time = self
            .last
            .map_or(Duration::ZERO, |last| cx.now().saturating_sub(last));
        self.last = Some(cx.now());
        let leads = core::mem::take(&mut self.leads);
        let Some(odometry) = self.pose.get(cx).filter(|pose| is_finite(pose)) else {
            self.path.retract(cx);
            return;
        };
        let pose = odometry.pose2d();
        if let Some(from) = self.from.replace(pose)
            && is_jump(&from, &pose, JUMP)
        {
            self.jumped = Some(cx.now());
            if !matches!(self.state, State::Arrived | State::GaveUp) {
                let way = from.distance_to(&pose);
                warn!(cx, "the pose jumped by {way:.2} m: it begins anew");
                (self.following, self.state) = (Following::default(), State::Nobody);
            }
        }
        let persons = self.persons.get(cx);
        let persons = persons.filter(|persons| {
            let is_old = cx.now().saturating_sub(persons.time()) > MAX_AGE;
            !is_old && self.jumped.is_none_or(|jumped| persons.time() > jumped)
        });
        let is_same = |persons: &Persons| persons.header.frame_id == odometry.header.frame_id;
        let is_usable = persons.as_deref().is_none_or(is_same);
        self.trouble = (!is_usable).then_some("the persons are in another frame than the pose");
        let all = persons
            .as_ref()
            .map_or(&[][..], |persons| persons.persons.as_slice());
        let is_somewhere = |person: &&Tracked| {
            let (Point2D { x, y }, [ahead, left]) = (person.position, person.velocity);
            is_usable && [x, y, ahead, left].into_iter().all(f64::is_finite)
        };
        let usable: Vec<Tracked> = all.iter().filter(is_somewhere).copied().collect();
        let terms = self.terms(cx);
        self.state = self
            .following
            .step(&terms, (time.as_secs_f64(), leads), &pose, &usable);
        let place = self.following.place().unwrap_or_default();
        let target = Pose2D::new(place.x, place.y, 0.0);
        let mission = Mission {
            state: match self.state {
                State::Arrived => Mission::DONE,
                State::GaveUp => Mission::FAILED,
                State::Nobody | State::Follows(_) | State::Near(_) | State::Searches(_) => Mission::RUNNING,
            },
            reached: (self.state == State::Arrived).into(),
            total: 1,
            note: Text::truncated(&self.words()),
            target,
            distance: pose.distance_to(&target),
            ..Mission::default()
        };
        self.mission.write(cx, mission);
        let way = self.following.way(terms.distance);
        if way.is_empty() || !is_usable {
            self.path.retract(cx);
            return;
        }
        let way = way.iter().map(|point| (point.x, point.y));
        let points: Vec<_> = core::iter::once((pose.x, pose.y)).chain(way).collect();
        self.path.write(cx, Path::through(odometry.header, &points));
    }

    fn terms(&self, cx: &Context) -> Terms {
        Terms {
            id: self.id.get(cx),
            choose: self.choose.get(cx),
            distance: self.distance.get(cx),
            patience: self.patience.get(cx),
            arrival: self.arrival.get(cx),
        }
    }

    fn words(&self) -> String {
        let id = self.following.id();
        if let Some(trouble) = self.trouble {
            return trouble.into();
        }
        match self.state {
            State::Nobody => "nobody to follow".into(),
            State::Follows(away) => format!("follows person {id}, {away:.1} m away"),
            State::Near(_) => format!("stands near person {id}"),
            State::Searches(time) => format!("searches person {id}, last seen {time:.0} s ago"),
            State::Arrived => format!("arrived with person {id}"),
            State::GaveUp => format!("gave up: person {id} was not found again"),
        }
    }
}

jde_schema::export!("follow", "Leads a robot after a person.", [Person]);

#[cfg(test)]
mod tests;
