//! The talker counts, and the listener logs each number once.

use jde_schema::Severity;
use jde_schema::bench::Bench;

use super::*;

fn ready(listener: &mut Bench<Listener>) -> bool {
    listener.check().expect("it checks").ready
}

fn heard(listener: &Bench<Listener>) -> Vec<&str> {
    listener.log().iter().map(|(_, words)| &**words).collect()
}

#[test]
fn the_talker_counts_from_1_and_goes_on_after_a_sleep() {
    let mut talker = Bench::<Talker>::new();
    assert_eq!(talker.exported::<u64>("count"), None);
    for count in 1..=3_u64 {
        talker.iterate().expect("it counts");
        assert_eq!(talker.exported("count"), Some(count));
    }
    talker.sleep().expect("it sleeps");
    talker.awake().expect("it wakes");
    talker.iterate().expect("it counts");
    assert_eq!(talker.exported("count"), Some(4_u64), "a sleep keeps its memory");
}

#[test]
fn the_listener_is_ready_for_a_number_it_has_not_said() {
    let mut listener = Bench::<Listener>::new();
    assert!(!ready(&mut listener), "nobody has said anything");
    listener.import("count", &7_u64);
    assert!(ready(&mut listener));
    listener.iterate().expect("it says it");
    assert!(!ready(&mut listener), "it has said that");
    listener.import("count", &8_u64);
    assert!(ready(&mut listener));
    listener.iterate().expect("it says it");
    assert_eq!(heard(&listener), ["heard 7", "heard 8"]);
    assert!(
        listener
            .log()
            .iter()
            .all(|(severity, _)| *severity == Severity::Info)
    );
}

#[test]
fn a_listener_that_must_speak_without_a_number_says_which_import_is_missing() {
    let mut listener = Bench::<Listener>::new();
    let reason = listener.iterate().expect_err("there is nothing to say").reason;
    assert_eq!(reason, "import `count` has no value");
}
