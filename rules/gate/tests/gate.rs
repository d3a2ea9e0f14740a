//! Tests of the gate on one thread. `loom.rs` tests it with several threads.
#![cfg(not(loom))]

use jde_gate::Gate;

type Numbers = Gate<Vec<u32>, usize>;

fn open() -> Numbers {
    let gate = Gate::new(vec![1, 2]);
    assert!(gate.enter(7));
    gate
}

/// Gives up the call. The successor gets an empty list, and the call keeps the number of elements.
fn give_up(gate: &Numbers, since: u64) -> Option<Vec<u32>> {
    gate.give_up(since, |used| Ok::<_, ()>((Vec::new(), used.len())), |_| ())
        .unwrap()
}

#[test]
fn a_call_that_returned_is_not_given_up() {
    for at_once in [true, false] {
        let gate = open();
        let returned = if at_once {
            gate.try_finish()
        } else {
            gate.finish(|used| used.push(3))
        };
        assert!(returned);
        assert_eq!(give_up(&gate, 7), None);
        assert!(!gate.is_closed());
    }
}

#[test]
fn a_later_call_is_not_given_up_in_place_of_an_earlier_one() {
    let gate = open();
    assert!(gate.try_finish());
    assert!(gate.enter(9));
    assert_eq!(give_up(&gate, 7), None, "another call runs now");
    assert_eq!(gate.with(|used| used.len()), Some(2));
    assert_eq!(give_up(&gate, 9), Some(Vec::new()));
}

#[test]
fn a_call_that_was_given_up_cannot_use_the_data_return_or_begin_again() {
    let gate = open();
    assert_eq!(give_up(&gate, 7), Some(Vec::new()));
    assert!(gate.is_closed());
    assert_eq!(gate.with(|_| ()), None);
    assert!(!gate.try_finish());
    assert!(!gate.finish(|_| panic!("the call was given up")));
    assert!(!gate.enter(9));
    assert_eq!(give_up(&gate, 7), None, "a call is given up once");
}

#[test]
fn a_call_continues_if_its_data_cannot_be_split() {
    let gate = open();
    let refused = gate.give_up(7, |_| Err::<((), usize), _>("no room"), |_| unreachable!());
    assert_eq!(refused, Err("no room"));
    assert_eq!(gate.with(|used| used.len()), Some(2));
    assert!(gate.try_finish());
}

#[test]
fn giving_up_does_not_wait_for_a_use_in_progress() {
    let gate = open();
    gate.with(|_| assert_eq!(give_up(&gate, 7), None));
    assert_eq!(give_up(&gate, 7), Some(Vec::new()));
}

#[test]
fn the_notification_finds_the_call_given_up() {
    let gate = open();
    let mut notifications = 0;
    let notify = |remaining: &usize| {
        notifications += 1;
        assert_eq!(*remaining, 2);
        assert!(gate.is_closed());
    };
    gate.give_up(7, |used| Ok::<_, ()>(((), used.len())), notify)
        .unwrap()
        .unwrap();
    assert_eq!(notifications, 1);
}
