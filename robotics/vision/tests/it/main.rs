//! The checks of the fuzzer, with its corpus and mutations of it.

mod checks;

use std::fs;
use std::path::Path;

use proptest::prelude::*;

fn corpus() -> Vec<Vec<u8>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/corpus/calibration");
    let files = fs::read_dir(folder).expect("the corpus is part of the project");
    files
        .map(|file| fs::read(file.expect("an entry").path()).expect("it is read"))
        .collect()
}

#[test]
fn the_corpus_has_a_calibration_of_each_kind() {
    let files = corpus();
    assert!(files.len() >= 3);
    files.iter().for_each(|bytes| checks::calibration(bytes));
}

proptest! {
    #[test]
    fn any_bytes_are_a_calibration_or_refused(
        file in any::<prop::sample::Index>(),
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..4),
        length in any::<prop::sample::Index>(),
    ) {
        let files = corpus();
        let mut bytes = file.get(&files).clone();
        for (place, byte) in changes {
            let at = place.index(bytes.len());
            bytes[at] = byte;
        }
        checks::calibration(&bytes);
        bytes.truncate(length.index(bytes.len() + 1));
        checks::calibration(&bytes);
    }
}
