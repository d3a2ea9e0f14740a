//! Several levels of roots, fathers whose children the file names, and the warning about roots that exclude
//! each other without need.

use std::time::Duration;

use jde_core::Policy;

use crate::catalogue::{application, check};

const ROOTS: &str = r#"roots   = ["teleop", "example"]"#;
const MISSION: &str = r#"mission = "example.mission""#;

/// Returns edits that replace the roots by `roots` and insert the schemas `more`.
fn with<'a>(roots: &'a str, more: &'a str) -> [(&'a str, &'a str); 3] {
    [(ROOTS, ""), (MISSION, roots), ("[schemas.look]", more)]
}

const SECOND: &str = r#"
[schemas.second]
type  = "sim/robot"
world = "office.toml"
start = [4.0, 2.0, "90deg"]

[schemas.other]
type      = "teleop"
actuators = { base = "second.velocity" }

[schemas.look]"#;

const CREW: &str = r#"
[schemas.second]
type  = "sim/robot"
world = "office.toml"
start = [4.0, 2.0, "90deg"]

[schemas.crew]
type     = "crew"
children = { walks = "other", waits = "third" }
groups.legs = { members = ["waits", "walks"], policy = "round-robin", turn = "1s", absence = "fallback", fallback = "walks" }

[schemas.other]
type      = "teleop"
actuators = { base = "second.velocity" }

[schemas.third]
type      = "teleop"
actuators = { base = "second.velocity" }

[schemas.look]"#;

#[test]
fn r13_each_level_of_roots_is_a_group_of_its_own() {
    let roots = r#"
[roots.left]
members = ["teleop", "example"]
policy  = "urgency"
[roots.right]
members = ["other"]"#;
    let application = application(&with(roots, SECOND));
    let levels: Vec<_> = application
        .groups
        .iter()
        .filter(|group| group.father.is_none())
        .map(|group| (group.name.as_str(), group.members.len(), group.policy))
        .collect();
    let expected = [
        ("roots/left", 2, Policy::URGENCY),
        ("roots/right", 1, Policy::PRIORITY),
    ];
    assert_eq!(levels, expected);
    assert_eq!(application.warnings(), [""; 0]);
}

#[test]
fn r13_faults_of_a_level_are_reported() {
    check(
        &with(
            r#"
root = { policy = "urgency" }
[roots.left]
members = ["teleop", "other"]
[roots."no name"]
members = ["teleop"]
polcy   = "priority"
[roots.right]
policy  = "priority"
[roots]
else = 3"#,
            SECOND,
        ),
        r#"
apps/good.toml:5:1: `root` configures the one level of `roots = [...]`, and this file has several levels
    help: write the keys in each level, beside its `members`
apps/good.toml:8:8: `no name` cannot be the name of a level
    help: use 1 to 64 letters, digits, `_` and `-`
apps/good.toml:9:12: `roots` of the application names `teleop` twice
    help: remove one
apps/good.toml:10:1: unknown key `polcy` in level `no name` of `roots`
    help: did you mean `policy`?
apps/good.toml:11:8: level `right` of `roots` has no members, so nothing would ever start in it
    help: name its motor schemas, such as members = ["teleop", "example"]; the first wins a collision
apps/good.toml:14:8: `else` of `roots` must be a table, not a whole number
"#,
    );
}

#[test]
fn r7_members_of_two_levels_must_not_share_an_actuator() {
    check(
        &with(
            r#"
[roots.left]
members = ["teleop"]
[roots.right]
members = ["example", "other"]"#,
            SECOND,
        ),
        r#"
apps/good.toml:30:22: `teleop` and `stop` could command `pioneer.velocity` at the same time: the groups `roots/left` and `roots/right` have a winner each
    help: bind the command in only one of them, or let them compete in one group
"#,
    );
}

#[test]
fn roots_of_one_level_that_share_no_actuator_cause_a_warning() {
    let application = application(&with(r#"roots = ["teleop", "example", "other"]"#, SECOND));
    assert_eq!(
        application.warnings(),
        [
            "line 11: the roots `teleop` and `example` share no actuator with `other`, and only one of all acts at a time. If they \
             are to act at once, give each its own level: [roots.NAME] with members = [...]"
        ]
    );
}

#[test]
fn the_file_may_name_the_children_of_a_father() {
    let application = application(&with(r#"roots = ["teleop", "example", "crew"]"#, CREW));
    let crew = application.instance("crew").expect("the name is known");
    let group = application
        .groups
        .iter()
        .find(|group| group.father == Some(crew))
        .expect("a group of crew");
    let names: Vec<_> = group
        .members
        .iter()
        .map(|member| application.instances[*member].name.as_str())
        .collect();
    assert_eq!(
        (group.name.as_str(), names),
        ("crew/legs", vec!["third", "other"])
    );
    assert_eq!(group.policy, Policy::round_robin(Duration::from_secs(1)));
    let other = application.instance("other").expect("the name is known");
    assert_eq!(group.absence, jde_core::Absence::Fallback(other));
    let roles: Vec<_> = application.instances[crew]
        .schema
        .children
        .iter()
        .map(|child| child.name.as_str())
        .collect();
    assert_eq!(roles, ["waits", "walks"]);
}

#[test]
fn faults_of_children_that_the_file_names_are_reported() {
    let crew = CREW
        .replace(
            r#"members = ["waits", "walks"]"#,
            r#"members = ["waits", "wlaks"]"#,
        )
        .replace(
            "[schemas.other]",
            "groups.arms.policy = \"priority\"\ngroups.head.members = [\"waits\"]\n[schemas.other]",
        );
    check(
        &with(r#"roots = ["teleop", "example", "crew"]"#, &crew),
        r#"
apps/good.toml:47:37: `members` of group `legs` of schema `crew` names `wlaks`, which is not a child of it
    help: did you mean `walks`?
apps/good.toml:47:117: `fallback` of group `legs` of schema `crew` is `walks`, which is not a member of the group
    help: roles of this group: `waits`
apps/good.toml:49:8: schema `crew` has no group `arms`
    help: list its members: members = [...], of its `children`
apps/good.toml:50:24: `members` of group `head` of schema `crew` names `waits`, which is a member of `legs` already
    help: a child competes in one group: remove one
apps/good.toml:57:22: `other` and `third` could command `second.velocity` at the same time: the groups `crew/all` and `crew/legs` have a winner each
    help: bind the command in only one of them, or let them compete in one group
"#,
    );
    let childless = CREW.replace(r#"children = { walks = "other", waits = "third" }"#, "");
    check(
        &with(
            r#"roots = ["teleop", "example", "crew", "other", "third"]"#,
            &childless,
        ),
        r#"
apps/good.toml:44:10: schema `crew` has no children to wake
    help: name them, such as children = { left = "NAME", right = "NAME" }
apps/good.toml:47:28: `members` of group `legs` of schema `crew` names `waits`, which is not a child of it
apps/good.toml:47:37: `members` of group `legs` of schema `crew` names `walks`, which is not a child of it
"#,
    );
}
