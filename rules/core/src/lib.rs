//! The rules of action selection (R1 to R17 of `docs/rules.md`), as a pure state machine.
//!
//! A [`Spec`] states the father of each schema, the schemas that it needs, and the policy of each group. A
//! [`Hierarchy`] is made from it. Callers report events (a check, the begin or the end of an iteration, a
//! fault, a timer) through its methods, which emit [`Effect`]s. Callers apply the effects in order, inside
//! the same transaction. The executors drive a hierarchy in real time or in virtual time (R16).
//!
//! The crate refuses to use a clock, a thread, a file or a random number. Everything that the rules do not
//! decide is an argument, so the same calls give the same effects to the bit. An unknown identifier never
//! causes a panic: such a call is refused or has no effect.
//!
//! ```
//! use jde_core::{Check, GroupSpec, Hierarchy, Kind, SchemaId, SchemaSpec, Spec};
//!
//! let ms = 1_000_000;
//! let (stop, goon) = (SchemaId(0), SchemaId(1));
//! let spec = Spec {
//!     schemas: vec![
//!         SchemaSpec::new("stop", Kind::Motor, 200 * ms),
//!         SchemaSpec::new("goon", Kind::Motor, 75 * ms),
//!     ],
//!     groups: vec![GroupSpec::new("roots", None, vec![stop, goon])],
//! };
//! let mut hierarchy = Hierarchy::new(spec).expect("a sound specification");
//! let mut effects = Vec::new();
//! hierarchy.start(0, &mut effects);
//! hierarchy.checked(1 * ms, goon, Check { ready: true, urgency: 0.0, cause: 0 }, &mut effects);
//! assert!(hierarchy.has_authority(goon));
//! assert!(hierarchy.begin(2 * ms, goon, &mut effects));
//!
//! // stop becomes ready while goon iterates: goon keeps its authority until its iteration has ended.
//! hierarchy.checked(3 * ms, stop, Check { ready: true, urgency: 0.0, cause: 2 * ms }, &mut effects);
//! assert!(hierarchy.has_authority(goon) && !hierarchy.has_authority(stop));
//! hierarchy.end(4 * ms, goon, &mut effects);
//! assert!(!hierarchy.has_authority(goon) && hierarchy.has_authority(stop));
//! ```

mod contract;
mod effect;
mod hierarchy;
mod policy;
mod record;
mod refused;
mod spec;
mod spec_error;
mod state;
mod validate;

pub use contract::{GroupContract, TakeoverBound, Term, contract};
pub use effect::{Effect, Level};
pub use hierarchy::{ArbitrationReply, Check, Handover, Hierarchy, Operator, Timer};
pub use policy::{NumberParameter, POLICIES, Policy, PolicyKind, TimeParameter};
pub use record::{Candidate, Case, Cause, Decider, Record};
pub use refused::Refused;
pub use spec::{
    Absence, DEFAULT_BUDGET, DEFAULT_PATIENCE, DEFAULT_RETRY, GroupId, GroupSpec, Kind, Nanos, Restart,
    SchemaId, SchemaSpec, Spec,
};
pub use spec_error::SpecError;
pub use state::{ActuationState, Health, Hold, HoldAction, Holder, Requester, State};
