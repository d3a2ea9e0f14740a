//! Calls the functions of an instance, which run in this process or in a process of their own, or are those of
//! a mock. The rest of the host treats all alike.

#![allow(unsafe_code)]

use jde_abi::raw;
use jde_loader::instance::{ArbitrationQuery, InProcessInstance, PluginContext, SavedMemory, Verdict};
use jde_panel::{Gesture, List};

use super::CallContext;
use super::host_table::HOST;
use super::isolated::IsolatedInstance;
use super::mocked::MockedInstance;

/// The functions of a created instance.
pub(crate) enum Body {
    InProcess(InProcessInstance),
    Isolated(Box<IsolatedInstance>),
    Mocked(MockedInstance),
}

/// Each function returns a status of the ABI. The reason for a failure is in the call.
impl Body {
    pub(super) fn create(call: &mut CallContext<'_>) -> Option<Self> {
        if let Some(mock) = call.engine.mocks.get(&call.number) {
            call.expect_no_motion();
            return Some(Self::Mocked(MockedInstance::new(mock)));
        }
        match call.engine.process_config(call.number) {
            None => {
                let listed = &call.engine.application.instances[call.number].listed;
                let own = call.build.ports() - listed.len();
                // SAFETY: the table was checked.
                let created =
                    unsafe { InProcessInstance::create(call.build.table, &HOST, context(call), listed, own) };
                if let Err(reason) = created {
                    call.failure.get_or_insert_with(|| reason.to_owned());
                }
                created.ok().map(Self::InProcess)
            }
            Some(config) => {
                IsolatedInstance::create(call, &config).map(|instance| Self::Isolated(Box::new(instance)))
            }
        }
    }

    pub(super) fn awake(&mut self, call: &mut CallContext<'_>) -> i32 {
        match self {
            Self::InProcess(instance) => instance.awake(context(call)),
            Self::Isolated(instance) => instance.awake(call),
            Self::Mocked(_) => raw::OK,
        }
    }

    pub(super) fn check(&mut self, call: &mut CallContext<'_>) -> (i32, bool, f64) {
        match self {
            Self::InProcess(instance) => instance.check(context(call)),
            Self::Isolated(instance) => instance.check(call),
            Self::Mocked(instance) => instance.check(call),
        }
    }

    /// Checks and iterates in one call, if [`Self::is_isolated`].
    pub(super) fn check_and_iterate(&mut self, call: &mut CallContext<'_>) -> (i32, bool, f64) {
        match self {
            Self::Isolated(instance) => instance.check_and_iterate(call),
            Self::InProcess(_) | Self::Mocked(_) => (raw::BAD_ARGUMENT, false, 0.0),
        }
    }

    pub(super) fn is_isolated(&self) -> bool {
        matches!(self, Self::Isolated(_))
    }

    pub(super) fn iterate(&mut self, call: &mut CallContext<'_>) -> i32 {
        match self {
            Self::InProcess(instance) => instance.iterate(context(call)),
            Self::Isolated(instance) => instance.iterate(call),
            Self::Mocked(instance) => instance.iterate(call),
        }
    }

    pub(super) fn arbitrate(
        &mut self,
        call: &mut CallContext<'_>,
        query: &ArbitrationQuery,
    ) -> (i32, Verdict) {
        match self {
            Self::InProcess(instance) => instance.arbitrate(context(call), query),
            Self::Isolated(instance) => instance.arbitrate(call, query),
            Self::Mocked(_) => MockedInstance::arbitrate(query),
        }
    }

    pub(super) fn sleep(&mut self, call: &mut CallContext<'_>) {
        match self {
            Self::InProcess(instance) => instance.sleep(context(call)),
            Self::Isolated(instance) => instance.sleep(call),
            Self::Mocked(_) => {}
        }
    }

    pub(super) fn draw(&mut self, call: &mut CallContext<'_>) -> (i32, Result<List, String>) {
        let now = call.engine.clock.now();
        match self {
            Self::InProcess(instance) => instance.draw(context(call), now),
            Self::Isolated(instance) => instance.draw(call),
            Self::Mocked(_) => (raw::OK, Err(String::from("a mock draws nothing"))),
        }
    }

    pub(super) fn touch(&mut self, call: &mut CallContext<'_>, by: &str, gesture: &Gesture) -> i32 {
        match self {
            Self::InProcess(instance) => instance.touch(context(call), by, gesture),
            Self::Isolated(instance) => instance.touch(call, by, gesture),
            Self::Mocked(_) => raw::OK,
        }
    }

    pub(super) fn save(&mut self, call: &mut CallContext<'_>) -> (i32, Result<Vec<u8>, String>) {
        match self {
            Self::InProcess(instance) => instance.save(context(call)),
            Self::Isolated(instance) => instance.save(call),
            Self::Mocked(_) => (raw::OK, Ok(Vec::new())),
        }
    }

    pub(super) fn restore(&mut self, call: &mut CallContext<'_>, memory: &SavedMemory) -> i32 {
        match self {
            Self::InProcess(instance) => instance.restore(context(call), memory),
            Self::Isolated(instance) => instance.restore(call, memory),
            Self::Mocked(_) => raw::OK,
        }
    }

    /// Whether its process is dead.
    pub(super) fn is_dead(&self) -> bool {
        match self {
            Self::InProcess(_) | Self::Mocked(_) => false,
            Self::Isolated(instance) => instance.is_dead(),
        }
    }

    /// Whether the rules must be informed of a failure. A death returns true only once.
    pub(super) fn claim_failure_report(&self) -> bool {
        match self {
            Self::InProcess(_) | Self::Mocked(_) => true,
            Self::Isolated(instance) => instance.claim_failure_report(),
        }
    }
}

/// The context that the functions of [`HOST`] expect.
fn context<'c>(call: &'c mut CallContext<'_>) -> PluginContext<'c> {
    // SAFETY: the functions of `HOST` expect a `CallContext` behind their context.
    unsafe { PluginContext::new(call) }
}
