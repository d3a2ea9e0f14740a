//! Reading, writing and operating by name.

use std::collections::btree_map::Entry;
use std::sync::Arc;

use jde_abi::describe::{Role, Type};
use jde_app::literal::parse_value;
use jde_board::value::{self, Value};
use jde_board::{Stamp, Variable};
use jde_core::{Id, Nanos, SchemaId, State as SchemaState};
use jde_host::{OperatorHandle, PanelViewGuard};
use jde_panel::{Gesture, MAX_RATE, PanelFrame};
use jde_records::snapshot::Snapshot;
use jde_records::{RecordKind, RunRecord};
use jde_sim::Edits;

use crate::Error;
use crate::names::{self, LivePort};
use crate::run::Run;

/// The name of the readers of variables.
const READER: &str = "program";
/// The modulation of a simulated robot that changes its world.
const EDIT: &str = "edit";

impl Run {
    /// Returns the variable at the front of a name, and the path after it.
    ///
    /// # Errors
    /// There is no such variable.
    pub fn find<'n>(&self, name: &'n str) -> Result<(Arc<Variable>, &'n str), Error> {
        names::find_variable(self.handle(), name)
    }

    /// Returns the port of a mock at the front of a name, its full name, and the path after it.
    ///
    /// # Errors
    /// No mock writes it.
    pub fn find_live<'n>(&self, name: &'n str) -> Result<(&'n str, &'n str, &LivePort), Error> {
        names::find_live(&self.live, name)
    }

    /// Returns the variable with exactly this name.
    fn variable(&self, name: &str) -> Result<Arc<Variable>, Error> {
        self.handle().board().get(name).map_err(Error::unknown)
    }

    fn schema(&self, name: &str) -> Result<SchemaId, Error> {
        names::find_schema(self.handle(), name)
    }

    /// Returns what `using` makes of the newest value of a variable; `None` without a value. The name may be that of
    /// a part, whose path `using` gets. No writer waits, and the value never changes meanwhile.
    ///
    /// # Errors
    /// There is no such variable.
    pub fn with_value<T>(
        &self,
        name: &str,
        using: impl FnOnce(&Arc<Type>, &[u8], &str) -> T,
    ) -> Result<Option<T>, Error> {
        let (variable, path) = self.find(name)?;
        let mut reader = variable.reader(READER).of_what_is_in_force();
        let value_type = &variable.describe().value_type;
        Ok(reader
            .latch(self.handle().now())
            .map(|latched| using(value_type, latched.bytes, path)))
    }

    /// Returns the newest value of a variable or of a part of it; `None` without a value.
    ///
    /// # Errors
    /// There is no such variable, or no such part.
    pub fn value(&self, name: &str) -> Result<Option<Value>, Error> {
        let read = self.with_value(name, |value_type, bytes, path| {
            value::get_path(value_type, bytes, path).map_err(Error::invalid)
        });
        read?.transpose()
    }

    /// Copies the newest value of a variable, without the elements of its sequences that are not present. Returns
    /// its stamp; `None` without a value.
    ///
    /// # Errors
    /// There is no such variable, or `bytes` has not its size.
    pub fn read(&self, name: &str, bytes: &mut [u8]) -> Result<Option<Stamp>, Error> {
        let variable = self.variable(name)?;
        let value_type = &variable.describe().value_type;
        if bytes.len() != value_type.bytes {
            let (type_name, size) = (&value_type.name, value_type.bytes);
            return Err(Error::invalid(format!(
                "`{name}` is a {type_name} of {size} bytes, and there is room for {}",
                bytes.len()
            )));
        }
        let mut reader = variable.reader(READER).of_what_is_in_force();
        Ok(reader.latch(self.handle().now()).map(|latched| {
            value_type.copy_into(latched.bytes, bytes);
            latched.stamp
        }))
    }

    /// Returns the type of a variable.
    ///
    /// # Errors
    /// There is no such variable.
    pub fn value_type(&self, name: &str) -> Result<Arc<Type>, Error> {
        Ok(Arc::clone(&self.variable(name)?.describe().value_type))
    }

    /// Returns the type of what the program can write: the port of a mock, or a modulation.
    ///
    /// # Errors
    /// There is nothing of that name.
    pub fn written_type(&self, name: &str) -> Result<Arc<Type>, Error> {
        match self.live.get(name) {
            Some(live) => Ok(Arc::clone(&live.value_type)),
            None => self.value_type(name),
        }
    }

    /// Writes a modulation or a period as an operator (R14), or what a mock writes. A text may have a unit.
    ///
    /// # Errors
    /// There is nothing of that name, the value does not fit, or the application refuses it or has ended.
    pub fn write(&self, name: &str, value: Value) -> Result<(), Error> {
        self.check_running()?;
        if let Some(live) = self.live.get(name) {
            let mut bytes = vec![0; live.value_type.bytes];
            let value = self.parse(name, value, &live.value_type, "")?;
            value::encode(&live.value_type, &value, &mut bytes).map_err(Error::invalid)?;
            return live.value.set(&bytes).map_err(Error::refused);
        }
        let (owner, own) = name.split_once('.').unwrap_or((name, ""));
        let schema = self.schema(owner)?;
        if own == "period" {
            let period_type = self.variable(name)?;
            let period = self.parse(name, value, &period_type.describe().value_type, "s")?;
            let seconds = period.into_only_field().as_number();
            let period = seconds.filter(|seconds| (0.0..9e9).contains(seconds));
            let Some(period) = period else {
                return Err(Error::invalid(format!("`{name}` is a number of seconds")));
            };
            return self.act(schema, |operator| {
                operator.set_period(schema, (period * 1e9).round() as Nanos)
            });
        }
        let ports = &self.handle().application().instances[schema].schema.ports;
        let is_modulation = |role: &Role| matches!(role, Role::Modulation { .. });
        let modulations = ports.iter().filter(|port| is_modulation(&port.role));
        let Some(port) = modulations.clone().find(|port| port.name == own) else {
            let known: Vec<_> = modulations.map(|port| port.name.as_str()).collect();
            return Err(Error::unknown(format!(
                "schema `{owner}` has no modulation `{own}`, but {}",
                known.join(", ")
            )));
        };
        let value = self.parse(name, value, &port.value_type, &port.unit)?;
        self.act(schema, |operator| operator.modulate(schema, own, &value))
    }

    /// Wakes a schema as its father would.
    ///
    /// # Errors
    /// There is no such schema, or why it was refused; likewise below.
    pub fn play(&self, schema: &str) -> Result<(), Error> {
        let schema = self.schema(schema)?;
        self.act(schema, |operator| operator.play(schema))
    }

    /// Puts a schema to sleep until it is released.
    ///
    /// # Errors
    /// As [`Self::play`].
    pub fn stop(&self, schema: &str) -> Result<(), Error> {
        let schema = self.schema(schema)?;
        self.act(schema, |operator| operator.hold_asleep(schema))
    }

    /// Makes a schema the winner of its group while it is awake.
    ///
    /// # Errors
    /// As [`Self::play`].
    pub fn force(&self, schema: &str) -> Result<(), Error> {
        let schema = self.schema(schema)?;
        self.act(schema, |operator| operator.force(schema))
    }

    /// Undoes what operators did to a schema.
    ///
    /// # Errors
    /// As [`Self::play`].
    pub fn release(&self, schema: &str) -> Result<(), Error> {
        let schema = self.schema(schema)?;
        let mut lease = self.shared.lease();
        self.shared.operator.release(schema).map_err(Error::refused)?;
        lease.release(schema);
        Ok(())
    }

    /// Stops all schemas at once, until [`Self::release_all`]. No lease ends that.
    ///
    /// # Errors
    /// The application has ended.
    pub fn stop_all(&self) -> Result<(), Error> {
        self.shared.operator.stop_all().map_err(Error::refused)
    }

    /// Undoes [`Self::stop_all`].
    ///
    /// # Errors
    /// The application has ended.
    pub fn release_all(&self) -> Result<(), Error> {
        self.shared.operator.release_all().map_err(Error::refused)
    }

    /// Gives all that the program holds as an operator a lease of this length from now on, ns: it is undone unless
    /// this is called again within the lease. Without a lease, it lasts until it is released.
    pub fn renew_lease(&self, lease: Option<Nanos>) {
        let now = self.handle().now();
        let until = lease.map(|lease| now.saturating_add(lease));
        self.shared.lease().renew(until);
    }

    /// Changes the world of a simulated robot, in the form of [`Edits`].
    ///
    /// # Errors
    /// There is no such driver, the change is none, or the application has ended.
    pub fn edit(&self, driver: &str, edits: &str) -> Result<(), Error> {
        let schema = self.schema(driver)?;
        self.check_running()?;
        let mut queues = self.shared.edits.lock();
        let queue = queues.entry(schema).or_default();
        let text = Edits::parse(edits).and_then(|edits| queue.push(&edits));
        let text = Value::Text(text.map_err(Error::invalid)?);
        self.shared
            .operator
            .modulate(schema, EDIT, &text)
            .map_err(Error::refused)
    }

    /// Returns the state of every schema and group.
    #[must_use]
    pub fn snapshot(&self) -> Snapshot {
        self.handle().snapshot()
    }

    /// Returns the state of a schema.
    ///
    /// # Errors
    /// There is no such schema.
    pub fn schema_state(&self, schema: &str) -> Result<SchemaState, Error> {
        let schema = self.schema(schema)?;
        Ok(self.snapshot().schemas[schema.index()].state)
    }

    /// Returns the winner of a group, such as `roots` or `example/base`; `None` if nobody wins.
    ///
    /// # Errors
    /// There is no such group.
    pub fn winner(&self, group: &str) -> Result<Option<String>, Error> {
        let snapshot = self.snapshot();
        let found = snapshot.groups.iter().find(|view| view.name == group);
        let Some(found) = found else {
            let known: Vec<_> = snapshot.groups.iter().map(|view| view.name.as_str()).collect();
            return Err(Error::unknown(format!(
                "there is no group `{group}`, but {}",
                known.join(", ")
            )));
        };
        Ok(found.winner.map(|winner| snapshot.schemas[winner].name.clone()))
    }

    /// Whether a schema has authority at present: the right to command and to wake children (R7).
    ///
    /// # Errors
    /// There is no such schema.
    pub fn has_authority(&self, schema: &str) -> Result<bool, Error> {
        let number = self.schema(schema)?.index();
        Ok(self.snapshot().schemas[number].authority)
    }

    /// Returns the newest records of a kind, at most 100 000.
    ///
    /// # Errors
    /// The run keeps no records; likewise below.
    pub fn records(&self, kind: RecordKind) -> Result<Vec<RunRecord>, Error> {
        self.observation(|observation| observation.records(kind))
    }

    /// Removes the oldest record and returns it, with the number of those that were dropped since the last call.
    ///
    /// # Errors
    /// As [`Self::records`].
    pub fn next_record(&self) -> Result<Option<(RunRecord, u64)>, Error> {
        self.observation(|observation| observation.next_record())
    }

    /// Begins to keep the values of a variable.
    ///
    /// # Errors
    /// As [`Self::records`], and there is no such variable.
    pub fn start_trace(&self, name: &str) -> Result<(), Error> {
        let variable = self.variable(name)?;
        self.observation(|observation| observation.start_trace(name, &variable))
    }

    /// Returns the times, ns, and the values of a variable that is traced.
    ///
    /// # Errors
    /// As [`Self::records`], and it is not traced.
    pub fn trace(&self, name: &str) -> Result<(Vec<u64>, Vec<u8>), Error> {
        let kept = self.observation(|observation| observation.trace(name))?;
        kept.ok_or_else(|| Error::invalid(format!("`{name}` is not traced")))
    }

    /// Returns the newest drawing of the panel of a schema, which is drawn from the first call on; `None` before its
    /// first drawing.
    ///
    /// # Errors
    /// There is no such schema, or it has no panel.
    pub fn panel(&self, schema: &str) -> Result<Option<Arc<PanelFrame>>, Error> {
        let schema = self.schema(schema)?;
        let view = || -> Result<PanelViewGuard, Error> {
            self.handle()
                .view_panel(schema, MAX_RATE, || {})
                .map_err(Error::refused)
        };
        if let Entry::Vacant(free) = self.state().panels.entry(schema) {
            free.insert(view()?);
        }
        Ok(self.handle().panel(schema))
    }

    /// Applies a gesture to the panel of a schema.
    ///
    /// # Errors
    /// Why it was refused.
    pub fn touch(&self, schema: &str, gesture: Gesture) -> Result<(), Error> {
        let schema = self.schema(schema)?;
        let by = &self.shared.by;
        self.handle().touch(by, schema, gesture).map_err(Error::refused)
    }

    /// Acts as an operator on a schema, which is then held.
    fn act(
        &self,
        schema: SchemaId,
        action: impl FnOnce(&OperatorHandle) -> Result<(), String>,
    ) -> Result<(), Error> {
        let (operator, mut lease) = (&self.shared.operator, self.shared.lease());
        // A lease that has ended does not hold for this action.
        lease.check(self.handle().now(), operator);
        let done = if lease.is_set() {
            action(&operator.under_lease())
        } else {
            action(operator)
        };
        done.map_err(Error::refused)?;
        lease.hold(schema);
        Ok(())
    }

    fn check_running(&self) -> Result<(), Error> {
        self.outcome().map_or(Ok(()), |outcome| {
            Err(Error::refused(format!("the application has ended: {outcome}")))
        })
    }

    /// Reads a text as the application file would; other values stay as they are.
    fn parse(&self, name: &str, value: Value, value_type: &Type, unit: &str) -> Result<Value, Error> {
        let Value::Text(text) = &value else {
            return Ok(value);
        };
        let owner = name.split_once('.').unwrap_or((name, ""));
        let file = &self.handle().application().path;
        let folder = file.parent().unwrap_or(file);
        parse_value(text, owner, value_type, unit, folder, name).map_err(Error::invalid)
    }
}
