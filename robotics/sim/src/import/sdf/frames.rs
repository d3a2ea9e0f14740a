//! Frames: the names that poses are relative to, and where they are (the proposal *Pose Frame Semantics* of SDFormat).
//!
//! A world and each model is a scope. The names of a scope are those of the frames, links, joints and models directly in
//! it; `a::b` is the `b` in the model `a`.

use std::collections::HashMap;
use std::collections::hash_map::Entry as ElementPlace;

use jde_files::{Budget, Exceeded};

use super::pose3::Pose3;

/// The memory of a frame: itself, its name and texts.
const FRAME: usize = size_of::<Frame>() + 160;

/// A pose as a file states it.
#[derive(Clone, Debug)]
pub(super) struct Stated {
    pub(super) pose: Pose3,
    /// The frame that it is in; empty for the one that its element implies.
    pub(super) relative_to: String,
}

impl Stated {
    pub(super) const ORIGIN: Self = Self {
        pose: Pose3::ORIGIN,
        relative_to: String::new(),
    };
}

/// A world or a model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Scope(usize);

/// A frame, a link, a joint or a model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Id(usize);

#[derive(Debug)]
struct ScopeFrames {
    /// The model; none for a world.
    model: Option<Id>,
    /// What leads to each name: the frame, or the models that it is in and the frame.
    names: HashMap<String, Vec<Id>>,
    /// Its pose in the world, once that is known.
    pose: Option<Result<Pose3, String>>,
}

#[derive(Debug)]
struct Frame {
    scope: Scope,
    stated: Stated,
    /// For a model: its scope, and the name there of the frame whose pose is stated instead of its own.
    inside: Option<(Scope, String)>,
    state: State,
}

#[derive(Debug)]
enum State {
    Unknown,
    /// Something that it depends on is being found.
    Waiting,
    /// Its pose in its scope.
    Known(Pose3),
    Failed(String),
}

/// All frames of a world.
#[derive(Debug)]
pub(super) struct Frames {
    frames: Vec<Frame>,
    scopes: Vec<ScopeFrames>,
}

impl Frames {
    pub(super) const WORLD: Scope = Scope(0);

    pub(super) fn new() -> Self {
        Self {
            frames: Vec::new(),
            scopes: vec![ScopeFrames {
                model: None,
                names: HashMap::new(),
                pose: Some(Ok(Pose3::ORIGIN)),
            }],
        }
    }

    /// Adds a frame. Of two of one name, the name denotes the first.
    pub(super) fn add(
        &mut self,
        scope: Scope,
        name: &str,
        stated: Stated,
        budget: &mut Budget,
    ) -> Result<Id, Exceeded> {
        budget.work(1)?;
        budget.hold(FRAME + 2 * name.len() + stated.relative_to.len())?;
        let id = Id(self.frames.len());
        self.frames.push(Frame {
            scope,
            stated,
            inside: None,
            state: State::Unknown,
        });
        if let ElementPlace::Vacant(place) = self.scopes[scope.0].names.entry(name.to_owned()) {
            place.insert(vec![id]);
        }
        Ok(id)
    }

    /// Makes a frame a model. `placed` is the name within of the frame whose pose is stated, or empty.
    pub(super) fn open(&mut self, model: Id, placed: &str) -> Scope {
        let scope = Scope(self.scopes.len());
        self.scopes.push(ScopeFrames {
            model: Some(model),
            names: HashMap::new(),
            pose: None,
        });
        self.frames[model.0].inside = Some((scope, placed.to_owned()));
        scope
    }

    /// Adds the names of a model to the scope that it is in, as if its parts were there.
    pub(super) fn merge(&mut self, model: Id, budget: &mut Budget) -> Result<(), Exceeded> {
        let Some((inside, _)) = self.frames[model.0].inside else {
            return Ok(());
        };
        let outside = self.frames[model.0].scope;
        let names = self.scopes[inside.0].names.clone();
        for (name, path) in names {
            budget.work(1)?;
            budget.hold(FRAME + name.len())?;
            if let ElementPlace::Vacant(place) = self.scopes[outside.0].names.entry(name) {
                place.insert([vec![model], path].concat());
            }
        }
        Ok(())
    }

    /// Returns the pose of a frame in its scope, or why it has none.
    pub(super) fn pose(&mut self, goal: Id) -> Result<Pose3, String> {
        // A chain of frames may be longer than a stack.
        let mut waiting = vec![goal];
        while let Some(&Id(index)) = waiting.last() {
            let found = match &self.frames[index].state {
                State::Known(pose) => Ok(Some(*pose)),
                State::Failed(reason) => Err(reason.clone()),
                State::Unknown | State::Waiting => self.attempt(index, &mut waiting),
            };
            self.frames[index].state = match found {
                Ok(Some(pose)) => State::Known(pose),
                Ok(None) => State::Waiting,
                Err(reason) => State::Failed(reason),
            };
            if !matches!(self.frames[index].state, State::Waiting) {
                waiting.pop();
            }
        }
        match &self.frames[goal.0].state {
            State::Known(pose) => Ok(*pose),
            State::Failed(reason) => Err(reason.clone()),
            State::Unknown | State::Waiting => Err("its pose is not known".to_owned()),
        }
    }

