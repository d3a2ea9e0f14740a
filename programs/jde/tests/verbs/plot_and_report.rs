//! `jde plot` and `jde report`: the recordings that they accept, their output files, and their errors.

use std::fs::{self, File};
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use html5ever::tendril::TendrilSink;
use jde_log::{Recording, record};
use jde_records::RunRecord;
use jde_types::{Odometry, Pose2D, Twist, Value};
use markup5ever_rcdom::{Handle, NodeData, RcDom};
use mcap::WriteOptions;
use mcap::records::MessageHeader;

use crate::support::{RunOutput, app, jde, jde_with_plugins, output_of, root};

/// Records a short mission in virtual time.
fn record(folder: &Path, options: &[&str]) -> PathBuf {
    let options = [&["--lockstep"], options].concat();
    record_application(&app("room.toml"), folder, &options)
}

/// Records an application.
fn record_application(app: &str, folder: &Path, options: &[&str]) -> PathBuf {
    let file = folder.join("drive.mcap");
    let mut args = vec!["run", app, "--record", file.to_str().unwrap()];
    args.extend(options);
    let run = output_of(&mut jde_with_plugins(&args));
    // A run with `--for` may end before its mission, with exit status 1.
    assert!(
        matches!(run.status, Some(0 | 1)) && run.out.contains("recorded "),
        "{run:?}"
    );
    file
}

/// Runs a verb on a recording.
fn run_on(verb: &str, file: &Path, options: &[&str]) -> RunOutput {
    let mut args = vec![verb, file.to_str().unwrap()];
    args.extend(options);
    output_of(&mut jde(&args))
}

/// Runs a verb on a recording, which must succeed, and returns the content of its output file.
fn written_by(verb: &str, file: &Path, extension: &str) -> Vec<u8> {
    let output = run_on(verb, file, &[]);
    assert_eq!(output.status, Some(0), "{}", output.err);
    let written = file.with_extension(extension);
    assert!(
        output
            .out
            .contains(&*written.file_name().unwrap().to_string_lossy()),
        "{}",
        output.out
    );
    fs::read(written).unwrap()
}

/// Returns the width and height of a PNG.
fn size(png: &[u8]) -> [u32; 2] {
    assert!(png.starts_with(b"\x89PNG\r\n\x1a\n"));
    [16, 20].map(|at| u32::from_be_bytes(png[at..at + 4].try_into().unwrap()))
}

/// A report, parsed as a browser does.
struct Page {
    dom: RcDom,
    html: String,
}

impl Page {
    fn of(file: &Path) -> Self {
        let html = String::from_utf8(written_by("report", file, "html")).unwrap();
        let dom =
            html5ever::parse_document(RcDom::default(), html5ever::ParseOpts::default()).one(html.as_str());
        assert!(dom.errors.borrow().is_empty(), "{:?}", dom.errors.borrow());
        Self { dom, html }
    }

    /// Returns the text of the element with an id.
    fn text(&self, id: &str) -> String {
        let mut text = String::new();
        visit(&self.element(id), &mut |node| {
            if let NodeData::Text { contents } = &node.data {
                text += &contents.borrow();
            }
        });
        text
    }

    /// Returns the number of elements with a name in the element with an id.
    fn count(&self, id: &str, name: &str) -> usize {
        let mut count = 0;
        visit(&self.element(id), &mut |node| {
            if let NodeData::Element { name: found, .. } = &node.data {
                count += usize::from(&*found.local == name);
            }
        });
        count
    }

    /// Returns the texts of the cells of each row in the element with an id.
    fn rows(&self, id: &str) -> Vec<Vec<String>> {
        let named = |node: &Handle, name: &str| match &node.data {
            NodeData::Element { name: found, .. } => &*found.local == name,
            _ => false,
        };
        let mut rows = Vec::new();
        visit(&self.element(id), &mut |node| {
            if named(node, "tr") {
                rows.push(Vec::new());
            } else if named(node, "td") {
                let mut text = String::new();
                visit(node, &mut |node| {
                    if let NodeData::Text { contents } = &node.data {
                        text += &contents.borrow();
                    }
                });
                rows.last_mut().expect("cells are in rows").push(text);
            }
        });
        rows
    }

    fn has(&self, id: &str) -> bool {
        self.find(id).is_some()
    }

    fn element(&self, id: &str) -> Handle {
        self.find(id)
            .unwrap_or_else(|| panic!("no element `{id}`: {}", self.html))
    }

    fn find(&self, id: &str) -> Option<Handle> {
        let mut found = None;
        visit(&self.dom.document, &mut |node| {
            if let NodeData::Element { attrs, .. } = &node.data
                && attrs
                    .borrow()
                    .iter()
                    .any(|attr| &*attr.name.local == "id" && &*attr.value == id)
            {
                found = Some(node.clone());
            }
        });
        found
    }
}

