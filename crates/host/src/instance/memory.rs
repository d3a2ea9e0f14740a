//! What an instance hands on to another build of its type, and how one takes the place of another without losing that of the
//! schema: going to sleep and waking up within a turn, in which nothing is commanded and no child is woken or put to sleep.

#![allow(unsafe_code)]

use jde_abi::{raw, state};

use super::body::Body;
use super::call::{Call, Leave};
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
pub(crate) fn memory_of(table: &raw::Schema) -> Result<Option<raw::State>, String> {
    // SAFETY: the table was checked when its plugin was loaded.
    let state = unsafe { state::of(table) };
    state.map_err(|wrong| format!("its ability `{}` is of no use: {wrong}", raw::ABILITY_STATE))
}

impl Instance {
    /// What it remembers; none if its build hands nothing on.
    pub(crate) fn save(&mut self) -> Result<Option<Remembered>, String> {
        let Some(table) = self.build.state else {
            return Ok(None);
        };
        self.release();
        let mut kept = Ok(Vec::new());
        let done = self.changing_nothing("save", |body, call| {
            let status;
            (status, kept) = body.save(call);
            status
        });
        self.release();
        done?;
        Ok(Some(Remembered {
            version: table.version,
            bytes: kept?,
        }))
    }

    /// Takes over what another build saved; answers whether its build does that.
    pub(crate) fn restore(&mut self, remembered: &Remembered) -> Result<bool, String> {
        if self.build.state.is_none() {
            return Ok(false);
        }
        self.release();
        let done = self.changing_nothing("restore", |body, call| body.restore(call, remembered));
        self.release();
        done.map(|()| true)
    }

    /// Wakes it up in the place of another: the schema was awake, so what is taken at its awakening stays (R8).
    pub(crate) fn rise(&mut self) -> Result<(), String> {
        self.release();
        let result = match self.table.awake {
            Some(_) => {
                let (status, failure, _) = self.call_as(Leave::Exports, Body::awake);
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
            Some(_) => self.call_as(Leave::Exports, Body::sleep).1,
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
        call: impl FnOnce(&mut Body, &mut Call<'_>) -> i32,
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
