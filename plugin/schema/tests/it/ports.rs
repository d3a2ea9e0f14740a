//! Inputs and outputs: values, stamps, missing values, refusals.

#![forbid(unsafe_code)]

use jde_schema::bench::Bench;
use jde_schema::prelude::*;

/// Copies a scan, and commands the base according to it.
#[derive(Describe)]
#[schema(motor, period = "10ms")]
struct Pass {
    #[import]
    scan: Import<LaserScan>,
    #[import(optional)]
    extra: Import<f64>,
    #[export]
    copy: Export<LaserScan>,
    #[modulation(default = 0.5, unit = "m/s", max = 1.0)]
    speed: Modulation<f64>,
    #[actuator]
    base: Actuator<Twist>,
    #[actuator(optional)]
    horn: Actuator<Flag>,
    outcomes: Vec<Outcome>,
    age: Option<Duration>,
    unwritten: bool,
}

impl Schema for Pass {
    fn iterate(&mut self, cx: &Context) -> Result {
        let scan = self.scan.require(cx)?;
        self.age = Some(scan.age(cx));
        let speed = self.speed.sample(cx);
        self.unwritten = speed.is_default();
        let extra = self.extra.get(cx).map_or(0.0, |extra| *extra);
        self.outcomes.push(self.base.command(
            cx,
            Twist::planar(*speed, if extra.is_nan() { extra } else { 0.0 }),
        ));
        self.outcomes.push(self.horn.command(cx, Flag::TRUE));
        let mut copy = self.copy.loan(cx);
        *copy = *scan;
        copy.angle_min = 7.0;
        if scan.ranges[0].is_infinite() {
            return Ok(());
        }
        copy.publish_at(scan.time());
        if let Some(extra) = self.extra.get(cx) {
            info!(cx, "extra is {}", *extra);
        }
        Ok(())
    }
}

fn scan(range: f32) -> LaserScan {
    LaserScan {
        range_max: 10.0,
        ranges: Seq::from_slice(&[range]).expect("it fits"),
        ..LaserScan::default()
    }
}

#[test]
fn a_missing_value_is_an_error_that_names_the_import() {
    let mut bench = Bench::<Pass>::new();
    let failure = bench.iterate().expect_err("no scan");
    assert_eq!(failure.reason, "import `scan` has no value");
}

#[test]
fn values_carry_their_time() {
    let mut bench = Bench::<Pass>::new();
    bench.set_now(Duration::from_millis(30));
    bench.import("scan", &scan(1.0));
    bench.set_now(Duration::from_millis(50));
    bench.iterate().expect("no fault");
    assert_eq!(bench.schema().age, Some(Duration::from_millis(20)));
    assert_eq!(
        bench.exported_at("copy"),
        Some(Duration::from_millis(30)),
        "the time of measurement, not of writing"
    );
}

#[test]
fn a_loan_that_is_not_published_changes_no_variable() {
    let mut bench = Bench::<Pass>::new();
    bench.import("scan", &scan(f32::INFINITY));
    bench.iterate().expect("no fault");
    assert_eq!(bench.exported::<LaserScan>("copy"), None);
    bench.import("scan", &scan(2.0));
    bench.iterate().expect("no fault");
    let copy = bench.exported::<LaserScan>("copy").expect("published");
    assert_eq!((copy.angle_min, copy.ranges.as_slice()), (7.0, &[2.0_f32][..]));
}

#[test]
fn r7_a_command_without_authority_is_refused_and_no_fault() {
    let mut bench = Bench::<Pass>::new();
    bench.import("scan", &scan(f32::INFINITY));
    bench.set_authority(false);
    bench.iterate().expect("a refusal is no fault");
    assert_eq!(bench.commanded::<Twist>("base"), None);
    assert_eq!(bench.schema().outcomes, [Outcome::Refused, Outcome::Refused]);
}

#[test]
fn a_command_that_is_not_finite_is_refused_and_no_fault() {
    let mut bench = Bench::<Pass>::new();
    bench.import("scan", &scan(f32::INFINITY));
    bench.import("extra", &f64::NAN);
    bench.iterate().expect("a refusal is no fault");
    assert_eq!(bench.commanded::<Twist>("base"), None);
    assert_eq!(bench.schema().outcomes[0], Outcome::NotFinite);
}

#[test]
fn the_bench_returns_only_commands_of_the_last_iteration() {
    let mut bench = Bench::<Pass>::new();
    bench.import("scan", &scan(f32::INFINITY));
    bench.iterate().expect("no fault");
    assert!(bench.schema().unwritten);
    assert_eq!(bench.commanded("base"), Some(Twist::planar(0.5, 0.0)));
    assert_eq!(bench.commanded("horn"), Some(Flag::TRUE));
    bench.set("speed", 0.1);
    bench.set_authority(false);
    bench.iterate().expect("no fault");
    assert!(!bench.schema().unwritten);
    assert_eq!(
        bench.commanded::<Twist>("base"),
        None,
        "a command of an earlier iteration remained"
    );
}

