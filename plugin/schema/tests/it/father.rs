//! Fathers wake, put to sleep, modulate and observe children, set policies, and arbitrate.

#![forbid(unsafe_code)]

use jde_schema::bench::Bench;
use jde_schema::prelude::*;

/// A father of two motor children and one perceptive child.
#[derive(Describe)]
#[schema(motor, period = "100ms")]
struct Father {
    #[child(group = "base")]
    brake: Child,
    #[child(group = "base")]
    cruise: Child,
    #[child(perceptive, optional)]
    map: Child,
    #[modulates(child = "cruise", name = "target")]
    target: Modulates<Pose2D>,
    #[modulates(child = "brake", name = "target")]
    brake_target: Modulates<Pose2D>,
    seen: Vec<(State, bool)>,
    outcomes: Vec<Outcome>,
    has_run: bool,
}

impl Schema for Father {
    fn iterate(&mut self, cx: &Context) -> Result {
        self.seen = [&self.brake, &self.cruise, &self.map]
            .into_iter()
            .filter_map(|child| child.status(cx))
            .map(|status| (status.state, status.faulted))
            .collect();
        if std::mem::replace(&mut self.has_run, true) {
            self.outcomes.push(self.cruise.sleep(cx));
            self.brake_target.set(cx, Pose2D::ORIGIN);
            return Ok(());
        }
        for child in [&self.brake, &self.cruise, &self.map] {
            self.outcomes.push(child.wake(cx));
        }
        let dwell = Duration::from_millis(300);
        self.outcomes
            .push(self.brake.set_policy(cx, Policy::sticky(dwell, 0.25)));
        self.outcomes
            .push(self.target.set(cx, Pose2D::new(1.0, 2.0, 0.5)));
        Ok(())
    }
}

impl Arbitrate for Father {
    fn arbitrate(&mut self, _: &Context, level: &Level) -> Result<Verdict> {
        let winner = level.winner().is_some_and(|winner| winner.is(&self.cruise));
        Ok(match level.case() {
            Case::Collision => Verdict::choose(&self.brake, format!("cruise won: {winner}")),
            Case::Absence => Verdict::nobody("ñ".repeat(100)),
        })
    }
}

#[test]
fn a_father_wakes_modulates_and_puts_to_sleep() {
    let mut bench = Bench::<Father>::new();
    bench.iterate().expect("it runs");
    assert_eq!(bench.awake_children(), ["brake", "cruise", "map"]);
    assert_eq!(
        bench.modulated("cruise", "target"),
        Some(Pose2D::new(1.0, 2.0, 0.5))
    );
    assert_eq!(
        bench.modulated::<Pose2D>("brake", "target"),
        None,
        "a modulation of the same name of another child"
    );
    let dwell = Duration::from_millis(300);
    assert_eq!(bench.policy("brake"), Some(Policy::sticky(dwell, 0.25)));
    assert_eq!(bench.schema().outcomes, [Outcome::Accepted; 5]);

    bench.set_faulted("brake", true);
    bench.iterate().expect("it runs");
    assert_eq!(bench.awake_children(), ["brake", "map"]);
    assert_eq!(bench.modulated("brake", "target"), Some(Pose2D::ORIGIN));
    assert_eq!(
        bench.schema().seen,
        [
            (State::Checking, true),
            (State::Checking, false),
            (State::Winner, false)
        ]
    );
}

#[test]
fn an_optional_child_left_unbound_has_no_status_and_is_not_woken() {
    let mut bench = Bench::<Father>::new();
    bench.unbind("map");
    bench.iterate().expect("it runs");
    assert_eq!(bench.awake_children(), ["brake", "cruise"]);
    let father = bench.schema();
    assert_eq!((father.seen.len(), father.outcomes[2]), (2, Outcome::Unbound));
}

#[test]
fn r7_a_father_without_authority_wakes_no_child_and_its_requests_are_refused() {
    let mut bench = Bench::<Father>::new();
    bench.set_authority(false);
    bench.iterate().expect("a refusal is no fault");
    assert!(bench.awake_children().is_empty());
    assert_eq!(bench.schema().outcomes, [Outcome::Refused; 5]);
}

#[test]
fn r4_a_father_chooses_among_the_awake_children_of_a_group() {
    let mut bench = Bench::<Father>::new();
    bench.set_child("brake", State::Ready);
    bench.set_child("cruise", State::Winner);
    let decision = bench.arbitrate("base").expect("a decision");
    assert_eq!(
        (decision.child.as_deref(), &*decision.reason),
        (Some("brake"), "cruise won: true")
    );
}

#[test]
fn r4_a_father_may_choose_no_winner_and_a_long_reason_is_cut_between_characters() {
    let mut bench = Bench::<Father>::new();
    bench.set_child("brake", State::Checking);
    bench.set_child("cruise", State::Checking);
    let decision = bench.arbitrate("base").expect("a decision");
    assert_eq!((decision.child, decision.reason), (None, "ñ".repeat(63)));
}

#[test]
#[should_panic(expected = "exactly one child of `base` is ready, so the host does not arbitrate")]
fn r3_the_bench_does_not_arbitrate_when_exactly_one_child_is_ready() {
    let mut bench = Bench::<Father>::new();
    bench.set_child("brake", State::Ready);
    bench.set_child("cruise", State::Ready);
    bench.set_precondition("brake", false);
    let _ = bench.arbitrate("base");
}
