//! Serde names for enumerations of other crates.

use jde_abi::describe::Kind;
use jde_core::{Health, State};
use serde::{Deserialize, Serialize};

/// [`Kind`] in words.
#[derive(Serialize, Deserialize)]
#[serde(remote = "Kind", rename_all = "kebab-case")]
pub(super) enum KindName {
    Perceptive,
    Motor,
    Driver,
}

/// [`State`] in words.
#[derive(Serialize, Deserialize)]
#[serde(remote = "State", rename_all = "kebab-case")]
pub(super) enum StateName {
    Slept,
    Checking,
    Ready,
    Winner,
}

/// [`Health`] in words.
#[derive(Serialize, Deserialize)]
#[serde(remote = "Health", rename_all = "kebab-case")]
pub(super) enum HealthName {
    Ok,
    Overrun,
    ArbitrationFailed(String),
    Faulted(String),
}
