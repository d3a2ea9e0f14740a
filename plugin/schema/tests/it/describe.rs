//! The host reads the same description of a schema that the derive macro was given.

#![forbid(unsafe_code)]

use jde_abi::describe::{Kind, Limits, Role, Validity};
use jde_abi::raw;
use jde_schema::bench::Bench;
use jde_schema::prelude::*;

/// How the base may move.
#[derive(PortBundle)]
struct SpeedLimits {
    /// The greatest speed.
    #[modulation(default = 0.3, unit = "m/s", min = 0, max = 1.5, was = "fast")]
    speed: Modulation<f64>,
    #[ports]
    turns: TurnLimits,
}

/// How the base may turn.
#[derive(PortBundle)]
struct TurnLimits {
    /// The greatest turn rate.
    #[modulation(default = 1.0, unit = "rad/s")]
    turn: Modulation<f64>,
}

/// Drives home.
///
/// And back.
#[derive(Describe)]
#[schema(motor, period = "75ms", budget = "5ms")]
pub(crate) struct DriveHome {
    /// The newest scan.
    #[import(trigger)]
    laser: Import<LaserScan>,
    /// The distance to the goal.
    #[import(optional, unit = "m", name = "far-off")]
    distance: Import<f64>,
    /// The progress of the mission.
    #[export(lasting)]
    mission: Export<Mission>,
    #[ports]
    limits: SpeedLimits,
    /// The goal.
    #[modulation(default = Pose2D::new(1.0, 2.0, 0.0))]
    home: Modulation<Pose2D>,
    /// A map.
    #[modulation(default = "worlds/office.toml", unit = "path", fixed)]
    map: Modulation<Text<256>>,
    /// Gains.
    #[modulation(default = [1.0, 2.0, 3.0])]
    gains: Modulation<[f64; 3]>,
    /// The base.
    #[actuator]
    base: Actuator<Twist>,
    /// The head, if there is one.
    #[actuator(optional)]
    head: Actuator<Vector3>,
    /// Goes straight.
    #[child(group = "base")]
    cruise: Child,
    /// Builds the map.
    #[child(perceptive, optional)]
    map_maker: Child,
    /// The goal of `cruise`.
    #[modulates(child = "cruise", name = "target")]
    cruise_target: Modulates<Pose2D>,
    /// The period of `cruise`.
    #[modulates(child = "cruise", name = "period", optional)]
    cruise_period: Modulates<f64>,
    visits: Vec<Pose2D>,
}

impl Schema for DriveHome {
    fn iterate(&mut self, cx: &Context) -> Result {
        self.visits.push(self.home.get(cx));
        let _ = (self.laser.is_bound(cx), self.distance.get(cx));
        let _ = (self.limits.speed.get(cx), self.limits.turns.turn.get(cx));
        let _ = (
            self.map.get(cx),
            self.gains.get(cx),
            self.cruise.wake(cx),
            self.map_maker.wake(cx),
        );
        self.mission.write(cx, Mission::default());
        self.base.command(cx, Twist::ZERO);
        self.head.command(cx, Vector3::default());
        self.cruise_target.set(cx, self.home.get(cx));
        self.cruise_period.set(cx, 0.05);
        Ok(())
    }
}

impl Arbitrate for DriveHome {
    fn arbitrate(&mut self, _: &Context, level: &Level) -> Result<Verdict> {
        assert_eq!(level.group(), "base");
        Ok(Verdict::nobody("there is only one"))
    }
}

/// A wheel.
#[derive(Describe)]
#[schema(driver, period = "10ms", name = "wheel-2")]
pub(crate) struct Wheel {
    /// The velocity.
    #[command(neutral = 0.0, validity = "500ms", unit = "rad/s")]
    velocity: Command<f64>,
    /// The angle.
    #[export(unit = "rad")]
    angle: Export<f64>,
}

impl Schema for Wheel {
    fn iterate(&mut self, cx: &Context) -> Result {
        let velocity = *self.velocity.get(cx);
        self.angle.write(cx, velocity);
        Ok(())
    }
}

const _: jde_abi::raw::Plugin = jde_schema::plugin!("demo", "Two schemas.", [DriveHome, Wheel]);

