//! How values end (R19): by their validity, by a retraction, and while their writer sleeps.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use jde_board::{Access, LASTING, Variable, Watch};

use crate::common::{EXPORT, float64, variable, word_array};

/// Values in a ring and in pinned slots, valid for 100 ns.
fn expiring() -> [Arc<Variable>; 2] {
    [float64(), word_array(40)].map(|value_type| variable(&value_type, Access::Export { validity: 100 }))
}

fn publish(variable: &Arc<Variable>, at: u64) {
    let mut writer = variable.writer(1, "eye").unwrap();
    writer.loan();
    // Measured long ago: the validity counts from the publication.
    writer.publish(0, at).unwrap();
}

/// Counts the ends of values.
fn ends(variable: &Arc<Variable>) -> (Arc<AtomicU64>, Watch) {
    let count = Arc::new(AtomicU64::new(0));
    let counted = Arc::clone(&count);
    let watch = variable.watch_end(move || {
        counted.fetch_add(1, Ordering::SeqCst);
    });
    (count, watch)
}

#[test]
fn r19_a_value_ends_with_its_validity_for_every_reader() {
    for eye in expiring() {
        publish(&eye, 1_000);
        let mut reader = eye.reader("stop");
        let mut late = eye.reader("late");
        assert_eq!(reader.latch(1_100).unwrap().stamp.valid_until, 1_100);
        assert!(late.latch(1_101).is_none());
        assert!(eye.has_value(1_100) && !eye.has_value(1_101));
        assert!(!eye.status(1_100).ended && eye.status(1_101).ended);
        assert!(
            reader.latch(1_101).is_some(),
            "a reader keeps the value that it holds (R8)"
        );
        assert!(reader.latch_newest(1_101).is_none());
        publish(&eye, 2_000);
        assert!(reader.latch_newest(2_000).is_some());
    }
}

#[test]
fn r7_a_command_that_is_over_is_no_value_to_readers_of_what_is_in_force() {
    for value_type in [float64(), word_array(40)] {
        let velocity = variable(&value_type, Access::Command { validity: 100 });
        let initial = velocity
            .reader("watch")
            .of_what_is_in_force()
            .latch(9_999)
            .is_some();
        assert_eq!(
            velocity.has_value(9_999),
            initial,
            "an initial value has no validity"
        );
        velocity.put(1, &vec![0; value_type.bytes], 1_000, 1_100).unwrap();
        let watching = velocity.reader("watch").of_what_is_in_force();
        let (mut driver, mut copy) = (velocity.reader("driver"), watching.duplicate());
        for mut reader in [watching, velocity.reader("late").of_what_is_in_force()] {
            assert!(reader.latch(1_100).is_some() && reader.latch_newest(1_101).is_none());
        }
        assert!(copy.latch(1_101).is_none() && driver.latch(1_101).is_some());
        assert!(velocity.has_value(1_100) && !velocity.has_value(1_101));
        assert!(!velocity.has_ended(1_100) && velocity.has_ended(1_101));
    }
}

#[test]
fn r19_lasting_values_and_modulations_do_not_expire() {
    for access in [EXPORT, Access::Modulation] {
        let map = variable(&float64(), access);
        publish(&map, 1);
        assert!(map.reader("plan").latch(u64::MAX).is_some());
        assert_eq!(map.expire(u64::MAX), None);
        assert!(!map.close(), "a lasting value outlives the sleep of its writer");
        assert!(map.reader("plan").latch(u64::MAX).is_some());
    }
}

#[test]
fn r19_the_end_of_a_validity_is_reported_once() {
    for eye in expiring() {
        let (count, _watch) = ends(&eye);
        assert_eq!(eye.expire(1_000), None, "there is no value");
        publish(&eye, 1_000);
        assert_eq!(eye.expire(1_000), Some(1_100));
        assert_eq!(count.load(Ordering::SeqCst), 0, "a publication is no end");
        assert_eq!(eye.expire(1_101), None);
        assert_eq!(eye.expire(1_102), None);
        assert_eq!(count.load(Ordering::SeqCst), 1);
        publish(&eye, 1_200);
        eye.retract();
        assert_eq!(eye.expire(9_000), None, "it has ended already");
        assert_eq!(count.load(Ordering::SeqCst), 2);
    }
}

#[test]
fn r19_while_its_writer_sleeps_a_variable_has_no_value() {
    for eye in expiring() {
        publish(&eye, 1_000);
        assert!(eye.close());
        assert!(!eye.close(), "it has ended already");
        let mut reader = eye.reader("stop");
        assert!(reader.latch_newest(1_001).is_none());
        publish(&eye, 1_010);
        assert!(
            reader.latch_newest(1_011).is_none(),
            "the end of a call that began before the sleep"
        );
        eye.retract();
        assert!(!eye.has_value(1_011), "a retraction does not open it");
        eye.open();
        assert!(reader.latch_newest(1_012).is_none(), "that value is from before");
        publish(&eye, 1_020);
        assert!(reader.latch_newest(1_021).is_some());
        eye.open();
        assert!(reader.latch_newest(1_022).is_some(), "it was open");
    }
}

#[test]
fn r19_an_end_is_also_a_change() {
    for eye in expiring() {
        let count = Arc::new(AtomicU64::new(0));
        let counted = Arc::clone(&count);
        let _watch = eye.watch(move || {
            counted.fetch_add(1, Ordering::SeqCst);
        });
        publish(&eye, 1);
        assert!(eye.close());
        eye.report_end();
        assert_eq!(count.load(Ordering::SeqCst), 2);
    }
}

#[test]
fn r19_the_longest_validity_does_not_overflow() {
    let eye = variable(
        &float64(),
        Access::Export {
            validity: LASTING - 1,
        },
    );
    publish(&eye, 1_000);
    assert!(eye.reader("stop").latch(u64::MAX).is_some());
}
