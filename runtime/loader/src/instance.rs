//! The functions of one instance, in this process: the only place where a plugin's functions are called.
//!
//! It does not know the host: the caller provides the context, which the plugin passes back to the host's
//! table.

#![allow(unsafe_code)]

use std::ffi::{CStr, CString, c_char, c_void};
use std::marker::PhantomData;
use std::ptr::NonNull;

use jde_abi::inspect::{self, Problem};
use jde_abi::lists::{self, ListedPort};
use jde_abi::raw::{self, Context, Host};
use jde_abi::{state, table};
use jde_panel::{Gesture, List};
use serde::{Deserialize, Serialize};

use super::{SchemaFunctions, forked};

/// An instance that was created in this process.
pub struct InProcessInstance {
    table: SchemaFunctions,
    panel: Option<raw::Panel>,
    state: Option<raw::State>,
    this: NonNull<c_void>,
}

// SAFETY: the ABI lets calls of one instance come from different threads one after another, and `&mut self`
// prevents concurrent calls.
unsafe impl Send for InProcessInstance {}

/// An arbitration query to a father.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ArbitrationQuery {
    /// The case, as the ABI numbers it.
    pub case: u32,
    /// The name of the group within the father.
    pub group: String,
    /// The competing children.
    pub candidates: Vec<CandidateChild>,
    /// The role of the current winner, if it is one of the father's.
    pub winner: Option<u32>,
}

/// A competing child.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct CandidateChild {
    /// Its role.
    pub child: u32,
    /// Its state, as the ABI numbers it.
    pub state: u32,
    /// Whether its precondition holds.
    pub ready: bool,
    /// Its urgency.
    pub urgency: f64,
}

/// The reply of a father: a role or none, and the reason.
#[derive(Debug, Default, Serialize, Deserialize)]
pub struct Verdict {
    /// The role of the chosen child; `None` for no child.
    pub child: Option<u32>,
    /// The reason.
    pub reason: String,
}

/// The memory that an instance has saved.
#[derive(Clone, Debug)]
pub struct SavedMemory {
    /// The version of the format.
    pub version: u32,
    /// The saved bytes.
    pub bytes: Vec<u8>,
}

/// Returns a type's functions for saving and restoring memory, if it has them.
///
/// # Errors
/// Why they cannot be used.
pub fn memory_of(table: &raw::Schema) -> Result<Option<raw::State>, String> {
    // SAFETY: the table was checked when its plugin was loaded.
    let state = unsafe { state::of(table) };
    state.map_err(|error| format!("its ability `{}` cannot be used: {error}", raw::ABILITY_STATE))
}

/// The context that a plugin passes back to the host's table. It is borrowed for the call, and nothing else
/// uses it during the call.
pub struct PluginContext<'c> {
    context: *mut Context,
    call: PhantomData<&'c mut ()>,
}

impl<'c> PluginContext<'c> {
    /// # Safety
    /// The functions of the table given to [`InProcessInstance::create`] expect a `T` behind their context.
    pub unsafe fn new<T>(target: &'c mut T) -> Self {
        Self {
            context: std::ptr::from_mut(target).cast(),
            call: PhantomData,
        }
    }
}

