//! The networks of `tests/data` against the numbers of onnxruntime, what must be refused, and damaged files.

use std::fs;
use std::path::{Path, PathBuf};

use super::*;

/// The difference to onnxruntime that another order of sums makes, of numbers near 1.
const ROUNDING_ERROR: f32 = 2e-6;

/// The numbers of onnxruntime, of `make.py` and `sb3.py`.
const LISTS: [&str; 2] = ["expected.txt", "sb3.txt"];

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/data")
        .join(name)
}

/// A network with the inputs and outputs of `expected.txt`.
struct Case {
    name: String,
    inputs: Vec<(String, Vec<f32>)>,
    outputs: Vec<(String, Vec<usize>, Vec<f32>)>,
}

fn cases() -> Vec<Case> {
    let lists = LISTS.map(|list| fs::read_to_string(data(list)).expect("the numbers are there"));
    let text = lists.concat();
    let mut cases: Vec<Case> = Vec::new();
    for line in text.lines() {
        let mut words = line.split(' ');
        let (kind, name) = (
            words.next().unwrap_or_default(),
            words.next().unwrap_or_default().to_owned(),
        );
        let numbers = |words: &mut dyn Iterator<Item = &str>| {
            words.map(|word| word.parse().expect("a number")).collect()
        };
        match (kind, cases.last_mut()) {
            ("case", _) => cases.push(Case {
                name,
                inputs: Vec::new(),
                outputs: Vec::new(),
            }),
            ("input", Some(case)) => case.inputs.push((name, numbers(&mut words))),
            ("output", Some(case)) => {
                let shape = words
                    .next()
                    .expect("a shape")
                    .split('x')
                    .filter_map(|side| side.parse().ok())
                    .collect();
                case.outputs.push((name, shape, numbers(&mut words)));
            }
            _ => panic!("this line is none: {line}"),
        }
    }
    cases
}

fn run(network: &mut Network, case: &Case) {
    for (name, numbers) in &case.inputs {
        let index = network
            .inputs()
            .position(|port| port.name == *name)
            .expect("the input is there");
        network.input_mut(index).copy_from_slice(numbers);
    }
    network.run().expect("a loaded network runs");
}

#[test]
fn every_operator_gives_the_numbers_of_onnxruntime() {
    let cases = cases();
    assert!(cases.len() > 90, "{} networks", cases.len());
    for case in cases {
        let mut network = Network::load(&data(&format!("{}.onnx", case.name)))
            .unwrap_or_else(|error| panic!("{}: {error}", case.name));
        // The second run shows that nothing of the first is left.
        for _ in 0..2 {
            run(&mut network, &case);
            assert_eq!(network.outputs().len(), case.outputs.len(), "{}", case.name);
            for (index, (name, shape, expected)) in case.outputs.iter().enumerate() {
                let port = network.outputs().nth(index).expect("the output is there").clone();
                assert_eq!((&port.name, &port.shape), (name, shape), "{}", case.name);
                let given = network.output(index);
                assert_eq!(given.len(), expected.len(), "{}", case.name);
                for (given, expected) in given.iter().zip(expected) {
                    let far = (given - expected).abs();
                    assert!(
                        far <= ROUNDING_ERROR * expected.abs().max(1.0),
                        "{}: {given} is not {expected}",
                        case.name
                    );
                }
            }
        }
    }
}

#[test]
fn what_would_run_with_other_numbers_is_refused_with_the_name_of_its_node() {
    let text = fs::read_to_string(data("refused.txt")).expect("the list is there");
    for line in text.lines() {
        let (name, words) = line.split_once(": ").expect("a name and words");
        let message = match Network::load(&data(&format!("{name}.onnx"))) {
            Ok(_) => panic!("{name} runs"),
            Err(error) => error.to_string(),
        };
        assert!(message.contains(words), "{name}: {message}");
    }
}

#[test]
fn an_output_that_is_a_choice_says_among_how_many() {
    let among = |name: &str| {
        let network = Network::load(&data(&format!("{name}.onnx"))).expect("it loads");
        Vec::from_iter(network.outputs().map(|port| port.chosen_among))
    };
    assert_eq!(among("sb3-dqn"), [Some(4)]);
    assert_eq!(among("sb3-discrete"), [Some(4), None, None]);
    assert_eq!(among("sb3-dqn-scores"), [None]);
    assert_eq!(among("argmax"), [Some(5)]);
}