/// Calls `action` for a node and all its descendants.
fn visit(node: &Handle, action: &mut dyn FnMut(&Handle)) {
    action(node);
    for child in node.children.borrow().iter() {
        visit(child, action);
    }
}

#[test]
fn plot_writes_beside_the_recording_or_to_another_file_or_to_standard_output() {
    let folder = tempfile::tempdir().unwrap();
    let file = record(folder.path(), &[]);
    assert_eq!(size(&written_by("plot", &file, "png")), [1200, 800]);
    let other = folder.path().join("other.png");
    let drawn = run_on(
        "plot",
        &file,
        &["--size", "640x900", "-o", other.to_str().unwrap(), "--from", "1s"],
    );
    assert_eq!((drawn.status, drawn.err.as_str()), (Some(0), ""));
    assert_eq!(size(&fs::read(other).unwrap()), [640, 900]);
    let printed = jde(&["plot", file.to_str().unwrap(), "-o", "-", "--from", "0s"])
        .output()
        .unwrap();
    assert_eq!(size(&printed.stdout), [1200, 800]);
    assert!(printed.stderr.is_empty());
    assert_eq!(
        printed.stdout,
        written_by("plot", &file, "png"),
        "the same recording gives the same picture"
    );
}

#[test]
fn plot_draws_named_numbers_and_suggests_names_for_unknown_ones() {
    let folder = tempfile::tempdir().unwrap();
    let file = record(folder.path(), &[]);
    let without = written_by("plot", &file, "png");
    let drawn = run_on(
        "plot",
        &file,
        &[
            "pioneer.odometry.twist.twist.linear.x",
            "goon.period",
            "guide.mission.reached",
        ],
    );
    assert_eq!((drawn.status, drawn.err.as_str()), (Some(0), ""));
    let name = "drive-pioneer.odometry.twist.twist.linear.x-goon.period-guide.mission.reached.png";
    let with = fs::read(file.with_file_name(name)).unwrap();
    assert!(drawn.out.starts_with("wrote "), "{}", drawn.out);
    assert_eq!(written_by("plot", &file, "png"), without, "it is still there");
    let again = run_on("plot", &file, &[]);
    assert!(again.out.starts_with("replaced "), "{}", again.out);
    assert!(size(&with) == [1200, 800] && with != without);
    for (name, error) in [
        ("pioneer.odometri.x", "did you mean `pioneer.odometry`?"),
        ("pioneer.odometry.twist.twist.linear.w", "has no field `w`"),
        ("pioneer.odometry", "is not a number"),
        ("pioneer", "is a schema, not a variable"),
    ] {
        let refused = run_on("plot", &file, &[name]);
        assert_eq!(refused.status, Some(2), "{name}: {refused:?}");
        assert!(refused.err.contains(error), "{name}: {}", refused.err);
    }
}

#[test]
fn invalid_options_are_refused_and_the_recording_is_unchanged() {
    let folder = tempfile::tempdir().unwrap();
    let file = record(folder.path(), &["--for", "2s"]).canonicalize().unwrap();
    let name = file.to_str().unwrap();
    let bytes = fs::read(&file).unwrap();
    for verb in ["plot", "report"] {
        for (options, status, error) in [
            (&["-o", name][..], 2, "is the recording itself"),
            (&["--from", "5s", "--to", "2s"], 2, "--from is not before --to"),
            (&["--from", "1h"], 2, "it goes from 0.000 s to "),
            (&["-o", "/no/such/folder/x"], 1, "/no/such/folder/x: "),
        ] {
            let refused = run_on(verb, &file, options);
            assert_eq!(refused.status, Some(status), "{verb} {options:?}: {refused:?}");
            assert!(refused.err.contains(error), "{verb} {options:?}: {}", refused.err);
        }
        let none = run_on(verb, &folder.path().join("none.mcap"), &[]);
        assert_eq!(none.status, Some(2), "{none:?}");
    }
    assert_eq!(fs::read(&file).unwrap(), bytes);
}

