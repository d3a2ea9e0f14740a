//! A shared variable: its cell, its readers and writers, its grants and its status. It opens readers and
//! writers.

#![allow(unsafe_code, reason = "a claimed slot is written in place")]

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use jde_abi::finite::Finite;
use parking_lot::Mutex;

use crate::notifier::Notifier;
use crate::rate::Rate;
use crate::register::Register;
use crate::store::Cell;
use crate::watch::{Occasion, Watch, Watchers};
use crate::{Access, Declaration, Error, LASTING, Nanos, Reader, Refused, Shared, Writer};

/// A shared variable. Any thread may call it.
pub struct Variable {
    declaration: Declaration,
    pub(crate) cell: Cell,
    finite: Option<Finite>,
    notifier: Notifier,
    rate: Rate,
    /// Values up to this number have ended before their validity; all, as long as it is closed.
    ended: AtomicU64,
    refused: AtomicU64,
    not_finite: AtomicU64,
    not_finite_at: Mutex<Option<String>>,
    watchers: Watchers,
    end_watchers: Watchers,
    ports: Mutex<Register>,
    /// Held while the host puts a value, so that one spare slot is enough for all of them.
    put_lock: Mutex<()>,
    /// Held while a reader beyond the declared number copies, so that one spare pin is enough for all of
    /// them.
    pub(crate) copy_lock: Mutex<()>,
}

/// The status of a variable.
#[derive(Clone, Debug, PartialEq)]
pub struct VariableStatus {
    /// Number of the newest value; 0 before the first.
    pub sequence: u64,
    /// Time since the newest value, in nanoseconds; `None` before the first.
    pub age: Option<Nanos>,
    /// Values per second, estimated.
    pub rate_hz: f64,
    /// As [`Variable::has_ended`].
    pub ended: bool,
    /// The writer of the newest value; `None` before the first.
    pub last_writer: Option<u32>,
    /// The open writers.
    pub writers: Vec<String>,
    /// The open readers.
    pub readers: Vec<String>,
    /// Values refused because their writer held no grant, because a guard refused them, or because they were
    /// outside of the limits.
    pub refused: u64,
    /// Values refused because they contained a NaN or an infinity.
    pub not_finite: u64,
    /// The field that was not finite in the last of these.
    pub not_finite_at: Option<String>,
}

impl Variable {
    pub(crate) fn new(mut declaration: Declaration, shared: bool) -> Result<Self, Error> {
        let finite = match declaration.access {
            Access::Export { .. } => {
                declaration.writers = 1;
                None
            }
            Access::Modulation | Access::Command { .. } => Some(Finite::new(&declaration.value_type)),
        };
        declaration.check(finite.as_ref())?;
        let cell = Cell::new(&declaration, shared).map_err(|error| Error::NoMemory {
            variable: declaration.full_name(),
            error: error.to_string(),
        })?;
        let register = Register::new(declaration.writers);
        Ok(Self {
            declaration,
            cell,
            finite,
            notifier: Notifier::default(),
            rate: Rate::default(),
            ended: AtomicU64::new(0),
            refused: AtomicU64::new(0),
            not_finite: AtomicU64::new(0),
            not_finite_at: Mutex::new(None),
            watchers: Watchers::default(),
            end_watchers: Watchers::default(),
            ports: Mutex::new(register),
            put_lock: Mutex::new(()),
            copy_lock: Mutex::new(()),
        })
    }

    /// Returns its declaration.
    #[must_use]
    pub fn describe(&self) -> &Declaration {
        &self.declaration
    }

    /// Returns the memory of its values, if other processes can map it.
    #[must_use]
    pub fn shared(&self) -> Option<&Shared> {
        match &self.cell {
            Cell::Pinned(pinned) => pinned.shared(),
            Cell::Ring(_) => None,
        }
    }

    /// Returns where latched or loaned bytes begin in that memory; `None` if they are elsewhere, as copies
    /// are.
    #[must_use]
    pub fn offset_of(&self, bytes: &[u8]) -> Option<usize> {
        match &self.cell {
            Cell::Pinned(pinned) => pinned.shared().and_then(|_| pinned.offset_of(bytes)),
            Cell::Ring(_) => None,
        }
    }