    /// Returns the pose of a frame, or `None` if another one must be found first, which is added to `waiting`.
    fn attempt(&self, index: usize, waiting: &mut Vec<Id>) -> Result<Option<Pose3>, String> {
        let frame = &self.frames[index];
        let base = self.path(frame.scope, &frame.stated.relative_to)?;
        let placed = match &frame.inside {
            Some((inside, placed)) => self.path(*inside, placed)?,
            None => Vec::new(),
        };
        for &Id(needed) in base.iter().chain(&placed) {
            match &self.frames[needed].state {
                State::Known(_) => {}
                State::Failed(reason) => return Err(reason.clone()),
                State::Waiting => return Err("its pose is relative to itself".to_owned()),
                State::Unknown if needed == index => return Err("its pose is relative to itself".to_owned()),
                State::Unknown => {
                    waiting.push(Id(needed));
                    return Ok(None);
                }
            }
        }
        let pose = self.along(&base).compose(frame.stated.pose);
        Ok(Some(pose.compose(self.along(&placed).inverse())))
    }

    /// Returns the pose at the end of a path of frames whose poses are known.
    fn along(&self, path: &[Id]) -> Pose3 {
        path.iter()
            .fold(Pose3::ORIGIN, |pose, id| match self.frames[id.0].state {
                State::Known(inner) => pose.compose(inner),
                State::Unknown | State::Waiting | State::Failed(_) => pose,
            })
    }

    /// Returns the pose in a scope of what a name denotes there.
    pub(super) fn named(&mut self, scope: Scope, name: &str) -> Result<Pose3, String> {
        let path = self.path(scope, name)?;
        for id in &path {
            self.pose(*id)?;
        }
        Ok(self.along(&path))
    }

    /// Returns the pose of a scope in the world.
    pub(super) fn scope(&mut self, scope: Scope) -> Result<Pose3, String> {
        // Models are within models to a limited depth.
        if let Some(pose) = &self.scopes[scope.0].pose {
            return pose.clone();
        }
        let pose = match self.scopes[scope.0].model {
            None => Ok(Pose3::ORIGIN),
            Some(model) => {
                let outer = self.scope(self.frames[model.0].scope);
                outer.and_then(|outer| Ok(outer.compose(self.pose(model)?)))
            }
        };
        self.scopes[scope.0].pose = Some(pose.clone());
        pose
    }

    /// Returns the frames that lead from a scope to a name.
    fn path(&self, Scope(index): Scope, name: &str) -> Result<Vec<Id>, String> {
        let (mut scope, mut path, mut rest) = (&self.scopes[index], Vec::new(), name);
        loop {
            let own = if scope.model.is_some() {
                "__model__"
            } else {
                "world"
            };
            if rest.is_empty() || rest == own {
                return Ok(path);
            }
            if let Some(found) = scope.names.get(rest) {
                path.extend(found);
                return Ok(path);
            }
            let inner = rest.split_once("::").and_then(|(first, behind)| {
                let found = scope.names.get(first)?;
                let (inside, _) = self.frames[found.last()?.0].inside.as_ref()?;
                Some((found, *inside, behind))
            });
            let Some((found, inside, behind)) = inner else {
                return Err(format!("its pose is relative to `{name}`, which is not there"));
            };
            path.extend(found);
            (scope, rest) = (&self.scopes[inside.0], behind);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Test {
        frames: Frames,
        budget: Budget,
    }

    impl Test {
        fn new() -> Self {
            Self {
                frames: Frames::new(),
                budget: Budget::default(),
            }
        }

        fn add(&mut self, scope: Scope, name: &str, x: f64, relative_to: &str) -> Id {
            let stated = Stated {
                pose: Pose3::at([x, 0.0, 0.0]),
                relative_to: relative_to.to_owned(),
            };
            self.frames.add(scope, name, stated, &mut self.budget).unwrap()
        }

        fn x(&mut self, id: Id) -> Result<f64, String> {
            self.frames.pose(id).map(|pose| pose.at[0])
        }
    }

    #[test]
    fn names_lead_into_models_and_placed_frames_stand_where_their_model_is_put() {
        let mut test = Test::new();
        let model = test.add(Frames::WORLD, "m", 10.0, "start");
        let inside = test.frames.open(model, "tip");
        test.add(inside, "tip", 3.0, "arm");
        test.add(inside, "arm", 1.0, "__model__");
        test.add(Frames::WORLD, "start", 0.5, "world");
        let beside = test.add(Frames::WORLD, "beside", 1.0, "m::arm");
        // The tip is at 10.5, four metres before the model.
        assert_eq!(test.x(model), Ok(6.5));
        assert_eq!(test.x(beside), Ok(8.5));
        assert_eq!(test.frames.scope(inside).unwrap().at[0], 6.5);
        let inner = test.add(inside, "inner", 2.0, "");
        let deep = test.frames.open(inner, "");
        test.add(deep, "leaf", 0.25, "");
        test.frames.merge(inner, &mut test.budget).unwrap();
        assert_eq!(test.frames.named(inside, "leaf").unwrap().at[0], 2.25);
        assert_eq!(
            test.frames.named(Frames::WORLD, "m::inner::leaf").unwrap().at[0],
            8.75
        );
    }

    #[test]
    fn long_chains_end_and_cycles_and_unknown_names_are_refused() {
        let mut test = Test::new();
        let mut last = test.add(Frames::WORLD, "0", 1.0, "");
        for number in 1..20_000 {
            last = test.add(Frames::WORLD, &number.to_string(), 1.0, &(number - 1).to_string());
        }
        assert_eq!(test.x(last), Ok(20_000.0));
        let first = test.add(Frames::WORLD, "a", 1.0, "b");
        let second = test.add(Frames::WORLD, "b", 1.0, "a");
        let own = test.add(Frames::WORLD, "c", 1.0, "c");
        for id in [first, second, own] {
            assert_eq!(test.x(id), Err("its pose is relative to itself".to_owned()));
        }
        let lost = test.add(Frames::WORLD, "d", 1.0, "a::nowhere");
        let message = "its pose is relative to `a::nowhere`, which is not there";
        assert_eq!(test.x(lost), Err(message.to_owned()));
    }
}
