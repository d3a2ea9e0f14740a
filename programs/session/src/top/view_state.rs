//! The state of the view between two redraws: the last snapshot, the timeline, the selection and the mode.
//!
//! It does not draw or read keys: `draw` and `keys` do.

use std::time::Duration;

use jde_core::{Health, Nanos};
use jde_records::DecidedBy;
use jde_records::snapshot::{SchemaView, Snapshot};
use jde_terminal::escape::escape;
use jde_timeline::{Ending, Hierarchy, HierarchyRow, Timeline};

use super::strip;
use super::theme::Theme;
use super::tree;
use super::{ObservedApplication, RobotView};

/// The time that one cell of a strip can cover, ns: from what a redraw can resolve to an hour on a wide
/// terminal.
pub(super) const TIME_BASES: [Nanos; 6] = [
    100_000_000,
    250_000_000,
    500_000_000,
    1_000_000_000,
    5_000_000_000,
    20_000_000_000,
];

/// The state of the view.
#[derive(Debug)]
pub(super) struct ViewState {
    pub(super) title: String,
    pub(super) theme: Theme,
    pub(super) snapshot: Snapshot,
    /// The rows, each with the lines of the tree before its name.
    pub(super) rows: Vec<(String, HierarchyRow)>,
    pub(super) robot: Option<RobotView>,
    pub(super) ending: Option<Ending>,
    /// How long the application has said nothing.
    pub(super) silent: Duration,
    pub(super) log: Vec<String>,
    pub(super) timeline: Timeline,
    /// The place of the selected schema.
    pub(super) selected: usize,
    /// The first row that is drawn. Drawing changes it so that the selection is visible.
    pub(super) first_row: usize,
    /// An index into [`TIME_BASES`].
    pub(super) time_base: usize,
    pub(super) mode: Mode,
    pub(super) status: Option<ActionResult>,
}

/// The meaning of the keys.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Mode {
    /// The view is shown, and keys act on it.
    Watch,
    /// The help is shown. Any key closes it.
    Help,
    /// The operator is typing a period for a schema.
    Period {
        /// The place of the schema.
        schema: usize,
        /// The typed text.
        typed: String,
    },
}

/// The result of the last action.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum ActionResult {
    /// The action was carried out.
    Done(String),
    /// The action was refused.
    Refused(String),
}

impl ViewState {
    pub(super) fn new(title: &str, theme: Theme, app: &dyn ObservedApplication) -> Self {
        let mut screen = Self {
            title: escape(title),
            theme,
            rows: Vec::new(),
            snapshot: Snapshot::default(),
            robot: None,
            ending: None,
            silent: Duration::ZERO,
            log: Vec::new(),
            timeline: Timeline::new(Hierarchy::default(), strip::KEEP),
            selected: 0,
            first_row: 0,
            time_base: 1,
            mode: Mode::Watch,
            status: None,
        };
        screen.observe(app);
        let first = screen.order().next();
        screen.selected = first.unwrap_or(0);
        screen
    }

    /// Reads the present state of the application.
    pub(super) fn observe(&mut self, app: &dyn ObservedApplication) {
        let ended = self.ending.as_ref().map(|_| self.snapshot.time);
        self.snapshot = escape_texts(app.snapshot());
        // The clock of an application that has ended may run on.
        self.snapshot.time = ended.unwrap_or(self.snapshot.time);
        self.timeline.add_snapshot(&self.snapshot);
        self.rows = tree::branches(self.timeline.hierarchy());
        self.rows.retain(|(_, row)| row.is_in(&self.snapshot));
        self.robot = app.robot();
        self.ending = app.ending();
        self.silent = app.silent();
        self.log = app.log_lines().iter().map(|line| escape(line)).collect();
    }

    /// Returns the selected schema, if there is one.
    pub(super) fn selection(&self) -> Option<&SchemaView> {
        self.snapshot.schemas.get(self.selected)
    }

    /// Returns the operator who stopped everything, until it is released.
    pub(super) fn stopped_by(&self) -> Option<&str> {
        let mut holds = self.snapshot.schemas.iter().flat_map(SchemaView::holds);
        Some(&holds.find(|hold| hold.with_everything)?.by)
    }

    /// Returns the row of the selected schema.
    pub(super) fn selected_row(&self) -> Option<usize> {
        self.rows
            .iter()
            .position(|(_, row)| row.schema() == Some(self.selected))
    }

    /// Moves the selection by a number of schemas, in the order of the rows, and stops at the ends.
    pub(super) fn select(&mut self, by: isize) {
        let order: Vec<usize> = self.order().collect();
        let Some(last) = order.len().checked_sub(1) else {
            return;
        };
        let row = order
            .iter()
            .position(|schema| *schema == self.selected)
            .unwrap_or(0);
        self.selected = order[row.saturating_add_signed(by).min(last)];
    }

    /// Returns the schemas in the order of the rows.
    fn order(&self) -> impl Iterator<Item = usize> {
        self.rows.iter().filter_map(|(_, row)| row.schema())
    }

    /// Returns the name of a schema by its place.
    pub(super) fn name(&self, schema: usize) -> &str {
        self.snapshot
            .schemas
            .get(schema)
            .map_or("?", |schema| schema.name.as_str())
    }

    /// Returns the time that one cell of a strip covers, ns.
    pub(super) fn slice(&self) -> Nanos {
        TIME_BASES[self.time_base]
    }
}

/// Escapes the control characters in the texts of a snapshot, which may come from any application.
fn escape_texts(mut snapshot: Snapshot) -> Snapshot {
    let show = |text: &mut String| *text = escape(text);
    snapshot.standstill.iter_mut().for_each(show);
    for schema in &mut snapshot.schemas {
        show(&mut schema.name);
        show(&mut schema.type_name);
        match &mut schema.health {
            Health::ArbitrationFailed(reason) | Health::Faulted(reason) => show(reason),
            Health::Ok | Health::Overrun => {}
        }
        let holds = schema.operator.iter_mut().chain(&mut schema.more_holds);
        holds.for_each(|hold| show(&mut hold.by));
    }
    for group in &mut snapshot.groups {
        show(&mut group.name);
        show(&mut group.policy);
        if let Some(switch) = &mut group.last {
            if let DecidedBy::Policy(policy) = &mut switch.decider {
                show(policy);
            }
            show(&mut switch.reason);
        }
    }
    snapshot
}
