//! What several schemas must agree on: where a sensor is, the outline of the robot, how near obstacles may come, and what
//! may be asked of the base. Ports declare it by their attributes, an outline by its type. It compares the values at the
//! start.

use std::fmt;

use jde_abi::describe::{Port, Role};
use jde_abi::{raw, unit};
use jde_core::SchemaId;
use jde_types::{Checks, Footprint, Point2D, Pose2D, Twist, Value};

use super::{Application, Binding, ImportSource, InstanceConfig, InstancePort};
use crate::period::format_setting;

/// Differences up to here are none, m and rad: people measure outlines and mounts by hand.
const MEASURING_ERROR: f64 = 0.01;
/// The factor up to which one limit does not exceed another.
const SAME_LIMIT: f64 = 1.000_001;

/// The type of what a driver knows of its base. Accelerations that a schema imports replace those that it states.
const DYNAMICS: &str = "jde_msgs/msg/BaseDynamics";

/// A value that a schema states: the line of the schema, the name of the modulation, and the value.
struct Stated<'a, T> {
    line: usize,
    name: String,
    unit: &'a str,
    value: T,
}

impl<T: fmt::Display> fmt::Display for Stated<'_, T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let space = if self.unit.is_empty() { "" } else { " " };
        write!(f, "`{}` is {}{space}{}", self.name, self.value, self.unit)
    }
}

impl Application {
    /// Warns of values that do not agree.
    pub(super) fn warn_of_disagreements(&self) -> Vec<String> {
        let mut warnings = self.warn_of_mounts();
        let mut outlines: Vec<(InstancePort, SchemaId)> = Vec::new();
        for (schema, instance) in self.instances.entries() {
            for binding in &instance.bindings {
                let Binding::Actuator {
                    target: Some(command),
                } = *binding
                else {
                    continue;
                };
                warnings.extend(self.warn_of_limits(schema, command));
                for guard in self.guards(schema, command) {
                    // One guard may judge several commands of a schema.
                    for warning in self.warn_of_guard(schema, guard) {
                        if !warnings.contains(&warning) {
                            warnings.push(warning);
                        }
                    }
                    outlines.push((command, guard));
                }
                outlines.push((command, schema));
            }
        }
        warnings.extend(self.warn_of_outlines(&outlines));
        warnings.extend(
            self.instances
                .iter()
                .flat_map(|instance| self.warn_of_ages(instance)),
        );
        warnings
    }