    /// Returns its status at `now`.
    #[must_use]
    pub fn status(&self, now: Nanos) -> VariableStatus {
        let stamp = self.cell.newest();
        let written = stamp.sequence > 0;
        let age = now.saturating_sub(stamp.time);
        let register = self.ports.lock();
        VariableStatus {
            sequence: stamp.sequence,
            age: written.then_some(age),
            rate_hz: self.rate.hz(age),
            ended: self.has_ended(now),
            last_writer: written.then_some(stamp.writer),
            writers: register.writers(),
            readers: register.readers(),
            refused: self.refused.load(Ordering::Relaxed),
            not_finite: self.not_finite.load(Ordering::Relaxed),
            not_finite_at: self.not_finite_at.lock().clone(),
        }
    }

    /// Returns the field that was not finite in the last value that was refused for it. It does not wait: `None`
    /// while another thread holds the name.
    #[must_use]
    pub fn not_finite_at(&self) -> Option<String> {
        self.not_finite_at.try_lock()?.clone()
    }

    /// Returns the number of the newest value; 0 before the first.
    #[must_use]
    pub fn newest(&self) -> u64 {
        match &self.cell {
            Cell::Ring(ring) => ring.newest(),
            Cell::Pinned(pinned) => pinned.newest().sequence,
        }
    }

    /// Opens it for writing. Stamps and grants use `id`, tools show `name`.
    ///
    /// # Errors
    /// [`Error::TooManyWriters`]: an export has one writer at a time, other variables as many as declared.
    pub fn writer(self: &Arc<Self>, id: u32, name: &str) -> Result<Writer, Error> {
        let mut register = self.ports.lock();
        let Some(writer_index) = register.open_writer(id, name) else {
            return Err(Error::TooManyWriters {
                variable: self.declaration.full_name(),
                name: name.to_owned(),
                most: self.declaration.writers,
                taken: register.writers(),
            });
        };
        if let Cell::Pinned(pinned) = &self.cell
            && register.granted.contains(&id)
        {
            pinned.grant(writer_index);
        }
        Ok(Writer::new(self.clone(), id, writer_index))
    }

    /// Opens it for reading. Tools show `name`.
    #[must_use]
    pub fn reader(self: &Arc<Self>, name: &str) -> Reader {
        let ticket = self.ports.lock().open_reader(name);
        Reader::new(self.clone(), ticket)
    }

    /// Waits for a value newer than number `sequence`, at most `timeout`, and returns the number of the
    /// newest. Returns at once if there is one.
    pub fn wait_newer(&self, sequence: u64, timeout: Duration) -> u64 {
        if self.newest() <= sequence {
            self.notifier.wait(timeout, || self.newest() > sequence);
        }
        self.newest()
    }

    /// Runs `call` after each publication and each end of a value, on the thread that publishes or ends it
    /// (R12), until the result is dropped. The call must return quickly, must not wait, and must not publish this
    /// variable. Without watches, a publication costs one more load.
    #[must_use = "the watch ends when it is dropped"]
    pub fn watch(self: &Arc<Self>, call: impl Fn() + Send + Sync + 'static) -> Watch {
        Watch::new(self, Occasion::Change, call)
    }

    /// Runs `call` as [`Self::watch`] does, but only after a value has ended and no other has replaced it.
    #[must_use = "the watch ends when it is dropped"]
    pub fn watch_end(self: &Arc<Self>, call: impl Fn() + Send + Sync + 'static) -> Watch {
        Watch::new(self, Occasion::End, call)
    }

    pub(crate) fn watchers(&self, occasion: Occasion) -> &Watchers {
        match occasion {
            Occasion::Change => &self.watchers,
            Occasion::End => &self.end_watchers,
        }
    }

    /// Permits a writer's commands to take effect (R7), now or as soon as it is opened. Only commands need
    /// grants.
    pub fn grant(&self, writer_id: u32) {
        let mut register = self.ports.lock();
        register.granted.insert(writer_id);
        if let Cell::Pinned(pinned) = &self.cell {
            register
                .grants_of(writer_id)
                .for_each(|writer_index| pinned.grant(writer_index));
        }
    }

