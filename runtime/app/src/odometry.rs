//! By which odometry a driver's sensors are compared with the motion of their base, so that one that repeats itself is
//! noticed.

use jde_abi::describe::{Kind, Role};
use jde_core::SchemaId;
use jde_types::{Checks, Odometry, Value};

use crate::{Application, InstanceConfig, InstancePort};

impl Application {
    /// Returns the odometry of the base on which a driver's sensors are: that of the driver itself, or else the only
    /// one of all drivers. `None` for other schemas, and if there is none or there
    /// are several.
    #[must_use]
    pub fn odometry_of(&self, instance: SchemaId) -> Option<InstancePort> {
        let odometry = Odometry::describe();
        let of = |instance: SchemaId| {
            let schema = &self.instances[instance].schema;
            let mut ports = schema.ports.iter();
            let port = ports.position(|port| {
                matches!(port.role, Role::Export { .. }) && port.value_type.name == odometry.name
            })?;
            Some(InstancePort { instance, port })
        };
        let is_driver = |instance: &SchemaId| self.instances[*instance].schema.kind == Kind::Driver;
        if !is_driver(&instance) {
            return None;
        }
        if let Some(own) = of(instance) {
            return Some(own);
        }
        let mut all = self.instances.ids().filter(is_driver).filter_map(of);
        all.next().filter(|_| all.next().is_none())
    }

    /// Warns of drivers with sensors of the surroundings that no odometry belongs to.
    pub(crate) fn warn_of_sensors(&self) -> impl Iterator<Item = String> {
        // Where nothing moves, sensors may repeat themselves.
        let moves = |instance: &InstanceConfig| {
            let mut ports = instance.schema.ports.iter();
            ports.any(|port| matches!(port.role, Role::Command { .. }))
        };
        let drivers = self.instances.entries();
        let moves = self.instances.iter().any(moves);
        drivers.filter(move |_| moves).filter_map(|(number, instance)| {
            let sensor = sensor(instance).filter(|_| instance.schema.kind == Kind::Driver)?;
            if self.odometry_of(number).is_some() {
                return None;
            }
            let InstanceConfig { line, name, .. } = instance;
            Some(format!(
                "line {line}: nothing notices if `{name}.{sensor}` repeats itself while the base moves: no driver, or more than one, \
                 exports an odometry. Use a driver that exports both, or one base in each application"
            ))
        })
    }
}

/// Returns the first export that measures the surroundings.
fn sensor(instance: &InstanceConfig) -> Option<&str> {
    let mut ports = instance.schema.ports.iter();
    let sensor = ports.find(|port| {
        let checks = Checks::of(&port.value_type);
        matches!(port.role, Role::Export { .. }) && checks.is_some_and(|checks| checks.repeats.is_some())
    });
    sensor.map(|port| port.name.as_str())
}
