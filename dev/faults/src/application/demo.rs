//! Safe navigation with additional schemas that misbehave on command: a sibling of the father, one between the
//! father and the child that drives straight on, one between the laser and the child that avoids obstacles;
//! and either an arm or a guard. A guard judges the commands of one actuator, and the sibling would command two.

use anyhow::{Context as _, Result};

use super::{FaultySchema, Root, TestApplication};
use crate::plan::TargetKind;
use crate::rng::Rng;

/// Places near obstacles, m, from which a guarded robot starts.
const START_PLACES: [(f64, f64); 4] = [(3.55, 1.6), (0.5, 5.55), (5.8, 7.5), (12.0, 6.4)];

/// The added schemas. `leader` is an ordinary father that passes its target to `goon`; `drifter` wins from
/// time to time.
const ADDED: &str = r#"
[schemas.drifter]
type = "fault/motor"
period = "30ms"
on = 0.4
speed = 0.15
turn = 0.3
actuators = { base = "pioneer.velocity" }

[schemas.leader]
type = "fault/motor"
period = "40ms"
children = { a = "goon" }

[schemas.eye]
type = "fault/eye"
imports = { input = "pioneer.laser" }
"#;

/// The arm.
const ARM: &str = r#"
[schemas.lifter]
type = "fault/motor"
speed = 0.1
actuators = { base = "gripper.velocity" }

[schemas.gripper]
type = "fault/device"
"#;

/// The guard. It is to judge commands that are fast enough to be dangerous.
const GUARD: &str = r#"
[schemas.guard]
type = "guard/footprint"
imports = { laser = "pioneer.laser", pose = "pioneer.odometry" }
footprint = { radius = 0.25 }
mount = { x = 0.018 }
"#;

/// Faults follow each other quickly, and the host must not give up a schema permanently because of that.
pub(super) const RESTART_SETTINGS: &str =
    "restart = { back-off = \"20ms\", limit = 1000 }\nhang = \"300ms\"\n";

pub(super) fn build(root: &Root, rng: &mut Rng) -> Result<TestApplication> {
    let path = root.0.join("apps/safe-navigation.toml");
    let text = std::fs::read_to_string(&path).with_context(|| format!("cannot read {}", path.display()))?;
    let mut table: toml::Table = text.parse().context("the demonstration is not TOML")?;
    table.remove("mission");
    table.insert(
        "roots".to_owned(),
        toml::Value::from(vec!["teleop", "drifter", "example"]),
    );
    let is_guarded = rng.one_in(2);
    let added = if is_guarded {
        let guard = toml::Table::from_iter([("guard".to_owned(), "guard".into())]);
        table.insert("root".to_owned(), guard.into());
        format!("{}{GUARD}", with_restarts(ADDED))
    } else {
        with_restarts(&format!("{ADDED}{ARM}"))
    };
    let isolated: Vec<&str> = ["drifter", "lifter", "leader", "eye"]
        .into_iter()
        .filter(|_| rng.one_in(3))
        .collect();
    let off = rng.between(800, 2500) as f64 / 1e3;
    let mut added: toml::Table = added.parse().context("the added schemas are not TOML")?;
    let added = section(&mut added)?;
    for (name, schema) in added.iter_mut() {
        let schema = schema.as_table_mut().context("a schema is a table")?;
        if name == "drifter" {
            schema.insert("off".to_owned(), off.into());
            if is_guarded {
                for (key, value) in [
                    ("on", rng.between(400, 3000) as f64 / 1e3),
                    ("speed", 0.8),
                    ("turn", 1.0),
                ] {
                    schema.insert(key.to_owned(), value.into());
                }
            } else {
                let children = toml::Table::from_iter([("e".to_owned(), "lifter".into())]);
                schema.insert("children".to_owned(), children.into());
            }
        }
        if isolated.contains(&name.as_str()) {
            schema.insert("isolate".to_owned(), isolation());
        }
    }
    let schemas = section(&mut table)?;
    schemas.extend(std::mem::take(added));
    let example = schemas.get_mut("example").and_then(toml::Value::as_table_mut);
    let example = example.context("the demonstration has no `example`")?;
    // 0: the route repeats without end.
    example.insert("rounds".to_owned(), 0.into());
    set(example, "children", "cruise", "leader")?;
    if is_guarded {
        let (x, y) = rng.pick(&START_PLACES);
        let start = toml::Value::from(vec![x, y, rng.between(0, 628) as f64 / 1e2]);
        let pioneer = schemas.get_mut("pioneer").and_then(toml::Value::as_table_mut);
        let pioneer = pioneer.context("the demonstration has no `pioneer`")?;
        pioneer.insert("start".to_owned(), vec![start].into());
    }
    let vff = schemas.get_mut("vff").and_then(toml::Value::as_table_mut);
    set(
        vff.context("the demonstration has no `vff`")?,
        "imports",
        "laser",
        "eye.laser",
    )?;
    let faulty = |name: &str, kind| FaultySchema {
        name: name.to_owned(),
        kind,
        isolated: isolated.contains(&name),
    };
    let mut schemas = vec![
        faulty("drifter", TargetKind::Motor),
        faulty("leader", TargetKind::Motor),
        faulty("eye", TargetKind::Eye),
        faulty("pioneer", TargetKind::Robot),
    ];
    if !is_guarded {
        schemas.push(faulty("lifter", TargetKind::Motor));
        schemas.push(faulty("gripper", TargetKind::Device));
    }
    Ok(TestApplication {
        text: toml::to_string(&table).context("the application is no longer TOML")?,
        path,
        schemas,
    })
}

/// Isolation in a process of its own with little memory, so that using all of it takes little time.
pub(super) fn isolation() -> toml::Value {
    toml::Table::from_iter([("memory".to_owned(), "64 MB".into())]).into()
}

/// Adds the restart and hang settings of a campaign to every schema.
pub(super) fn with_restarts(text: &str) -> String {
    let lines = text.lines().map(|line| {
        if line.starts_with("[schemas.") {
            format!("{line}\n{RESTART_SETTINGS}")
        } else {
            format!("{line}\n")
        }
    });
    lines.collect()
}

fn section(table: &mut toml::Table) -> Result<&mut toml::Table> {
    let schemas = table.get_mut("schemas").and_then(toml::Value::as_table_mut);
    schemas.context("the application has no schemas")
}

fn set(schema: &mut toml::Table, key: &str, role: &str, to: &str) -> Result<()> {
    let roles = schema.get_mut(key).and_then(toml::Value::as_table_mut);
    let role = roles.and_then(|roles| roles.get_mut(role));
    *role.with_context(|| format!("the demonstration has no such role in its {key}"))? = to.into();
    Ok(())
}