    /// Refuses a writer's commands from now on. Once this has returned, no publication of that writer takes
    /// effect, even if it began before. It never waits for the writer. Earlier commands stay until they are
    /// replaced or expire.
    pub fn withdraw(&self, writer_id: u32) {
        let mut register = self.ports.lock();
        register.granted.remove(&writer_id);
        if let Cell::Pinned(pinned) = &self.cell {
            register
                .grants_of(writer_id)
                .for_each(|writer_index| pinned.withdraw(writer_index));
        }
    }

    /// Returns whether a writer's commands take effect.
    #[must_use]
    pub fn has_grant(&self, writer_id: u32) -> bool {
        self.ports.lock().granted.contains(&writer_id)
    }

    /// Publishes a value of the host itself (braking, holding, an operator), whatever the grants, and returns
    /// its number.
    ///
    /// # Errors
    /// [`Refused::NoAuthority`] for exports, [`Refused::NotFinite`], [`Refused::OutOfRange`],
    /// [`Refused::WrongSize`].
    pub fn put(&self, writer: u32, bytes: &[u8], time: Nanos, valid_until: Nanos) -> Result<u64, Refused> {
        let (Access::Modulation | Access::Command { .. }, Cell::Pinned(pinned)) =
            (self.declaration.access, &self.cell)
        else {
            return Err(Refused::NoAuthority);
        };
        if bytes.len() != self.declaration.value_type.bytes {
            return Err(Refused::WrongSize);
        }
        self.check(bytes)?;
        let guard = self.put_lock.lock();
        let mut claim = pinned.claim();
        // SAFETY: claimed from this cell; the slice ends with the copy.
        unsafe { pinned.bytes_mut(&mut claim) }.copy_from_slice(bytes);
        let published = pinned.publish(claim, None, time, writer, valid_until);
        drop(guard);
        self.finish_publish(published.map_err(|_| Refused::NoAuthority), time)
    }

    /// Retracts the newest value of an export: a reader that latches gets no value until the next one. A
    /// reader that holds the value keeps it until it releases it. Watches are called (R12). Has no effect on
    /// modulations and commands, which keep their values.
    pub fn retract(&self) {
        let newest = self.newest();
        if self.is_export() && self.ended.fetch_max(newest, Ordering::AcqRel) < newest {
            self.report_end();
        }
    }

    /// Retracts the newest value of an export if its validity is over. Returns when it will be, if there is a
    /// value that expires. Readers need no such call; it is for the watches.
    pub fn expire(&self, now: Nanos) -> Option<Nanos> {
        let stamp = self.cell.newest();
        let last = self.last_instant()?;
        if last >= now {
            return Some(last);
        }
        if self.ended.fetch_max(stamp.sequence, Ordering::AcqRel) < stamp.sequence {
            self.report_end();
        }
        None
    }

    /// Returns the last instant at which the newest value is valid, if it is an export that expires and has not ended.
    #[must_use]
    pub fn last_instant(&self) -> Option<Nanos> {
        let stamp = self.cell.newest();
        let ends = self.expires() && stamp.sequence > 0 && self.is_visible(stamp.sequence);
        ends.then_some(stamp.valid_until)
    }

    /// Ends every value of an export that expires, also those that are published from now on, until
    /// [`Self::open`]: its writer sleeps (R19). It waits for nothing. Returns whether readers lost a value, which
    /// the caller then reports by [`Self::report_end`].
    #[must_use = "the watches must be called"]
    pub fn close(&self) -> bool {
        if !self.expires() {
            return false;
        }
        let newest = self.newest();
        newest > 0 && self.ended.swap(u64::MAX, Ordering::AcqRel) < newest
    }

    /// Reverses [`Self::close`] for values that are published from now on. Only for the thread that calls its
    /// writer.
    pub fn open(&self) {
        if self.ended.load(Ordering::Acquire) == u64::MAX {
            self.ended.store(self.newest(), Ordering::Release);
        }
    }

    /// Calls the watches because a value has ended.
    pub fn report_end(&self) {
        self.watchers.call();
        self.end_watchers.call();
    }

    /// Returns whether a [reader of what is in force](Reader::of_what_is_in_force) that latches gets a value. It does not
    /// wait.
    #[must_use]
    pub fn has_value(&self, now: Nanos) -> bool {
        let stamp = self.cell.newest();
        // Initial values and modulations have no end.
        self.is_visible(stamp.sequence) && stamp.valid_until >= now
    }

