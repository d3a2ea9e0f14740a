//! An application with a driver and a pilot, whose modulations the test sets.

use core::f64::consts::PI;
use std::any::Any;
use std::path::Path;
use std::time::Duration;

use jde_board::value::Value;
use jde_core::SchemaId;
use jde_host::{Handle, Options, Running};
use jde_loader::{Plugins, SearchPath};
use jde_records::event::Outcome;
use jde_schema::derived::raw;
use jde_schema::prelude::{Connection, LaserScan, Odometry, Pose2D, normalize_angle};
use jde_watchdog::Watchdog;

use crate::pilot::{Pilot, Watcher};
use crate::plugins;

/// A room with a robot at [`START`], as a world file of the simulator.
pub(crate) const ROOM: &str = r#"
name  = "room"
walls = [{ name = "wall", points = [[0, 0], [5, 0], [5, 4], [0, 4]], closed = true }]
[robots.pioneer]
start = { x = 2.5, y = 1.5 }
"#;

/// The start of every robot.
pub(crate) const START: Pose2D = Pose2D {
    x: 2.5,
    y: 1.5,
    theta: 0.0,
};

/// The longest time between two checks of a condition.
const POLL_PERIOD: Duration = Duration::from_millis(20);

static SUITE: raw::Plugin = jde_schema::plugin!("suite", "Schemas of the suite.", [Pilot, Watcher]);

/// The environment of a driver under test.
pub(crate) struct DriverConfig {
    /// The lines of the driver's table in the application.
    pub(crate) driver_toml: String,
    /// Resources that must live as long as the driver, such as a server or a folder.
    pub(crate) resources: Box<dyn Any>,
}

/// A running application.
pub(crate) struct Fixture {
    running: Running,
    handle: Handle,
    /// Resources that must live as long as the application.
    pub(crate) resources: Box<dyn Any>,
    pilot: SchemaId,
    _watchdog: Watchdog,
}

impl Fixture {
    /// Starts the application, and returns when the robot is connected and a scan has arrived.
    pub(crate) fn start(config: DriverConfig) -> Self {
        let mut path = SearchPath::default();
        path.push(plugins(), "built for this test");
        let mut plugins = Plugins::new(path);
        plugins.link(&SUITE).expect("the plugin of the suite is valid");
        let text = format!(
            r#"
            roots = ["pilot", "watcher"]
            [schemas.pioneer]
            {}
            [schemas.pilot]
            type = "suite/pilot"
            actuators = {{ base = "pioneer.velocity", head = "pioneer.head" }}
            [schemas.watcher]
            type = "suite/watcher"
            imports = {{ odometry = "pioneer.odometry" }}
            "#,
            config.driver_toml
        );
        let application = jde_app::parse(&text, Path::new("apps/suite.toml"), &[], &plugins)
            .unwrap_or_else(|faults| panic!("{faults}"));
        let running = Running::start(application, &plugins, Options::default()).expect("it starts");
        let handle = running.handle();
        let pilot = handle.application().instance("pilot").expect("there is a pilot");
        let fixture = Self {
            running,
            handle,
            resources: config.resources,
            pilot,
            _watchdog: Watchdog::for_test(),
        };
        fixture.wait_until(|fixture| fixture.is_up() && fixture.laser().is_some());
        fixture
    }

    /// Waits until a condition holds.
    #[track_caller]
    pub(crate) fn wait_until(&self, condition: impl Fn(&Self) -> bool) {
        let odometry = self.handle.board().get("pioneer.odometry");
        let odometry = odometry.expect("every base has one");
        while !condition(self) {
            assert_eq!(self.handle.outcome(), None, "the application has not ended");
            // Most conditions change with the next odometry. The timeout covers the others.
            odometry.wait_newer(odometry.newest(), POLL_PERIOD);
        }
    }

    /// Returns the newest value of a variable.
    pub(crate) fn read<T: jde_schema::Value>(&self, variable: &str) -> Option<T> {
        self.handle
            .value(variable)
            .unwrap_or_else(|error| panic!("{error}"))
    }

    /// Returns the newest odometry.
    pub(crate) fn odometry(&self) -> Option<Odometry> {
        self.read("pioneer.odometry")
    }

    /// Returns the newest scan.
    pub(crate) fn laser(&self) -> Option<Box<LaserScan>> {
        self.read("pioneer.laser").map(Box::new)
    }

    /// Returns the pose of the odometry.
    #[track_caller]
    pub(crate) fn pose(&self) -> Pose2D {
        self.odometry().expect("the odometry has arrived").pose2d()
    }

    /// Returns whether the robot is connected and its odometry has arrived.
    pub(crate) fn is_up(&self) -> bool {
        let connection: Option<Connection> = self.read("pioneer.connection");
        connection.is_some_and(|connection| connection.is_up()) && self.odometry().is_some()
    }

    /// Returns whether the robot is at rest, according to its odometry.
    pub(crate) fn is_standing(&self) -> bool {
        self.odometry().is_some_and(|odometry| {
            let twist = odometry.twist.twist;
            twist.linear.x.abs() < 0.002 && twist.angular.z.abs() < 0.005
        })
    }

    /// Sets the speeds that the pilot commands from now on.
    pub(crate) fn drive(&self, linear: f64, angular: f64) {
        self.modulate("linear", linear);
        self.modulate("angular", angular);
    }

    /// Writes a modulation of the pilot.
    pub(crate) fn modulate(&self, name: &str, value: f64) {
        self.handle
            .operator("suite")
            .modulate(self.pilot, name, &Value::Float(value))
            .expect("the pilot has this modulation");
    }

    /// Stops, and waits until the robot is at rest.
    pub(crate) fn halt(&self) {
        self.drive(0.0, 0.0);
        self.wait_until(Self::is_standing);
    }

    /// Drives a distance ahead, in metres, and stops.
    pub(crate) fn drive_distance(&self, metres: f64) {
        let start = self.pose();
        self.drive(0.25, 0.0);
        // Braking takes a tenth of a metre.
        self.wait_until(|fixture| fixture.pose().distance_to(&start) > metres - 0.1);
        self.halt();
    }

    /// Turns to a heading of the odometry, in radians, and stops.
    pub(crate) fn turn_to(&self, heading: f64) {
        let error = |fixture: &Self| normalize_angle(heading - fixture.pose().theta);
        self.wait_until(|fixture| {
            let error = error(fixture);
            // The speed falls with the error, but stays high enough for a robot whose commands are whole degrees a
            // second.
            fixture.drive(0.0, (1.2 * error).clamp(-0.7, 0.7) + 0.02_f64.copysign(error));
            error.abs() < 1.0 * PI / 180.0
        });
        self.halt();
    }

    /// Returns the index of the pilot's instance, to hold or release it.
    pub(crate) fn pilot(&self) -> SchemaId {
        self.pilot
    }

    /// Returns the handle of the application.
    pub(crate) fn handle(&self) -> &Handle {
        &self.handle
    }

    /// Ends the application, and returns its outcome and the resources.
    pub(crate) fn stop(self) -> (Outcome, Box<dyn Any>) {
        self.handle.stop();
        (self.running.wait(), self.resources)
    }
}
