//! The gate on one thread: the meaning of each of its results. Threads are in `loom.rs`.
#![cfg(not(loom))]

use jde_gate::Gate;

type Numbers = Gate<Vec<u32>, usize>;

fn open() -> Numbers {
    let gate = Gate::new(vec![1, 2]);
    assert!(gate.enter(7));
    gate
}

/// Gives up the call: an empty list for the successor, the number of elements for the call.
fn give_up(gate: &Numbers, since: u64) -> Option<Vec<u32>> {
    gate.give_up(since, |used| Ok::<_, ()>((Vec::new(), used.len())), |_| ())
        .unwrap()
}

#[test]
fn a_call_that_returned_is_not_given_up() {
    for at_once in [true, false] {
        let gate = open();
        let left = if at_once {
            gate.try_finish()
        } else {
            gate.finish(|used| used.push(3))
        };
        assert!(left);
        assert_eq!(give_up(&gate, 7), None);
        assert!(!gate.is_closed());
    }
}

#[test]
fn only_the_call_that_was_meant_is_given_up() {
    let gate = open();
    assert!(gate.try_finish());
    assert!(gate.enter(9));
    assert_eq!(give_up(&gate, 7), None, "another call runs since");
    assert_eq!(gate.with(|used| used.len()), Some(2));
    assert_eq!(give_up(&gate, 9), Some(Vec::new()));
}

#[test]
fn who_was_given_up_neither_uses_anything_nor_returns_nor_enters() {
    let gate = open();
    assert_eq!(give_up(&gate, 7), Some(Vec::new()));
    assert!(gate.is_closed());
    assert_eq!(gate.with(|_| ()), None);
    assert!(!gate.try_finish());
    assert!(!gate.finish(|_| panic!("there is nothing to put in order")));
    assert!(!gate.enter(9));
    assert_eq!(give_up(&gate, 7), None, "it is given up once");
}

#[test]
fn who_cannot_be_parted_from_what_it_has_goes_on() {
    let gate = open();
    let refused = gate.give_up(7, |_| Err::<((), usize), _>("no room"), |_| unreachable!());
    assert_eq!(refused, Err("no room"));
    assert_eq!(gate.with(|used| used.len()), Some(2));
    assert!(gate.try_finish());
}

#[test]
fn what_is_being_used_is_not_waited_for() {
    let gate = open();
    gate.with(|_| assert_eq!(give_up(&gate, 7), None));
    assert_eq!(give_up(&gate, 7), Some(Vec::new()));
}

#[test]
fn whoever_is_told_finds_the_call_given_up() {
    let gate = open();
    let mut times = 0;
    let told = |kept: &usize| {
        times += 1;
        assert_eq!(*kept, 2);
        assert!(gate.is_closed());
    };
    gate.give_up(7, |used| Ok::<_, ()>(((), used.len())), told)
        .unwrap()
        .unwrap();
    assert_eq!(times, 1);
}
