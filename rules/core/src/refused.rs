//! The reasons for which a request of a father or an operator is refused.
//!
//! The one error type of the running hierarchy; a specification has its own.

use std::fmt;

use crate::state::Hold;

/// Why a request to wake, sleep, play, stop, force or release was refused.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub enum Refused {
    /// The application has not started or is shut down.
    NotRunning,
    /// No schema has this identifier.
    Unknown {
        /// Its index.
        index: u32,
    },
    /// A father may wake its own motor children and any perceptive schema, and no other.
    NotChild {
        /// The schema that made the request.
        father: String,
        /// The schema that the request named.
        child: String,
    },
    /// Only a WINNER whose fathers are all WINNER may wake or put to sleep (R7).
    NoAuthority {
        /// The schema that made the request.
        father: String,
        /// The first schema upwards that is not WINNER.
        because: String,
    },
    /// A handover replaces the schema or one of its fathers, so everything below is going to sleep (R5).
    BeingReplaced {
        /// The father that made the request, or the schema that an operator plays.
        schema: String,
    },
    /// An operator stopped the schema. The father's request takes effect when the schema is released (R14).
    Stopped {
        /// The stopped schema.
        schema: String,
    },
    /// Somebody else stopped the schema, and what is done under a lease ends no stop of others (R14).
    HeldStopped {
        /// The stopped schema.
        schema: String,
        /// The stop.
        stop: Hold,
    },
    /// An operator unloaded the schema, so it cannot be played.
    Unloaded {
        /// The unloaded schema.
        schema: String,
    },
    /// The schema is faulted; only a schema that is awake can be forced.
    Faulted {
        /// The faulted schema.
        schema: String,
        /// Its fault.
        reason: String,
    },
    /// Only a motor schema competes, so only a motor schema can be forced.
    NotMotor {
        /// The schema, which is perceptive or a driver.
        schema: String,
    },
}

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotRunning => {
                write!(
                    f,
                    "the application is not running: it has not started, or it is shut down"
                )
            }
            Self::Unknown { index } => {
                write!(
                    f,
                    "there is no schema number {index}: use an identifier of this application"
                )
            }
            Self::NotChild { father, child } => write!(
                f,
                "`{child}` is not a child of `{father}`: a father wakes its own motor children and perceptive schemas"
            ),
            Self::NoAuthority { father, because } => write!(
                f,
                "`{father}` has no authority: `{because}` is not WINNER; wake and sleep children only while winning"
            ),
            Self::BeingReplaced { schema } => write!(
                f,
                "`{schema}` is losing its place, and what is below goes to sleep: try again when it wins"
            ),
            Self::Stopped { schema } => {
                write!(
                    f,
                    "`{schema}` was stopped by an operator: release it to let it wake"
                )
            }
            Self::HeldStopped { schema, stop: _ } => write!(
                f,
                "`{schema}` is stopped by another operator, and an action with a lease does not end that: release it first"
            ),
            Self::Unloaded { schema } => write!(f, "`{schema}` is unloaded; load it first"),
            Self::Faulted { schema, reason } => {
                write!(
                    f,
                    "`{schema}` is faulted ({reason}): it wakes by its restart policy, or when it is played, loaded or reloaded"
                )
            }
            Self::NotMotor { schema } => {
                write!(
                    f,
                    "`{schema}` competes with nobody: only a motor schema can be forced; play or stop it instead"
                )
            }
        }
    }
}

impl std::error::Error for Refused {}
