//! Tests of the analysis and its pictures with generated recordings.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, SystemTime};

use jde_core::{Case, Health, State};
use jde_drawing::ColorRole;
use jde_log::{RecordedGroup, RecordedHierarchy, RecordedSchema, Recording};
use jde_recorder::{Origin, Recorder, RecorderOptions, Stamps, Topic};
use jde_records::event::{StateChange, What};
use jde_records::{CandidateRecord, DecidedBy, Decision, RunRecord};
use jde_types::{Mission, Odometry, Pose2D, Truth, Twist, Value};
use tiny_skia::{ColorU8, Pixmap};

use crate::{Analysis, Series, Size, Wanted, draw_recording, page};

mod outlines;
mod overruns;

const SECOND: u64 = 1_000_000_000;

/// Two schemas take turns of ten seconds for a minute while the robot moves along a line. `names` are the
/// schemas.
fn record(file: &Path, names: [&str; 2], has_hierarchy: bool) -> Recording {
    let recorder = recorder(file, has_hierarchy.then(|| hierarchy(names)));
    let odometry = export::<Odometry>(&recorder, "odometry");
    turns(&recorder, names, |time, sequence| {
        let pose = Pose2D::new(time as f64 / 1e9 * 0.1, 0.0, 0.0);
        let value = Odometry::planar(jde_types::Time::default(), pose, Twist::planar(0.1, 0.0));
        odometry.put(value.as_bytes(), at(time, sequence));
    });
    recorder.finish();
    Recording::open(file).unwrap()
}

/// Records the selections of that minute; calls `drive` ten times a second.
fn turns(recorder: &Recorder, names: [&str; 2], drive: impl Fn(u64, u64)) {
    for turn in 0..6 {
        let (winner, loser) = (names[turn % 2], names[(turn + 1) % 2]);
        let time_s = turn as f64 * 10.0;
        let before = (turn > 0).then(|| loser.to_owned());
        recorder.push_record(RunRecord::Decision(decision(time_s, before, winner, names)));
        let states = [
            (loser, State::Winner, State::Checking),
            (winner, State::Ready, State::Winner),
        ];
        for (schema, from, to) in states.into_iter().skip(usize::from(turn == 0)) {
            recorder.push_record(RunRecord::State(StateChange {
                time: (time_s * 1e9) as u64,
                schema: schema.to_owned(),
                from,
                to,
            }));
        }
        for tenth in 0..100 {
            let time = turn as u64 * 10 * SECOND + tenth * SECOND / 10;
            drive(time, time / (SECOND / 10) + 1);
        }
    }
    let faulted = What::HealthChanged {
        schema: names[1].to_owned(),
        health: Health::Faulted("it <broke> & fell".to_owned()),
    };
    recorder.push_record(faulted.at(59_900_000_000).into());
}

pub(crate) fn recorder(file: &Path, hierarchy: Option<RecordedHierarchy>) -> Recorder {
    let options = RecorderOptions {
        origin: Origin {
            application: "turns".to_owned(),
            seed: 7,
            started: SystemTime::UNIX_EPOCH + Duration::from_secs(1000),
            folder: None,
            file: None,
            hierarchy,
        },
        application: None,
        overwrite: true,
        lossless: true,
        on_trouble: Box::new(|trouble| panic!("{trouble}")),
    };
    Recorder::create(file, options).unwrap()
}

/// A topic for a variable that the robot exports.
fn export<T: Value>(recorder: &Recorder, name: &str) -> Topic {
    let about = BTreeMap::from([
        ("variable".to_owned(), format!("robot.{name}")),
        ("access".to_owned(), "export".to_owned()),
    ]);
    recorder.topic(&format!("/robot/{name}"), Arc::new(T::describe()), about)
}

fn at(time: u64, sequence: u64) -> Stamps {
    Stamps {
        published: time,
        measured: time,
        sequence,
    }
}

fn hierarchy(names: [&str; 2]) -> RecordedHierarchy {
    RecordedHierarchy {
        lockstep: false,
        writes: true,
        schemas: names
            .map(|name| RecordedSchema {
                name: name.to_owned(),
                type_name: String::new(),
                period_ns: Some(SECOND / 10),
                ports: Vec::new(),
                commands: Vec::new(),
            })
            .to_vec(),
        groups: vec![RecordedGroup {
            name: "roots".to_owned(),
            members: names.map(str::to_owned).to_vec(),
            policy: Some("sticky".to_owned()),
            takeover_ns: Some(SECOND / 1000),
        }],
    }
}