#[test]
fn names_kinds_and_times_are_as_declared() {
    let (home, wheel) = (Bench::<DriveHome>::new(), Bench::<Wheel>::new());
    let (home, wheel) = (home.description(), wheel.description());
    assert_eq!((&*home.name, home.kind), ("drive-home", Kind::Motor));
    assert_eq!((&*wheel.name, wheel.kind), ("wheel-2", Kind::Driver));
    assert_eq!((home.period_ns, home.budget_ns), (75_000_000, Some(5_000_000)));
    assert_eq!(
        (wheel.period_ns, wheel.budget_ns),
        (10_000_000, None),
        "without a declared budget, the host uses the period"
    );
    assert_eq!(home.doc, "Drives home.\n\nAnd back.");
    assert!(home.arbitrates);
    assert!(!wheel.arbitrates);
}

#[test]
fn ports_of_bundles_are_where_the_bundle_is() {
    let mut bench = Bench::<DriveHome>::new();
    let names: Vec<&str> = bench.description().ports.iter().map(|port| &*port.name).collect();
    assert_eq!(names[2..6], ["mission", "speed", "turn", "home"]);
    let former: Vec<_> = bench
        .description()
        .ports
        .iter()
        .filter_map(|port| port.former_name.as_deref())
        .collect();
    assert_eq!(former, ["fast"]);
    bench.set("turn", 0.5);
    bench.iterate().expect("each port has its own number");
    assert_eq!(bench.description().modulation_named("fast"), Some(3));
}

#[test]
fn ports_are_as_their_attributes_declare() {
    let bench = Bench::<DriveHome>::new();
    let ports = &bench.description().ports;
    let port = |name: &str| ports.iter().find(|port| port.name == name).expect(name);

    assert_eq!(port("laser").role, Role::Import);
    assert!(port("laser").has(raw::TRIGGER));
    assert_eq!(port("laser").value_type.name, "sensor_msgs/msg/LaserScan");
    assert_eq!(port("laser").doc, "The newest scan.");
    assert!(!port("laser").has(raw::OPTIONAL));
    assert_eq!(
        (port("far-off").has(raw::OPTIONAL), &*port("far-off").unit),
        (true, "m")
    );
    assert!(!port("far-off").has(raw::TRIGGER));
    let validity = Validity::Lasting;
    assert_eq!(port("mission").role, Role::Export { validity });
    assert_eq!(
        port("speed").role,
        Role::Modulation {
            default: 0.3_f64.to_ne_bytes().to_vec(),
            limits: Limits {
                least: Some(0.0),
                greatest: Some(1.5),
                choices: Vec::new()
            },
        }
    );
    assert_eq!(
        (port("base").role.clone(), port("base").has(raw::OPTIONAL)),
        (Role::Actuator, false)
    );
    assert_eq!(
        (port("head").role.clone(), port("head").has(raw::OPTIONAL)),
        (Role::Actuator, true)
    );
    assert_eq!(port("target").role, Role::ChildModulation { child: 0 });
    assert_eq!(
        (port("period").role.clone(), port("period").has(raw::OPTIONAL)),
        (Role::ChildModulation { child: 0 }, true)
    );

    let Role::Modulation { default, limits } = &port("map").role else {
        panic!("a modulation")
    };
    assert_eq!((default.len(), limits), (260, &Limits::default()));
    assert!(port("map").has(raw::FIXED));
    assert!(default[4..].starts_with(b"worlds/office.toml\0"));
    assert_eq!(port("gains").value_type.name, "jde_msgs/msg/Float64Array");
}

#[test]
fn children_are_as_their_attributes_declare() {
    let bench = Bench::<DriveHome>::new();
    let [cruise, map_maker] = &bench.description().children[..] else {
        panic!("two children")
    };
    assert_eq!(
        (&*cruise.name, &*cruise.group, cruise.motor, cruise.optional),
        ("cruise", "base", true, false)
    );
    assert_eq!(
        (&*map_maker.name, map_maker.motor, map_maker.optional),
        ("map_maker", false, true)
    );
    assert_eq!(cruise.doc, "Goes straight.");
}

#[test]
fn a_command_has_its_neutral_value_and_validity() {
    let bench = Bench::<Wheel>::new();
    let velocity = &bench.description().ports[0];
    let neutral = 0.0_f64.to_ne_bytes().to_vec();
    assert_eq!(
        velocity.role,
        Role::Command {
            neutral,
            validity_ns: 500_000_000,
        }
    );
    assert_eq!(velocity.unit, "rad/s");
}
