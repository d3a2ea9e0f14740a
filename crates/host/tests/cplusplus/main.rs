//! The tests of conformance that depend on the language of a schema, with the schemas in C++: its inputs and outputs, its
//! children and arbitration, its faults, hangs and judgements. The other tests are about the host alone.

#[path = "../common/mod.rs"]
mod common;
mod exceptions;

#[path = "../conformance/arbitration.rs"]
mod arbitration;
#[path = "../conformance/faults.rs"]
mod faults;
#[path = "../conformance/guards.rs"]
mod guards;
#[path = "../conformance/hangs.rs"]
mod hangs;
#[path = "../conformance/takeover/mod.rs"]
mod takeover;
#[path = "../conformance/values.rs"]
mod values;
