//! The values that a drive's expressions and measures read: variables, signals, and the true motion of
//! robots. It evaluates an expression only when one of its values has changed.

use std::collections::BTreeMap;
use std::sync::Arc;

use jde_app::Application;
use jde_board::{Reader, Variable};
use jde_conditions::{Expression, Names, Signals};
use jde_core::Nanos;
use jde_host::Handle;
use jde_records::event::Event;
use jde_timeline::Export;
use jde_types::{BatteryState, Mission, Truth, Value};

use super::motion::RobotMotion;

/// The values of a drive.
pub struct DriveValues {
    expressions: Vec<Expression>,
    /// Whether a value of the expression has changed since its last evaluation.
    is_stale: Vec<bool>,
    results: Vec<Option<f64>>,
    variables: Vec<WatchedVariable>,
    signals: Signals,
    /// The users of each signal, by its number.
    signal_users: BTreeMap<usize, Vec<Use>>,
    robots: Vec<RobotValues>,
    mission: Option<VariableSource>,
}

/// An expression, and the place of a variable or a signal in it.
type Use = (usize, usize);

/// A variable that expressions read.
struct WatchedVariable {
    source: VariableSource,
    users: Vec<Use>,
}

/// A variable, and what was read last.
struct VariableSource {
    variable: Arc<Variable>,
    reader: Reader,
    /// The number of that value, and whether there was one.
    seen: (u64, bool),
}

/// A robot whose true state is exported.
struct RobotValues {
    truth: VariableSource,
    truth_name: String,
    battery: Option<VariableSource>,
    motion: RobotMotion,
    pose: Option<[f64; 3]>,
}

/// Returns the robots of an application whose true state is exported.
pub(crate) fn robots(application: &Application) -> Vec<Export> {
    Export::of_application(application, &Truth::describe())
}

impl VariableSource {
    fn open(handle: &Handle, name: &str) -> Option<Self> {
        let variable = handle.board().find(name)?;
        Some(Self {
            reader: variable.reader("experiment").of_what_is_in_force(),
            variable,
            seen: (0, false),
        })
    }

    /// Returns the present bytes if they have changed since the last call; `Some(None)` if there is no value
    /// any more.
    fn changed(&mut self, now: Nanos) -> Option<Option<&[u8]>> {
        let newest = (self.variable.newest(), self.variable.has_value(now));
        if std::mem::replace(&mut self.seen, newest) == newest {
            return None;
        }
        Some(self.reader.latch_newest(now).map(|latched| latched.bytes))
    }

    /// Returns the present value if it has changed since the last call.
    fn changed_value<T: Value>(&mut self, now: Nanos) -> Option<T> {
        T::from_bytes(self.changed(now)??)
    }
}

impl DriveValues {
    /// Opens all variables that the expressions name.
    #[must_use]
    pub fn new(expressions: &[Expression], handle: &Handle) -> Self {
        let application = handle.application();
        let batteries = Export::of_application(application, &BatteryState::describe());
        let robots = robots(application).into_iter().filter_map(|robot| {
            let battery = batteries.iter().find(|battery| battery.owner == robot.owner);
            Some(RobotValues {
                truth: VariableSource::open(handle, &robot.key)?,
                truth_name: robot.key,
                battery: battery.and_then(|battery| VariableSource::open(handle, &battery.key)),
                motion: RobotMotion::default(),
                pose: None,
            })
        });
        let mission = application.mission;
        let mission = mission.and_then(|port| VariableSource::open(handle, &application.variable_name(port)));
        let mut values = Self {
            is_stale: Vec::new(),
            results: Vec::new(),
            variables: Vec::new(),
            signals: Signals::new(&Names::of(application)),
            signal_users: BTreeMap::new(),
            robots: robots.collect(),
            mission,
            expressions: Vec::new(),
        };
        values.set_expressions(expressions, handle);
        values
    }

    /// Evaluates these expressions from now on, in place of the ones before.
    pub fn set_expressions(&mut self, expressions: &[Expression], handle: &Handle) {
        let mut variables: BTreeMap<String, Vec<Use>> = BTreeMap::new();
        self.signal_users.clear();
        self.expressions = expressions.to_vec();
        for (expression, parsed) in self.expressions.iter_mut().enumerate() {
            let inputs: Vec<_> = parsed.inputs().map(str::to_owned).collect();
            for (place, name) in inputs.into_iter().enumerate() {
                let users = match self.signals.find(&name) {
                    Some(signal) => {
                        parsed.set(place, self.signals.value(signal));
                        self.signal_users.entry(signal).or_default()
                    }
                    None => variables.entry(name).or_default(),
                };
                users.push((expression, place));
            }
        }
        let variables = variables.into_iter().filter_map(|(name, users)| {
            let source = VariableSource::open(handle, &name)?;
            Some(WatchedVariable { source, users })
        });
        self.variables = variables.collect();
        self.is_stale = vec![true; expressions.len()];
        self.results = vec![None; expressions.len()];
    }

    /// Takes an event.
    pub fn add_event(&mut self, event: &Event) {
        self.signals.process_event(event);
    }

    /// Reads what has changed at an instant, and returns the value of each expression.
    pub fn update(&mut self, now: Nanos) -> &[Option<f64>] {
        for WatchedVariable { source, users } in &mut self.variables {
            if let Some(bytes) = source.changed(now) {
                for (expression, place) in users.iter() {
                    self.expressions[*expression].set(*place, bytes);
                    self.is_stale[*expression] = true;
                }
            }
        }
        self.update_robots(now);
        self.signals.advance(now);
        let (users, expressions, is_stale) = (&self.signal_users, &mut self.expressions, &mut self.is_stale);
        self.signals.take_changes(|signal, value| {
            for (expression, place) in users.get(&signal).into_iter().flatten() {
                expressions[*expression].set(*place, value);
                is_stale[*expression] = true;
            }
        });
        for (place, expression) in self.expressions.iter_mut().enumerate() {
            if std::mem::take(&mut self.is_stale[place]) {
                self.results[place] = expression.value();
            }
        }
        &self.results
    }

    /// Returns the pose of the first robot: m, m, rad.
    pub(super) fn pose(&self) -> Option<[f64; 3]> {
        self.robots.first()?.pose
    }

    /// Returns the motions of all robots.
    pub(super) fn motions(&self) -> Vec<RobotMotion> {
        self.robots.iter().map(|robot| robot.motion.clone()).collect()
    }

    fn update_robots(&mut self, now: Nanos) {
        let mission = self
            .mission
            .as_mut()
            .and_then(|mission| mission.changed_value::<Mission>(now));
        for robot in &mut self.robots {
            if let Some(bytes) = robot.truth.changed(now).flatten() {
                self.signals.process_value(&robot.truth_name, Some(bytes));
                if let Some(truth) = Truth::from_bytes(bytes) {
                    robot.motion.observe(now, &truth);
                    robot.pose = Some([truth.pose.x, truth.pose.y, truth.pose.theta]);
                }
            }
            if let Some(battery) = robot
                .battery
                .as_mut()
                .and_then(|battery| battery.changed_value::<BatteryState>(now))
            {
                let power = f64::from(battery.voltage) * f64::from(battery.current);
                robot.motion.observe_power(now, power);
            }
        }
        if let (Some(mission), Some(robot)) = (mission, self.robots.first_mut()) {
            robot.motion.observe_mission(&mission);
        }
    }
}
