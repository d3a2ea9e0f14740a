//! An experiment, complete and free of faults, and the drives that it consists of.

use std::path::PathBuf;

use jde_app::{Faults, Override};
use jde_conditions::Expression;
use jde_core::Nanos;
use jde_host::Mock;
use jde_sim::Footprint;
use serde_json::Value;

use crate::drive::measure::Measure;
use crate::drive::property::Property;
use crate::drive::step::DriveStep;
use crate::result::Columns;

/// The modulation that names the world of a simulated robot.
pub(crate) const WORLD: &str = "world";

/// The name of the axis of the cases.
pub(crate) const CASE: &str = "case";

/// An experiment.
#[derive(Clone, Debug)]
pub struct Experiment {
    /// Its name.
    pub name: String,
    /// A description; may be empty.
    pub doc: String,
    /// The file it was read from, absolute.
    pub file: PathBuf,
    /// The application's file, absolute.
    pub application: PathBuf,
    /// The longest drive, ns.
    pub limit: Nanos,
    /// What varies; the drives are the product, the last axis fastest.
    pub axes: Vec<Axis>,
    /// The values that every drive sets.
    pub set: Vec<Override>,
    /// Builds of plugins; the first one is used where no axis chooses.
    pub variants: Vec<Variant>,
    /// All expressions, each once; the parts below name them by their places.
    pub expressions: Vec<Expression>,
    /// What ends a drive early.
    pub end: Option<usize>,
    /// Whether the mission must be done.
    pub mission: Mission,
    /// Whether a drive passes in which a schema faults.
    pub ignores_faults: bool,
    /// Whether a drive fails in which a turn takes longer than its budget by the machine's clock.
    pub judges_budgets: bool,
    /// What must hold, in the order of [`Columns::properties`], which names the mission last if it is one.
    pub properties: Vec<Property>,
    /// What is measured, in the order of [`Columns::measures`].
    pub measures: Vec<Measure>,
    /// What happens meanwhile.
    pub steps: Vec<DriveStep>,
    /// The schemas that are replaced by their ports.
    pub mocks: Vec<(String, Mock)>,
    /// The recordings that mocks play.
    pub recordings: Vec<PathBuf>,
    /// The world of the simulated robot where no axis chooses another.
    pub world: Option<PathBuf>,
    /// The body of the simulated robot, if there is one.
    pub robot: Option<Footprint>,
    /// The columns of the results.
    pub columns: Columns,
    /// Names of before that the file uses: no reason to refuse it.
    pub concerns: Option<Faults>,
}

/// Something that varies.
#[derive(Clone, Debug)]
pub struct Axis {
    /// Its column.
    pub name: String,
    /// Its values.
    pub values: AxisValues,
}

/// The values of an axis.
#[derive(Clone, Debug)]
pub enum AxisValues {
    /// Seeds of the application.
    Seeds(Vec<u64>),
    /// Anything else.
    Choices(Vec<AxisChoice>),
}

/// A value of an axis.
#[derive(Clone, Debug)]
pub struct AxisChoice {
    /// The value in results.
    pub label: Value,
    /// The seed that it states.
    pub seed: Option<u64>,
    /// The values that it sets.
    pub overrides: Vec<Override>,
    /// The place of its builds in [`Experiment::variants`].
    pub variant: Option<usize>,
}

/// Builds that are used in place of those along the search path.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Variant {
    /// Its name; empty for the builds along the search path.
    pub name: String,
    /// The plugins that it replaces, and their files.
    pub plugins: Vec<(String, PathBuf)>,
}

/// Whether the application's mission must be done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mission {
    /// It is a property.
    Required,
    /// It is no property, or the application has none.
    Ignored,
}

/// What one drive runs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DriveSettings {
    /// The value of each axis.
    pub labels: Vec<Value>,
    /// The seed; the application's own if `None`.
    pub seed: Option<u64>,
    /// The values that it sets.
    pub overrides: Vec<Override>,
    /// The builds that it uses.
    pub variant: usize,
}

impl AxisValues {
    fn len(&self) -> usize {
        match self {
            Self::Seeds(seeds) => seeds.len(),
            Self::Choices(choices) => choices.len(),
        }
    }
}

impl Experiment {
    /// The most drives of an experiment.
    pub const MAX_DRIVES: usize = 1_000_000;

    /// Returns the number of drives.
    #[must_use]
    pub fn drives(&self) -> usize {
        self.axes
            .iter()
            .fold(1, |product, axis| product.saturating_mul(axis.values.len()))
    }

    /// Returns the world file of a drive; `None` without a simulated robot.
    #[must_use]
    pub fn world_of(&self, drive: usize) -> Option<PathBuf> {
        let overrides = self.settings(drive).overrides;
        let set = overrides.iter().rev().find(|set| set.variable == WORLD);
        let written = set
            .map(|set| serde_json::from_str::<PathBuf>(&set.value).unwrap_or_else(|_| (&set.value).into()));
        let folder = set.map(|set| set.folder.as_path());
        written
            .zip(folder)
            .map(|(path, folder)| folder.join(path))
            .or_else(|| self.world.clone())
    }

    /// Returns the name of the case of a drive; `None` without cases.
    #[must_use]
    pub fn case_of<'s>(&self, settings: &'s DriveSettings) -> Option<&'s str> {
        let place = self.axes.iter().position(|axis| axis.name == CASE)?;
        settings.labels[place].as_str()
    }

    /// Returns the names of the cases.
    pub(crate) fn cases(axes: &[Axis]) -> impl Iterator<Item = &str> {
        let cases = axes.iter().filter(|axis| axis.name == CASE);
        cases.flat_map(|axis| {
            match &axis.values {
                AxisValues::Choices(cases) => cases.as_slice(),
                AxisValues::Seeds(_) => &[],
            }
            .iter()
            .filter_map(|case| case.label.as_str())
        })
    }

    /// Returns what a drive runs, by its number.
    #[must_use]
    pub fn settings(&self, drive: usize) -> DriveSettings {
        let mut settings = DriveSettings {
            labels: Vec::with_capacity(self.axes.len()),
            seed: None,
            overrides: self.set.clone(),
            variant: 0,
        };
        let mut places = Vec::with_capacity(self.axes.len());
        let mut rest = drive;
        for axis in self.axes.iter().rev() {
            places.push(rest % axis.values.len());
            rest /= axis.values.len();
        }
        for (axis, place) in self.axes.iter().zip(places.into_iter().rev()) {
            match &axis.values {
                AxisValues::Seeds(seeds) => {
                    settings.labels.push(seeds[place].into());
                    settings.seed = Some(seeds[place]);
                }
                AxisValues::Choices(choices) => {
                    let choice = &choices[place];
                    settings.labels.push(choice.label.clone());
                    settings.seed = choice.seed.or(settings.seed);
                    settings.overrides.extend(choice.overrides.iter().cloned());
                    settings.variant = choice.variant.unwrap_or(settings.variant);
                }
            }
        }
        settings
    }
}
