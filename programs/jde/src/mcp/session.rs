//! What all calls of a server share: what it was started with, its holds, and the calls under way.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use jde_link::message::{Action, Request};
use jde_link::{Client, Reach, Remote};
use parking_lot::Mutex;

use super::Options;
use super::folder::Folder;
use super::holds::Holds;
use super::tools::Right;
use crate::cli::tools::client::{Context, Target};
use crate::failure::Failure;

/// The most calls under way.
pub(super) const MAX_CALLS: usize = 8;

/// A server.
pub(super) struct Session {
    target: Target,
    may_operate: bool,
    pub(super) jobs: usize,
    /// The longest time of a test or an experiment.
    pub(super) limit: Duration,
    pub(super) folder: Folder,
    pub(super) holds: Holds,
    /// The operator's name.
    by: String,
    calls: Mutex<Vec<Arc<AtomicBool>>>,
}

/// A call under way, from its thread's point of view. It counts until it is dropped.
pub(super) struct Running {
    session: Arc<Session>,
    /// Set when its answer is of no use any more.
    pub(super) abort: Arc<AtomicBool>,
}

impl Session {
    pub(super) fn new(options: Options, folder: Folder) -> Self {
        let operator = jde_link::operator();
        let host = operator.rsplit_once('@').map_or("", |(_, host)| host);
        Self {
            target: options.target,
            may_operate: options.operate,
            jobs: options.jobs,
            limit: options.limit,
            folder,
            holds: Holds::default(),
            by: format!("agent@{host}"),
            calls: Mutex::default(),
        }
    }

    /// Whether the server was started with this right.
    pub(super) fn permits(&self, right: Right) -> bool {
        match right {
            Right::Inspect | Right::Simulate | Right::Stop => true,
            Right::Operate => self.may_operate,
        }
    }

    /// Connects to an application: the named one, or the only one.
    ///
    /// # Errors
    /// There is none, or the server is for another one alone.
    pub(super) fn remote(&self, named: Option<&str>) -> Result<Remote, Failure> {
        self.check_name(named)?;
        Context::default().remote(&self.target, named)
    }

    /// Prepares a search for applications.
    ///
    /// # Errors
    /// No endpoint accepts.
    pub(super) fn client(&self) -> Result<Client, Failure> {
        Context::default().client(&self.target)
    }

    /// Returns where applications are, and the name of the one that is meant, if it is one.
    ///
    /// # Errors
    /// The server is for another one alone, or a file of credentials cannot be read.
    pub(super) fn reach(&self, named: Option<&str>) -> Result<(Reach, Option<String>), Failure> {
        self.check_name(named)?;
        let name = named
            .map(str::to_owned)
            .or_else(|| self.only().map(str::to_owned));
        Ok((Context::default().reach(&self.target)?, name))
    }

    /// The only application of this server, if it has one.
    pub(super) fn only(&self) -> Option<&str> {
        self.target.app.as_deref().filter(|name| !name.is_empty())
    }

    fn check_name(&self, named: Option<&str>) -> Result<(), Failure> {
        match (self.only(), named) {
            (Some(only), Some(named)) if only != named => Err(Failure::broken(format!(
                "this server is for the application `{only}` alone"
            ))),
            _ => Ok(()),
        }
    }

    /// Returns the request of the agent.
    pub(super) fn request(&self, action: Action) -> Request {
        Request {
            by: self.by.clone(),
            action,
            lease_ms: None,
        }
    }

    /// Counts a call; `None` if too many are under way. A stop counts apart, so that other calls cannot delay it.
    pub(super) fn begin_call(session: &Arc<Self>, right: Right) -> Option<Running> {
        let abort = Arc::new(AtomicBool::new(false));
        if right != Right::Stop {
            let mut calls = session.calls.lock();
            if calls.len() >= MAX_CALLS {
                return None;
            }
            calls.push(Arc::clone(&abort));
        }
        Some(Running {
            session: Arc::clone(session),
            abort,
        })
    }

    /// Ends what can be ended of all calls under way.
    pub(super) fn abort_calls(&self) {
        let calls = self.calls.lock();
        calls.iter().for_each(|call| call.store(true, Ordering::Relaxed));
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        let mut calls = self.session.calls.lock();
        calls.retain(|call| !Arc::ptr_eq(call, &self.abort));
    }
}
