//! Changes of a world while it runs: robots are put elsewhere, boxes added, things removed, movers halted,
//! colours raised.
//!
//! A change takes no simulated time. A refused one changes nothing.

use super::{RobotId, World};
use crate::edit::{Edit, EditAction};
use crate::error::WorldError;
use crate::file::BoxPlan;
use crate::loose::CONTACT_GAP;
use crate::mover::Mover;
use crate::robot::CONTACT;
use crate::scene::Fixture;
use crate::shape::Shape;
use crate::solid::Solid;

impl World {
    /// Makes a change. `robot` is the one that an edit places if it names none.
    ///
    /// Movers pass through a box that is added on their way. A robot cannot be removed.
    ///
    /// # Errors
    /// An unknown name; a name that is taken; a place that is not free, or for a robot outside the world's
    /// bounds.
    pub fn edit(&mut self, robot: RobotId, edit: &Edit) -> Result<(), WorldError> {
        match &edit.action {
            EditAction::Place(None, pose) => self.place(robot, *pose)?,
            EditAction::Place(Some(name), pose) => {
                let found = self.robots().find(|(_, known)| known == name).map(|(id, _)| id);
                let found =
                    found.ok_or_else(|| self.unknown("robot", name, self.robots().map(|(_, name)| name)))?;
                self.place(found, *pose)?;
            }
            EditAction::Add(plan) => self.add_box(plan)?,
            EditAction::Remove(name) => self.remove(name)?,
            EditAction::Halt(name) => self.halt(name, true)?,
            EditAction::Resume(name) => self.halt(name, false)?,
            EditAction::Raise(name) => self.signal(name, true)?,
            EditAction::Lower(name) => self.signal(name, false)?,
        }
        self.update_contacts();
        Ok(())
    }

    /// Returns how often the standing things have changed since the world was created.
    pub fn changes(&self) -> u64 {
        self.changes
    }

    fn add_box(&mut self, plan: &BoxPlan) -> Result<(), WorldError> {
        let (name, solid) = match plan {
            BoxPlan::Fixed(Fixture { name, outline, .. }, _) => (name, Solid::new(outline)),
            BoxPlan::Loose(body) => (&body.name, body.solid().clone()),
        };
        if self.shapes().any(|shape| shape.name == name) || self.robot_names().any(|robot| robot == name) {
            return Err(WorldError::NameTaken { name: name.clone() });
        }
        if let Some(by) = self.obstacle(&solid, matches!(plan, BoxPlan::Loose(_))) {
            let (name, by) = (name.clone(), by.to_owned());
            return Err(WorldError::BoxBlocked { name, by });
        }
        match plan {
            BoxPlan::Fixed(fixture, legs) => {
                self.scene.add([std::slice::from_ref(fixture), legs].concat());
                self.changes += 1;
            }
            BoxPlan::Loose(body) => self.loose.add(body.clone()),
        }
        Ok(())
    }

    /// Returns what a new box would overlap. Standing things may overlap one another, as in a file. A robot
    /// that has a box put down beside it has not collided with it.
    fn obstacle<'a>(&'a self, solid: &'a Solid, loose: bool) -> Option<&'a str> {
        let fixed = loose
            .then(|| self.scene.near(solid, CONTACT_GAP))
            .into_iter()
            .flatten();
        let movers = self
            .movers
            .iter()
            .map(|mover| (mover.name(), mover.solid().clone(), CONTACT_GAP));
        let bodies = self.loose.bodies().iter();
        let bodies = bodies.map(|body| (body.name.as_str(), body.solid().clone(), CONTACT_GAP));
        let robots = self.others(usize::MAX).map(|(index, body)| {
            let solid = if loose { body.circle() } else { body.solid() };
            (self.robot_slots[index].start.robot.as_str(), solid, CONTACT)
        });
        let mut near = movers
            .chain(bodies)
            .chain(robots)
            .filter(|(_, other, gap)| other.distance_to_solid(solid) < *gap)
            .map(|(name, ..)| name);
        near.next().or_else(|| fixed.into_iter().next())
    }

    fn remove(&mut self, name: &str) -> Result<(), WorldError> {
        let fixed = self.shapes().any(|shape| shape.name == name && !shape.moving) && self.scene.remove(name);
        self.changes += u64::from(fixed);
        let movers = self.movers.len();
        self.movers.retain(|mover| mover.name() != name);
        if self.loose.remove(name) || fixed || self.movers.len() < movers {
            return Ok(());
        }
        Err(self.unknown("thing", name, self.shapes().map(|Shape { name, .. }| name)))
    }

    fn halt(&mut self, name: &str, halted: bool) -> Result<(), WorldError> {
        let mut found = false;
        for mover in self.movers.iter_mut().filter(|mover| mover.name() == name) {
            mover.halt(halted);
            found = true;
        }
        if found {
            return Ok(());
        }
        Err(self.unknown("mover", name, self.movers.iter().map(Mover::name)))
    }

    fn signal(&mut self, name: &str, raised: bool) -> Result<(), WorldError> {
        let people = self.movers.iter_mut().filter(|mover| mover.person().is_some());
        let mut found = false;
        for person in people.filter(|person| person.name() == name) {
            person.signal(raised);
            found = true;
        }
        if found {
            return Ok(());
        }
        let people = self.movers.iter().filter(|mover| mover.person().is_some());
        Err(self.unknown("person", name, people.map(Mover::name)))
    }

    fn unknown<'a>(
        &self,
        kind: &'static str,
        name: &str,
        known: impl Iterator<Item = &'a str>,
    ) -> WorldError {
        let mut known: Vec<String> = known.map(str::to_owned).collect();
        known.sort_unstable();
        known.dedup();
        WorldError::UnknownThing {
            world: self.name.clone(),
            kind,
            name: name.to_owned(),
            nearest: jde_nearest::nearest(name, known.iter().map(String::as_str)).map(str::to_owned),
            known,
        }
    }
}
