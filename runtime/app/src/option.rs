//! Values given outside the file, for one run. Checks no value.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

use jde_document::quote;

/// A value given outside the file, for one run: `--set schema.variable=value`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Override {
    /// The instance.
    pub schema: String,
    /// One of its modulations, `period` or `type`.
    pub variable: String,
    /// TOML, or a text without its quotes.
    pub value: String,
    /// The folder of relative paths.
    pub folder: PathBuf,
    /// Where a file states it, for messages; `None` for an option.
    pub place: Option<String>,
}

impl FromStr for Override {
    type Err = String;

    /// Parses `schema.variable=value`. Relative paths start in the working directory.
    fn from_str(text: &str) -> Result<Self, String> {
        let parts = text
            .split_once('=')
            .and_then(|(name, value)| Some((name.trim().split_once('.')?, value)));
        match parts {
            Some(((schema, variable), value)) if !schema.is_empty() && !variable.is_empty() => Ok(Self {
                schema: schema.to_owned(),
                variable: variable.to_owned(),
                value: value.trim().to_owned(),
                folder: std::env::current_dir().unwrap_or_default(),
                place: None,
            }),
            Some(_) | None => Err(format!(
                "{} is not an option: write schema.variable=value, such as goon.fast=\"0.3 m/s\"",
                quote(text)
            )),
        }
    }
}

impl fmt::Display for Override {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            schema,
            variable,
            value,
            ..
        } = self;
        match &self.place {
            Some(place) => write!(f, "{place}: {schema}.{variable}={value}"),
            None => write!(f, "--set {schema}.{variable}={value}"),
        }
    }
}
