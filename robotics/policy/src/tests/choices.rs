//! Choices as people write them: networks that choose one of several commands, and what is wrong with a file.

use std::fs;

use jde_types::{Odometry, Value as _};

use super::{data, faults, load, moving, observer, text};

/// The file of the tests with a network beside it.
fn choose(network: &str) -> String {
    text("choose.toml").replace("../../../onnx/tests/data/sb3-dqn.onnx", network)
}

/// Two commands, whose scores are the speeds of the robot.
fn by_speeds(network: &str) -> String {
    let file = text("same.toml").replace("same.onnx", network);
    let inputs = file.split("[[output]]").next().expect("it has inputs").to_owned();
    inputs + "[choices]\ncommands = [{ linear = { x = 0.25, y = 0.5 } }, { angular.z = -1 }]\n"
}

#[test]
fn exports_of_stable_baselines_command_what_onnxruntime_chooses() {
    let numbers =
        fs::read_to_string(data("../../../onnx/tests/data/sb3.txt")).expect("the numbers are there");
    for (name, of) in [
        ("sb3-dqn", None),
        ("sb3-dqn-scores", None),
        ("sb3-discrete", Some(0)),
    ] {
        let mut lines = numbers
            .lines()
            .skip_while(|line| *line != format!("case {name}"))
            .skip(1);
        let input = lines.next().expect("its input").split(' ').skip(2);
        let input: Vec<f32> = input.map(|number| number.parse().expect("a number")).collect();
        let output: Vec<&str> = lines.next().expect("its output").split(' ').collect();
        let given: Vec<f32> = output[3..]
            .iter()
            .map(|number| number.parse().expect("a number"))
            .collect();
        let highest = |best: usize, at: usize| if given[at] > given[best] { at } else { best };
        let expected = match given.len() {
            1 => given[0] as usize,
            _ => (1..given.len()).fold(0, highest),
        };
        let output = of.map_or(String::new(), |_: usize| {
            format!("[choices]\nof = \"{}\"", output[1])
        });
        let file = choose(&format!("{name}.onnx"));
        let file = if output.is_empty() {
            file
        } else {
            file.replace("[choices]", &output)
        };
        let (policy, mut runner) = load(&file).expect("the file is right");
        assert_eq!((policy.choices(), policy.commands()), (Some(4), true));
        let decision = runner.step(&input).expect("the numbers are finite");
        assert_eq!(decision.choice, Some(expected), "{name}");
        assert_eq!(decision.command, policy.command(&[expected as f64]), "{name}");
    }
}

#[test]
fn the_highest_score_chooses_and_of_equal_ones_the_first() {
    let (policy, mut runner) = load(&by_speeds("same.onnx")).expect("the file is right");
    let mut observer = observer(&policy, &[Odometry::describe()]);
    let mut decide = |ahead, turn| {
        let seen = observer.observe(&moving(ahead, turn)).expect("all is there");
        runner.step(seen).expect("the numbers are finite")
    };
    assert_eq!(decide(0.5, 0.25).command, [0.25, 0.5, 0.0]);
    assert_eq!(decide(0.5, 0.75).command, [0.0, 0.0, -1.0]);
    assert_eq!(decide(-0.5, -0.25).choice, Some(1));
    assert_eq!(decide(0.5, 0.5).choice, Some(0));
    assert_eq!(policy.command(&[1.0]), [0.0, 0.0, -1.0]);
    assert_eq!(policy.command(&[2.0]), [0.0; 3], "there is no such choice");
    assert_eq!(policy.action([0.0, 0.0, -0.75]), [1.0]);
    assert_eq!(policy.action([0.25, 0.25, -0.25]), [0.0]);
}

#[test]
fn a_score_that_is_not_finite_is_no_choice() {
    let (_, mut runner) = load(&by_speeds("log.onnx")).expect("the file is right");
    assert_eq!(runner.step(&[2.0, 1.0]).expect("they are finite").choice, Some(0));
    let words = runner.step(&[2.0, -1.0]).expect_err("there is no logarithm");
    assert_eq!(words, "the network gave NaN in `action`");
    // A network that chooses by itself shows only what it chose.
    let (_, mut runner) = load(&choose("sb3-dqn.onnx")).expect("the file is right");
    let words = runner.step(&[f32::NAN; 6]).expect_err("it has no highest number");
    assert!(
        words.contains("(ArgMax): number 0 of its input is NaN"),
        "{words}"
    );
}

#[test]
fn what_choices_cannot_be_is_refused_with_its_line() {
    let dqn = choose("sb3-dqn.onnx");
    let cases = [
        (
            dqn.replace("  {},\n", ""),
            "has 1 numbers of choices among 4, and the file lists 3 commands",
        ),
        (
            choose("sb3-dqn-scores.onnx").replace("  {},\n", ""),
            "has 4 scores, of the shape [1, 4], and the file lists 3 commands",
        ),
        (
            dqn.replace("{}", "{ linear.z = 1 }"),
            "policy.toml:11:12: unknown key `z` in `linear` of command 0",
        ),
        (
            dqn.replace("linear.x = 0.4", "linear.x = \"fast\""),
            "`x` of `linear` of command 1 must be a number, not a text",
        ),
        (
            dqn.replace("commands = [", "commands = []\ndoubt = ["),
            "`commands` of `choices` of the policy must be a list of 2 to 1000 commands, such as { linear.x = 0.2 }",
        ),
        (
            dqn.clone() + "[[output]]\ncommand = \"linear.x\"\nbounds = [0, 1]\nscale = \"none\"\n",
            "this output commands what [choices] commands too",
        ),
        (
            dqn.clone() + "[chunk]\nsteps = 4\nspacing = 0.1\n",
            "a network that makes chunks gives numbers of [[output]], and no [choices]",
        ),
        (
            dqn.split("[choices]").next().expect("it has inputs").to_owned()
                + "[[output]]\ncommand = \"linear.x\"\nbounds = [0, 1]\nscale = \"none\"\n",
            "is the number of a choice\n    help: state the commands among which it chooses, in [choices]",
        ),
    ];
    for (text, expected) in cases {
        let words = faults(&text);
        assert!(words.contains(expected), "{expected} is not in:\n{words}");
    }
}
