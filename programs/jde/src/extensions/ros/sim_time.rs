//! `use_sim_time`, the parameter by which every node of ROS 2 chooses its clock: here that of the drivers of ROS 2 that state
//! none.

use jde_link::Subject as _;
use jde_link::message::Action;
use jde_link_host::Running;
use serde_json::{Value, json};

use super::OPERATOR;
use super::parameters::BOOL;

/// Its name.
pub(crate) const SIM_TIME: &str = "use_sim_time";
/// The modulation of a driver that it sets, and its choices.
pub(crate) const CLOCK: &str = "clock";
const WALL_TIME: u64 = 0;
const FOLLOWED_TIME: u64 = 1;

/// Whether the time is that of `/clock`.
#[derive(Clone, Debug, Default)]
pub(crate) struct SimTime {
    /// At the start, and then as it was set.
    pub(crate) is_simulated: bool,
    /// The schemas whose clock follows it.
    pub(crate) schemas: Vec<String>,
}

impl SimTime {
    /// Its value as that of a parameter.
    pub(super) fn value(&self) -> Value {
        json!({ "type": BOOL, "bool_value": self.is_simulated })
    }

    /// Its descriptor.
    pub(super) fn descriptor() -> Value {
        json!({
            "name": SIM_TIME,
            "type": BOOL,
            "description": "Whether the drivers of ROS 2 that state no clock take the time of /clock for the stamps of messages. \
                            Schemas and devices run in the time of this machine in any case.",
        })
    }

    /// Lets the drivers follow `/clock`, or the clock of this machine.
    ///
    /// # Errors
    /// The value is no bool, or a driver refuses it.
    pub(super) fn set(&mut self, subject: &Running, value: &Value) -> Result<(), String> {
        if value["type"] != BOOL {
            return Err(format!("`{SIM_TIME}` is a bool"));
        }
        let is_simulated = value["bool_value"] == true;
        for schema in &self.schemas {
            let action = Action::Modulate {
                schema: schema.clone(),
                variable: CLOCK.to_owned(),
                value: json!(if is_simulated { FOLLOWED_TIME } else { WALL_TIME }),
            };
            subject.act(OPERATOR, &action).map_err(|refusal| refusal.error)?;
        }
        self.is_simulated = is_simulated;
        Ok(())
    }
}