    /// Warns of schemas that read one sensor and state different mounts of it.
    fn warn_of_mounts(&self) -> Vec<String> {
        let mut first: Vec<(ImportSource, Stated<'_, Pose2D>)> = Vec::new();
        let mut warnings = Vec::new();
        for (id, instance) in self.instances.entries() {
            let sensors: Vec<_> = sensors(instance).collect();
            let mounts: Vec<_> = self.stated::<Pose2D>(id, |port| port.has(raw::MOUNT)).collect();
            // Of several sensors, nothing says which one a mount is of.
            let (&[sensor], Ok([own])) = (&sensors[..], <[_; 1]>::try_from(mounts)) else {
                continue;
            };
            let Some((_, other)) = first.iter().find(|(source, _)| *source == sensor) else {
                first.push((sensor, own));
                continue;
            };
            let turned = jde_types::normalize_angle(own.value.theta - other.value.theta);
            if own.value.distance_to(&other.value) > MEASURING_ERROR || turned.abs() > MEASURING_ERROR {
                warnings.push(format!(
                    "line {}: `{}` is {}, and `{}` in line {} is {}, but both say where the sensor of `{}` is: state the same in both",
                    own.line,
                    own.name,
                    pose(&own.value),
                    other.name,
                    other.line,
                    pose(&other.value),
                    self.source_name(sensor),
                ));
            }
        }
        warnings
    }

    /// Warns of schemas that command one base, or judge its commands, and state different outlines of it. An outline that is
    /// a margin is a zone around the base.
    fn warn_of_outlines(&self, bodies: &[(InstancePort, SchemaId)]) -> Vec<String> {
        let mut stated: Vec<(InstancePort, Stated<'_, Footprint>)> = Vec::new();
        let mut warnings = Vec::new();
        for (command, schema) in bodies {
            let Some(own) = self
                .stated::<Footprint>(*schema, |port| !port.has(raw::MARGIN))
                .next()
            else {
                continue;
            };
            if stated
                .iter()
                .any(|(of, other)| of == command && other.name == own.name)
            {
                continue;
            }
            let first = stated.iter().find(|(of, _)| of == command);
            if let Some((_, other)) = first
                && !is_same_outline(&own.value, &other.value)
            {
                warnings.push(format!(
                    "line {}: `{}` and `{}` in line {} are different outlines of the robot that `{}` moves: state the same in both",
                    own.line,
                    own.name,
                    other.name,
                    other.line,
                    self.variable_name(*command),
                ));
            }
            stated.push((*command, own));
        }
        warnings
    }

    /// Warns of a schema that comes as near to obstacles as its guard permits, or nearer, and of one that expects more of the
    /// base than its guard.
    fn warn_of_guard(&self, schema: SchemaId, guard: SchemaId) -> Vec<String> {
        let mut warnings = Vec::new();
        for own in self.stated::<f64>(schema, |port| port.has(raw::MARGIN)) {
            for judge in self.stated::<f64>(guard, |port| port.has(raw::MARGIN)) {
                if judge.value >= own.value {
                    warnings.push(format!(
                        "line {}: {judge}, and {own} in line {}: the guard refuses commands before the schema would stop by itself. Lower \
                         that of the guard, or raise that of the schema",
                        judge.line, own.line,
                    ));
                }
            }
        }
        let knows = |schema| imports(&self.instances[schema], DYNAMICS);
        for own in self.stated::<f64>(schema, |port| port.has(raw::LIMIT)) {
            if own.unit.ends_with("s2") && (knows(schema) || knows(guard)) {
                if knows(schema) != knows(guard) {
                    warnings.push(format!(
                        "line {}: {own}, and only one of `{}` and its guard `{}` imports the dynamics of the base: bind `dynamics` in both",
                        own.line, self.instances[schema].name, self.instances[guard].name,
                    ));
                }
                continue;
            }
            let limits = self.stated::<f64>(guard, |port| port.has(raw::LIMIT));
            let limit = limits.filter(|limit| unit::same(limit.unit, own.unit));
            warnings.extend(
                limit.filter_map(|limit| {
                    exceeded(&own, &limit, "the guard refuses what the schema counts on")
                }),
            );
        }
        warnings
    }

    /// Warns of a schema that asks for more than the driver of the command permits (R7).
    fn warn_of_limits(&self, schema: SchemaId, command: InstancePort) -> Vec<String> {
        let name = format!(
            "{}_limits",
            self.instances[command.instance].schema.ports[command.port].name
        );
        let Some(stated) = self
            .stated::<Twist>(command.instance, |port| port.name == name)
            .next()
        else {
            return Vec::new();
        };
        let of = |unit: &str| match unit {
            _ if unit::same(unit, "m/s") => Some(stated.value.linear.x),
            _ if unit::same(unit, "rad/s") => Some(stated.value.angular.z),
            _ => None,
        };
        let own = self.stated::<f64>(schema, |port| port.has(raw::LIMIT));
        own.filter_map(|own| {
            let limit = Stated {
                line: stated.line,
                name: stated.name.clone(),
                unit: own.unit,
                value: of(own.unit).filter(|limit| *limit > 0.0)?,
            };
            exceeded(&own, &limit, "the host lessens what the schema counts on")
        })
        .collect()
    }

    /// Warns of imports that end before their source writes again. One that iterates on change has no period (R12).
    fn warn_of_ages(&self, instance: &InstanceConfig) -> Vec<String> {
        let bindings = instance.schema.ports.iter().zip(&instance.bindings);
        bindings
            .filter_map(|(port, binding)| {
                let Binding::Import {
                    source: Some(ImportSource::Local(source)),
                    stale_ns: Some(stale),
                    ..
                } = binding
                else {
                    return None;
                };
                let writer = &self.instances[source.instance];
                (*stale < writer.period_ns && !has_trigger(writer)).then(|| {
                    format!(
                        "line {}: `stale` of `{}.{}` is {}, and `{}` in line {} writes every {}: the value ends before the next one is due",
                        instance.line,
                        instance.name,
                        port.name,
                        format_setting(*stale),
                        writer.name,
                        writer.line,
                        format_setting(writer.period_ns),
                    )
                })
            })
            .collect()
    }

    /// The values of this type that modulations of a schema have at the start, of those that are asked for.
    fn stated<T: Value>(
        &self,
        schema: SchemaId,
        is_asked: impl Fn(&Port) -> bool,
    ) -> impl Iterator<Item = Stated<'_, T>> {
        let instance = &self.instances[schema];
        let bindings = instance.schema.ports.iter().zip(&instance.bindings);
        bindings.filter_map(move |(port, binding)| match binding {
            Binding::Modulation { initial, .. }
                if is_asked(port) && port.value_type.same_as(&T::describe()) =>
            {
                Some(Stated {
                    line: instance.line,
                    name: format!("{}.{}", instance.name, port.name),
                    unit: &port.unit,
                    value: T::from_bytes(initial)?,
                })
            }
            _ => None,
        })
    }
}

/// Whether a new value of an import lets it iterate.
fn has_trigger(instance: &InstanceConfig) -> bool {
    let mut bindings = instance.bindings.iter();
    bindings.any(|binding| {
        matches!(
            binding,
            Binding::Import {
                source: Some(_),
                trigger: true,
                ..
            }
        )
    })
}

/// Whether an import of this type is bound.
fn imports(instance: &InstanceConfig, of: &str) -> bool {
    let bindings = instance.schema.ports.iter().zip(&instance.bindings);
    let mut of_type = bindings.filter(|(port, _)| port.value_type.name == of);
    of_type.any(|(_, binding)| matches!(binding, Binding::Import { source: Some(_), .. }))
}

/// The sources of the imports that measure the surroundings.
fn sensors(instance: &InstanceConfig) -> impl Iterator<Item = ImportSource> {
    let bindings = instance.schema.ports.iter().zip(&instance.bindings);
    bindings.filter_map(|(port, binding)| match (&port.role, binding) {
        (
            Role::Import,
            Binding::Import {
                source: Some(source), ..
            },
        ) => {
            let measures = Checks::of(&port.value_type).is_some_and(|checks| checks.repeats.is_some());
            measures.then_some(*source)
        }
        _ => None,
    })
}

/// What is to be said of a limit that is above another one.
fn exceeded(own: &Stated<'_, f64>, limit: &Stated<'_, f64>, consequence: &str) -> Option<String> {
    (own.value > limit.value * SAME_LIMIT).then(|| {
        format!(
            "line {}: {own}, and {limit} in line {}: {consequence}. Lower that of the schema",
            own.line, limit.line
        )
    })
}

/// Whether both are circles of one radius, or convex areas with the same corners, whichever is the first.
fn is_same_outline(one: &Footprint, other: &Footprint) -> bool {
    if one.points.is_empty() && other.points.is_empty() {
        return (one.radius - other.radius).abs() <= MEASURING_ERROR;
    }
    let has = |of: &Footprint, a: &Point2D| {
        of.points
            .iter()
            .any(|b| libm::hypot(a.x - b.x, a.y - b.y) <= MEASURING_ERROR)
    };
    one.points.iter().all(|corner| has(other, corner)) && other.points.iter().all(|corner| has(one, corner))
}

fn pose(pose: &Pose2D) -> String {
    let Pose2D { x, y, theta } = pose;
    format!("({x} m, {y} m, {:.0} deg)", theta.to_degrees())
}
