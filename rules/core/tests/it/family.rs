//! A father with three children, for tests that make each call themselves.

use jde_core::{
    Check, Effect, GroupId, GroupSpec, Hierarchy, Holder, Kind, Policy, Restart, SchemaId, SchemaSpec, Spec,
};

pub(crate) const FATHER: SchemaId = SchemaId(0);
pub(crate) const A: SchemaId = SchemaId(1);
pub(crate) const B: SchemaId = SchemaId(2);
pub(crate) const C: SchemaId = SchemaId(3);
pub(crate) const CHILDREN: GroupId = GroupId(1);
pub(crate) const ANA: Holder = Holder::lasting(1);
pub(crate) const READY: Check = Check {
    ready: true,
    urgency: 0.0,
    cause: 0,
};

/// Returns a father that wins and has woken the first two of its three children, which compete by `policy`.
pub(crate) fn family(policy: Policy) -> Hierarchy {
    let restart = Restart::OnFault {
        backoff: 10,
        limit: u32::MAX,
        within: u64::MAX,
    };
    let schema = |name| SchemaSpec {
        restart,
        ..SchemaSpec::new(name, Kind::Motor, 10)
    };
    let children = GroupSpec {
        policy,
        ..GroupSpec::new("children", Some(FATHER), vec![A, B, C])
    };
    let spec = Spec {
        schemas: ["father", "a", "b", "c"].map(schema).to_vec().into(),
        groups: vec![GroupSpec::new("roots", None, vec![FATHER]), children].into(),
    };
    let mut h = Hierarchy::new(spec).expect("a valid specification");
    effects(|out| {
        h.at(0, out).start();
        h.at(0, out).checked(FATHER, READY);
        h.at(0, out).wake(FATHER, A).expect("authority");
        h.at(0, out).wake(FATHER, B).expect("authority");
    });
    h
}

pub(crate) fn effects(call: impl FnOnce(&mut Vec<Effect>)) -> Vec<Effect> {
    let mut out = Vec::new();
    call(&mut out);
    out
}
