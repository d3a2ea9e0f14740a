//! Runs each check on the corpus of its fuzz target, on mutants of it, and on noise.

use std::fs;
use std::path::{Path, PathBuf};

/// About how many bytes are checked for each target.
const BYTES: usize = 1 << 20;

/// At most how many files are changed for a target. Messages are decoded as each standard type, of which some have megabytes.
fn most_mutants(target: &str) -> usize {
    if target == "cdr" { 100 } else { 10_000 }
}

/// A random number generator that is the same in every run.
struct Generator(u64);

impl Generator {
    fn below(&mut self, limit: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as usize % limit.max(1)
    }

    fn byte(&mut self) -> u8 {
        self.below(256) as u8
    }

    fn noise(&mut self) -> Vec<u8> {
        (0..self.below(400)).map(|_| self.byte()).collect()
    }

    /// Changes some places of a file. Bytes of the file itself occur more often than by chance.
    fn mutate(&mut self, mut bytes: Vec<u8>) -> Vec<u8> {
        for _ in 0..=self.below(6) {
            let at = self.below(bytes.len());
            let known = bytes.get(self.below(bytes.len())).copied();
            let byte = known
                .filter(|_| self.below(2) == 0)
                .unwrap_or_else(|| self.byte());
            match self.below(6) {
                0 => bytes.truncate(at),
                1 => bytes.insert(at, byte),
                2 => drop(bytes.drain(at..bytes.len().min(at + self.below(40)))),
                3 => {
                    let piece = bytes[at..].to_vec();
                    bytes.extend(piece);
                }
                _ => bytes
                    .iter_mut()
                    .skip(at)
                    .take(1)
                    .for_each(|changed| *changed = byte),
            }
        }
        bytes
    }
}

fn fuzzers() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz")
}

/// Returns the names in a folder, sorted.
fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    let path = entries.map(|entry| entry.expect("an entry").path());
    let mut names: Vec<String> = path
        .map(|path| path.file_name().expect("a name").to_string_lossy().into_owned())
        .collect();
    names.sort();
    names
}

fn hold(target: &str, check: fn(&[u8])) {
    let folder = fuzzers().join("corpus").join(target);
    let corpus: Vec<Vec<u8>> = names(&folder)
        .iter()
        .map(|name| fs::read(folder.join(name)).expect("it is read"))
        .collect();
    corpus.iter().for_each(|bytes| check(bytes));
    let mut generator = Generator(0x9E37_79B9_7F4A_7C15);
    let mut checked = 0;
    for _ in 0..most_mutants(target) {
        let file = corpus[generator.below(corpus.len())].clone();
        for bytes in [generator.mutate(file), generator.noise()] {
            check(&bytes);
            checked += bytes.len();
        }
        if checked > BYTES {
            return;
        }
    }
}

/// A test of each target, and one of their list.
macro_rules! targets {
    ($($name:ident)*) => {
        $(
            #[test]
            fn $name() {
                hold(stringify!($name), jde_fuzzing::$name);
            }
        )*

        #[test]
        fn each_target_has_a_program_a_corpus_and_a_test() {
            let targets = [$(stringify!($name)),*];
            let programs = targets.map(|target| format!("{target}.rs"));
            assert_eq!(names(&fuzzers().join("fuzz_targets")), programs);
            assert_eq!(names(&fuzzers().join("corpus")), targets);
            let manifest = fs::read_to_string(fuzzers().join("Cargo.toml")).expect("it is read");
            for target in targets {
                assert!(manifest.contains(&format!("\nname = \"{target}\"\n")), "{target}");
                let program = fuzzers().join(format!("fuzz_targets/{target}.rs"));
                let text = fs::read_to_string(program).expect("it is read");
                let end = format!("\nlibfuzzer_sys::fuzz_target!(|data: &[u8]| jde_fuzzing::{target}(data));\n");
                assert!(text.ends_with(&end), "{text}");
            }
        }
    };
}

targets! {
    answer
    application
    calibration
    carmen_log
    cdr
    command
    definition
    gesture
    head
    import
    imu
    lidar
    link
    list
    map_file
    player_session
    player_stream
    receiver
    recording
    session
}
