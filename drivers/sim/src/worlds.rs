//! The worlds of this process, shared by the robots of one application. It opens and lends; it steps nothing.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};

use jde_sim::{World, WorldError};

/// Which application opened which file.
type Key = (u64, String);

/// Worlds that some robot is in. Applications do not see each other's.
static OPEN: Mutex<Vec<(Key, Weak<Mutex<World>>)>> = Mutex::new(Vec::new());

/// The application's world of that file: the one that is open, or a new one at time 0.
pub(crate) fn open(application: u64, path: &str, seed: u64) -> Result<Arc<Mutex<World>>, WorldError> {
    let mut open = lock(&OPEN);
    open.retain(|(_, world)| world.strong_count() > 0);
    let key = (application, path.to_owned());
    if let Some(world) = open
        .iter()
        .find(|(known, _)| *known == key)
        .and_then(|(_, world)| world.upgrade())
    {
        return Ok(world);
    }
    let world = Arc::new(Mutex::new(World::load(path, seed)?));
    open.push((key, Arc::downgrade(&world)));
    Ok(world)
}

/// A world is never left half stepped: a panic inside one is as good a reason as any to go on with what is there.
pub(crate) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