#[test]
fn r15_the_report_lists_every_switch_schema_and_group() {
    let folder = tempfile::tempdir().unwrap();
    let file = record(folder.path(), &[]);
    let recording = Recording::open(&file).unwrap();
    let messages = recording.messages().unwrap().map(Result::unwrap);
    let switches = messages.filter_map(|message| match record::read(&message) {
        Some(RunRecord::Decision(decision)) if decision.changed => Some(decision),
        _ => None,
    });
    let switches: Vec<_> = switches.collect();
    assert!(switches.len() > 2);
    let page = Page::of(&file);
    // The first row is the header.
    assert_eq!(page.count("switches", "tr"), switches.len() + 1);
    let rows = page.text("switches");
    for switch in &switches {
        assert!(rows.contains(&format!("{:.3} s", switch.time_s)) && rows.contains(&switch.reason));
    }
    let schemas = page.text("schemas");
    for name in ["pioneer", "guide", "stop", "vff", "goon"] {
        assert!(schemas.contains(name), "{name} in {schemas}");
    }
    assert!(
        schemas.contains("75 ms") && schemas.contains("50 ms"),
        "{schemas}"
    );
    let groups = page.text("groups");
    assert!(
        groups.contains("guide/base") && groups.contains("father") && groups.contains("155 ms"),
        "{groups}"
    );
    assert!(page.count("path", "svg") == 1 && page.count("states", "svg") == 1);
    assert!(page.html.contains("2 of 2 reached"));
}

/// Scans trigger `stop`, `vff` and `goon`, and the WINNER of them commands once in each iteration. So the
/// number of commands is the number of iterations, and the times between commands are the periods.
#[test]
fn iterations_and_periods_of_triggered_schemas_are_those_of_their_commands() {
    for options in [&["--lockstep"][..], &["--for", "2s"]] {
        let folder = tempfile::tempdir().unwrap();
        let file = record_application(&app("room.toml"), folder.path(), options);
        let recording = Recording::open(&file).unwrap();
        let messages = recording.messages().unwrap().map(Result::unwrap);
        let velocities = messages.filter(|message| message.channel.topic == "/pioneer/velocity");
        // The application itself commands the neutral velocity before the first WINNER and after the last.
        // All numbers of the neutral velocity are 0, after the header of CDR.
        let commands = velocities.filter(|message| message.data[4..].iter().any(|byte| *byte != 0));
        let times: Vec<u64> = commands.map(|message| message.publish_time).collect();
        let rows = Page::of(&file).rows("schemas");
        let rows = rows.iter().filter(|row| {
            row.first()
                .is_some_and(|name| ["stop", "vff", "goon"].contains(&name.as_str()))
        });
        let mut iterations = 0;
        for row in rows {
            let count: usize = row[2].parse().unwrap();
            iterations += count;
            if count > 1 {
                let mean = (times[times.len() - 1] - times[0]) as f64 / (times.len() - 1) as f64 / 1e6;
                let reported: f64 = row[4].strip_suffix(" ms").unwrap().parse().unwrap();
                assert!((reported / mean - 1.0).abs() < 0.2, "{row:?}: {mean} ms");
            }
        }
        // A run in real time may end while the WINNER iterates: the final neutral command takes effect, and
        // the command of that iteration does not.
        let superseded = usize::from(!options.contains(&"--lockstep"));
        let counts = times.len()..=times.len() + superseded;
        assert!(
            counts.contains(&iterations),
            "{options:?}: {iterations} iterations, {} commands",
            times.len()
        );
        assert!(iterations > 5);
    }
}

#[test]
fn partial_and_triggered_recordings_are_reported_and_plotted() {
    let folder = tempfile::tempdir().unwrap();
    let partial = record(folder.path(), &["--record-only", "*.laser"]);
    let page = Page::of(&partial);
    assert!(page.html.contains("There is no path") && !page.has("path") && page.has("switches"));
    size(&written_by("plot", &partial, "png"));
    let options = [
        "--when",
        "guide.mission.reached >= 1u",
        "--before",
        "2s",
        "--after",
        "1s",
        "--overwrite",
    ];
    let triggered = record(folder.path(), &options).with_file_name("drive-001.mcap");
    let page = Page::of(&triggered);
    assert!(
        page.html.contains("guide.mission.reached &gt;= 1u"),
        "{}",
        page.html
    );
    assert!(page.html.contains("turns were not recorded") && page.has("path"));
    // The contracts are known, although the recording has no turns.
    assert!(page.text("groups").contains("155 ms"), "{}", page.text("groups"));
    size(&written_by("plot", &triggered, "png"));
}

