//! Steps: what happens to the application during a drive, at a time or on a condition, each once.

use std::collections::BTreeMap;

use jde_board::value::{Value, get_path};
use jde_core::{Nanos, SchemaId};
use jde_host::{Handle, OperatorHandle, SensorFault};
use jde_sim::{EditQueue, Edits};

/// A step.
#[derive(Clone, Debug)]
pub struct DriveStep {
    /// The case in which it happens; in all if `None`.
    pub case: Option<String>,
    /// When it happens.
    pub when: StepTime,
    /// What happens.
    pub action: StepAction,
    /// Its place in the file, for messages: `file:line`.
    pub place: String,
}

/// When a step happens.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StepTime {
    /// At this time, ns.
    At(Nanos),
    /// At the first instant at which the expression in this place is true.
    When(usize),
}

/// What a step does, as an operator (R14). Schemas are places in the application.
#[derive(Clone, Debug, PartialEq)]
pub enum StepAction {
    /// Wakes a schema.
    Play(SchemaId),
    /// Puts a schema to sleep.
    Stop(SchemaId),
    /// Makes a schema the winner of its group.
    Force(SchemaId),
    /// Undoes all actions on a schema.
    Release(SchemaId),
    /// Writes modulations and periods.
    Write(Vec<StepWrite>),
    /// Changes the world of a simulated robot.
    Edit {
        /// The robot's driver.
        driver: SchemaId,
        /// The changes, in the form of [`Edits`].
        text: String,
    },
    /// Lets an export fail.
    Fail {
        /// The schema.
        schema: SchemaId,
        /// The export.
        export: String,
        /// How it fails.
        fault: SensorFault,
        /// How long, ns; until the drive ends if `None`.
        time: Option<Nanos>,
    },
}

/// What a step writes.
#[derive(Clone, Debug, PartialEq)]
pub enum StepWrite {
    /// A modulation: schema, name, value.
    Value(SchemaId, String, Value),
    /// The period of a schema, ns.
    Period(SchemaId, Nanos),
}

/// The name of the operator in recordings.
const OPERATOR: &str = "experiment";

/// Carries out the steps of a drive.
pub struct Operator {
    handle: OperatorHandle,
    /// The changes of each world so far, by the driver that makes them.
    edits: BTreeMap<SchemaId, EditQueue>,
    /// Exports that fail until a time: schema and export.
    failing: Vec<(Nanos, SchemaId, String)>,
}

/// The modulation of a simulated robot that changes its world, and the export that counts the changes.
pub(crate) const EDIT: &str = "edit";
const EDIT_COUNT: &str = "edits";

impl Operator {
    /// Returns the operator of a drive.
    #[must_use]
    pub fn new(handle: &Handle) -> Self {
        Self {
            handle: handle.operator(OPERATOR),
            edits: BTreeMap::new(),
            failing: Vec::new(),
        }
    }

    /// Carries a step out.
    ///
    /// # Errors
    /// Why the application refuses it.
    pub fn perform(&mut self, step: &DriveStep, now: Nanos) -> Result<(), String> {
        self.act(&step.action, now)
            .map_err(|reason| format!("the step at {} was refused: {reason}", step.place))
    }

    fn act(&mut self, action: &StepAction, now: Nanos) -> Result<(), String> {
        match action {
            StepAction::Play(schema) => self.handle.play(*schema),
            StepAction::Stop(schema) => self.handle.hold_asleep(*schema),
            StepAction::Force(schema) => self.handle.force(*schema),
            StepAction::Release(schema) => self.handle.release(*schema),
            StepAction::Write(writes) => writes.iter().try_for_each(|write| match write {
                StepWrite::Value(schema, name, value) => self.handle.modulate(*schema, name, value),
                StepWrite::Period(schema, period) => self.handle.set_period(*schema, *period),
            }),
            StepAction::Edit { driver, text } => {
                let queue = self.edits.entry(*driver).or_default();
                let text = Edits::parse(text).and_then(|edits| queue.push(&edits));
                let text = text.map_err(|error| error.to_string())?;
                self.handle.modulate(*driver, EDIT, &Value::Text(text))
            }
            StepAction::Fail {
                schema,
                export,
                fault,
                time,
            } => {
                self.handle.fail_export(*schema, export, *fault)?;
                let until = time.map(|time| (now.saturating_add(time), *schema, export.clone()));
                self.failing.extend(until);
                Ok(())
            }
        }
    }

    /// Repairs the exports whose time is over.
    ///
    /// # Errors
    /// Why the application refuses it.
    pub fn repair(&mut self, now: Nanos) -> Result<(), String> {
        let (due, failing) = std::mem::take(&mut self.failing)
            .into_iter()
            .partition(|(until, ..)| *until <= now);
        self.failing = failing;
        let mut due: Vec<(Nanos, SchemaId, String)> = due;
        due.drain(..)
            .try_for_each(|(_, schema, export)| self.handle.repair_export(schema, &export))
    }

    /// Returns why a change of a world was refused, if one was.
    #[must_use]
    pub fn refused_edit(&self, handle: &Handle) -> Option<String> {
        self.edits.keys().find_map(|driver| {
            let name = &handle.application().instances[*driver].name;
            let variable = handle.board().find(&format!("{name}.{EDIT_COUNT}"))?;
            let value_type = variable.describe().value_type.clone();
            let mut reader = variable.reader(OPERATOR);
            let bytes = reader.latch(handle.now())?.bytes;
            let refused = get_path(&value_type, bytes, "refused").ok()?.as_number()?;
            let Value::Text(note) = get_path(&value_type, bytes, "note").ok()? else {
                return None;
            };
            (refused > 0.0).then(|| format!("{name} refused to change the world: {note}"))
        })
    }
}
