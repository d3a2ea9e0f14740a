//! Watches end while other threads publish, from any thread, and are not called after that (R12).

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Barrier, mpsc};
use std::thread;

use parking_lot::Mutex;

use crate::common::{float64, variable};
use jde_board::{Access, Variable, Watch};
use jde_watchdog::Watchdog;

fn modulation() -> Arc<Variable> {
    variable(&float64(), Access::Modulation)
}

fn put(variable: &Variable) {
    variable.put(1, &1f64.to_ne_bytes(), 0, 0).expect("a value");
}

#[test]
fn r12_a_dropped_watch_is_never_called_again() {
    let variable = modulation();
    let done = AtomicBool::new(false);
    thread::scope(|threads| {
        let writers = [(); 2].map(|()| {
            threads.spawn(|| {
                while !done.load(Ordering::Relaxed) {
                    put(&variable);
                }
            })
        });
        for _ in 0..2_000 {
            let (dropped, calls) = (Arc::new(AtomicBool::new(false)), Arc::new(AtomicUsize::new(0)));
            let (is_dropped, counted) = (Arc::clone(&dropped), Arc::clone(&calls));
            let watch = variable.watch(move || {
                assert!(!is_dropped.load(Ordering::SeqCst), "called after its end");
                counted.fetch_add(1, Ordering::SeqCst);
            });
            while calls.load(Ordering::SeqCst) == 0 {
                thread::yield_now();
            }
            drop(watch);
            dropped.store(true, Ordering::SeqCst);
        }
        done.store(true, Ordering::Relaxed);
        for writer in writers {
            writer.join().expect("no call came after the end of its watch");
        }
    });
}

#[test]
fn r12_dropping_a_watch_waits_for_its_call_on_another_thread() {
    let _watchdog = Watchdog::for_test();
    let variable = modulation();
    let (inside, returned) = (Arc::new(Barrier::new(2)), Arc::new(AtomicBool::new(false)));
    let (proceed, wait) = mpsc::channel::<()>();
    let (entered, return_flag, wait) = (Arc::clone(&inside), Arc::clone(&returned), Mutex::new(wait));
    let watch = variable.watch(move || {
        entered.wait();
        wait.lock().recv().expect("the signal to continue");
        return_flag.store(true, Ordering::SeqCst);
    });
    thread::scope(|threads| {
        threads.spawn(|| put(&variable));
        inside.wait();
        let dropper = threads.spawn(|| {
            drop(watch);
            assert!(returned.load(Ordering::SeqCst), "the call was still running");
        });
        proceed.send(()).expect("the call waits");
        dropper.join().expect("the drop waited");
    });
}

#[test]
fn r12_a_watch_may_end_itself_inside_its_call() {
    let variable = modulation();
    let (slot, calls): (Arc<Mutex<Option<Watch>>>, Arc<AtomicUsize>) = Default::default();
    let (own, counted) = (Arc::clone(&slot), Arc::clone(&calls));
    let watch = variable.watch(move || {
        counted.fetch_add(1, Ordering::SeqCst);
        let watch = own.lock().take();
        drop(watch);
    });
    *slot.lock() = Some(watch);
    put(&variable);
    put(&variable);
    assert_eq!(calls.load(Ordering::SeqCst), 1);
}

#[test]
fn r12_ending_one_watch_does_not_affect_the_others() {
    let variable = modulation();
    let calls: [Arc<AtomicUsize>; 3] = Default::default();
    let [first, second, third] = calls.each_ref().map(|calls| {
        let calls = Arc::clone(calls);
        variable.watch(move || {
            calls.fetch_add(1, Ordering::SeqCst);
        })
    });
    put(&variable);
    drop(second);
    put(&variable);
    drop((first, third));
    put(&variable);
    assert_eq!(calls.map(|calls| calls.load(Ordering::SeqCst)), [2, 1, 2]);
}
