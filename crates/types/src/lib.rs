//! The standard interfaces of sensors and actuators.
