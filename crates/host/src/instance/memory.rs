//! What an instance hands on to another build of its type, and how one takes the place of another without losing that of the
//! schema: going to sleep and waking up within a turn, in which nothing is commanded and no child is woken or put to sleep.

use jde_abi::{raw, state};

use super::host_table::Leave;
use super::{Instance, outcome};

/// What an instance has saved.
#[derive(Clone, Debug)]
pub(crate) struct Remembered {
    pub(crate) version: u32,
    pub(crate) bytes: Vec<u8>,
}

/// How a type hands on what it remembers, if it does.
///
/// # Errors
/// What is wrong with that.
pub(crate) fn memory_of(table: &'static raw::Schema) -> Result<Option<&'static raw::State>, String> {
    // SAFETY: the table was checked when its plugin was loaded.
    let state = unsafe { state::of(table) };
    state.map_err(|wrong| format!("its ability `{}` is of no use: {wrong}", raw::ABILITY_STATE))
}

impl Instance {
    /// What it remembers; none if its build hands nothing on.
    pub(crate) fn save(&mut self) -> Result<Option<Remembered>, String> {
        let Some((table, save)) = self.build.state.and_then(|table| Some((table, table.save?))) else {
            return Ok(None);
        };
        self.release();
        let (done, kept) = state::lend(|saver| {
            // SAFETY: as in `awake`; the saver lives for the call.
            self.changing_nothing("save", |this, context| unsafe { save(this, context, saver) })
        });
        self.release();
        done?;
        let bytes = kept.map_err(|too_many| too_many.to_string())?;
        Ok(Some(Remembered {
            version: table.version,
            bytes,
        }))
    }

    /// Takes over what another build saved; answers whether its build does that.
    pub(crate) fn restore(&mut self, remembered: &Remembered) -> Result<bool, String> {
        let Some(restore) = self.build.state.and_then(|table| table.restore) else {
            return Ok(false);
        };
        let Remembered { version, bytes } = remembered;
        self.release();
        let done = self.changing_nothing("restore", |this, context| {
            let (data, length) = (bytes.as_ptr().cast(), bytes.len() as u64);
            // SAFETY: as in `awake`; the bytes live for the call.
            unsafe { restore(this, context, *version, data, length) }
        });
        self.release();
        done.map(|()| true)
    }

    /// Wakes it up in the place of another.
    pub(crate) fn rise(&mut self) -> Result<(), String> {
        self.release();
        let result = match self.table.awake {
            Some(awake) => {
                // SAFETY: as in `awake`.
                let (status, failure, _) =
                    self.call_as(Leave::Exports, |this, context| unsafe { awake(this, context) });
                outcome("awake", status, failure)
            }
            None => Ok(()),
        };
        self.release();
        result
    }

    /// Puts it to sleep, for another to take its place.
    pub(crate) fn recline(&mut self) -> Result<(), String> {
        self.release();
        let failure = match self.table.sleep {
            Some(sleep) => {
                // SAFETY: as in `awake`.
                let call = |this, context| unsafe { sleep(this, context) };
                let ((), failure, _) = self.call_as(Leave::Exports, call);
                failure
            }
            None => None,
        };
        self.release();
        failure.map_or(Ok(()), Err)
    }

    /// The build it is of.
    pub(crate) fn build(&self) -> &crate::build::Shared {
        &self.build
    }

    /// Its panel, if it has one: whether that can be touched.
    pub(crate) fn panel(&self) -> Option<bool> {
        self.panel.map(|panel| panel.touch.is_some())
    }

    fn changing_nothing(
        &mut self,
        what: &str,
        call: impl FnOnce(*mut core::ffi::c_void, *mut raw::Context) -> i32,
    ) -> Result<(), String> {
        let (status, failure, leave) = self.call_as(Leave::Nothing(None), call);
        match leave {
            Leave::Nothing(Some(tried)) => {
                Err(format!("it tried to {tried} in {what}, which changes nothing"))
            }
            Leave::Nothing(None) | Leave::All | Leave::Exports => outcome(what, status, failure),
        }
    }
}
