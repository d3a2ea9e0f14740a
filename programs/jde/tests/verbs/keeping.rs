//! `jde experiment` in a folder with results of before.

use std::fs;

use jde_watchdog::Watchdog;

use crate::experimenting::{experiment, lines, pair};

#[test]
fn an_experiment_that_runs_again_keeps_the_results_of_before_and_says_where() {
    let _watchdog = Watchdog::for_test();
    let folder = tempfile::tempdir().unwrap();
    pair(folder.path());
    let first = experiment(folder.path(), &["pair.toml"]);
    assert!(!first.err.contains("before"), "{}", first.err);
    let results = folder.path().join("results");
    let [now, before] = ["pair", "pair.before"].map(|name| results.join(name));
    let of_first = lines(&now);
    for (old, new) in [("1..6", "1..2"), ("1..2", "1..3")] {
        let file = folder.path().join("pair.toml");
        let text = fs::read_to_string(&file).unwrap();
        fs::write(&file, text.replace(old, new)).unwrap();
        let kept = lines(&now);
        let again = experiment(folder.path(), &["pair.toml"]);
        assert!(
            again
                .err
                .contains("the results of before are in results/pair.before"),
            "{}",
            again.err
        );
        assert_eq!(lines(&before), kept);
        assert_ne!(lines(&now), kept);
    }
    assert_ne!(lines(&before), of_first, "the last ones");
}
