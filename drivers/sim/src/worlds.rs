//! The worlds of this process, shared by the robots of one application. It opens, lends and keeps one driver to a robot; it
//! steps nothing.

use std::fs;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};

use jde_sim::{HeadCommand, RobotConfig, RobotId, Twist2, World, WorldError};

/// Worlds that some robot is in; the last to leave one takes it along. Applications do not see each other's.
static OPEN: Mutex<Vec<(Key, Weak<Shared>)>> = Mutex::new(Vec::new());

/// Which application opened which file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Key {
    application: u64,
    file: PathBuf,
}

/// A world, and the robots in it that have a driver now.
pub(crate) struct Shared {
    world: Mutex<World>,
    driven: Mutex<Vec<RobotId>>,
}

/// The one driver's hold on a robot. Let go of, the robot stands still where it is, until another takes it.
pub(crate) struct Hold {
    shared: Arc<Shared>,
    robot: RobotId,
}

/// Why a robot has no driver.
#[derive(Debug, thiserror::Error)]
pub(crate) enum HoldError {
    #[error(transparent)]
    World(#[from] WorldError),
    #[error(
        "robot `{0}` has a driver already: give each driver its own, by its name or by `robot = \"...\"`"
    )]
    Driven(String),
}

impl Hold {
    /// Takes a robot of the application's world of that file: the world that is open, or a new one at time 0.
    ///
    /// A robot that another driver left in it, as one that faulted does, is found where it was left.
    pub(crate) fn take(
        (application, path, seed): (u64, &str, u64),
        name: &str,
        config: RobotConfig,
    ) -> Result<Self, HoldError> {
        let shared = open(Key::new(application, path), path, seed)?;
        // Held until the end, so that of two who want one robot the second sees the first.
        let mut driven = lock(&shared.driven);
        let robot = enter(&mut lock(&shared.world), name, config)?;
        if driven.contains(&robot) {
            return Err(HoldError::Driven(name.to_owned()));
        }
        driven.push(robot);
        drop(driven);
        Ok(Self { shared, robot })
    }

    /// The world, for as long as no other robot needs it.
    pub(crate) fn world(&self) -> MutexGuard<'_, World> {
        lock(&self.shared.world)
    }

    /// Has the robot stand still, and its head stay as it is.
    pub(crate) fn rest(&self) {
        let mut world = self.world();
        // Nothing at all is finite, which is all that a command must be.
        let _ = world.command(self.robot, Twist2::default());
        let _ = world.command_head(self.robot, HeadCommand::default());
    }

    /// The robot in it.
    pub(crate) fn robot(&self) -> RobotId {
        self.robot
    }
}

impl Drop for Hold {
    fn drop(&mut self) {
        self.rest();
        lock(&self.shared.driven).retain(|robot| *robot != self.robot);
    }
}

/// The world of that key, if a robot's driver has opened it.
pub(crate) fn find(key: &Key) -> Option<Arc<Shared>> {
    let open = lock(&OPEN);
    let known = open.iter().find(|(known, _)| known == key);
    known.and_then(|(_, shared)| shared.upgrade())
}

impl Key {
    /// However the path of a file is written, its world is one; a file that is not there is known by the text.
    pub(crate) fn new(application: u64, path: &str) -> Self {
        let file = fs::canonicalize(path).unwrap_or_else(|_| path.into());
        Self { application, file }
    }
}

impl Shared {
    /// The world, for as long as no robot needs it.
    pub(crate) fn lock(self: &Arc<Self>) -> MutexGuard<'_, World> {
        lock(&self.world)
    }
}

fn open(key: Key, path: &str, seed: u64) -> Result<Arc<Shared>, WorldError> {
    let mut open = lock(&OPEN);
    open.retain(|(_, shared)| shared.strong_count() > 0);
    let known = open.iter().find(|(known, _)| *known == key);
    if let Some(shared) = known.and_then(|(_, shared)| shared.upgrade()) {
        return Ok(shared);
    }
    let shared = Arc::new(Shared {
        world: Mutex::new(World::load(path, seed)?),
        driven: Mutex::default(),
    });
    open.push((key, Arc::downgrade(&shared)));
    Ok(shared)
}

fn enter(world: &mut World, name: &str, config: RobotConfig) -> Result<RobotId, WorldError> {
    let there = world.robots().find(|(_, known)| *known == name);
    match there.map(|(robot, _)| robot) {
        Some(robot) => Ok(robot),
        None => world.add_robot(name, config),
    }
}

/// A world is never left half stepped: a panic inside one is as good a reason as any to go on with what is there.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
