//! What no client can do to the server, and what it answers.

use std::io::{BufRead, BufReader};
use std::process::Stdio;

use serde_json::{Value, json};

use super::Agent;
use crate::attached::{Sandbox, navigation, schema};
use crate::support::{pair, signal};

#[test]
fn a_line_that_is_no_message_gets_an_error_and_the_next_one_an_answer() {
    let sandbox = Sandbox::new();
    let mut agent = Agent::connect(&sandbox, &[]);
    assert_eq!(agent.error(b"{\"jsonrpc\": ").0, -32700);
    assert_eq!(agent.error(b"\xff\xfe").0, -32700);
    assert_eq!(
        agent
            .error(b"[{\"jsonrpc\": \"2.0\", \"id\": 1, \"method\": \"ping\"}]")
            .0,
        -32600
    );
    let (code, message) = agent.error(&vec![b'x'; 3 << 20]);
    assert!(code == -32600 && message.contains("at most"), "{message}");
    let early = b"{\"jsonrpc\": \"2.0\", \"id\": 9, \"method\": \"tools/list\"}";
    let (code, message) = agent.error(early);
    assert!(code == -32600 && message.contains("initialize"), "{message}");
    let called = b"{\"jsonrpc\": \"2.0\", \"id\": 9, \"method\": \"tools/call\", \"params\": {\"name\": \"stop_all\"}}";
    assert_eq!(agent.error(called).0, -32600);
    // Neither is answered, and neither ends the server.
    agent.write(b"{\"jsonrpc\": \"2.0\", \"method\": \"notifications/initialized\"}\n\n");
    agent.write(b"{\"jsonrpc\": \"2.0\", \"id\": 4, \"result\": {}}\n");
    agent.initialize();
    assert_eq!(agent.error(b"nonsense").0, -32700);
    let unknown = agent.request("no/such", &json!({}));
    assert_eq!(unknown["error"]["code"], -32601, "{unknown}");
    let unknown = agent.request("tools/call", &json!({"name": "rm", "arguments": {}}));
    assert_eq!(unknown["error"]["code"], -32602, "{unknown}");
    let odd = agent.request("tools/call", &json!({"name": 5}));
    assert!(odd["error"].is_object(), "{odd}");
    assert!(agent.tools().contains(&"why".to_owned()));
    assert_eq!(agent.close(), Some(0));
}

#[test]
fn an_agent_sees_what_a_person_sees() {
    let sandbox = Sandbox::new();
    let mut agent = Agent::start(&sandbox, &[]);
    assert_eq!(agent.call("applications", &json!({}))["applications"], json!([]));
    let none = agent.refusal("hierarchy", &json!({}));
    assert!(
        none.contains("no application runs") && !none.contains("jde run"),
        "{none}"
    );
    let _robot = navigation(&sandbox);
    sandbox.until(&["ps"], |now| schema(now, "goon")["state"] == "winner");
    let listed = agent.call("applications", &json!({}));
    assert_eq!(listed["applications"][0]["name"], "safe-navigation", "{listed}");
    let hierarchy = &agent.call("hierarchy", &json!({"application": "safe-navigation"}))["hierarchy"];
    assert_eq!(schema(hierarchy, "goon")["kind"], "motor");
    let why = agent.call("why", &json!({"question": "goon"}));
    assert_eq!(why["selection"]["decision"]["choice"], "goon", "{why}");
    let variables = agent.call("variables", &json!({"patterns": ["goon.*"], "values": true}));
    let fast = variables["variables"].as_array().expect("a list").iter();
    let fast: Vec<_> = fast.filter(|variable| variable["name"] == "goon.fast").collect();
    assert_eq!(fast[0]["value"], "0.4 m/s", "{fast:?}");
    let values = agent.call(
        "get",
        &json!({"variables": ["goon.fast", "pioneer.odometry.pose.pose.position.x"]}),
    );
    assert_eq!(values[0]["value"], 0.4, "{values}");
    let panel = agent.call("panel", &json!({"schema": "example"}));
    assert!(
        panel["text"].as_str().expect("a text").contains("clear"),
        "{panel}"
    );
    for (tool, arguments, reason) in [
        ("why", json!({"question": "did gon win"}), "did you mean `goon`?"),
        (
            "get",
            json!({"variables": ["pioneer.lasr"]}),
            "did you mean `pioneer.laser`?",
        ),
        ("get", json!({"variables": ["--help"]}), "there is no"),
        ("panel", json!({"schema": "goon; reboot"}), "there is no panel"),
        ("picture", json!({"variable": "pioneer.laser"}), "no picture"),
        (
            "hierarchy",
            json!({"application": "../safe-navigation"}),
            "no application is called",
        ),
        (
            "hierarchy",
            json!({"aplication": "x"}),
            "the arguments do not fit",
        ),
        (
            "get",
            json!({"variables": "goon.fast"}),
            "the arguments do not fit",
        ),
        ("get", json!({"variables": ["x".repeat(900_000)]}), "there is no"),
    ] {
        let refusal = agent.refusal(tool, &arguments);
        assert!(refusal.contains(reason), "{tool}: {:.400}", refusal);
    }
    let other = Agent::start(&sandbox, &["--app", "another"])
        .refusal("hierarchy", &json!({"application": "safe-navigation"}));
    assert!(other.contains("alone"), "{other}");
}

