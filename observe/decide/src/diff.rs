//! Describes the differences between two applications for the user.

use jde_log::RecordedHierarchy;

/// Describes how the second application differs from the first.
pub(super) fn diff_hierarchies(then: &RecordedHierarchy, now: &RecordedHierarchy) -> Vec<String> {
    let mut differences = Vec::new();
    for member in &then.schemas {
        match now.schemas.iter().find(|other| other.name == member.name) {
            None => differences.push(format!(
                "`{}` ({}) is no longer in the application",
                member.name, member.type_name
            )),
            Some(other) if other.type_name != member.type_name => differences.push(format!(
                "`{}` is a {}, and was a {}",
                member.name, other.type_name, member.type_name
            )),
            Some(other) if other.ports != member.ports => {
                differences.push(format!(
                    "`{}` has other ports: {}",
                    member.name,
                    ports(&member.ports, &other.ports)
                ));
            }
            Some(_) => {}
        }
    }
    for member in &now.schemas {
        if !then.schemas.iter().any(|other| other.name == member.name) {
            differences.push(format!("`{}` ({}) is new", member.name, member.type_name));
        }
    }
    for group in &then.groups {
        match now.groups.iter().find(|other| other.name == group.name) {
            None => differences.push(format!("the group {} no longer exists", group.name)),
            Some(other) if other.members != group.members => differences.push(format!(
                "the candidates of {} are {}, and were {}",
                group.name,
                other.members.join(", "),
                group.members.join(", ")
            )),
            Some(_) => {}
        }
    }
    for group in &now.groups {
        if !then.groups.iter().any(|other| other.name == group.name) {
            differences.push(format!("the group {} is new", group.name));
        }
    }
    differences
}

fn ports(then: &[String], now: &[String]) -> String {
    let missing = |names: &[String], others: &[String], word: &str| {
        let names: Vec<_> = names
            .iter()
            .filter(|port| !others.contains(port))
            .cloned()
            .collect();
        (!names.is_empty()).then(|| format!("{word} {}", names.join(", ")))
    };
    let parts = [missing(now, then, "with"), missing(then, now, "without")];
    let parts: Vec<_> = parts.into_iter().flatten().collect();
    if parts.is_empty() {
        "in another order".to_owned()
    } else {
        parts.join(" and ")
    }
}
