//! `--split` and `--keep` as a user sees them: the files, the verbs that read them as one recording, and the
//! refusals.

use std::fs::File;
use std::path::Path;

use jde_log::Recording;

use crate::support::{Said, app, jde, jde_with_plugins, json, said};

/// Records a run whose mission is done, in files of two seconds each.
fn record(folder: &Path, more: &[&str]) -> Said {
    let (app, file) = (app("room.toml"), folder.join("drive.mcap"));
    let mut args = vec!["run", &app, "--lockstep", "--json", "--record"];
    args.push(file.to_str().expect("a path of a test"));
    args.extend(more);
    said(&mut jde_with_plugins(&args))
}

#[test]
fn a_split_drive_is_told_drawn_and_decided_again_like_one() {
    let folder = tempfile::tempdir().unwrap();
    let run = record(folder.path(), &["--split", "2s"]);
    assert_eq!(run.status, Some(0), "{}", run.err);
    let recorded = &json(&run.out)["recording"];
    let count = recorded["parts"]["count"].as_u64().unwrap();
    assert!(count > 2, "{recorded}");
    assert!(run.err.contains(&format!(" in {count} files, ")), "{}", run.err);
    let second = folder.path().join("drive-002.mcap");
    for asked in [folder.path(), &folder.path().join("drive.mcap"), &second] {
        let told = said(&mut jde(&["info", asked.to_str().unwrap(), "--json"]));
        assert_eq!(told.status, Some(0), "{}", told.err);
        let told = json(&told.out);
        assert_eq!(told["messages"], recorded["kept"]);
        assert_eq!(told["parts"]["files"].as_array().unwrap().len() as u64, count);
    }
    let words = said(&mut jde(&["info", folder.path().to_str().unwrap()])).out;
    assert!(words.contains(&format!("in {count} files: ")), "{words}");
    assert!(words.contains("drive-001.mcap"), "{words}");

    let second = second.to_str().unwrap();
    let again = said(&mut jde_with_plugins(&["replay", "--decide", second]));
    assert_eq!(again.status, Some(0), "{}{}", again.out, again.err);

    let page = folder.path().join("page.html");
    let page = page.to_str().unwrap();
    for verb in [["report", page], ["plot", &page.replace("html", "png")]] {
        let done = said(&mut jde(&[verb[0], second, "-o", verb[1]]));
        assert_eq!(done.status, Some(0), "{}", done.err);
    }
    let first = folder.path().join("drive-001.mcap");
    let over = said(&mut jde(&["plot", second, "-o", first.to_str().unwrap()]));
    assert_eq!(over.status, Some(2), "another part is the recording too");

    // Without its first part a recording can be described, but not decided again.
    std::fs::remove_file(first).unwrap();
    let told = said(&mut jde(&["info", second]));
    assert!(
        told.out.contains("the first part is not there any more"),
        "{}",
        told.out
    );
    let text = said(&mut jde(&["report", second, "-o", "-"])).out;
    assert!(text.contains("the first part is not there any more"));
    let again = said(&mut jde_with_plugins(&["replay", "--decide", second]));
    assert_eq!(again.status, Some(2), "{}", again.err);
    assert!(
        again.err.contains("does not begin with the start"),
        "{}",
        again.err
    );
}

#[test]
fn what_is_kept_of_a_drive_is_bounded() {
    let folder = tempfile::tempdir().unwrap();
    let run = record(folder.path(), &["--split", "1s", "--keep", "200kB"]);
    assert_eq!(run.status, Some(0), "{}", run.err);
    assert!(run.err.contains(" deleted: "), "{}", run.err);
    let recording = Recording::open(folder.path()).unwrap();
    assert!(recording.first_part() > Some(1));
    let bytes: u64 = recording.files().map(|file| file.metadata().unwrap().len()).sum();
    assert!(bytes <= 200_000, "{bytes}");
}

#[test]
fn what_another_run_writes_is_left_alone_and_named() {
    let folder = tempfile::tempdir().unwrap();
    let part = folder.path().join("drive-001.mcap");
    assert_eq!(record(folder.path(), &["--split", "2s"]).status, Some(0));
    // A recording that is being written holds this lock.
    let written = File::open(&part).unwrap();
    written.lock().unwrap();
    let run = record(folder.path(), &["--split", "2s", "--overwrite"]);
    assert_eq!(run.status, Some(0), "{}", run.err);
    let left = format!("{} not deleted because another recording", part.display());
    assert!(run.err.contains(&left), "{}", run.err);
    assert_eq!(
        json(&run.out)["recording"]["parts"]["left"][0],
        part.to_str().unwrap()
    );

    let whole = folder.path().join("drive.mcap");
    std::fs::write(&whole, "all of it").unwrap();
    let written = File::open(&whole).unwrap();
    written.lock().unwrap();
    let refused = record(folder.path(), &["--overwrite"]);
    assert_eq!(refused.status, Some(2), "{}", refused.err);
    assert!(
        refused.err.contains("drive.mcap is being written by another"),
        "{}",
        refused.err
    );
    assert_eq!(std::fs::read_to_string(&whole).unwrap(), "all of it");
}

#[test]
fn nonsense_is_refused_before_anything_is_written() {
    for (more, words) in [
        (&["--split", "5parsecs"][..], "neither a size nor a time"),
        (&["--split", "10kB"], "from 100 kB"),
        (&["--split", "100kB"], "1 MB or more"),
        (&["--split", "0.1s"], "1 s or more"),
        (&["--keep", "1GB"], "--split"),
        (&["--split", "1GB", "--keep", "1.5GB"], "less than two files"),
        (&["--split", "1GB", "--when", "collision"], "cannot be used with"),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let refused = record(folder.path(), more);
        assert_eq!(refused.status, Some(2), "{more:?}: {}", refused.err);
        assert!(refused.err.contains(words), "{more:?}: {}", refused.err);
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().to_str().unwrap();
    let nothing = said(&mut jde(&["info", path]));
    assert!(nothing.err.contains("holds no recording"), "{}", nothing.err);
}