/// Each function returns a status of the ABI.
impl InProcessInstance {
    /// Creates an instance of a type with `own` ports of its own, and gives it the ports of its lists.
    ///
    /// # Errors
    /// If the plugin returned none, or refused these ports: what failed, which is the reason if the plugin states none.
    ///
    /// # Safety
    /// `table` was checked.
    pub unsafe fn create(
        table: SchemaFunctions,
        host: &'static Host,
        context: PluginContext<'_>,
        listed: &[ListedPort],
        own: usize,
    ) -> Result<Self, &'static str> {
        forked::watch();
        let create = table.create.expect("read::plugin refuses schemas without create");
        // SAFETY: the caller guarantees the table; the context lives for the call and belongs to that host.
        let this = forked::call(|| unsafe { create(table.own, host, context.context) });
        let this = Self {
            table,
            panel: panel_of(&table),
            // An error was reported when the build was made.
            state: memory_of(&table).unwrap_or_default(),
            this: NonNull::new(this).ok_or("its create returned null without a reason")?,
        };
        // SAFETY: the table was checked when its plugin was loaded.
        let lists = unsafe { lists::of(&table) };
        if let Ok(Some(raw::Lists { set: Some(set), .. })) = lists {
            let ports = lists::tables(listed, own);
            let count = ports.len() as u32;
            // SAFETY: as for `create`; the tables live for the call, and what they point to for ever.
            let status =
                forked::call(|| unsafe { set(this.this.as_ptr(), context.context, ports.as_ptr(), count) });
            if status != raw::OK {
                return Err("its set refused the ports of its lists without a reason");
            }
        }
        Ok(this)
    }

    /// Wakes the instance up.
    pub fn awake(&mut self, context: PluginContext<'_>) -> i32 {
        match self.table.awake {
            // SAFETY: `this` came from this table's create; the context lives for the call.
            Some(awake) => forked::call(|| unsafe { awake(self.this.as_ptr(), context.context) }),
            None => raw::OK,
        }
    }

    /// Evaluates the precondition. Also returns whether it is true, and the urgency.
    pub fn check(&mut self, context: PluginContext<'_>) -> (i32, bool, f64) {
        let mut out = raw::Precondition {
            size: size_of::<raw::Precondition>() as u32,
            ready: 1,
            urgency: 0.0,
        };
        let status = match self.table.check {
            Some(check) => {
                // SAFETY: as in `awake`; `out` lives for the call.
                forked::call(|| unsafe { check(self.this.as_ptr(), context.context, &raw mut out) })
            }
            None => raw::OK,
        };
        (status, out.ready != 0, out.urgency)
    }

    /// Runs one iteration.
    pub fn iterate(&mut self, context: PluginContext<'_>) -> i32 {
        let iterate = self
            .table
            .iterate
            .expect("read::plugin refuses schemas without iterate");
        // SAFETY: as in `awake`.
        forked::call(|| unsafe { iterate(self.this.as_ptr(), context.context) })
    }

    /// Calls a father's arbitration. Also returns the verdict.
    pub fn arbitrate(&mut self, context: PluginContext<'_>, query: &ArbitrationQuery) -> (i32, Verdict) {
        let Some(arbitrate) = self.table.arbitrate else {
            return (raw::FAILED, Verdict::default());
        };
        let candidates: Vec<raw::Candidate> = query.candidates.iter().map(CandidateChild::raw).collect();
        let group = CString::new(query.group.as_str()).unwrap_or_default();
        let level = raw::Level {
            size: size_of::<raw::Level>() as u32,
            case: query.case,
            group: group.as_ptr(),
            candidates: candidates.as_ptr(),
            candidate_count: candidates.len() as u32,
            winner: query.winner.map_or(-1, |role| role as i32),
        };
        let mut verdict = raw::Verdict {
            size: size_of::<raw::Verdict>() as u32,
            child: -1,
            reason: [0; 128],
        };
        // SAFETY: as in `awake`; level and verdict live for the call.
        let status = forked::call(|| unsafe {
            arbitrate(
                self.this.as_ptr(),
                context.context,
                &raw const level,
                &raw mut verdict,
            )
        });
        let verdict = Verdict {
            child: u32::try_from(verdict.child).ok(),
            reason: text_from_chars(&verdict.reason),
        };
        (status, verdict)
    }

    /// Puts the instance to sleep.
    pub fn sleep(&mut self, context: PluginContext<'_>) {
        if let Some(sleep) = self.table.sleep {
            // SAFETY: as in `awake`.
            forked::call(|| unsafe { sleep(self.this.as_ptr(), context.context) });
        }
    }

    /// Draws the panel. Also returns the drawing.
    pub fn draw(&mut self, context: PluginContext<'_>, time: u64) -> (i32, Result<List, String>) {
        let Some(draw) = self.panel.and_then(|panel| panel.draw) else {
            return (raw::FAILED, Err(String::from("it has no panel")));
        };
        let (status, list) = jde_panel::lend_pen(time, |pen| {
            // SAFETY: as in `awake`; the pen lives for the call.
            forked::call(|| unsafe { draw(self.this.as_ptr(), context.context, pen) })
        });
        (status, list.map_err(|error| error.to_string()))
    }

    /// Delivers a gesture of `by` on the panel.
    pub fn touch(&mut self, context: PluginContext<'_>, by: &str, gesture: &Gesture) -> i32 {
        let Some(touch) = self.panel.and_then(|panel| panel.touch) else {
            return raw::OK;
        };
        jde_panel::lend_gesture(by, gesture, |gesture| {
            // SAFETY: as in `awake`; the gesture lives for the call.
            forked::call(|| unsafe { touch(self.this.as_ptr(), context.context, gesture) })
        })
    }

    /// Saves the memory. Also returns the saved bytes.
    pub fn save(&mut self, context: PluginContext<'_>) -> (i32, Result<Vec<u8>, String>) {
        let Some(save) = self.state.and_then(|state| state.save) else {
            return (raw::FAILED, Err(String::from("it saves no memory")));
        };
        let (status, saved) = state::lend(|saver| {
            // SAFETY: as in `awake`; the saver lives for the call.
            forked::call(|| unsafe { save(self.this.as_ptr(), context.context, saver) })
        });
        (status, saved.map_err(|error| error.to_string()))
    }

    /// Restores the memory that another build saved.
    pub fn restore(&mut self, context: PluginContext<'_>, saved: &SavedMemory) -> i32 {
        let Some(restore) = self.state.and_then(|state| state.restore) else {
            return raw::FAILED;
        };
        let SavedMemory { version, bytes } = saved;
        // SAFETY: as in `awake`; the bytes live for the call.
        forked::call(|| unsafe {
            restore(
                self.this.as_ptr(),
                context.context,
                *version,
                bytes.as_ptr().cast(),
                bytes.len() as u64,
            )
        })
    }
}

