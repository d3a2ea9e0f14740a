//! Chunks as people write them: the commands that are made of a network's numbers, and what is wrong with a file.

use super::{faults, moving, ready, text};
use crate::ChunkRule;

#[test]
fn a_chunk_is_a_row_for_each_command() {
    let (policy, mut runner, mut observer) = ready("faster.toml");
    let rule = ChunkRule {
        steps: 4,
        spacing: 0.1,
        blend: Some(0.5),
    };
    assert_eq!(policy.chunk(), Some(rule));
    let seen = observer.observe(&moving(0.75, 0.5)).expect("all is there");
    let decision = runner.step(seen).expect("the numbers are finite");
    assert_eq!(decision.command, [0.75, 0.0, 1.0], "the first one");
    let ahead: Vec<f32> = runner
        .commands()
        .iter()
        .map(|command| command[0] as f32)
        .collect();
    assert_eq!(
        ahead,
        [0.75, 0.85, 0.95, 1.0],
        "unscaled and clipped as any other"
    );
    assert!(runner.commands().iter().all(|command| command[2] == 1.0));
    assert_eq!(ready("same.toml").0.chunk(), None);
}

#[test]
fn what_a_chunk_cannot_be_is_refused_with_its_line() {
    let faster = text("faster.toml");
    let cases = [
        (
            faster.replace("steps   = 4", "steps = 8"),
            "`action` has the shape [1, 4, 2]: expected a row for each of 8 steps",
        ),
        (
            faster.replace("index   = 1", "index = 2"),
            "`action` has 2 numbers for a step, and none at 2",
        ),
        (
            faster.replace("steps   = 4", "steps = 129"),
            "policy.toml:12:9: `steps` of `chunk` of the policy must be a whole number, 1 to 128",
        ),
        (
            faster.replace("spacing = 0.1", "spacing = 0"),
            "is 0: expected the time from one command to the next in seconds, 0.001 to 10",
        ),
        (
            faster.replace("spacing = 0.1", "spacing = 3.0"),
            "a chunk lasts 12 s, and 10 s is the most",
        ),
        (
            faster.replace("period  = 0.2", "period = 0.5"),
            "a chunk lasts 0.4 s, and the next one is made after 0.5 s\n    help: state more steps, or a shorter `period`",
        ),
        (
            faster.replace("blend   = 0.5", "blend = 1.5"),
            "is 1.5: expected the weight of a chunk as a share of that of the one before, 0.001 to 1",
        ),
        (
            faster.replacen(
                "field = \"odometry.twist.twist.linear.x\"",
                "command = \"linear.x\"",
                1,
            ),
            "a network that makes chunks does not see the last command",
        ),
        (
            faster.replace("faster.onnx", "same.onnx"),
            "`action` has the shape [1, 2]: expected a row for each of 4 steps",
        ),
    ];
    for (text, expected) in cases {
        let words = faults(&text);
        assert!(words.contains(expected), "{expected} is not in:\n{words}");
    }
}
