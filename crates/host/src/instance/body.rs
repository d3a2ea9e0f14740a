//! Where the functions of an instance run: in this process, or in one of their own. The rest of the host
//! treats both alike.

#![allow(unsafe_code)]

use jde_loader::instance::{ArbitrationQuery, InProcessInstance, PluginContext, SavedMemory, Verdict};
use jde_panel::{Gesture, List};

use super::CallContext;
use super::host_table::HOST;
use super::isolated::IsolatedInstance;

/// The functions of an instance that was created.
pub(crate) enum Body {
    InProcess(InProcessInstance),
    Isolated(Box<IsolatedInstance>),
}

/// Each function returns a status of the ABI. The reason for a failure is in the call.
impl Body {
    pub(super) fn create(call: &mut CallContext<'_>) -> Option<Self> {
        match call.engine.process_config(call.number) {
            // SAFETY: the table was checked.
            None => unsafe { InProcessInstance::create(call.build.table, &HOST, context(call)) }
                .map(Self::InProcess),
            Some(room) => IsolatedInstance::create(call, &room).map(|apart| Self::Isolated(Box::new(apart))),
        }
    }

    pub(super) fn awake(&mut self, call: &mut CallContext<'_>) -> i32 {
        match self {
            Self::InProcess(here) => here.awake(context(call)),
            Self::Isolated(apart) => apart.awake(call),
        }
    }

    pub(super) fn check(&mut self, call: &mut CallContext<'_>) -> (i32, bool, f64) {
        match self {
            Self::InProcess(here) => here.check(context(call)),
            Self::Isolated(apart) => apart.check(call),
        }
    }

    pub(super) fn iterate(&mut self, call: &mut CallContext<'_>) -> i32 {
        match self {
            Self::InProcess(here) => here.iterate(context(call)),
            Self::Isolated(apart) => apart.iterate(call),
        }
    }

    pub(super) fn arbitrate(
        &mut self,
        call: &mut CallContext<'_>,
        question: &ArbitrationQuery,
    ) -> (i32, Verdict) {
        match self {
            Self::InProcess(here) => here.arbitrate(context(call), question),
            Self::Isolated(apart) => apart.arbitrate(call, question),
        }
    }

    pub(super) fn sleep(&mut self, call: &mut CallContext<'_>) {
        match self {
            Self::InProcess(here) => here.sleep(context(call)),
            Self::Isolated(apart) => apart.sleep(call),
        }
    }

    pub(super) fn draw(&mut self, call: &mut CallContext<'_>) -> (i32, Result<List, String>) {
        let now = call.engine.clock.now();
        match self {
            Self::InProcess(here) => here.draw(context(call), now),
            Self::Isolated(apart) => apart.draw(call),
        }
    }

    pub(super) fn touch(&mut self, call: &mut CallContext<'_>, by: &str, gesture: &Gesture) -> i32 {
        match self {
            Self::InProcess(here) => here.touch(context(call), by, gesture),
            Self::Isolated(apart) => apart.touch(call, by, gesture),
        }
    }

    pub(super) fn save(&mut self, call: &mut CallContext<'_>) -> (i32, Result<Vec<u8>, String>) {
        match self {
            Self::InProcess(here) => here.save(context(call)),
            Self::Isolated(apart) => apart.save(call),
        }
    }

    pub(super) fn restore(&mut self, call: &mut CallContext<'_>, remembered: &SavedMemory) -> i32 {
        match self {
            Self::InProcess(here) => here.restore(context(call), remembered),
            Self::Isolated(apart) => apart.restore(call, remembered),
        }
    }

    /// Whether its process is dead.
    pub(super) fn is_dead(&self) -> bool {
        match self {
            Self::InProcess(_) => false,
            Self::Isolated(apart) => apart.is_dead(),
        }
    }

    /// Whether the rules must be informed of a failure. A death returns true only once.
    pub(super) fn claim_failure_report(&self) -> bool {
        match self {
            Self::InProcess(_) => true,
            Self::Isolated(apart) => apart.claim_failure_report(),
        }
    }
}

/// The context that the functions of [`HOST`] expect.
fn context<'c>(call: &'c mut CallContext<'_>) -> PluginContext<'c> {
    // SAFETY: the functions of `HOST` expect a `Call` behind their context.
    unsafe { PluginContext::new(call) }
}
