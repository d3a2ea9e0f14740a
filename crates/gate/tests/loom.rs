//! The gate under loom, which tries every interleaving of two threads and the stale values that the memory
//! model allows. Run by `RUSTFLAGS="--cfg loom" cargo test -p jde-gate --release --test loom`; empty
//! otherwise.
#![cfg(loom)]
#![allow(unsafe_code, reason = "loom's cells are written raw, and checked")]

use jde_gate::Gate;
use loom::cell::UnsafeCell;
use loom::sync::Arc;
use loom::thread;

/// Counts the uses. Loom fails a run in which two threads access it at once, or without an order between
/// them.
struct Uses(UnsafeCell<u32>);

// SAFETY: the gate keeps threads apart, which is what loom checks.
unsafe impl Sync for Uses {}

impl Uses {
    fn count(&self) -> u32 {
        self.0.with_mut(|count| {
            // SAFETY: loom checks it.
            unsafe {
                *count += 1;
                *count
            }
        })
    }
}

/// The data of the gate, and what remains of it.
type Shared = Arc<Gate<Arc<Uses>, u32>>;

/// Returns a gate, entered at 7, and a second handle to its data, for the thread that gives up the call.
fn entered() -> (Shared, Arc<Uses>) {
    let uses = Arc::new(Uses(UnsafeCell::new(0)));
    let gate = Arc::new(Gate::new(uses.clone()));
    assert!(gate.enter(7));
    (gate, uses)
}

/// Returns whether the call was given up. From then on the calling thread has exclusive access to the data.
fn give_up(gate: &Shared, since: u64, uses: &Uses) -> bool {
    let part = |used: &mut Arc<Uses>| Ok::<_, ()>(((), used.count()));
    let given_up = gate.give_up(since, part, |_| ()).unwrap().is_some();
    if given_up {
        uses.count();
    }
    given_up
}

/// Runs the call on a thread of its own and gives it up on this one. Exactly one of the two must succeed.
fn race(call: fn(&Shared) -> bool) {
    loom::model(move || {
        let (gate, uses) = entered();
        let other = {
            let gate = gate.clone();
            thread::spawn(move || call(&gate))
        };
        let given_up = give_up(&gate, 7, &uses);
        let returned = other.join().unwrap();
        assert_eq!(given_up, gate.is_closed());
        // A held lock is no reason to wait: then the call was not given up and has returned.
        assert_ne!(returned, given_up, "a call ends once");
    });
}

#[test]
fn a_call_ends_once_though_it_returns_without_the_lock() {
    race(|gate| gate.try_finish() || gate.finish(|_| unreachable!("it was given up")));
}

#[test]
fn a_call_ends_once_and_puts_in_order_what_is_still_its_own() {
    race(|gate| {
        let mut tidied = false;
        let left = gate.finish(|used| {
            used.count();
            tidied = true;
        });
        assert_eq!(left, tidied);
        left
    });
}

#[test]
fn nobody_uses_what_was_taken_away() {
    race(|gate| {
        let first = gate.with(|used| used.count()).is_some();
        let second = gate.with(|used| used.count()).is_some();
        assert!(first || !second, "what was taken away does not come back");
        let left = gate.try_finish() || gate.finish(|_| ());
        assert!(second || !left, "who was refused does not return");
        left
    });
}

#[test]
fn the_next_call_is_not_given_up_for_the_one_before() {
    loom::model(|| {
        let (gate, uses) = entered();
        let other = {
            let gate = gate.clone();
            thread::spawn(move || {
                let first = gate.try_finish() || gate.finish(|_| ());
                assert_eq!(gate.enter(9), first, "only who returned enters again");
                first && (gate.try_finish() || gate.finish(|_| ()))
            })
        };
        let given_up = give_up(&gate, 7, &uses);
        assert_ne!(other.join().unwrap(), given_up);
    });
}

#[test]
fn who_cannot_be_parted_from_what_it_has_returns_as_ever() {
    loom::model(|| {
        let (gate, _) = entered();
        let other = {
            let gate = gate.clone();
            thread::spawn(move || gate.try_finish() || gate.finish(|used| assert!(used.count() > 0)))
        };
        let part = |used: &mut Arc<Uses>| {
            used.count();
            Err::<((), u32), _>(())
        };
        let refused = gate.give_up(7, part, |_| ());
        assert!(matches!(refused, Ok(None) | Err(())));
        assert!(other.join().unwrap(), "nobody gave it up");
    });
}