    /// Returns whether the newest value has ended: an export that nobody reads any more, or a command whose validity is
    /// over, of which its driver reads the neutral value.
    #[must_use]
    pub fn has_ended(&self, now: Nanos) -> bool {
        self.newest() > 0 && !self.has_value(now)
    }

    pub(crate) fn is_export(&self) -> bool {
        matches!(self.declaration.access, Access::Export { .. })
    }

    /// Whether it is an export whose values have a validity.
    #[must_use]
    pub fn expires(&self) -> bool {
        matches!(self.declaration.access, Access::Export { validity } if validity != LASTING)
    }

    /// Returns whether readers get a value that is valid: it was published and not ended, or it is an initial
    /// value.
    #[inline]
    pub(crate) fn is_visible(&self, sequence: u64) -> bool {
        sequence > self.ended.load(Ordering::Acquire) || (sequence == 0 && self.declaration.initial.is_some())
    }

    pub(crate) fn bytes(&self) -> usize {
        self.declaration.value_type.bytes
    }

    /// Returns the index of the grant that this writer must hold, if any.
    pub(crate) fn gate(&self, writer_index: usize) -> Option<usize> {
        match self.declaration.access {
            Access::Export { .. } | Access::Modulation => None,
            Access::Command { .. } => Some(writer_index),
        }
    }

    pub(crate) fn valid_until(&self, now: Nanos, least: Nanos) -> Nanos {
        match self.declaration.access {
            Access::Export { validity } => now.saturating_add(validity),
            Access::Modulation => Nanos::MAX,
            Access::Command { validity } => now.saturating_add(validity.max(least)),
        }
    }

    /// Checks a value of a modulation or a command. All their writers use it: fathers, operators, the host
    /// (R8).
    pub(crate) fn check(&self, bytes: &[u8]) -> Result<(), Refused> {
        let Some(finite) = &self.finite else {
            return Ok(());
        };
        if let Some(field) = finite.first_not_finite(bytes) {
            self.not_finite.fetch_add(1, Ordering::Relaxed);
            // If a tool holds the lock, the older name remains: a writer does not wait for a tool.
            if let Some(mut at) = self.not_finite_at.try_lock() {
                *at = Some(field);
            }
            return Err(Refused::NotFinite);
        }
        let Declaration {
            limits, value_type, ..
        } = &self.declaration;
        if limits.is_none() || limits.check(value_type, bytes).is_ok() {
            return Ok(());
        }
        self.refused.fetch_add(1, Ordering::Relaxed);
        Err(Refused::OutOfRange)
    }

    /// Ends every attempt to publish: a success notifies the waiting threads and the watches, a refusal is
    /// counted.
    pub(crate) fn finish_publish(
        &self,
        published: Result<u64, Refused>,
        time: Nanos,
    ) -> Result<u64, Refused> {
        if published.is_err() {
            self.count_refused();
            return published;
        }
        self.rate.record(time);
        self.notifier.notify_all();
        self.watchers.call();
        published
    }

    pub(crate) fn count_refused(&self) {
        self.refused.fetch_add(1, Ordering::Relaxed);
    }

    pub(crate) fn reader_name(&self, ticket: usize) -> String {
        self.ports.lock().reader_name(ticket).to_owned()
    }

    /// Returns a ticket for a slot of the cell, if readers may hold one more.
    pub(crate) fn open_slot(&self) -> Result<usize, Error> {
        let mut register = self.ports.lock();
        let ticket = register.open_reader("an abandoned call");
        if ticket < self.declaration.readers {
            return Ok(ticket);
        }
        register.close_reader(ticket);
        Err(Error::TooManyReaders {
            variable: self.declaration.full_name(),
            most: self.declaration.readers,
        })
    }

    pub(crate) fn close_writer(&self, writer_index: usize) {
        let mut register = self.ports.lock();
        register.close_writer(writer_index);
        if let Cell::Pinned(pinned) = &self.cell {
            pinned.withdraw(writer_index);
        }
    }

    pub(crate) fn close_reader(&self, ticket: usize) {
        self.ports.lock().close_reader(ticket);
    }
}
