//! The handles of the program: numbers that are never used twice.

use std::collections::BTreeMap;
use std::sync::{Arc, LazyLock};

use jde_embed::{LoadedApplication, Run};
use parking_lot::{RwLock, RwLockReadGuard, RwLockWriteGuard};

use crate::boundary::Failure;
use crate::tables;

/// What a handle denotes.
#[derive(Clone)]
pub(crate) enum Object {
    /// Of a `jde_application`.
    Application(Arc<LoadedApplication>),
    /// Of a `jde_run`.
    Run(Arc<Run>),
}

#[derive(Default)]
struct Handles {
    objects: BTreeMap<usize, Object>,
    last: usize,
}

static HANDLES: LazyLock<RwLock<Handles>> = LazyLock::new(RwLock::default);

/// Returns the handle of an object.
pub(crate) fn open<T>(object: Object) -> *mut T {
    let mut handles = write();
    handles.last += 1;
    let number = handles.last;
    handles.objects.insert(number, object);
    std::ptr::without_provenance_mut(number)
}

/// Returns the run of a handle.
pub(crate) fn run(handle: *mut tables::Run) -> Result<Arc<Run>, Failure> {
    match read().objects.get(&handle.addr()) {
        Some(Object::Run(run)) => Ok(Arc::clone(run)),
        _ => Err(closed("run")),
    }
}

/// Returns the application of a handle.
pub(crate) fn application(handle: *mut tables::Application) -> Result<Arc<LoadedApplication>, Failure> {
    match read().objects.get(&handle.addr()) {
        Some(Object::Application(application)) => Ok(Arc::clone(application)),
        _ => Err(closed("application")),
    }
}

/// Closes a handle: later calls with it are errors.
pub(crate) fn close<T>(handle: *mut T) {
    let object = write().objects.remove(&handle.addr());
    // Without the lock, for a run comes to rest now.
    drop(object);
}

fn closed(what: &str) -> Failure {
    Failure::new(
        tables::NO_HANDLE,
        format!("the {what} was closed, or the handle is none of libjde's"),
    )
}

fn read() -> RwLockReadGuard<'static, Handles> {
    HANDLES.read()
}

fn write() -> RwLockWriteGuard<'static, Handles> {
    HANDLES.write()
}
