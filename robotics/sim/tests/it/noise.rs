//! Runs the checks of the fuzzers on the fuzzing corpus and on mutations of it.

use std::fs;
use std::path::Path;

use crate::checks;

/// The number of mutants of each file. One takes less than a millisecond.
const MUTANTS: usize = 100;

/// Runs a check on the corpus of a target, on each file cut at some places, and on each with some bytes changed.
fn run(target: &str, check: fn(&[u8])) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../fuzz/corpus")
        .join(target);
    let mut seed = 1_u64;
    let mut below = |limit: usize| {
        seed = seed
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (seed >> 33) as usize % limit.max(1)
    };
    for entry in fs::read_dir(folder).expect("the corpus is part of the project") {
        let bytes = fs::read(entry.expect("an entry").path()).expect("it is read");
        check(&bytes);
        for _ in 0..MUTANTS {
            let mut mutant = bytes.clone();
            for _ in 0..=below(3) {
                let at = below(mutant.len());
                match (below(3), below(256) as u8) {
                    (0, _) => mutant.truncate(at),
                    (1, byte) => mutant
                        .iter_mut()
                        .skip(at)
                        .take(1)
                        .for_each(|changed| *changed = byte),
                    (_, _) => {
                        let piece = mutant[at..].to_vec();
                        mutant.extend(piece);
                    }
                }
            }
            check(&mutant);
        }
    }
}

#[test]
fn any_bytes_are_a_map_or_refused() {
    run("map_file", checks::map);
}

#[test]
fn any_bytes_are_a_world_of_another_program_or_refused() {
    run("import", checks::import);
}
