//! The worlds of this process, shared by the robots of one application. This module opens and lends them, and
//! permits one driver per robot. It steps nothing.

use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;
use std::sync::{Arc, Weak};

use jde_sim::{HeadCommand, LaserModel, RobotId, Twist2, World, WorldError};
use parking_lot::{Mutex, MutexGuard};

use crate::edits::EditProgress;

/// Open worlds. A world closes with its last holder. Applications do not share worlds.
static OPEN_WORLDS: Mutex<Vec<(Key, Weak<SharedWorld>)>> = Mutex::new(Vec::new());

/// The application, and the file that it opened.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Key {
    application: u64,
    file: PathBuf,
}

/// A world, and the robots in it that have a driver.
pub(crate) struct SharedWorld {
    world: Mutex<World>,
    driven: Mutex<Vec<RobotId>>,
    /// The edits that each robot's driver has made. They outlive a driver that restarts, as the world does.
    edits: Mutex<BTreeMap<RobotId, EditProgress>>,
    /// The lasers of each robot that has had a driver.
    lasers: Mutex<BTreeMap<RobotId, Vec<LaserModel>>>,
}

/// The exclusive access of one driver to a robot. When it is dropped, the robot stops where it is until another
/// driver takes it.
pub(crate) struct RobotClaim {
    shared: Arc<SharedWorld>,
    robot: RobotId,
}

/// The reason why a driver cannot take a robot.
#[derive(Debug, thiserror::Error)]
pub(crate) enum ClaimError {
    /// Why there is no such world, or no such robot in it, with the faulty lines.
    #[error("{0}")]
    World(String),
    #[error(
        "robot `{0}` has a driver already: give each driver its own, by its name or by `robot = \"...\"`"
    )]
    Driven(String),
}

impl From<WorldError> for ClaimError {
    fn from(error: WorldError) -> Self {
        Self::World(format!("{error:#}"))
    }
}

impl RobotClaim {
    /// Takes a robot of the application's world of that file: the open world, or a new one at time 0. `enter`
    /// finds the robot in the world, or adds it.
    ///
    /// A robot that an earlier driver left in the world, such as one that faulted, is where that driver left
    /// it.
    pub(crate) fn acquire(
        (application, path, seed): (u64, &str, u64),
        lasers: Vec<LaserModel>,
        enter: impl FnOnce(&mut World) -> Result<RobotId, WorldError>,
    ) -> Result<Self, ClaimError> {
        let shared = open(Key::new(application, path), path, seed)?;
        // Held until the end, so that of two drivers that take one robot, the second is refused.
        let mut driven = shared.driven.lock();
        let mut world = shared.world.lock();
        let robot = enter(&mut world)?;
        if driven.contains(&robot) {
            return Err(ClaimError::Driven(world.robot_name(robot).to_owned()));
        }
        drop(world);
        shared.lasers.lock().insert(robot, lasers);
        driven.push(robot);
        drop(driven);
        Ok(Self { shared, robot })
    }

    /// Locks the world. Other robots wait until it is unlocked.
    pub(crate) fn world(&self) -> MutexGuard<'_, World> {
        self.shared.world.lock()
    }

    /// Locks the edits that the drivers of this world have made. The world may be locked already.
    pub(crate) fn edits(&self) -> MutexGuard<'_, BTreeMap<RobotId, EditProgress>> {
        self.shared.edits.lock()
    }

    /// Stops the robot and holds its head.
    pub(crate) fn stop(&self) {
        let mut world = self.world();
        // Zero commands are finite, which is all that a command must be, so these calls cannot fail.
        let _ = world.command(self.robot, Twist2::default());
        let _ = world.command_head(self.robot, HeadCommand::default());
    }

    /// The robot in the world.
    pub(crate) fn robot(&self) -> RobotId {
        self.robot
    }
}

impl Drop for RobotClaim {
    fn drop(&mut self) {
        self.stop();
        self.shared.driven.lock().retain(|robot| *robot != self.robot);
    }
}

/// Reads a world to inspect it. An error shows the faulty lines.
pub(crate) fn load(path: &str, seed: u64) -> Result<World, String> {
    World::load(path, seed).map_err(|error| format!("{error:#}"))
}

/// Returns the world of that key, if a robot's driver has opened it.
pub(crate) fn find(key: &Key) -> Option<Arc<SharedWorld>> {
    let open = OPEN_WORLDS.lock();
    let known = open.iter().find(|(known, _)| known == key);
    known.and_then(|(_, shared)| shared.upgrade())
}

impl Key {
    /// All spellings of a path give the same key. A file that does not exist has its text as key.
    pub(crate) fn new(application: u64, path: &str) -> Self {
        let file = fs::canonicalize(path).unwrap_or_else(|_| path.into());
        Self { application, file }
    }
}

impl SharedWorld {
    /// Locks the world. Robots wait until it is unlocked.
    pub(crate) fn lock(self: &Arc<Self>) -> MutexGuard<'_, World> {
        self.world.lock()
    }

    /// Returns the lasers of a robot, as its driver has them. The world may be locked already.
    pub(crate) fn lasers(&self, robot: RobotId) -> Vec<LaserModel> {
        self.lasers.lock().get(&robot).cloned().unwrap_or_default()
    }
}

fn open(key: Key, path: &str, seed: u64) -> Result<Arc<SharedWorld>, WorldError> {
    let mut open = OPEN_WORLDS.lock();
    open.retain(|(_, shared)| shared.strong_count() > 0);
    let known = open.iter().find(|(known, _)| *known == key);
    if let Some(shared) = known.and_then(|(_, shared)| shared.upgrade()) {
        return Ok(shared);
    }
    let shared = Arc::new(SharedWorld {
        world: Mutex::new(World::load(path, seed)?),
        driven: Mutex::default(),
        edits: Mutex::default(),
        lasers: Mutex::default(),
    });
    open.push((key, Arc::downgrade(&shared)));
    Ok(shared)
}