#[test]
fn every_file_of_the_tests_is_used() {
    let text = ["expected.txt", "sb3.txt", "refused.txt"]
        .map(|list| fs::read_to_string(data(list)).expect("the list is there"))
        .concat();
    for entry in fs::read_dir(data("")).expect("the folder is there") {
        let path = entry.expect("an entry").path();
        let name = path
            .file_stem()
            .and_then(|name| name.to_str())
            .expect("a name")
            .to_owned();
        let is_used = text.contains(&format!("case {name}\n")) || text.contains(&format!("{name}: "));
        assert!(
            is_used || path.extension().is_none_or(|ending| ending != "onnx"),
            "{name}"
        );
    }
}

#[test]
fn a_missing_file_is_named() {
    let error = Network::load(Path::new("nowhere/policy.onnx")).expect_err("there is none");
    assert!(
        error
            .to_string()
            .starts_with("nowhere/policy.onnx: it cannot be read"),
        "{error}"
    );
}

#[test]
fn nan_in_an_input_is_nan_in_the_outputs() {
    // A network that loses its numbers must show it: `max` would make 0 of NaN.
    for case in cases()
        .iter()
        .filter(|case| case.inputs.len() == 1 && !["hardsigmoid"].contains(&case.name.as_str()))
    {
        let mut network = Network::load(&data(&format!("{}.onnx", case.name))).expect("it loads");
        network.input_mut(0).fill(f32::NAN);
        // A network that chooses has no number that would show it.
        if let Err(error) = network.run() {
            assert!(
                error
                    .to_string()
                    .contains("(ArgMax): number 0 of its input is NaN"),
                "{error}"
            );
            continue;
        }
        let is_lost = network.output(0).iter().any(|number| number.is_nan());
        assert!(is_lost, "{}: {:?}", case.name, network.output(0));
    }
}

#[test]
fn the_hash_is_that_of_the_file_and_of_the_weights_beside_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let copy = |name: &str| fs::copy(data(name), folder.path().join(name)).expect("a copy");
    for name in ["external.onnx", "external.data", "mlp.onnx"] {
        copy(name);
    }
    let hash = |name: &str| {
        Network::load(&folder.path().join(name))
            .expect("it loads")
            .hash()
            .to_owned()
    };
    let before = hash("external.onnx");
    assert_eq!(before.len(), 64);
    assert_ne!(before, hash("mlp.onnx"));
    let mut weights = fs::read(folder.path().join("external.data")).expect("the weights");
    weights[5] ^= 1;
    fs::write(folder.path().join("external.data"), weights).expect("the weights are changed");
    assert_ne!(before, hash("external.onnx"));
}

#[cfg(unix)]
#[test]
fn a_link_does_not_lead_out_of_the_folder() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::copy(data("external.onnx"), folder.path().join("external.onnx")).expect("a copy");
    std::os::unix::fs::symlink(data("external.data"), folder.path().join("external.data")).expect("a link");
    let error = Network::load(&folder.path().join("external.onnx")).expect_err("it leaves");
    assert!(
        error.to_string().contains("which is a link that leaves"),
        "{error}"
    );
}

#[test]
fn a_damaged_file_is_an_error_and_never_a_panic() {
    let mut random = fastrand::Rng::with_seed(5);
    for name in [
        "mlp", "gru", "dynamic", "conv", "slice", "split", "gather", "expand", "maxpool",
    ] {
        let whole = fs::read(data(&format!("{name}.onnx"))).expect("the file is there");
        for length in 0..whole.len().min(300) {
            drop(Network::parse(&whole[..length], None));
        }
        for _ in 0..400 {
            let mut damaged = whole.clone();
            for _ in 0..random.usize(1..6) {
                let at = random.usize(..damaged.len().min(900));
                damaged[at] = random.u8(..);
            }
            if let Ok(mut network) = Network::parse(&damaged, None) {
                network.run().expect("a loaded network runs");
            }
        }
    }
}

#[test]
fn the_bits_are_the_same_whatever_ran_before() {
    let cases = cases();
    let case = cases
        .iter()
        .find(|case| case.name == "mlp")
        .expect("the case is there");
    let mut network = Network::load(&data("mlp.onnx")).expect("it loads");
    run(&mut network, case);
    let bits: Vec<u32> = network.output(0).iter().map(|number| number.to_bits()).collect();
    // As computed on x86-64; every machine must agree.
    assert_eq!(bits, EXPECTED_BITS, "{bits:#x?}");
    network.input_mut(0).fill(3.0);
    network.run().expect("it runs");
    run(&mut network, case);
    assert_eq!(
        network
            .output(0)
            .iter()
            .map(|number| number.to_bits())
            .collect::<Vec<_>>(),
        bits
    );
}

const EXPECTED_BITS: [u32; 2] = [0x3f02_0db1, 0xbe0b_1190];
