//! A hundred schemas: a robot, an arm, perceptive schemas that read each other, and motor schemas in deep and
//! wide groups, under all policies and absences, some in processes of their own.

use std::fmt::Write as _;

use super::demo::{isolation, with_restarts};
use super::{FaultySchema, Root, TestApplication};
use crate::plan::TargetKind;
use crate::rng::Rng;

/// The number of schemas.
pub(crate) const COUNT: usize = 100;
const EYE_COUNT: usize = 6;
const ROOT_COUNT: usize = 3;
/// The robot, the arm and the eyes are not motor schemas.
const MOTOR_COUNT: usize = COUNT - EYE_COUNT - 2;
/// The largest number of fathers above a schema.
const MAX_DEPTH: usize = 7;
/// The roles of the type for children of one group.
const ROLES: [&str; 4] = ["a", "b", "c", "d"];
const ARM_ROLES: [&str; 2] = ["e", "f"];
/// One in this number of motor schemas runs in a process of its own.
const ISOLATED_ONE_IN: u64 = 20;

/// The device that a schema's subtree commands.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Side {
    Base,
    Arm,
}

struct Node {
    side: Side,
    depth: usize,
    children: Vec<(&'static str, usize)>,
}

pub(super) fn build(root: &Root, rng: &mut Rng) -> TestApplication {
    let nodes = grow(rng);
    let roots: Vec<String> = (0..ROOT_COUNT).map(name).collect();
    let executor = rng.pick(&["threads", "threads", "pool"]);
    let mut text = format!(
        "executor = \"{executor}\"\nname = \"hundred\"\nroots = {roots:?}\nroot = {}\n",
        group(rng, None)
    );
    text += "[schemas.pioneer]\ntype = \"sim/robot\"\nworld = \"../worlds/corridor.toml\"\n";
    let mut body = String::from("[schemas.arm]\ntype = \"fault/device\"\n");
    let mut schemas = vec![faulty_schema("arm", TargetKind::Device, false)];
    for eye in 0..EYE_COUNT {
        let input = if eye < 2 {
            "pioneer.laser".to_owned()
        } else {
            format!("eye{}.laser", rng.between(0, eye as u64 - 1))
        };
        let isolated = rng.one_in(6);
        let _ = writeln!(
            body,
            "[schemas.eye{eye}]\ntype = \"fault/eye\"\nimports = {{ input = \"{input}\" }}"
        );
        let _ = writeln!(body, "period = \"{}ms\"", rng.pick(&[30, 50, 80]));
        isolate(&mut body, isolated);
        schemas.push(faulty_schema(&format!("eye{eye}"), TargetKind::Eye, isolated));
    }
    for (number, node) in nodes.iter().enumerate() {
        let isolated = rng.one_in(ISOLATED_ONE_IN);
        motor(&mut body, rng, number, node);
        isolate(&mut body, isolated);
        schemas.push(faulty_schema(&name(number), TargetKind::Motor, isolated));
    }
    text += &with_restarts(&body);
    TestApplication {
        text,
        path: root.0.join("apps/hundred.toml"),
        schemas,
    }
}

/// Builds the hierarchy: a random schema with a free role gets the next child. Only the roots have a second
/// group, which commands the arm, so that no two schemas that can win together command the same device.
fn grow(rng: &mut Rng) -> Vec<Node> {
    let node = |side, depth| Node {
        side,
        depth,
        children: Vec::new(),
    };
    let mut nodes: Vec<Node> = (0..ROOT_COUNT).map(|_| node(Side::Base, 0)).collect();
    while nodes.len() < MOTOR_COUNT {
        let father = rng.between(0, nodes.len() as u64 - 1) as usize;
        let Node { side, depth, .. } = nodes[father];
        let to_arm = father < ROOT_COUNT && rng.one_in(3);
        let roles: &[&str] = if to_arm { &ARM_ROLES } else { &ROLES };
        let taken = |role: &&&str| !nodes[father].children.iter().any(|(other, _)| other == *role);
        let Some(role) = roles.iter().find(taken).copied().filter(|_| depth < MAX_DEPTH) else {
            continue;
        };
        let child = nodes.len();
        nodes[father].children.push((role, child));
        nodes.push(node(if to_arm { Side::Arm } else { side }, depth + 1));
    }
    nodes
}

fn motor(body: &mut String, rng: &mut Rng, number: usize, node: &Node) {
    let _ = writeln!(body, "[schemas.{}]\ntype = \"fault/motor\"", name(number));
    let _ = writeln!(body, "period = \"{}ms\"", rng.pick(&[10, 20, 25, 50]));
    let (on, off) = (rng.between(100, 1500), rng.between(0, 3));
    let off = if off == 0 { 0 } else { rng.between(50, 700) };
    let _ = writeln!(body, "on = {:.3}\noff = {:.3}", on as f64 / 1e3, off as f64 / 1e3);
    let _ = writeln!(body, "phase = {:.3}", rng.between(0, 2000) as f64 / 1e3);
    let _ = writeln!(body, "urge = {}.0", rng.between(0, 9));
    if rng.one_in(8) {
        let _ = writeln!(
            body,
            "imports = {{ needs = \"eye{}.laser\" }}",
            rng.between(0, EYE_COUNT as u64 - 1)
        );
    }
    if node.children.is_empty() {
        let device = match node.side {
            Side::Base => "pioneer",
            Side::Arm => "arm",
        };
        let _ = writeln!(body, "actuators = {{ base = \"{device}.velocity\" }}");
        let _ = writeln!(body, "speed = {:.2}", rng.between(5, 30) as f64 / 1e2);
        let _ = writeln!(body, "turn = {:.2}", rng.between(0, 60) as f64 / 1e2 - 0.3);
        return;
    }
    let roles: Vec<String> = node
        .children
        .iter()
        .map(|(role, child)| format!("{role} = \"{}\"", name(*child)))
        .collect();
    let _ = writeln!(body, "children = {{ {} }}", roles.join(", "));
    for (name, all) in [("base", &ROLES[..]), ("arm", &ARM_ROLES[..])] {
        let first = node.children.iter().find(|(role, _)| all.contains(role));
        if let Some((role, _)) = first {
            let _ = writeln!(body, "groups.{name} = {}", group(rng, Some(role)));
        }
    }
}

/// Returns a group's policy and absence. The roots have no father that could arbitrate, and no role as a fallback.
fn group(rng: &mut Rng, fallback: Option<&str>) -> String {
    let policies = [
        "\"priority\"",
        "\"urgency\"",
        "\"sticky\", dwell = \"150ms\", hysteresis = 1.0",
        "\"round-robin\", turn = \"200ms\"",
        "\"father\"",
    ];
    let policies = &policies[..if fallback.is_some() { 5 } else { 4 }];
    let policy = rng.pick(policies);
    let absence = match (rng.between(0, 2), fallback) {
        (0, Some(role)) => format!("\"fallback\", fallback = \"{role}\""),
        (1, _) => "\"hold\", hold = \"100ms\"".to_owned(),
        _ => "\"brake\"".to_owned(),
    };
    format!("{{ policy = {policy}, absence = {absence} }}")
}

fn isolate(body: &mut String, isolated: bool) {
    if isolated {
        let _ = writeln!(body, "isolate = {}", isolation());
    }
}

fn faulty_schema(name: &str, kind: TargetKind, isolated: bool) -> FaultySchema {
    FaultySchema {
        name: name.to_owned(),
        kind,
        isolated,
    }
}

fn name(number: usize) -> String {
    format!("m{number:02}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_are_a_hundred_schemas_and_other_seeds_group_them_otherwise() {
        let text = |seed| build(&Root::usual(), &mut Rng::new(seed, "test")).text;
        assert_eq!(text(1).matches("\n[schemas.").count(), COUNT);
        assert_eq!(text(1), text(1));
        assert_ne!(text(1), text(2));
    }
}
