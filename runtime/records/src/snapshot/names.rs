//! Serde names for enumerations of other crates.

use jde_abi::describe::Kind;
use jde_core::{Case, Health, State};
use serde::{Deserialize, Serialize};

/// The names of [`Kind`].
#[derive(Serialize, Deserialize)]
#[serde(remote = "Kind", rename_all = "kebab-case")]
pub(crate) enum KindName {
    Perceptive,
    Motor,
    Driver,
}

/// The names of [`State`].
#[derive(Serialize, Deserialize)]
#[serde(remote = "State", rename_all = "kebab-case")]
pub(crate) enum StateName {
    Slept,
    Checking,
    Ready,
    Winner,
}

/// The names of [`Health`].
#[derive(Serialize, Deserialize)]
#[serde(remote = "Health", rename_all = "kebab-case")]
pub(crate) enum HealthName {
    Ok,
    Overrun,
    ArbitrationFailed(String),
    Faulted(String),
}

/// The names of [`Case`].
#[derive(Serialize, Deserialize)]
#[serde(remote = "Case", rename_all = "kebab-case")]
pub(crate) enum CaseName {
    Alone,
    Collision,
    Absence,
    Forced,
}
