//! How long values and commands are valid (R19, R7). It follows from the file and the types alone and is fixed at
//! the start, so no period that is written later lengthens it.

use crate::period::format_setting;
use jde_abi::describe::{Role, Validity};
use jde_core::Nanos;

use super::{Application, Binding, InstanceConfig};

/// The periods for which a value is valid unless its type states a time. One late or skipped turn is usual on a
/// machine without real-time scheduling; two in a row are not.
const VALUE_PERIODS: Nanos = 3;
/// No value is valid for a shorter time because of its periods, ns: a busy machine may delay a thread that long.
const MIN_VALIDITY: Nanos = 60_000_000;
/// The periods for which a command is in force at least, so that a schema that is slow by design is not silent.
const COMMAND_PERIODS: Nanos = 2;
/// The validity of a lasting value.
const LASTING_VALIDITY: Nanos = Nanos::MAX;

impl InstanceConfig {
    /// Returns how long a value of an export is valid after its publication, ns; [`Nanos::MAX`] if it is lasting,
    /// and for other ports.
    #[must_use]
    pub fn validity_ns(&self, port: usize) -> Nanos {
        match self.schema.ports[port].role {
            Role::Export { validity } => match validity {
                Validity::Periods => self.period_ns.saturating_mul(VALUE_PERIODS).max(MIN_VALIDITY),
                Validity::Time(ns) => ns,
                Validity::Lasting => LASTING_VALIDITY,
            },
            _ => LASTING_VALIDITY,
        }
    }

    /// Returns how long a command of the schema is in force at least, ns, if its period is `period`. A longer period
    /// than that of the file does not lengthen it.
    #[must_use]
    #[inline]
    pub fn command_validity_ns(&self, period: Nanos) -> Nanos {
        period.min(self.period_ns).saturating_mul(COMMAND_PERIODS)
    }
}

impl Application {
    /// Warns of commands that are in force for longer than their driver states, because their schema is slow, and
    /// of values that end before the next one is due.
    pub(super) fn warn_of_validity(&self) -> impl Iterator<Item = String> {
        self.instances
            .iter()
            .flat_map(|instance| self.slow_commands(instance).chain(short_values(instance)))
    }

    fn slow_commands(&self, instance: &InstanceConfig) -> impl Iterator<Item = String> {
        let least = instance.command_validity_ns(instance.period_ns);
        instance.bindings.iter().filter_map(move |binding| {
            let Binding::Actuator {
                target: Some(command),
            } = binding
            else {
                return None;
            };
            let driver = &self.instances[command.instance].schema;
            let Role::Command { validity_ns, .. } = driver.ports[command.port].role else {
                return None;
            };
            (least > validity_ns).then(|| {
                format!(
                    "line {}: a command of schema `{}` to `{}` is in force for {}, two of its periods, and for {} by its driver: \
                     if it falls silent, the actuator goes on for so long. Shorten its `period`",
                    instance.line,
                    instance.name,
                    self.variable_name(*command),
                    format_setting(least),
                    format_setting(validity_ns),
                )
            })
        })
    }
}

/// The exports whose type states a shorter time than the period of the file.
fn short_values(instance: &InstanceConfig) -> impl Iterator<Item = String> {
    let ports = instance.schema.ports.iter();
    ports.filter_map(|port| match port.role {
        Role::Export {
            validity: Validity::Time(validity),
        } if validity < instance.period_ns => Some(format!(
            "line {}: a value of `{}.{}` is valid for {}, and `period` is {}: it ends before the next one is due",
            instance.line,
            instance.name,
            port.name,
            format_setting(validity),
            format_setting(instance.period_ns)
        )),
        _ => None,
    })
}