impl InProcessInstance {
    /// Inspects the resources that its modulations name. Also returns the problems found.
    pub fn inspect(&mut self, context: PluginContext<'_>) -> (i32, Result<Vec<Problem>, String>) {
        // SAFETY: the table was checked.
        let inspect = unsafe { inspect::of(&self.table) }.unwrap_or_default();
        let Some(inspect) = inspect.and_then(|inspect| inspect.inspect) else {
            return (raw::FAILED, Err(String::from("it has no inspection")));
        };
        inspect::lend(|problems| {
            // SAFETY: as in `awake`; the list lives for the call.
            forked::call(|| unsafe { inspect(self.this.as_ptr(), context.context, problems) })
        })
    }
}

impl Drop for InProcessInstance {
    fn drop(&mut self) {
        let this = std::mem::replace(&mut self.this, NonNull::dangling());
        if let Some(destroy) = self.table.destroy {
            // SAFETY: `this` came from this table's create and is returned once, since it is dropped once.
            forked::call(|| unsafe { destroy(this.as_ptr()) });
        }
    }
}

impl CandidateChild {
    fn raw(&self) -> raw::Candidate {
        raw::Candidate {
            size: size_of::<raw::Candidate>() as u32,
            child: self.child,
            state: self.state,
            ready: u32::from(self.ready),
            urgency: self.urgency,
        }
    }
}

/// Returns the panel of a type of schema, if it has one. The loader has checked that it can be drawn.
pub fn panel_of(table: &raw::Schema) -> Option<raw::Panel> {
    // SAFETY: the table was checked.
    unsafe { table::ability(table, raw::ABILITY_PANEL) }.ok()?
}

/// Returns the text before the first NUL, or the whole text without one.
fn text_from_chars(text: &[c_char]) -> String {
    let bytes: Vec<u8> = text.iter().map(|c| *c as u8).chain([0]).collect();
    CStr::from_bytes_until_nul(&bytes)
        .map(|text| text.to_string_lossy().into_owned())
        .unwrap_or_default()
}
