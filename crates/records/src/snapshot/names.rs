//! Serde names for enumerations of other crates.

use jde_abi::describe::Kind;
use jde_core::{Health, State};
use serde::{Deserialize, Serialize};

/// The names of [`Kind`].
#[derive(Serialize, Deserialize)]
#[serde(remote = "Kind", rename_all = "kebab-case")]
pub(super) enum KindName {
    Perceptive,
    Motor,
    Driver,
}

/// The names of [`State`].
#[derive(Serialize, Deserialize)]
#[serde(remote = "State", rename_all = "kebab-case")]
pub(super) enum StateName {
    Slept,
    Checking,
    Ready,
    Winner,
}

/// The names of [`Health`].
#[derive(Serialize, Deserialize)]
#[serde(remote = "Health", rename_all = "kebab-case")]
pub(super) enum HealthName {
    Ok,
    Overrun,
    ArbitrationFailed(String),
    Faulted(String),
}