fn decision(time_s: f64, before: Option<String>, winner: &str, names: [&str; 2]) -> Decision {
    let candidate = |name: &str| CandidateRecord {
        name: name.to_owned(),
        state: State::Ready,
        ready: name == winner,
        urgency: Some(0.5),
    };
    Decision {
        number: 1,
        time_s,
        group: "roots".to_owned(),
        case: Case::Alone,
        candidates: names.map(candidate).to_vec(),
        before,
        choice: Some(winner.to_owned()),
        decider: DecidedBy::Nobody,
        reason: "the only one ready".to_owned(),
        cause: "time was up".to_owned(),
        changed: true,
        takeover_us: Some(1500.0),
        refused: Vec::new(),
    }
}

fn read(recording: &Recording, wanted: Wanted) -> Analysis {
    Analysis::read(recording, wanted, &mut |_| {}).unwrap()
}

fn columns(columns: usize) -> Wanted {
    Wanted {
        columns,
        ..Wanted::default()
    }
}

/// The number of pixels of a column with a colour.
fn count_in_column(pixels: &Pixmap, x: u32, color: ColorU8) -> usize {
    let column = (0..pixels.height()).map(|y| pixels.pixel(x, y).unwrap().demultiply());
    column.filter(|pixel| *pixel == color).count()
}

#[test]
fn a_picture_has_the_given_size_and_its_bands_the_colour_of_the_winner() {
    let folder = tempfile::tempdir().unwrap();
    let recording = record(&folder.path().join("turns.mcap"), ["one", "two"], true);
    assert_bands_have_the_winners_colours(&recording);
}

#[test]
fn without_a_path_every_winner_has_a_colour_too() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("turns.mcap");
    let recorder = recorder(&file, Some(hierarchy(["one", "two"])));
    turns(&recorder, ["one", "two"], |_, _| ());
    recorder.finish();
    let recording = Recording::open(&file).unwrap();
    assert_bands_have_the_winners_colours(&recording);
    let page = page(&read(&recording, columns(600)), "turns.mcap");
    for tone in [ColorRole::Of(0), ColorRole::Of(1)] {
        assert!(page.contains(&format!("background:var({tone})")), "{page}");
    }
}

fn assert_bands_have_the_winners_colours(recording: &Recording) {
    let size = Size {
        width: 1600,
        height: 1067,
    };
    let analysis = read(recording, columns(size.columns()));
    let png = draw_recording(&analysis, size).png().unwrap();
    let pixels = Pixmap::decode_png(&png).unwrap();
    assert_eq!((pixels.width(), pixels.height()), (1600, 1067));
    let area = crate::sheet::times(&analysis, size);
    for second in 0..60_u32 {
        // The last value is a tenth of a second before the end of the minute.
        let share = (second as f32 + 0.5) / 59.9;
        let x = (area.left + area.width * share) as u32;
        let (winner, loser) = if second / 10 % 2 == 0 { (0, 1) } else { (1, 0) };
        let [won, lost] =
            [winner, loser].map(|place| count_in_column(&pixels, x, ColorRole::Of(place).light()));
        assert!(won > 10 && won > 3 * lost, "{second} s: {won} and {lost}");
    }
}

#[test]
fn numbers_are_drawn_in_a_chart() {
    let folder = tempfile::tempdir().unwrap();
    let recording = record(&folder.path().join("turns.mcap"), ["one", "two"], false);
    let series = Series {
        topic: "/robot/odometry".to_owned(),
        variable: "robot.odometry".to_owned(),
        name: "robot.odometry.pose.pose.position.x".to_owned(),
        unit: "m".to_owned(),
        number: Box::new(|message| {
            let bytes = jde_ros::cdr::decode(&Odometry::describe(), message)?;
            Ok(Odometry::from_bytes(&bytes).map(|odometry| odometry.pose2d().x))
        }),
    };
    let wanted = Wanted {
        series: vec![series],
        from: Some(20 * SECOND),
        to: Some(40 * SECOND),
        ..columns(800)
    };
    let analysis = read(&recording, wanted);
    let (least, greatest) = analysis.traces[0].1.range().unwrap();
    assert!(
        (least - 2.0).abs() < 0.02 && (greatest - 4.0).abs() < 0.02,
        "{least} to {greatest}"
    );
    assert_eq!(analysis.groups[0].switches, 3, "at 20, 30 and 40 s");
    let size = Size {
        width: 800,
        height: 600,
    };
    let pixels = draw_recording(&analysis, size).png().unwrap();
    let pixels = Pixmap::decode_png(&pixels).unwrap();
    assert!((0..800).any(|x| count_in_column(&pixels, x, ColorRole::Of(0).light()) > 0));
}