#[test]
fn a_damaged_recording_is_reported_up_to_the_damage() {
    let folder = tempfile::tempdir().unwrap();
    // Long enough for several chunks: only complete chunks can be read.
    let app = root().join("apps/safe-navigation.toml");
    let file = record_application(
        app.to_str().unwrap(),
        folder.path(),
        &["--lockstep", "--for", "60s"],
    );
    let bytes = fs::read(&file).unwrap();
    fs::write(&file, &bytes[..bytes.len() * 3 / 4]).unwrap();
    let page = Page::of(&file);
    assert!(page.html.contains("ends too soon, at byte "), "{}", page.html);
    assert!(page.has("switches") && page.has("path"));
    size(&written_by("plot", &file, "png"));
    for verb in ["plot", "report"] {
        let err = run_on(verb, &file, &[]).err;
        assert!(err.contains("ends too soon, at byte "), "{verb}: {err}");
    }
    fs::write(&file, "no recording").unwrap();
    for verb in ["plot", "report"] {
        let none = run_on(verb, &file, &[]);
        assert_eq!(none.status, Some(2));
        assert!(
            none.err.contains("is no MCAP file and no bag of ROS 2"),
            "{none:?}"
        );
    }
}

#[test]
fn a_recording_by_another_program_is_reported_and_plotted() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("ros.mcap");
    let mut writer = WriteOptions::new()
        .create(BufWriter::new(File::create(&file).unwrap()))
        .unwrap();
    // Strings without a bound, as ROS 2 writes them.
    let definition = jde_ros::definition::definition(&Odometry::describe()).replace("<=52", "");
    assert!(!definition.contains("<="), "{definition}");
    let schema = writer
        .add_schema("nav_msgs/msg/Odometry", "ros2msg", definition.as_bytes())
        .unwrap();
    let channel_id = writer
        .add_channel(schema, "/base/odom", "cdr", &Default::default())
        .unwrap();
    let mut message = Vec::new();
    for tenth in 0..102_u32 {
        let pose = Pose2D::new(f64::from(tenth) * 0.1, 1.0, 0.0);
        let value = Odometry::planar(jde_types::Time::default(), pose, Twist::planar(1.0, 0.0));
        jde_ros::cdr::encode(&Odometry::describe(), value.as_bytes(), &mut message);
        if tenth >= 100 {
            // The name of the frame follows its length and is longer; what comes after it stays aligned.
            message[12] += 56;
            message.splice(16..16, [b'x'; 56]);
        }
        let time = 1_700_000_000_000_000_000 + u64::from(tenth) * 100_000_000;
        let header = MessageHeader {
            channel_id,
            sequence: tenth,
            log_time: time,
            publish_time: time,
        };
        writer.write_to_known_channel(&header, &message).unwrap();
    }
    writer.finish().unwrap();
    drop(writer);
    let page = Page::of(&file);
    assert!(
        page.html.contains("no selections were recorded") && page.html.contains("10.1 m"),
        "{}",
        page.html
    );
    assert!(page.has("path") && page.has("topics") && !page.has("switches") && !page.has("schemas"));
    let left_out = "the end of `frame_id` in /base/odom is left out: it has room for 52 bytes (2 times)";
    assert!(page.html.contains(left_out), "{}", page.html);
    let played = run_on("replay", &file, &["--plain", "--speed", "100x"]);
    assert!(
        played.out.contains(&format!("not played: {left_out}")),
        "{played:?}"
    );
    size(&written_by("plot", &file, "png"));
    for name in [
        "base.odom.pose.pose.position.x",
        "/base/odom.pose.pose.position.x",
    ] {
        let drawn = run_on("plot", &file, &[name]);
        assert_eq!((drawn.status, drawn.err.as_str()), (Some(0), ""), "{name}");
    }
}

#[test]
fn an_empty_recording_has_a_report_and_no_plot() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("empty.mcap");
    let mut writer = WriteOptions::new()
        .create(BufWriter::new(File::create(&file).unwrap()))
        .unwrap();
    writer.finish().unwrap();
    drop(writer);
    let page = Page::of(&file);
    assert!(page.html.contains("holds no messages"), "{}", page.html);
    let refused = run_on("plot", &file, &[]);
    assert_eq!(refused.status, Some(2));
    assert!(
        refused.err.contains("nothing that can be drawn"),
        "{}",
        refused.err
    );
}

#[test]
fn completions_offer_the_numbers_of_a_recording() {
    let folder = tempfile::tempdir().unwrap();
    let file = record(folder.path(), &["--for", "1s"]);
    let mut completion = jde(&[
        "--",
        "jde",
        "plot",
        file.to_str().unwrap(),
        "pioneer.odometry.twist.",
    ]);
    completion
        .env("COMPLETE", "bash")
        .env("_CLAP_COMPLETE_INDEX", "3")
        .env("_CLAP_COMPLETE_COMP_TYPE", "9")
        .env("_CLAP_COMPLETE_SPACE", "false")
        .env("_CLAP_IFS", "\n");
    let offered = output_of(&mut completion).out;
    assert!(
        offered
            .lines()
            .any(|word| word == "pioneer.odometry.twist.twist.linear.x"),
        "{offered}"
    );
}
