//! The files that an agent may name, and what it runs in the simulator.

use std::fs;
use std::os::unix::fs::symlink;

use serde_json::json;

use super::Agent;
use crate::attached::Sandbox;
use crate::support::signal;

#[test]
fn files_outside_the_folder_do_not_exist_for_an_agent() {
    let sandbox = Sandbox::new();
    let folder = sandbox.folder().join("robot");
    fs::create_dir(&folder).expect("a folder");
    fs::write(sandbox.folder().join("secret.toml"), "password = 1").expect("a file");
    symlink(sandbox.folder().join("secret.toml"), folder.join("link.toml")).expect("a link");
    symlink(sandbox.folder(), folder.join("tests")).expect("a link");
    fs::write(folder.join("--all.toml"), "").expect("a file");
    let mut agent = Agent::start(&sandbox, &["--folder", folder.to_str().expect("UTF-8")]);
    for path in [
        "link.toml",
        "../secret.toml",
        "tests/secret.toml",
        "/etc/passwd",
        "/proc/self/environ",
    ] {
        for (tool, arguments) in [
            ("check", json!({"file": path})),
            ("test", json!({"paths": [path]})),
            ("experiment", json!({"file": path})),
            ("recording", json!({"recording": path})),
            ("report", json!({"recording": path})),
            ("why", json!({"recording": path, "question": "nobody"})),
        ] {
            let refusal = agent.refusal(tool, &arguments);
            assert!(refusal.contains("there is no file"), "{tool} {path}: {refusal}");
            assert!(!refusal.contains("password"), "{tool} {path}: {refusal}");
        }
    }
    let option = agent.refusal("check", &json!({"file": "--all.toml"}));
    assert!(option.contains("does not begin with `-`"), "{option}");
    fs::write(folder.join("faulty.toml"), "name = 1\n").expect("a file");
    let faulty = agent.call("check", &json!({"file": "faulty.toml"}));
    assert_eq!(faulty["is_usable"], false, "{faulty}");
    let shipped = agent.call("check", &json!({"file": "safe-navigation"}));
    assert_eq!(shipped["is_usable"], true, "{shipped}");
    assert!(
        shipped["application"]
            .as_str()
            .expect("a text")
            .contains("contracts"),
        "{shipped}"
    );
}

#[test]
fn an_agent_drives_in_the_simulator_until_it_cancels() {
    let sandbox = Sandbox::new();
    let folder = sandbox.folder().join("robot");
    fs::create_dir(&folder).expect("a folder");
    let application = crate::support::root().join("apps/safe-navigation.toml");
    let experiment = |seconds: u32, seeds: &str| {
        format!(
            "name = \"drive\"\napplication = {application:?}\nfor = \"{seconds}s\"\nmission = \"ignored\"\n\
             [axes]\nseeds = \"{seeds}\"\n[must.\"no collision\"]\nnever = \"collisions > 0\"\n"
        )
    };
    fs::write(folder.join("short.toml"), experiment(2, "1..3")).expect("a file");
    fs::write(folder.join("long.toml"), experiment(3000, "1..1000")).expect("a file");
    let mut agent = Agent::start(&sandbox, &["--folder", folder.to_str().expect("UTF-8")]);
    let driven = agent.call("experiment", &json!({"file": "short.toml"}));
    assert_eq!(
        (&driven["drives"], &driven["passed"]),
        (&json!(3), &json!(3)),
        "{driven}"
    );
    let tested = agent.call("test", &json!({"paths": ["short.toml"]}));
    assert_eq!(tested["passed"], 3, "{tested}");
    let names: Vec<_> = fs::read_dir(&folder).expect("a folder").flatten().collect();
    assert_eq!(names.len(), 2, "no file is written");
    let id = agent.send(
        "tools/call",
        &json!({"name": "experiment", "arguments": {"file": "long.toml"}}),
    );
    while children(agent.server.id()).is_empty() {}
    let cancel = json!({"jsonrpc": "2.0", "method": "notifications/cancelled", "params": {"requestId": id}});
    agent.write(format!("{cancel}\n").as_bytes());
    while !children(agent.server.id()).is_empty() {}
    assert_eq!(agent.call("applications", &json!({}))["applications"], json!([]));
    agent.send(
        "tools/call",
        &json!({"name": "experiment", "arguments": {"file": "long.toml"}}),
    );
    while children(agent.server.id()).is_empty() {}
    let driving = children(agent.server.id());
    assert_eq!(agent.close(), Some(0));
    let is_gone = |process: &u32| !fs::exists(format!("/proc/{process}")).unwrap_or(false);
    while !driving.iter().all(is_gone) {}
    let mut killed = Agent::start(&sandbox, &["--folder", folder.to_str().expect("UTF-8")]);
    killed.send(
        "tools/call",
        &json!({"name": "experiment", "arguments": {"file": "long.toml"}}),
    );
    while children(killed.server.id()).is_empty() {}
    let driving = children(killed.server.id());
    signal("KILL", &killed.server);
    while !driving.iter().all(is_gone) {}
    let limited = Agent::start(
        &sandbox,
        &["--folder", folder.to_str().expect("UTF-8"), "--limit", "1s"],
    )
    .refusal("experiment", &json!({"file": "long.toml"}));
    assert!(limited.contains("took longer than 1 s"), "{limited}");
}

/// The processes that a process has started and that serve drives.
fn children(parent: u32) -> Vec<u32> {
    let threads = fs::read_dir(format!("/proc/{parent}/task"))
        .into_iter()
        .flatten()
        .flatten();
    let lists = threads.filter_map(|thread| fs::read_to_string(thread.path().join("children")).ok());
    let numbers: Vec<u32> = lists
        .flat_map(|list| {
            list.split_whitespace()
                .filter_map(|number| number.parse().ok())
                .collect::<Vec<_>>()
        })
        .collect();
    let serves = |process: &u32| {
        let line = fs::read(format!("/proc/{process}/cmdline")).unwrap_or_default();
        String::from_utf8_lossy(&line).contains("--serve-drives")
    };
    numbers.into_iter().filter(serves).collect()
}
