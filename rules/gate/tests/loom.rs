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

// SAFETY: the gate excludes concurrent access, which loom checks.
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
    let split = |used: &mut Arc<Uses>| Ok::<_, ()>(((), used.count()));
    let given_up = gate.give_up(since, split, |_| ()).unwrap().is_some();
    if given_up {
        uses.count();
    }
    given_up
}

/// Runs the call on another thread and gives it up on this one. Exactly one of the two must succeed.
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
fn a_call_that_returns_without_the_lock_ends_once() {
    race(|gate| gate.try_finish() || gate.finish(|_| unreachable!("the call was given up")));
}

#[test]
fn a_call_that_cleans_up_ends_once() {
    race(|gate| {
        let mut cleaned_up = false;
        let returned = gate.finish(|used| {
            used.count();
            cleaned_up = true;
        });
        assert_eq!(returned, cleaned_up);
        returned
    });
}

#[test]
fn a_call_that_was_given_up_uses_no_data() {
    race(|gate| {
        let first = gate.with(|used| used.count()).is_some();
        let second = gate.with(|used| used.count()).is_some();
        assert!(first || !second, "a refused call got access again");
        let returned = gate.try_finish() || gate.finish(|_| ());
        assert!(second || !returned, "a refused call returned normally");
        returned
    });
}

#[test]
fn a_later_call_is_not_given_up_in_place_of_an_earlier_one() {
    loom::model(|| {
        let (gate, uses) = entered();
        let other = {
            let gate = gate.clone();
            thread::spawn(move || {
                let first = gate.try_finish() || gate.finish(|_| ());
                assert_eq!(
                    gate.enter(9),
                    first,
                    "only a call that returned can be followed by another"
                );
                first && (gate.try_finish() || gate.finish(|_| ()))
            })
        };
        let given_up = give_up(&gate, 7, &uses);
        assert_ne!(other.join().unwrap(), given_up);
    });
}

#[test]
fn a_call_returns_normally_if_its_data_cannot_be_split() {
    loom::model(|| {
        let (gate, _) = entered();
        let other = {
            let gate = gate.clone();
            thread::spawn(move || gate.try_finish() || gate.finish(|used| assert!(used.count() > 0)))
        };
        let split = |used: &mut Arc<Uses>| {
            used.count();
            Err::<((), u32), _>(())
        };
        let refused = gate.give_up(7, split, |_| ());
        assert!(matches!(refused, Ok(None) | Err(())));
        assert!(other.join().unwrap(), "the call was not given up");
    });
}
