//! `--split` and `--keep`: the files, the verbs that read them as one recording, and invalid options.

use std::fs::File;
use std::path::Path;

use jde_log::Recording;

use crate::support::{RunOutput, app, jde, jde_with_plugins, json, output_of};

/// Records a run that completes its mission.
fn record(folder: &Path, options: &[&str]) -> RunOutput {
    let (app, file) = (app("room.toml"), folder.join("drive.mcap"));
    let mut args = vec!["run", &app, "--lockstep", "--json", "--record"];
    args.push(file.to_str().expect("the path is UTF-8"));
    args.extend(options);
    output_of(&mut jde_with_plugins(&args))
}

#[test]
fn info_report_plot_and_replay_read_a_split_recording_as_one() {
    let folder = tempfile::tempdir().unwrap();
    let run = record(folder.path(), &["--split", "2s"]);
    assert_eq!(run.status, Some(0), "{}", run.err);
    let recorded = &json(&run.out)["recording"];
    let count = recorded["parts"]["count"].as_u64().unwrap();
    assert!(count > 2, "{recorded}");
    assert!(run.err.contains(&format!(" in {count} files, ")), "{}", run.err);
    let second = folder.path().join("drive-002.mcap");
    for path in [folder.path(), &folder.path().join("drive.mcap"), &second] {
        let info = output_of(&mut jde(&["info", path.to_str().unwrap(), "--json"]));
        assert_eq!(info.status, Some(0), "{}", info.err);
        let info = json(&info.out);
        assert_eq!(info["messages"], recorded["kept"]);
        assert_eq!(info["parts"]["files"].as_array().unwrap().len() as u64, count);
    }
    let text = output_of(&mut jde(&["info", folder.path().to_str().unwrap()])).out;
    assert!(text.contains(&format!("in {count} files: ")), "{text}");
    assert!(text.contains("drive-001.mcap"), "{text}");

    let second = second.to_str().unwrap();
    let again = output_of(&mut jde_with_plugins(&["replay", "--decide", second]));
    assert_eq!(again.status, Some(0), "{}{}", again.out, again.err);

    let page = folder.path().join("page.html");
    let page = page.to_str().unwrap();
    for verb in [["report", page], ["plot", &page.replace("html", "png")]] {
        let done = output_of(&mut jde(&[verb[0], second, "-o", verb[1]]));
        assert_eq!(done.status, Some(0), "{}", done.err);
    }
    let first = folder.path().join("drive-001.mcap");
    let overwrite = output_of(&mut jde(&["plot", second, "-o", first.to_str().unwrap()]));
    assert_eq!(overwrite.status, Some(2), "plot must not overwrite a part");

    // A recording without its first part can be described, but not replayed.
    std::fs::remove_file(first).unwrap();
    let info = output_of(&mut jde(&["info", second]));
    assert!(
        info.out.contains("the first part no longer exists"),
        "{}",
        info.out
    );
    let text = output_of(&mut jde(&["report", second, "-o", "-"])).out;
    assert!(text.contains("the first part no longer exists"));
    let again = output_of(&mut jde_with_plugins(&["replay", "--decide", second]));
    assert_eq!(again.status, Some(2), "{}", again.err);
    assert!(
        again.err.contains("does not begin with the start"),
        "{}",
        again.err
    );
}

#[test]
fn keep_limits_the_size_of_a_recording() {
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
fn files_that_another_recording_is_writing_are_reported_and_not_deleted() {
    let folder = tempfile::tempdir().unwrap();
    let part = folder.path().join("drive-001.mcap");
    assert_eq!(record(folder.path(), &["--split", "2s"]).status, Some(0));
    // A recording that is being written holds this lock.
    let written = File::open(&part).unwrap();
    written.lock().unwrap();
    let run = record(folder.path(), &["--split", "2s", "--overwrite"]);
    assert_eq!(run.status, Some(0), "{}", run.err);
    let warning = format!("{} is not deleted: another recording", part.display());
    assert!(run.err.contains(&warning), "{}", run.err);
    assert_eq!(
        json(&run.out)["recording"]["parts"]["left"][0]["file"],
        part.to_str().unwrap()
    );

    let unsplit = folder.path().join("drive.mcap");
    std::fs::write(&unsplit, "content").unwrap();
    let written = File::open(&unsplit).unwrap();
    written.lock().unwrap();
    let refused = record(folder.path(), &["--overwrite"]);
    assert_eq!(refused.status, Some(2), "{}", refused.err);
    assert!(
        refused.err.contains("drive.mcap is being written by another"),
        "{}",
        refused.err
    );
    assert_eq!(std::fs::read_to_string(&unsplit).unwrap(), "content");
}

#[test]
fn invalid_options_are_reported_before_anything_is_written() {
    for (options, error) in [
        (&["--split", "5parsecs"][..], "neither a size nor a time"),
        (&["--split", "10kB"], "from 100 kB"),
        (&["--split", "100kB"], "1 MB or more"),
        (&["--split", "0.1s"], "1 s or more"),
        (&["--keep", "1GB"], "--split"),
        (&["--split", "1GB", "--keep", "1.5GB"], "less than two files"),
        (&["--split", "1GB", "--when", "conflict"], "cannot be used with"),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let refused = record(folder.path(), options);
        assert_eq!(refused.status, Some(2), "{options:?}: {}", refused.err);
        assert!(refused.err.contains(error), "{options:?}: {}", refused.err);
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().to_str().unwrap();
    let nothing = output_of(&mut jde(&["info", path]));
    assert!(nothing.err.contains("holds no recording"), "{}", nothing.err);
}
