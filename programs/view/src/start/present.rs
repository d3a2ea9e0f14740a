//! How an application stands, in a few words: who acts, its battery, its mission. It asks and decides nothing.

use jde_link::Remote;
use jde_link::message::VariableInfo;
use jde_timeline::acting;
use jde_types::{BatteryState, Mission, Value};

/// How an application stands.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Present {
    /// The winners, from the roots down; or why there are none.
    pub(super) acting: String,
    /// The charge or the voltage; empty if no schema exports it.
    pub(super) battery: String,
    /// The progress; empty without a mission.
    pub(super) mission: String,
}

impl Present {
    /// Asks the application. Waits for its answers.
    pub(super) fn of(remote: &Remote) -> Self {
        let acting = match remote.hierarchy() {
            Err(_) => "no answer".to_owned(),
            Ok(snapshot) => match (acting(&snapshot), snapshot.standstill) {
                (_, Some(reason)) => format!("stands still: {reason}"),
                (names, None) if names.is_empty() => "nobody".to_owned(),
                (names, None) => names.join(" > "),
            },
        };
        let variables = remote.variables(false).unwrap_or_default();
        let battery = newest::<BatteryState>(remote, &variables);
        let mission = newest::<Mission>(remote, &variables);
        Self {
            acting,
            battery: battery.map_or_else(String::new, |battery| battery_text(&battery)),
            mission: mission.map_or_else(String::new, |mission| mission_text(&mission)),
        }
    }
}

/// The newest value of the first export of a type.
fn newest<T: Value>(remote: &Remote, variables: &[VariableInfo]) -> Option<T> {
    let name = T::describe().name;
    let mut exports = variables.iter().filter(|variable| variable.access == "export");
    let sample = remote
        .get(&exports.find(|variable| variable.type_name == name)?.name)
        .ok()?;
    T::from_bytes(sample.bytes.as_deref()?)
}

/// A charge that is not measured is not a number.
fn battery_text(battery: &BatteryState) -> String {
    match (battery.percentage, battery.voltage) {
        (charge, _) if charge.is_finite() => format!("{:.0} %", charge * 100.0),
        (_, voltage) if voltage.is_finite() => format!("{voltage:.1} V"),
        (_, _) => String::new(),
    }
}

fn mission_text(mission: &Mission) -> String {
    let state = match mission.state {
        0 => "under way",
        1 => "done",
        2 => "failed",
        _ => "unknown",
    };
    match (mission.total, mission.note.as_str()) {
        (0, "") => state.to_owned(),
        (0, note) => format!("{state}: {note}"),
        (total, _) => format!("{state}, {} of {total}", mission.reached),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_charge_is_a_share_or_else_a_voltage() {
        let battery = |percentage, voltage| BatteryState {
            percentage,
            voltage,
            ..BatteryState::default()
        };
        assert_eq!(battery_text(&battery(0.42, 12.0)), "42 %");
        assert_eq!(battery_text(&battery(f32::NAN, 12.04)), "12.0 V");
        assert_eq!(battery_text(&battery(f32::NAN, f32::NAN)), "");
    }

    #[test]
    fn a_mission_counts_its_targets() {
        let mission = |state, reached, total| Mission {
            state,
            reached,
            total,
            ..Mission::default()
        };
        assert_eq!(mission_text(&mission(0, 1, 3)), "under way, 1 of 3");
        assert_eq!(mission_text(&mission(1, 0, 0)), "done");
    }
}
