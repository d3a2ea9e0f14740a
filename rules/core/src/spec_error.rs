//! The faults of a specification, with the remedy of each in its message.
//!
//! The one error type of the setup; a running hierarchy has its own.

use std::fmt;

/// One fault of a specification.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub enum SpecError {
    /// Two schemas, or two groups, have the same name.
    DuplicateName {
        /// `"schema"` or `"group"`.
        what: &'static str,
        /// The name.
        name: String,
    },
    /// A group or a schema names a schema that does not exist.
    UnknownSchema {
        /// The group or the schema that refers to it.
        by: String,
        /// The index that does not exist.
        index: u32,
    },
    /// A group has no members.
    EmptyGroup {
        /// The group.
        group: String,
    },
    /// A schema is listed as a member twice.
    TwoFathers {
        /// The schema.
        schema: String,
        /// The group that lists it first.
        first: String,
        /// The group that lists it again.
        second: String,
    },
    /// A motor schema is in no group, so it could never compete.
    NoGroup {
        /// The schema.
        schema: String,
    },
    /// A perceptive schema is a member of a group.
    PerceptiveMember {
        /// The schema.
        schema: String,
        /// The group.
        group: String,
    },
    /// A perceptive schema is the father of a group.
    PerceptiveFather {
        /// The schema.
        schema: String,
        /// The group.
        group: String,
    },
    /// A schema needs a motor schema, which a need cannot keep awake.
    MotorNeeded {
        /// The schema with the need.
        schema: String,
        /// The motor schema.
        needs: String,
    },
    /// A schema is its own father, directly or through others.
    FatherCycle {
        /// The names along the cycle.
        path: Vec<String>,
    },
    /// Perceptive schemas need each other in a cycle, so none of them could ever sleep.
    NeedCycle {
        /// The names along the cycle.
        path: Vec<String>,
    },
    /// The fallback of a group is not one of its members.
    FallbackNotMember {
        /// The group.
        group: String,
        /// The fallback.
        fallback: String,
    },
    /// A period of 0.
    ZeroPeriod {
        /// The schema.
        schema: String,
    },
    /// A parameter of a policy is a time of 0, or a number that is negative or not finite.
    BadParameter {
        /// The group.
        group: String,
        /// The parameter's key in application files.
        key: &'static str,
        /// What it must be.
        expected: &'static str,
    },
    /// The policy of a group of roots is the father's own function, but roots have no father.
    NoArbitrator {
        /// The group.
        group: String,
    },
}

impl fmt::Display for SpecError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::DuplicateName { what, name } => {
                write!(f, "two {what}s are called `{name}`: give each its own name")
            }
            Self::UnknownSchema { by, index } => {
                write!(
                    f,
                    "`{by}` names schema number {index}, which does not exist: name a listed one"
                )
            }
            Self::EmptyGroup { group } => {
                write!(
                    f,
                    "the group `{group}` has no members: list a motor schema or remove the group"
                )
            }
            Self::TwoFathers {
                schema,
                first,
                second,
            } => write!(
                f,
                "`{schema}` is a member of `{first}` and again of `{second}`: a schema has one place; use a second instance"
            ),
            Self::NoGroup { schema } => {
                write!(
                    f,
                    "the motor schema `{schema}` is in no group: make it a root or someone's child"
                )
            }
            Self::PerceptiveMember { schema, group } => {
                write!(
                    f,
                    "`{schema}` is perceptive but a member of `{group}`: list it among the needs instead"
                )
            }
            Self::PerceptiveFather { schema, group } => {
                write!(
                    f,
                    "`{schema}` is perceptive but the father of `{group}`: only a motor schema has children"
                )
            }
            Self::MotorNeeded { schema, needs } => write!(
                f,
                "`{schema}` needs the motor schema `{needs}`: needs are perceptive schemas and drivers"
            ),
            Self::FatherCycle { path } => {
                write!(
                    f,
                    "a schema is its own father: {}; break the circle",
                    path.join(" > ")
                )
            }
            Self::NeedCycle { path } => {
                write!(
                    f,
                    "perceptive schemas need each other: {}; break the circle",
                    path.join(" > ")
                )
            }
            Self::FallbackNotMember { group, fallback } => {
                write!(
                    f,
                    "the fallback `{fallback}` is not a member of `{group}`: name a member"
                )
            }
            Self::ZeroPeriod { schema } => {
                write!(f, "`{schema}` has a period of 0: give a time above 0")
            }
            Self::BadParameter { group, key, expected } => {
                write!(f, "`{key}` of `{group}` must be {expected}")
            }
            Self::NoArbitrator { group } => {
                write!(
                    f,
                    "the roots `{group}` have no father to decide: choose a ready-made policy"
                )
            }
        }
    }
}

impl std::error::Error for SpecError {}
