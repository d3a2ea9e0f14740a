//! The talker counts, and the listener logs each number once.

use jde_schema::Severity;
use jde_schema::bench::Bench;

use super::*;

fn ready(listener: &mut Bench<Listener>) -> bool {
    listener.check().expect("no fault").ready
}

fn messages(listener: &Bench<Listener>) -> Vec<&str> {
    listener.log().iter().map(|(_, text)| &**text).collect()
}

#[test]
fn the_talker_counts_from_1_and_continues_after_a_sleep() {
    let mut talker = Bench::<Talker>::new();
    assert_eq!(talker.exported::<u64>("count"), None);
    for count in 1..=3_u64 {
        talker.iterate().expect("no fault");
        assert_eq!(talker.exported("count"), Some(count));
    }
    talker.sleep().expect("no fault");
    talker.awake().expect("no fault");
    talker.iterate().expect("no fault");
    assert_eq!(talker.exported("count"), Some(4_u64), "a sleep keeps its memory");
}

#[test]
fn the_listener_is_ready_for_a_number_that_it_has_not_logged() {
    let mut listener = Bench::<Listener>::new();
    assert!(!ready(&mut listener), "there is no number");
    listener.import("count", &7_u64);
    assert!(ready(&mut listener));
    listener.iterate().expect("no fault");
    assert!(!ready(&mut listener), "the number is logged");
    listener.import("count", &8_u64);
    assert!(ready(&mut listener));
    listener.iterate().expect("no fault");
    assert_eq!(messages(&listener), ["heard 7", "heard 8"]);
    assert!(
        listener
            .log()
            .iter()
            .all(|(severity, _)| *severity == Severity::Info)
    );
}

#[test]
fn a_listener_without_a_number_fails_and_names_the_import() {
    let mut listener = Bench::<Listener>::new();
    let reason = listener.iterate().expect_err("the import has no value").reason;
    assert_eq!(reason, "import `count` has no value");
}
