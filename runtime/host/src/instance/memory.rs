//! The memory that an instance saves for another build of its type, and the replacement of one instance by
//! another that continues with this memory. Going to sleep and waking up occur within one turn, in which
//! nothing is commanded and no child is woken or put to sleep.

use jde_loader::build::SharedBuild;
use jde_loader::instance::SavedMemory;

use super::body::Body;
use super::call::{CallContext, Permissions};
use super::{Instance, call_result};

impl Instance {
    /// Saves the instance's memory. `None` if its build cannot save.
    pub(crate) fn save(&mut self) -> Result<Option<SavedMemory>, String> {
        let Some(table) = self.build.state else {
            return Ok(None);
        };
        self.release();
        let mut bytes = Ok(Vec::new());
        let result = self.call_read_only("save", |body, call| {
            let status;
            (status, bytes) = body.save(call);
            status
        });
        self.release();
        result?;
        Ok(Some(SavedMemory {
            version: table.version,
            bytes: bytes?,
        }))
    }

    /// Restores the memory that another build saved. Returns whether its build supports that.
    pub(crate) fn restore(&mut self, memory: &SavedMemory) -> Result<bool, String> {
        if self.build.state.is_none() {
            return Ok(false);
        }
        self.release();
        let result = self.call_read_only("restore", |body, call| body.restore(call, memory));
        self.release();
        result.map(|()| true)
    }

    /// Wakes the instance up in the place of another. The schema was awake, so the values latched at its
    /// awakening stay (R8).
    pub(crate) fn awake_in_place(&mut self) -> Result<(), String> {
        self.release();
        let result = match self.table.awake {
            Some(_) => {
                let (status, failure, _) = self.call_with(Permissions::ExportsOnly, Body::awake);
                call_result("awake", status, failure)
            }
            None => Ok(()),
        };
        self.release();
        result
    }

    /// Puts the instance to sleep, so that another can take its place.
    pub(crate) fn sleep_in_place(&mut self) -> Result<(), String> {
        self.release();
        let failure = match self.table.sleep {
            Some(_) => self.call_with(Permissions::ExportsOnly, Body::sleep).1,
            None => None,
        };
        self.release();
        failure.map_or(Ok(()), Err)
    }

    /// Returns the build of the instance.
    pub(crate) fn build(&self) -> &SharedBuild {
        &self.build
    }

    /// Whether its panel can be touched; `None` without a panel.
    pub(crate) fn panel(&self) -> Option<bool> {
        self.panel.map(|panel| panel.touch.is_some())
    }

    fn call_read_only(
        &mut self,
        what: &str,
        call: impl FnOnce(&mut Body, &mut CallContext<'_>) -> i32,
    ) -> Result<(), String> {
        let (status, failure, permissions) = self.call_with(Permissions::ReadOnly(None), call);
        match permissions {
            Permissions::ReadOnly(Some(action)) => {
                Err(format!("it tried to {action} in {what}, which changes nothing"))
            }
            Permissions::ReadOnly(None) | Permissions::All | Permissions::ExportsOnly => {
                call_result(what, status, failure)
            }
        }
    }
}
