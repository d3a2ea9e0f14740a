//! The rules of action selection (R1 to R17 of `docs/rules.md`), as a pure state machine.
//!
//! A [`Spec`] states the father of each schema, the schemas that it needs, and the policy of each group. A
//! [`Hierarchy`] is made from it. Callers report events (a check, the begin or the end of an iteration, a
//! fault, a timer) by a [`Transaction`], which emits [`Effect`]s. Callers apply them in order, before the next
//! transaction. The executors drive a hierarchy in real time or in virtual time (R16).
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
//!     ]
//!     .into(),
//!     groups: vec![GroupSpec::new("roots", None, vec![stop, goon])].into(),
//! };
//! let mut hierarchy = Hierarchy::new(spec).expect("a sound specification");
//! let mut effects = Vec::new();
//! hierarchy.at(0, &mut effects).start();
//! hierarchy.at(1 * ms, &mut effects).checked(goon, Check { ready: true, urgency: 0.0, cause: 0 });
//! assert!(hierarchy.has_authority(goon));
//! assert!(hierarchy.at(2 * ms, &mut effects).begin(goon));
//!
//! // stop becomes ready while goon iterates: goon keeps its authority until its iteration has ended.
//! hierarchy.at(3 * ms, &mut effects).checked(stop, Check { ready: true, urgency: 0.0, cause: 2 * ms });
//! assert!(hierarchy.has_authority(goon) && !hierarchy.has_authority(stop));
//! hierarchy.at(4 * ms, &mut effects).end(goon);
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
mod table;
mod validate;

pub use contract::{GroupContract, TakeoverBound, Term, contract};
pub use effect::{Effect, Level};
pub use hierarchy::{ArbitrationReply, Check, Handover, Hierarchy, Operator, Timer, Transaction};
pub use policy::{NumberParameter, POLICIES, Policy, PolicyKind, TimeParameter};
pub use record::{Candidate, Case, Cause, Decider, Record};
pub use refused::Refused;
pub use spec::{
    Absence, DEFAULT_BUDGET, DEFAULT_PATIENCE, DEFAULT_RETRY, GroupId, GroupSpec, Kind, Nanos, Restart,
    SchemaId, SchemaSpec, Spec,
};
pub use spec_error::SpecError;
pub use state::{ActuationState, Health, Hold, HoldAction, Holder, Requester, State};
pub use table::{Id, Table};
