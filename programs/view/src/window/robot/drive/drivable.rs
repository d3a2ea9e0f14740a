//! The schemas for driving by hand: those that command the chosen body, and never those of another one.

use eframe::egui::{self, Ui};
use jde_link::message::SchemaInfo;

use crate::session::WindowSession;

/// The types of the schemas that drive a base and turn a head.
const BASE: &str = "teleop/base";
const HEAD: &str = "teleop/head";

/// The schemas for driving one body by hand.
pub(super) struct DrivableSchemas<'a> {
    pub(super) base: Option<&'a SchemaInfo>,
    pub(super) head: Option<&'a SchemaInfo>,
}

impl<'a> DrivableSchemas<'a> {
    /// Finds the schemas for `body`, among all schemas and for all `bodies`.
    pub(super) fn of(all: &'a [SchemaInfo], body: &str, bodies: &[String]) -> Self {
        let of_type =
            |type_name: &'static str| all.iter().filter(move |schema| schema.type_name == type_name);
        let of_body =
            |type_name| of_type(type_name).find(|schema| commanded(schema).any(|owner| owner == body));
        // A filter of speeds may be between the schema and the body. With a single body, it cannot belong to
        // another.
        let only_base = || of_type(BASE).next().filter(|_| bodies.len() < 2);
        // A head may have its own driver, which does not show the body that it is mounted on.
        let unowned_head = || {
            of_type(HEAD)
                .find(|schema| !commanded(schema).any(|owner| bodies.iter().any(|body| body == owner)))
        };
        Self {
            base: of_body(BASE).or_else(only_base),
            head: of_body(HEAD).or_else(unowned_head),
        }
    }
}

/// The schemas that a schema commands.
fn commanded(schema: &SchemaInfo) -> impl Iterator<Item = &str> {
    let actuators = schema.ports.iter().filter(|port| port.role == "actuator");
    actuators.filter_map(|port| Some(port.variable.as_deref()?.split_once('.')?.0))
}

/// Shows how to add the missing schemas.
pub(super) fn advice(ui: &mut Ui, session: &WindowSession, body: &str) {
    if body.is_empty() {
        ui.weak("this application has no schema that drives");
        return;
    }
    let roots = session
        .schemas()
        .groups
        .iter()
        .find(|group| group.father.is_none());
    let roots = roots.map_or(&[][..], |group| &group.members);
    let mut names = vec!["\"teleop\"".to_owned()];
    names.extend(roots.iter().map(|root| format!("\"{root}\"")));
    // Limits of the velocity have its type too.
    let command = session.variables().iter().find(|variable| {
        variable.owner == body
            && variable.access == "command"
            && variable.type_name == "geometry_msgs/msg/Twist"
    });
    let command = command.map_or_else(|| format!("{body}.velocity"), |command| command.name.clone());
    let lines = format!(
        "roots = [{}]\n\n[schemas.teleop]\ntype      = \"teleop/base\"\nactuators = {{ base = \"{command}\" }}\n",
        names.join(", ")
    );
    ui.label("This application cannot be driven by hand. Add these lines to its file:");
    ui.add(
        egui::TextEdit::multiline(&mut lines.as_str())
            .code_editor()
            .desired_rows(5)
            .desired_width(f32::INFINITY),
    );
    if ui.button("Copy").on_hover_text("Copy the lines").clicked() {
        ui.ctx().copy_text(lines);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn schema(name: &str, type_name: &str, commands: &str) -> SchemaInfo {
        let info = serde_json::json!({
            "name": name, "type": type_name, "kind": "motor", "doc": "", "father": null, "group": null, "period_s": 0.1,
            "budget_s": 0.01, "children": [],
            "ports": [{ "name": "base", "role": "actuator", "type": "geometry_msgs/msg/Twist", "doc": "", "unit": "",
                        "range": {}, "fixed": false, "variable": commands }],
        });
        serde_json::from_value(info).expect("the description is valid")
    }

    fn found<'a>(all: &'a [SchemaInfo], body: &str, bodies: &[&str]) -> [Option<&'a str>; 2] {
        let bodies: Vec<_> = bodies.iter().map(|body| (*body).to_owned()).collect();
        let DrivableSchemas { base, head } = DrivableSchemas::of(all, body, &bodies);
        [base, head].map(|schema| schema.map(|schema| schema.name.as_str()))
    }

    #[test]
    fn each_of_two_bodies_is_driven_only_by_its_own_schemas() {
        let both = ["anna", "bert"];
        let all = [
            schema("of_anna", BASE, "anna.velocity"),
            schema("head_of_anna", HEAD, "anna.pan_tilt"),
        ];
        assert_eq!(
            found(&all, "anna", &both),
            [Some("of_anna"), Some("head_of_anna")]
        );
        assert_eq!(found(&all, "bert", &both), [None, None]);
    }

    #[test]
    fn a_single_body_may_be_driven_through_a_filter_and_a_head_may_have_its_own_driver() {
        let all = [
            schema("manual", BASE, "filter.velocity"),
            schema("gaze", HEAD, "camera_mount.pan_tilt"),
        ];
        assert_eq!(found(&all, "anna", &["anna"]), [Some("manual"), Some("gaze")]);
        assert_eq!(found(&all, "anna", &["anna", "bert"]), [None, Some("gaze")]);
    }
}
