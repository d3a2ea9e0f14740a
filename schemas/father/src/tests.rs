//! It wakes every child that the application names, including none.

use jde_schema::State;
use jde_schema::bench::Bench;

use super::*;

#[test]
fn all_children_are_woken_whatever_their_number() {
    let names: Vec<String> = (0..20).map(|number| format!("robot-{number}")).collect();
    let children: Vec<_> = names.iter().map(|name| (name.as_str(), "all")).collect();
    for number in [0, 1, 20] {
        let mut all = Bench::<All>::new();
        all.name_children(&children[..number]);
        all.iterate().expect("the iteration succeeds");
        assert_eq!(all.awake_children(), names[..number]);
    }
}

#[test]
fn a_child_that_went_to_sleep_is_woken_again() {
    let mut all = Bench::<All>::new();
    all.name_children(&[("left", "left"), ("right", "right")]);
    all.iterate().expect("the iteration succeeds");
    all.set_child("right", State::Slept);
    assert_eq!(all.awake_children(), ["left"]);
    all.iterate().expect("the iteration succeeds");
    assert_eq!(all.awake_children(), ["left", "right"]);
}

#[test]
fn r7_without_authority_no_child_is_woken() {
    let mut all = Bench::<All>::new();
    all.name_children(&[("left", "left"), ("right", "right")]);
    all.set_authority(false);
    all.iterate().expect("a refusal is not a fault");
    assert!(all.awake_children().is_empty());
}
