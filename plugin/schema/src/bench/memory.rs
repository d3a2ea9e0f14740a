//! The memory of a schema, on the bench: one instance restores what another saved, as at a reload.

#![allow(unsafe_code)]

use jde_abi::{raw, state};

use super::{Bench, Failure};

/// The memory that an instance saved.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Remembered {
    /// The version of its format.
    pub version: u32,
    /// The saved bytes, which only the schema can interpret.
    pub bytes: Vec<u8>,
}

/// The schema's memory.
impl<S> Bench<S> {
    /// Saves the schema's memory, as before a reload.
    ///
    /// # Errors
    /// If the schema panics, tries to write, or saves too many bytes.
    ///
    /// # Panics
    /// If the schema has no memory of its own.
    pub fn save(&mut self) -> Result<Remembered, Failure> {
        let table = self.memory();
        let Some(save) = table.save else {
            panic!("`{}` cannot save: its `save` is null", self.description.name)
        };
        self.state.drawing = Some(Vec::new());
        // SAFETY: the table's own function, instance and context, and a saver that lives until it returns.
        let (done, saved) =
            state::lend(|saver| self.call(|instance, cx| unsafe { save(instance, cx, saver) }));
        self.refuse_writes("save")?;
        done?;
        let bytes = saved.map_err(|too_many| Failure {
            code: raw::BAD_ARGUMENT,
            reason: too_many.to_string(),
        })?;
        Ok(Remembered {
            version: table.version,
            bytes,
        })
    }

    /// Restores what another instance saved, as after a reload.
    ///
    /// # Errors
    /// If the schema fails, panics or tries to write.
    ///
    /// # Panics
    /// If the schema has no memory of its own.
    pub fn restore(&mut self, remembered: &Remembered) -> Result<(), Failure> {
        let Some(restore) = self.memory().restore else {
            panic!(
                "`{}` cannot restore: its `restore` is null",
                self.description.name
            )
        };
        let Remembered { version, bytes } = remembered;
        self.state.drawing = Some(Vec::new());
        // SAFETY: the table's own function, instance and context, and bytes that live until it returns.
        let done = self.call(|instance, cx| unsafe {
            restore(instance, cx, *version, bytes.as_ptr().cast(), bytes.len() as u64)
        });
        self.refuse_writes("restore")?;
        done
    }

    /// Fails if a call that must change nothing tried to change something.
    pub(super) fn refuse_writes(&mut self, call: &str) -> Result<(), Failure> {
        let attempts = self.state.drawing.take().unwrap_or_default();
        match attempts.first() {
            None => Ok(()),
            Some(attempt) => Err(Failure {
                code: raw::REFUSED,
                reason: format!("it tried to {attempt} in {call}, which changes nothing"),
            }),
        }
    }

    fn memory(&self) -> raw::State {
        // SAFETY: the bench has read and validated this table.
        match unsafe { state::of(&self.table) } {
            Ok(Some(table)) => table,
            Ok(None) => panic!(
                "`{}` has no memory; write `impl Memory` for it",
                self.description.name
            ),
            Err(wrong) => panic!(
                "the memory of `{}` cannot be used: {wrong}",
                self.description.name
            ),
        }
    }
}
