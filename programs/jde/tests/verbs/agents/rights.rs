//! What an agent may do to robots (R14).

use serde_json::json;

use super::{Agent, holds};
use crate::attached::{Sandbox, navigation, schema};
use crate::support::signal;

#[test]
fn r14_without_the_option_an_agent_operates_nothing_and_may_still_stop_everything() {
    let sandbox = Sandbox::new();
    let _robot = navigation(&sandbox);
    sandbox.until(&["ps"], |now| schema(now, "goon")["state"] == "winner");
    let mut agent = Agent::start(&sandbox, &[]);
    let tools = agent.tools();
    for (tool, arguments) in [
        ("play", json!({"schema": "goon"})),
        ("stop", json!({"schema": "goon"})),
        ("force", json!({"schema": "goon"})),
        ("release", json!({"schema": "goon"})),
        ("set", json!({"modulation": "goon.fast", "value": "0.1"})),
        ("period", json!({"schema": "goon", "period": "1s"})),
        ("stop", json!({"schema": "goon", "operate": true})),
    ] {
        assert!(!tools.iter().any(|listed| listed == tool), "{tools:?}");
        let refusal = agent.refusal(tool, &arguments);
        assert!(
            refusal.contains("permits no") && !refusal.contains("--"),
            "{refusal}"
        );
    }
    assert!(holds(&sandbox, "goon").is_empty());
    let stopped = agent.call("stop_all", &json!({}));
    assert_eq!(
        stopped["stopped"][0]["application"], "safe-navigation",
        "{stopped}"
    );
    assert!(sandbox.motors_awake().is_empty());
    assert!(holds(&sandbox, "example")[0].starts_with("stopped by agent@"));
    // It is no lease: it stays when the agent is gone.
    assert_eq!(agent.close(), Some(0));
    assert!(sandbox.motors_awake().is_empty());
    sandbox.run_ok(&["release", "--all"]);
    sandbox.until(&["ps"], |now| schema(now, "example")["state"] == "winner");
}

#[test]
fn r14_what_an_agent_holds_is_shown_and_ends_with_it_and_nothing_else_does() {
    let sandbox = Sandbox::new();
    let _robot = navigation(&sandbox);
    sandbox.until(&["ps"], |now| schema(now, "goon")["state"] == "winner");
    let mut agent = Agent::start(&sandbox, &["--operate"]);
    agent.call("force", &json!({"schema": "stop"}));
    assert!(holds(&sandbox, "stop")[0].starts_with("forced by agent@"));
    assert_eq!(agent.call("release", &json!({"schema": "stop"}))["released"], 1);
    assert!(holds(&sandbox, "stop").is_empty());
    let twice = agent.refusal("release", &json!({"schema": "stop"}));
    assert!(twice.contains("holds nothing"), "{twice}");
    agent.call("set", &json!({"modulation": "goon.fast", "value": "0.2 m/s"}));
    agent.call("set", &json!({"modulation": "goon.fast", "value": "0.1 m/s"}));
    assert_eq!(sandbox.json(&["get", "goon.fast"])["value"], 0.1);
    agent.call("period", &json!({"schema": "vff", "period": "50ms"}));
    // Its own stop does not refuse its play, and that of a person does.
    agent.call("stop", &json!({"schema": "goon"}));
    agent.call("play", &json!({"schema": "goon"}));
    sandbox.run_ok(&["stop", "vff"]);
    let refusal = agent.refusal("play", &json!({"schema": "vff"}));
    assert!(refusal.contains("`vff` is stopped by ana@"), "{refusal}");
    assert!(!refusal.contains("jde "), "{refusal}");
    for (tool, arguments, reason) in [
        ("stop", json!({"schema": "gon"}), "did you mean `goon`?"),
        ("set", json!({"modulation": "goon.fast", "value": "nan"}), "goon"),
        (
            "set",
            json!({"modulation": "pioneer.laser", "value": "1"}),
            "not a modulation",
        ),
        (
            "set",
            json!({"modulation": "goon.fast", "value": "-1e300"}),
            "goon",
        ),
        ("period", json!({"schema": "goon", "period": "-5"}), "period"),
        ("force", json!({"schema": "pioneer"}), "pioneer"),
    ] {
        let refusal = agent.refusal(tool, &arguments);
        assert!(refusal.contains(reason), "{tool}: {refusal}");
    }
    let events = sandbox.run_ok(&["events", "--once"]);
    assert!(
        events.contains("agent@") && events.contains("goon.fast"),
        "{events}"
    );
    assert_eq!(agent.close(), Some(0));
    sandbox.until(&["get", "goon.fast"], |now| now["value"] == 0.4);
    sandbox.until(&["ps"], |now| schema(now, "goon")["operator"].is_null());
    assert!(holds(&sandbox, "vff")[0].starts_with("stopped by ana@"));
}

#[test]
fn r14_the_holds_of_a_server_that_is_killed_end() {
    let sandbox = Sandbox::new();
    let _robot = navigation(&sandbox);
    let mut agent = Agent::start(&sandbox, &["--operate"]);
    agent.call("force", &json!({"schema": "stop"}));
    sandbox.until(&["ps"], |now| schema(now, "stop")["operator"]["kind"] == "forced");
    signal("KILL", &agent.server);
    sandbox.until(&["ps"], |now| schema(now, "stop")["operator"].is_null());
}
