//! `jde mcp`: what an agent may do, and what no client can do to the server. The clients here write raw lines.

mod files;
mod protocol;
mod rights;

use std::io::{BufRead, BufReader, Write};
use std::process::{Child, ChildStdin, ChildStdout, Stdio};

use serde_json::{Value, json};

use crate::attached::{Sandbox, schema};
use crate::support::jde_with_plugins;

/// A client of the protocol, and its server.
struct Agent {
    server: Child,
    input: Option<ChildStdin>,
    output: BufReader<ChildStdout>,
    last_id: u64,
}

impl Agent {
    /// Starts a server without a session.
    fn connect(sandbox: &Sandbox, options: &[&str]) -> Self {
        let mut command = sandbox.command(jde_with_plugins(&["mcp"]));
        let mut server = command
            .args(options)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .expect("the executable starts");
        Self {
            input: server.stdin.take(),
            output: BufReader::new(server.stdout.take().expect("a pipe")),
            server,
            last_id: 0,
        }
    }

    /// Starts a server with a session.
    fn start(sandbox: &Sandbox, options: &[&str]) -> Self {
        let mut agent = Self::connect(sandbox, options);
        agent.initialize();
        agent
    }

    fn initialize(&mut self) {
        let parameters = json!({
            "protocolVersion": "2025-11-25",
            "capabilities": {},
            "clientInfo": {"name": "test", "version": "1"},
        });
        let answer = self.request("initialize", &parameters);
        assert_eq!(answer["result"]["serverInfo"]["name"], "jde", "{answer}");
        self.write(b"{\"jsonrpc\": \"2.0\", \"method\": \"notifications/initialized\"}\n");
    }

    fn write(&mut self, bytes: &[u8]) {
        let input = self.input.as_mut().expect("the input is open");
        input.write_all(bytes).expect("the server reads");
    }

    fn read(&mut self) -> Value {
        let mut line = String::new();
        self.output.read_line(&mut line).expect("the server answers");
        serde_json::from_str(&line).unwrap_or_else(|error| panic!("{error}: {line}"))
    }

    /// Writes a line, and returns the code and the message of the error that answers it.
    fn error(&mut self, line: &[u8]) -> (i64, String) {
        self.write(line);
        self.write(b"\n");
        let answer = self.read();
        let error = &answer["error"];
        let message = error["message"].as_str().unwrap_or_default().to_owned();
        (
            error["code"].as_i64().unwrap_or_else(|| panic!("{answer}")),
            message,
        )
    }

    fn send(&mut self, method: &str, parameters: &Value) -> u64 {
        self.last_id += 1;
        let id = self.last_id;
        let request = json!({"jsonrpc": "2.0", "id": id, "method": method, "params": parameters});
        self.write(format!("{request}\n").as_bytes());
        id
    }

    fn request(&mut self, method: &str, parameters: &Value) -> Value {
        let id = self.send(method, parameters);
        let answer = self.read();
        assert_eq!(answer["id"], id, "{answer}");
        answer
    }

    fn result_of(&mut self, tool: &str, arguments: &Value) -> Value {
        let answer = self.request("tools/call", &json!({"name": tool, "arguments": arguments}));
        let result = answer["result"].clone();
        assert!(result.is_object(), "{tool}: {answer}");
        result
    }

    /// Calls a tool that must succeed, and returns its data.
    fn call(&mut self, tool: &str, arguments: &Value) -> Value {
        let result = self.result_of(tool, arguments);
        assert_ne!(result["isError"], true, "{tool}: {result}");
        result["structuredContent"]["data"].clone()
    }

    /// Calls a tool that must fail, and returns the reason.
    fn refusal(&mut self, tool: &str, arguments: &Value) -> String {
        let result = self.result_of(tool, arguments);
        assert_eq!(result["isError"], true, "{tool}: {result}");
        result["content"][0]["text"]
            .as_str()
            .expect("a reason")
            .to_owned()
    }

    fn tools(&mut self) -> Vec<String> {
        let answer = self.request("tools/list", &json!({}));
        let tools = answer["result"]["tools"].as_array().expect("a list").iter();
        tools
            .map(|tool| tool["name"].as_str().expect("a name").to_owned())
            .collect()
    }

    /// Closes the input, and waits for the end of the server. Returns its exit status.
    fn close(&mut self) -> Option<i32> {
        self.input = None;
        self.server.wait().expect("it can be waited for").code()
    }
}

impl Drop for Agent {
    fn drop(&mut self) {
        // The server may have ended already.
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}

/// The holds of a schema, as their operators and what they do.
fn holds(sandbox: &Sandbox, name: &str) -> Vec<String> {
    let now = sandbox.json(&["ps"]);
    let schema = schema(&now, name);
    let more = schema["more_holds"].as_array().cloned().unwrap_or_default();
    let all = std::iter::once(schema["operator"].clone()).chain(more);
    let held = all.filter(|hold| !hold.is_null());
    held.map(|hold| {
        format!(
            "{} by {}",
            hold["kind"].as_str().unwrap(),
            hold["by"].as_str().unwrap()
        )
    })
    .collect()
}
