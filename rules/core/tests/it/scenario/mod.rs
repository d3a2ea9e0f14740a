//! A scenario in TOML: a small hierarchy, its events, and their expected effects.
//!
//! This is the format of the file. `player` plays a scenario; `phrases` converts between text and the values of
//! the state machine.

mod phrases;
mod player;

use std::collections::BTreeMap;

use jde_core::{GroupSpec, Kind, Restart, SchemaId, SchemaSpec, Spec};
use serde::Deserialize;

use phrases::{absence, policy, time};

/// One file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Scenario {
    title: String,
    rule: Vec<String>,
    #[serde(default)]
    #[allow(dead_code, reason = "for the reader of the file")]
    about: String,
    #[serde(default)]
    perceptive: Vec<String>,
    groups: BTreeMap<String, GroupTable>,
    #[serde(default)]
    schemas: BTreeMap<String, SchemaTable>,
    step: Vec<Step>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct GroupTable {
    father: Option<String>,
    members: Vec<String>,
    policy: Option<String>,
    absence: Option<String>,
    patience: Option<String>,
    budget: Option<String>,
    retry: Option<String>,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
struct SchemaTable {
    #[serde(default)]
    needs: Vec<String>,
    period: Option<String>,
    budget: Option<String>,
    #[serde(default)]
    triggered: bool,
    restart: Option<RestartTable>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RestartTable {
    after: String,
    times: u32,
    /// The default is one minute.
    within: Option<String>,
}

/// The events of one time, and their expected effects.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Step {
    at: String,
    #[serde(default)]
    when: Vec<String>,
    /// These effects occur in this order; others may occur in between.
    #[serde(default)]
    order: Vec<String>,
    /// None of these effects occurs.
    #[serde(default)]
    never: Vec<String>,
    #[serde(default)]
    states: BTreeMap<String, String>,
    #[serde(default)]
    winner: BTreeMap<String, String>,
    /// Exactly these schemas hold authority.
    authority: Option<Vec<String>>,
    #[serde(default)]
    health: BTreeMap<String, String>,
    /// The last record of a group in this step.
    #[serde(default)]
    why: BTreeMap<String, Why>,
    /// Parts of the messages of this step's refusals.
    refused: Option<Vec<String>>,
    /// When the next timer is due; "none" for none.
    timer: Option<String>,
    #[serde(default)]
    contract: BTreeMap<String, String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Why {
    case: Option<String>,
    before: Option<String>,
    choice: Option<String>,
    decider: Option<String>,
    /// The record's reason contains this text.
    reason: Option<String>,
    cause: Option<String>,
    caused_at: Option<String>,
    changed: Option<bool>,
    candidates: Option<Vec<String>>,
}

impl Scenario {
    pub(crate) fn parse(text: &str) -> Result<Self, String> {
        toml::from_str(text).map_err(|error| error.to_string())
    }

    pub(crate) fn title(&self) -> &str {
        &self.title
    }

    pub(crate) fn rules(&self) -> &[String] {
        &self.rule
    }

    /// Plays the scenario twice. The second run must have the same effects (R16).
    pub(crate) fn play(&self) -> Result<(), String> {
        let first = player::play(self)?;
        let second = player::play(self)?;
        if first == second {
            Ok(())
        } else {
            Err("R16: the second run differs".into())
        }
    }

    /// Returns the motor schemas in the order of the groups, then the perceptive ones.
    fn schema_names(&self) -> Vec<&str> {
        let mut names: Vec<&str> = Vec::new();
        for group in self.groups.values() {
            names.extend(group.members.iter().map(String::as_str));
        }
        names.extend(self.perceptive.iter().map(String::as_str));
        names
    }

    fn spec(&self) -> Result<Spec, String> {
        let names = self.schema_names();
        let find = |name: &String| {
            let index = names
                .iter()
                .position(|known| known == name)
                .ok_or(format!("the scenario has no schema `{name}`"))?;
            Ok::<_, String>(SchemaId(u32::try_from(index).expect("few schemas")))
        };
        if let Some(unknown) = self.schemas.keys().find(|name| !names.contains(&name.as_str())) {
            return Err(format!("the scenario has no schema `{unknown}`"));
        }
        let mut spec = Spec::default();
        for name in &names {
            let perceptive = self.perceptive.iter().any(|p| p == name);
            let kind = if perceptive { Kind::Perceptive } else { Kind::Motor };
            let mut schema = SchemaSpec::new(*name, kind, 100_000_000);
            if let Some(table) = self.schemas.get(*name) {
                schema.needs = table.needs.iter().map(find).collect::<Result<_, _>>()?;
                schema.triggered = table.triggered;
                if let Some(period) = &table.period {
                    schema.period = time(period)?;
                }
                if let Some(budget) = &table.budget {
                    schema.budget = time(budget)?;
                }
                if let Some(restart) = &table.restart {
                    schema.restart = Restart::OnFault {
                        backoff: time(&restart.after)?,
                        limit: restart.times,
                        within: restart.within.as_deref().map_or(Ok(60_000_000_000), time)?,
                    };
                }
            }
            spec.schemas.push(schema);
        }
        for (name, table) in &self.groups {
            let members = table.members.iter().map(find).collect::<Result<_, _>>()?;
            let father = table.father.as_ref().map(find).transpose()?;
            let mut group = GroupSpec::new(name, father, members);
            if let Some(text) = &table.policy {
                group.policy = policy(text)?;
            }
            if let Some(text) = &table.absence {
                group.absence = absence(text, |name| find(&name.to_owned()))?;
            }
            if let Some(text) = &table.patience {
                group.patience = time(text)?;
            }
            if let Some(text) = &table.budget {
                group.budget = time(text)?;
            }
            if let Some(text) = &table.retry {
                group.retry = time(text)?;
            }
            spec.groups.push(group);
        }
        Ok(spec)
    }
}