#[test]
fn a_time_range_counts_only_its_own_data() {
    let folder = tempfile::tempdir().unwrap();
    let recording = record(&folder.path().join("turns.mcap"), ["one", "two"], true);
    let counts = |from: u64, to: u64| {
        let wanted = Wanted {
            from: Some(from * SECOND),
            to: Some(to * SECOND),
            ..columns(600)
        };
        let analysis = read(&recording, wanted);
        let selections = analysis.groups.iter().map(|group| group.decisions).sum::<u64>();
        let page = page(&analysis, "turns.mcap");
        assert!(page.contains(&format!("of {selections} selections")), "{page}");
        (
            analysis
                .timeline
                .schemas()
                .iter()
                .map(|schema| schema.counts.faults)
                .sum::<u64>(),
            selections,
        )
    };
    // The only fault was at 59.9 s.
    assert_eq!(counts(15, 45), (0, 3));
    assert_eq!(counts(35, 60), (1, 2));
    assert_eq!(counts(0, 60), (1, 6));
}

#[test]
fn contacts_and_the_least_clearance_are_those_of_the_time_range() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("truth.mcap");
    let record = |first: u64| {
        let recorder = recorder(&file, None);
        let topic = export::<Truth>(&recorder, "truth");
        // Contacts at 10 s and at 30 s; the clearance decreases at 10 s, and again at 50 s.
        for second in first..=60 {
            let truth = Truth {
                collisions: u64::from(second >= 10) + u64::from(second >= 30),
                min_clearance: match second {
                    0..10 => 1.0,
                    10..50 => 0.2,
                    _ => 0.1,
                },
                ..Truth::default()
            };
            topic.put(truth.as_bytes(), at(second * SECOND, second + 1));
        }
        recorder.finish();
        Recording::open(&file).unwrap()
    };
    let counts = |recording: &Recording, from: Option<u64>, to: u64| {
        let wanted = Wanted {
            from: from.map(|from| from * SECOND),
            to: Some(to * SECOND),
            ..columns(600)
        };
        let ending = read(recording, wanted).ending;
        (ending.collisions.unwrap(), ending.min_clearance)
    };
    let recording = record(0);
    assert_eq!(counts(&recording, None, 60), (2, Some(0.1)));
    assert_eq!(counts(&recording, Some(0), 20), (1, Some(0.2)));
    assert_eq!(counts(&recording, Some(20), 40), (1, None));
    assert_eq!(counts(&recording, Some(31), 60), (0, Some(0.1)));
    // Recording started after the robot had driven for a while.
    let recording = record(20);
    assert_eq!(counts(&recording, None, 40), (1, None));
    assert_eq!(counts(&recording, None, 60), (1, Some(0.1)));
}

#[test]
fn a_recording_that_began_later_shows_the_targets_that_it_contains() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("later.mcap");
    let recorder = recorder(&file, None);
    let topic = export::<Mission>(&recorder, "mission");
    for (second, reached) in [(100, 3), (101, 3), (102, 4), (103, 5)] {
        let mission = Mission {
            reached,
            total: 7,
            target: Pose2D::new(f64::from(reached), 0.0, 0.0),
            distance: 1.0,
            ..Mission::default()
        };
        topic.put(mission.as_bytes(), at(second * SECOND, second));
    }
    recorder.finish();
    let recording = Recording::open(&file).unwrap();
    let targets = read(&recording, columns(600)).ending.drive.targets;
    let known: Vec<_> = targets
        .iter()
        .map(|target| (target.number, target.x, target.reached))
        .collect();
    assert_eq!(known, [(4, 3.0, true), (5, 4.0, true), (6, 5.0, false)]);
}

#[test]
fn the_hierarchy_is_derived_if_the_recording_does_not_describe_it() {
    let folder = tempfile::tempdir().unwrap();
    for has_hierarchy in [true, false] {
        let recording = record(&folder.path().join("turns.mcap"), ["one", "two"], has_hierarchy);
        let analysis = read(&recording, columns(600));
        let names: Vec<_> = analysis
            .hierarchy()
            .schemas()
            .iter()
            .map(|schema| schema.name.as_str())
            .collect();
        assert_eq!(names, ["one", "two"]);
        assert_eq!(analysis.hierarchy().groups()[0].members, [0, 1]);
        assert_eq!(
            analysis
                .timeline
                .schemas()
                .iter()
                .map(|schema| schema.counts.takeovers)
                .collect::<Vec<_>>(),
            [3, 3]
        );
        assert_eq!(
            analysis.hierarchy().groups()[0].contract,
            has_hierarchy.then_some(SECOND / 1000)
        );
        let seconds = analysis.bands[0].time(jde_core::State::Winner) as f64 / 1e9;
        assert!((seconds - 30.0).abs() < 0.01, "{seconds}");
    }
}

