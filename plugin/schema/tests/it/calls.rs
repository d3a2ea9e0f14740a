//! Panics and errors end at the boundary. The host receives their message and location.

#![forbid(unsafe_code)]

use jde_abi::raw;
use jde_schema::bench::{Bench, Failure};
use jde_schema::prelude::*;

/// Panics or returns an error in the call that a modulation names.
#[derive(Describe)]
#[schema(motor, period = "10ms")]
struct Fragile {
    /// The call that panics.
    #[modulation(default = "")]
    panics: Modulation<Text<32>>,
    /// The call that returns an error.
    #[modulation(default = "")]
    errs: Modulation<Text<32>>,
    /// The urgency that the check returns.
    #[modulation(default = 0.0)]
    urgency: Modulation<f64>,
    #[modulation(default = 1.0)]
    divisor: Modulation<f64>,
    #[child(group = "g")]
    only_child: Child,
    calls: u32,
}

impl Fragile {
    fn fail_if_selected(&mut self, cx: &Context, call: &str) -> Result {
        self.calls += 1;
        assert!(self.panics.get(cx) != call, "requested panic in {call}");
        if self.errs.get(cx) == call {
            let cause = std::io::Error::other("the cable is loose");
            return Err(Box::new(cause));
        }
        Ok(())
    }
}

impl Schema for Fragile {
    fn awake(&mut self, cx: &Context) -> Result {
        self.fail_if_selected(cx, "awake")
    }

    fn check(&mut self, cx: &Context) -> Result<Precondition> {
        self.fail_if_selected(cx, "check")?;
        Ok(Precondition::from(true).urgency(self.urgency.get(cx) / self.divisor.get(cx)))
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        self.fail_if_selected(cx, "iterate")
    }

    fn sleep(&mut self, cx: &Context) {
        let _ = self.fail_if_selected(cx, "sleep");
    }
}

impl Arbitrate for Fragile {
    fn arbitrate(&mut self, cx: &Context, _: &Level) -> Result<Verdict> {
        self.fail_if_selected(cx, "arbitrate")?;
        Ok(Verdict::choose(&self.only_child, "it is the only one"))
    }
}

fn call(bench: &mut Bench<Fragile>, call: &str) -> Result<(), Failure> {
    match call {
        "awake" => bench.awake(),
        "check" => bench.check().map(drop),
        "iterate" => bench.iterate(),
        "sleep" => bench.sleep(),
        _ => bench.arbitrate("g").map(drop),
    }
}

const CALLS: [&str; 5] = ["awake", "check", "iterate", "sleep", "arbitrate"];

#[test]
fn a_panic_in_any_call_is_caught_with_its_message_and_location() {
    for name in CALLS {
        let mut bench = Bench::<Fragile>::new();
        bench.set("panics", Text::<32>::new(name));
        let failure = call(&mut bench, name).expect_err(name);
        // A sleep returns no code, so the message alone reports the failure.
        assert_eq!(
            failure.code,
            if name == "sleep" { raw::OK } else { raw::PANICKED }
        );
        assert!(
            failure.reason.contains(&format!("requested panic in {name}")),
            "{}",
            failure.reason
        );
        assert!(
            failure.reason.contains("tests/it/calls.rs:"),
            "{}",
            failure.reason
        );

        bench.set("panics", Text::<32>::EMPTY);
        assert_eq!(
            call(&mut bench, name),
            Ok(()),
            "the instance cannot be called again"
        );
        assert_eq!(bench.schema().calls, 2, "the instance lost its memory");
    }
}

#[test]
fn an_error_in_any_call_reaches_the_host_with_its_message() {
    for name in CALLS.into_iter().filter(|&name| name != "sleep") {
        let mut bench = Bench::<Fragile>::new();
        bench.set("errs", Text::<32>::new(name));
        let failure = call(&mut bench, name).expect_err(name);
        assert_eq!(failure.code, raw::FAILED);
        assert_eq!(failure.reason, "the cable is loose");
        assert!(!failure.panicked());
    }
}

#[test]
fn an_urgency_that_is_not_finite_is_an_error() {
    let mut bench = Bench::<Fragile>::new();
    bench.set("divisor", 0.0);
    for urgency in [0.0, 1.0] {
        bench.set("urgency", urgency);
        let failure = bench.check().expect_err("an urgency that is not finite");
        assert!(failure.reason.contains("must be finite"), "{failure}");
    }
    bench.set("divisor", 1.0);
    bench.set("urgency", -2.5);
    assert_eq!(
        bench.check(),
        Ok(Precondition {
            ready: true,
            urgency: -2.5
        })
    );
}

struct Bomb;

impl Drop for Bomb {
    fn drop(&mut self) {
        panic!("in drop");
    }
}

impl Default for Bomb {
    fn default() -> Self {
        Self
    }
}

/// Panics in its drop.
#[derive(Describe)]
#[schema(perceptive, period = "1s")]
struct PanicsInDrop {
    #[allow(dead_code, reason = "its drop is what matters")]
    bomb: Bomb,
}

impl Schema for PanicsInDrop {
    fn iterate(&mut self, _: &Context) -> Result {
        // A payload whose own drop panics must not end the process either.
        std::panic::panic_any(Bomb)
    }
}

#[test]
fn a_panic_in_the_drop_of_an_instance_or_of_a_payload_is_caught() {
    let mut bench = Bench::<PanicsInDrop>::new();
    let failure = bench.iterate().expect_err("it panics");
    assert!(failure.panicked());
    assert!(failure.reason.ends_with("without words"), "{failure}");
    drop(bench);
}

struct MissingDevice;

impl Default for MissingDevice {
    fn default() -> Self {
        panic!("no such device")
    }
}

/// Panics in its creation.
#[derive(Describe)]
#[schema(perceptive, period = "1s")]
struct PanicsInCreation {
    #[allow(dead_code, reason = "its creation is what matters")]
    device: MissingDevice,
}

impl Schema for PanicsInCreation {
    fn iterate(&mut self, _: &Context) -> Result {
        Ok(())
    }
}

#[test]
fn a_panic_in_the_creation_of_an_instance_is_caught_with_its_message() {
    let failure = Bench::<PanicsInCreation>::try_new()
        .err()
        .expect("the creation panics");
    assert!(failure.reason.contains("no such device"), "{failure}");
}

#[test]
fn panics_outside_a_call_reach_the_previous_hook() {
    let mut bench = Bench::<Fragile>::new();
    bench.set("panics", Text::<32>::new("iterate"));
    let _ = bench.iterate();
    let outside = std::panic::catch_unwind(|| panic!("outside")).expect_err("it panics");
    assert_eq!(outside.downcast_ref::<&str>(), Some(&"outside"));
}