#[test]
fn a_flood_of_calls_is_answered_and_refused_beyond_the_limit() {
    let sandbox = Sandbox::new();
    let _robot = sandbox.start(&pair(), &[]);
    let mut agent = Agent::start(&sandbox, &[]);
    let calls = 100;
    for _ in 0..calls {
        agent.send("tools/call", &json!({"name": "hierarchy", "arguments": {}}));
    }
    let answers: Vec<Value> = (0..calls).map(|_| agent.read()).collect();
    let is_refused = |answer: &&Value| answer["result"]["isError"] == true;
    let refused = answers.iter().filter(is_refused).count();
    assert!((1..calls).contains(&refused), "{refused}");
    for answer in answers.iter().filter(is_refused) {
        let text = answer["result"]["content"][0]["text"].as_str().expect("a reason");
        assert!(text.contains("calls are under way"), "{text}");
    }
    agent.call("hierarchy", &json!({}));
    // A request with the id of one that has no answer yet.
    agent.write(b"{\"jsonrpc\": \"2.0\", \"id\": 7777, \"method\": \"tools/call\", \"params\": {\"name\": \"hierarchy\"}}\n");
    assert_eq!(
        agent
            .error(b"{\"jsonrpc\": \"2.0\", \"id\": 7777, \"method\": \"ping\"}")
            .0,
        -32600
    );
    assert_eq!(agent.read()["id"], 7777);
}

#[test]
fn a_server_whose_output_nobody_reads_ends_with_its_input() {
    let sandbox = Sandbox::new();
    let _robot = navigation(&sandbox);
    let mut agent = Agent::start(&sandbox, &["--operate"]);
    agent.call("force", &json!({"schema": "stop"}));
    // More than a pipe holds.
    for _ in 0..200 {
        agent.send("tools/list", &json!({}));
    }
    assert_eq!(agent.close(), Some(0));
    sandbox.until(&["ps"], |now| schema(now, "stop")["operator"].is_null());
}

#[test]
fn a_server_ends_when_the_process_that_started_it_is_killed() {
    let sandbox = Sandbox::new();
    let mut shell = sandbox.command(std::process::Command::new("sh"));
    // Both streams stay open: the test holds their other ends.
    let mut shell = shell
        .args([
            "-c",
            "exec 3<&0; \"$0\" mcp <&3 & wait",
            env!("CARGO_BIN_EXE_jde"),
        ])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("a shell");
    let mut agent = Agent {
        input: shell.stdin.take(),
        output: BufReader::new(shell.stdout.take().expect("a pipe")),
        server: shell,
        last_id: 0,
    };
    agent.initialize();
    signal("KILL", &agent.server);
    let mut rest = String::new();
    agent.output.read_line(&mut rest).expect("it can be read");
    assert_eq!(rest, "", "the server closes its output at its end");
}