#[test]
fn r17_a_takeover_beyond_its_contract_is_highlighted() {
    let folder = tempfile::tempdir().unwrap();
    let recording = record(&folder.path().join("turns.mcap"), ["one", "two"], true);
    let page = page(&read(&recording, columns(600)), "turns.mcap");
    assert!(page.contains(r#"<span class="bad">1.50 ms</span>"#), "{page}");
}

#[test]
fn no_name_or_text_of_a_recording_becomes_markup() {
    let folder = tempfile::tempdir().unwrap();
    let malicious = ["<script>alert(1)</script>", "\"><img src=x onerror=alert(2)>"];
    let recording = record(&folder.path().join("evil.mcap"), malicious, true);
    let page = page(&read(&recording, columns(600)), "<b>evil</b>.mcap");
    assert_eq!(page.matches("<script").count(), 1, "the page's own");
    for forbidden in ["<img", "<b>evil", "<broke>", "onerror=alert(2)>"] {
        assert!(!page.contains(forbidden), "{forbidden}");
    }
    assert!(page.contains("&lt;script&gt;alert(1)&lt;/script&gt;"));
}

#[test]
fn the_page_loads_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let recording = record(&folder.path().join("turns.mcap"), ["one", "two"], true);
    let page = page(&read(&recording, columns(600)), "turns.mcap");
    for forbidden in ["http:", "https:", "src=", "@import", "url(//", "<link"] {
        assert!(!page.contains(forbidden), "{forbidden}");
    }
    assert!(page.contains("default-src 'none'"));
}

#[test]
fn a_page_does_not_grow_with_the_length_of_the_recording() {
    let folder = tempfile::tempdir().unwrap();
    let recording = record(&folder.path().join("turns.mcap"), ["one", "two"], true);
    let [fine, coarse] =
        [20_000, 300].map(|count| page(&read(&recording, columns(count)), "turns.mcap").len());
    // Three stretches in each: the number of bars does not depend on that of the columns.
    assert!(fine < 2 * coarse, "{fine} and {coarse}");
}

/// Two robots with different commanders: `one` commands `left`, `two` commands `right`.
fn two_robots(file: &Path) -> Recording {
    let names = ["one", "two"];
    let mut recorded = hierarchy(names);
    for (member, robot) in recorded.schemas.iter_mut().zip(["left", "right"]) {
        member.commands = vec![robot.to_owned()];
    }
    recorded.groups = names
        .iter()
        .map(|name| RecordedGroup {
            name: format!("roots/{name}"),
            members: vec![(*name).to_owned()],
            policy: None,
            takeover_ns: None,
        })
        .collect();
    let recorder = recorder(file, Some(recorded));
    let topics = ["left", "right"].map(|robot| {
        let about = BTreeMap::from([
            ("variable".to_owned(), format!("{robot}.truth")),
            ("access".to_owned(), "export".to_owned()),
        ]);
        recorder.topic(&format!("/{robot}/truth"), Arc::new(Truth::describe()), about)
    });
    for (name, group) in names.iter().zip(["roots/one", "roots/two"]) {
        recorder.push_record(RunRecord::Decision(Decision {
            group: group.to_owned(),
            ..decision(0.5, None, name, names)
        }));
        recorder.push_record(RunRecord::State(StateChange {
            time: 500_000_000,
            schema: (*name).to_owned(),
            from: State::Ready,
            to: State::Winner,
        }));
    }
    for second in 1..=20 {
        for (robot, topic) in topics.iter().enumerate() {
            let truth = Truth {
                pose: Pose2D::new(second as f64 * (1.0 + robot as f64), robot as f64, 0.0),
                ..Truth::default()
            };
            topic.put(truth.as_bytes(), at(second * SECOND, second));
        }
    }
    recorder.finish();
    Recording::open(file).unwrap()
}

#[test]
fn both_paths_of_two_robots_are_reported_with_their_actors() {
    let folder = tempfile::tempdir().unwrap();
    let recording = two_robots(&folder.path().join("two.mcap"));
    let analysis = read(&recording, columns(600));
    let paths = &analysis.ending.drive.paths;
    let reported: Vec<_> = paths
        .iter()
        .map(|path| {
            (
                path.robot.as_str(),
                path.points.len(),
                path.distance,
                path.points[9].winner,
            )
        })
        .collect();
    assert_eq!(
        reported,
        [("left", 20, 19.0, Some(0)), ("right", 20, 38.0, Some(1))]
    );
    let page = page(&analysis, "two.mcap");
    for text in ["19.0 m<small>left</small>", "38.0 m<small>right</small>"] {
        assert!(page.contains(text), "{text}");
    }
}
