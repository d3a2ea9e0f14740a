//! The content of an experiment's page: texts, numbers to draw, and drives.

use jde_drawing::map::{DriveMap, FailurePlace};

/// The content of the page. Empty parts are left out.
#[derive(Clone, Debug, Default)]
pub struct Report {
    /// The name of the experiment.
    pub name: String,
    /// What it is for.
    pub doc: String,
    /// The most important numbers.
    pub facts: Vec<Fact>,
    /// A row for each combination of axes.
    pub results: Table,
    /// The differences of rows from the first.
    pub differences: Table,
    /// How often each property failed.
    pub properties: Table,
    /// How the values of each measure are distributed.
    pub distributions: Vec<Distribution>,
    /// Where drives failed, in each world.
    pub places: Vec<FailureMap>,
    /// The drives that did not pass.
    pub failures: Vec<FailedDrive>,
    /// How the numbers were computed.
    pub method: String,
}

/// One of the most important numbers.
#[derive(Clone, Debug, Default)]
pub struct Fact {
    /// What it is.
    pub label: String,
    /// The number.
    pub value: String,
    /// What a reader may want to know beside it; may be empty.
    pub detail: String,
    /// Whether it is bad news.
    pub is_bad: bool,
}

/// A table of texts.
#[derive(Clone, Debug, Default)]
pub struct Table {
    /// What the reader needs to understand it; may be empty.
    pub note: String,
    /// The titles of the columns.
    pub titles: Vec<Title>,
    /// The rows, each with a cell for each title.
    pub rows: Vec<Vec<Cell>>,
}

/// The title of a column.
#[derive(Clone, Debug, Default)]
pub struct Title {
    /// The text.
    pub text: String,
    /// Whether its cells are numbers, which are aligned right.
    pub is_number: bool,
}

/// A cell of a table.
#[derive(Clone, Debug, Default)]
pub struct Cell {
    /// The text.
    pub text: String,
    /// Smaller lines below it.
    pub details: Vec<String>,
    /// Whether it stands out.
    pub is_strong: bool,
    /// Whether it is bad news.
    pub is_bad: bool,
}

/// The distributions of one measure, which share an axis.
#[derive(Clone, Debug, Default)]
pub struct Distribution {
    /// The name of the measure.
    pub measure: String,
    /// Its unit; may be empty.
    pub unit: String,
    /// The rows of the results.
    pub rows: Vec<DistributionRow>,
}

/// The distribution of one row. Values that are not finite are left out.
#[derive(Clone, Debug, Default)]
pub struct DistributionRow {
    /// The name of the row.
    pub name: String,
    /// The values of drives that passed.
    pub passed: Vec<f64>,
    /// The values of drives that did not.
    pub others: Vec<f64>,
    /// The median and the ends of its interval.
    pub median: Option<[f64; 3]>,
}

/// Where drives failed in one world.
#[derive(Clone, Debug, Default)]
pub struct FailureMap {
    /// The name of the world.
    pub title: String,
    /// Why the world is not drawn; may be empty.
    pub note: String,
    /// The world: only its bounds, shapes and paint are drawn.
    pub ground: DriveMap,
    /// The places.
    pub places: Vec<FailurePlace>,
}

/// A drive that did not pass.
#[derive(Clone, Debug, Default)]
pub struct FailedDrive {
    /// Its number.
    pub number: usize,
    /// Its place on the axes: `seed 18, goon.fast 0.5 m/s`.
    pub axes: String,
    /// Its outcome: `failed`.
    pub outcome: String,
    /// Why it did not pass.
    pub why: String,
    /// Its path until it failed; only for the first [`IN_FULL`](super::IN_FULL).
    pub path: Option<DriveMap>,
    /// The last selections before it failed, the newest last.
    pub selections: Vec<String>,
    /// The command that repeats it.
    pub command: String,
}

impl<T: Into<String>> From<T> for Cell {
    fn from(text: T) -> Self {
        Self {
            text: text.into(),
            ..Self::default()
        }
    }
}