#[test]
fn optional_ports_left_unbound_are_no_fault() {
    let mut bench = Bench::<Pass>::new();
    bench.import("scan", &scan(1.0));
    bench.unbind("extra");
    bench.unbind("horn");
    bench.iterate().expect("no fault");
    assert_eq!(bench.schema().outcomes, [Outcome::Accepted, Outcome::Unbound]);
    assert!(bench.log().is_empty());
    bench.import("extra", &2.0);
    bench.iterate().expect("no fault");
    assert_eq!(
        bench.log(),
        [(jde_schema::Severity::Info, "extra is 2".to_owned())]
    );
}

/// Keeps the command that it receives.
#[derive(Describe)]
#[schema(driver, period = "10ms")]
struct Base {
    #[command(neutral = Twist::ZERO, validity = "500ms")]
    velocity: Command<Twist>,
    received: Option<(Twist, bool)>,
}

impl Schema for Base {
    fn iterate(&mut self, cx: &Context) -> Result {
        let velocity = self.velocity.get(cx);
        self.received = Some((*velocity, velocity.in_force()));
        Ok(())
    }
}

#[test]
fn r7_a_driver_reads_the_neutral_value_when_no_command_is_in_force() {
    let ahead = Twist::planar(0.4, 0.0);
    let mut bench = Bench::<Base>::new();
    bench.iterate().expect("no fault");
    assert_eq!(
        bench.schema().received,
        Some((Twist::ZERO, false)),
        "before the first"
    );
    bench.command("velocity", &ahead);
    bench.set_now(Duration::from_millis(500));
    bench.iterate().expect("no fault");
    assert_eq!(bench.schema().received, Some((ahead, true)), "while valid");
    bench.set_now(Duration::from_millis(501));
    bench.iterate().expect("no fault");
    assert_eq!(bench.schema().received, Some((Twist::ZERO, false)), "and after");
}

#[test]
#[should_panic(expected = "there is no import `scam`; did you mean `scan`?")]
fn an_unknown_port_on_the_bench_panics_with_the_nearest_name() {
    Bench::<Pass>::new().import("scam", &scan(f32::INFINITY));
}

#[test]
#[should_panic(expected = "`scan` is a sensor_msgs/msg/LaserScan, not a geometry_msgs/msg/Twist")]
fn a_value_of_another_type_on_the_bench_panics_with_both_types() {
    Bench::<Pass>::new().import("scan", &Twist::ZERO);
}

/// Forwards a number, and retracts it when its source has no value.
#[derive(Describe)]
#[schema(perceptive, period = "10ms")]
struct Relay {
    #[import]
    near: Import<f64>,
    #[export]
    far: Export<f64>,
}

impl Schema for Relay {
    fn awake(&mut self, cx: &Context) -> Result {
        cx.require_real_time()
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        match self.near.get(cx) {
            Some(near) => self.far.write(cx, *near),
            None => self.far.retract(cx),
        }
        Ok(())
    }
}

#[test]
fn a_retracted_value_is_none() {
    let mut bench = Bench::<Relay>::new();
    bench.import("near", &1.5);
    bench.iterate().expect("no fault");
    assert_eq!(bench.exported::<f64>("far"), Some(1.5));
    bench.retract("near");
    bench.iterate().expect("no fault");
    assert_eq!(bench.exported::<f64>("far"), None);
}

#[test]
fn a_schema_that_requires_real_time_fails_in_lockstep() {
    let mut bench = Bench::<Relay>::new();
    bench.awake().expect("a new bench is in real time");
    bench.set_real_time(false);
    let failure = bench.awake().expect_err("lockstep is not real time");
    assert!(failure.reason.contains("--lockstep"), "{}", failure.reason);
}

#[test]
#[should_panic(expected = "`velocity` is not finite, and a command is")]
fn a_command_that_is_not_finite_is_refused_on_the_bench() {
    Bench::<Base>::new().command("velocity", &Twist::planar(f64::INFINITY, 0.0));
}

#[test]
#[should_panic(expected = "`speed` is not finite, and a modulation is")]
fn a_modulation_that_is_not_finite_is_refused_on_the_bench() {
    Bench::<Pass>::new().set("speed", f64::NAN);
}

#[test]
#[should_panic(expected = "`speed` is 1.5 m/s, and at most 1 m/s is allowed")]
fn a_modulation_out_of_its_range_is_refused_on_the_bench() {
    Bench::<Pass>::new().set("speed", 1.5);
}
