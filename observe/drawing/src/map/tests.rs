//! Tests of the maps of drives, by the pixels at given places.

use jde_sim::{Bounds, Outline};
use tiny_skia::{ColorU8, Pixmap};

use super::frame::Frame;
use super::legend::{self, Sign};
use super::*;
use crate::ColorRole;

fn point(time: f64, x: f64, y: f64, winner: Option<usize>) -> PathPoint {
    PathPoint {
        time,
        x,
        y,
        heading: 0.0,
        winner,
    }
}

fn still(outline: Outline) -> Obstacle {
    Obstacle {
        outline,
        moving: false,
    }
}

/// A room of 10 x 6 m: goon drives along y = 2 from x = 1 to 5, vff from there to 9; then no schema, 1 m up.
fn room() -> DriveMap {
    let path = vec![
        point(0.0, 1.0, 2.0, Some(0)),
        point(6.0, 5.0, 2.0, Some(1)),
        point(9.0, 9.0, 2.0, None),
        point(10.0, 9.0, 3.0, None),
    ];
    DriveMap {
        title: "a room".to_owned(),
        bounds: Some(Bounds {
            min: [0.0, 0.0],
            max: [10.0, 6.0],
        }),
        shapes: vec![
            still(Outline::Segment {
                from: [0.0, 6.0],
                to: [10.0, 6.0],
            }),
            still(Outline::Box {
                center: [3.0, 4.5],
                size: [1.0, 1.0],
                angle: 0.5,
            }),
            Obstacle {
                outline: Outline::Circle {
                    center: [7.0, 4.5],
                    radius: 0.5,
                },
                moving: true,
            },
        ],
        paths: vec![RobotPath {
            points: path,
            body: Some(Footprint::Circle { radius: 0.25 }),
            ..RobotPath::default()
        }],
        schema_names: vec!["goon".to_owned(), "vff".to_owned()],
        targets: vec![
            Target {
                number: 1,
                x: 9.0,
                y: 5.0,
                reached: true,
            },
            Target {
                number: 2,
                x: 1.0,
                y: 5.0,
                reached: false,
            },
        ],
        takeovers: vec![Takeover {
            x: 5.0,
            y: 2.0,
            to: 1,
        }],
        ..DriveMap::default()
    }
}

fn frame(drive: &DriveMap) -> Frame {
    Frame::of(drive, &legend::entries(drive, &Palette::of(drive)), true)
}

/// The picture of a drive at one pixel per unit.
fn draw(drive: &DriveMap) -> Pixmap {
    super::draw(drive, true).pixels(1.0)
}

fn color(picture: &Pixmap, (x, y): (f32, f32)) -> ColorU8 {
    picture
        .pixel(x as u32, y as u32)
        .expect("the probe is inside the picture")
        .demultiply()
}

fn probe(drive: &DriveMap, x: f64, y: f64) -> ColorU8 {
    color(&draw(drive), frame(drive).at(x, y))
}

/// The number of pixels in a rectangle that are not white.
fn inked(picture: &Pixmap, columns: std::ops::Range<u32>, rows: std::ops::Range<u32>) -> usize {
    let places = rows.flat_map(|y| columns.clone().map(move |x| (x, y)));
    places
        .filter(|(x, y)| color(picture, (*x as f32, *y as f32)) != ColorRole::Paper.light())
        .count()
}

#[test]
fn the_path_has_the_colour_of_the_winner() {
    let drive = room();
    let palette = Palette::of(&drive);
    let (goon, vff) = (palette.tone(Some(0)).light(), palette.tone(Some(1)).light());
    assert_ne!(goon, vff);
    assert_eq!(probe(&drive, 2.5, 2.0), goon);
    assert_eq!(probe(&drive, 7.5, 2.0), vff);
    assert_eq!(probe(&drive, 9.0, 2.4), ColorRole::Nobody.light());
}

#[test]
fn walls_are_dark_furniture_is_grey_and_movers_are_light() {
    let drive = room();
    assert_eq!(probe(&drive, 2.5, 6.0), ColorRole::Ink.light());
    assert_eq!(probe(&drive, 3.0, 4.5), ColorRole::Furniture.light());
    let moving = probe(&drive, 7.0, 4.6);
    assert!(
        moving.red() > ColorRole::Furniture.light().red() && moving != ColorRole::Paper.light(),
        "{moving:?}"
    );
}

#[test]
fn paint_lies_under_everything_and_the_later_covers_the_earlier() {
    let mut drive = room();
    let square = |x: f64, darkness: f32| Paint {
        outline: Outline::Box {
            center: [x, 2.5],
            size: [2.0, 1.6],
            angle: 0.0,
        },
        darkness,
    };
    drive.paint = vec![square(2.6, 1.0), square(3.6, 0.0)];
    let dark = probe(&drive, 2.2, 2.6);
    assert!((100..200).contains(&dark.red()), "{dark:?}");
    assert_eq!(probe(&drive, 3.2, 2.6), ColorRole::Paper.light());
    let path = Palette::of(&drive).tone(Some(0)).light();
    assert_eq!(probe(&drive, 2.5, 2.0), path);
}

#[test]
fn y_points_up() {
    let drive = room();
    let frame = frame(&drive);
    assert!(frame.at(0.0, 5.0).1 < frame.at(0.0, 1.0).1);
    assert!(frame.at(5.0, 0.0).0 > frame.at(1.0, 0.0).0);
}

#[test]
fn only_a_reached_target_has_a_filled_badge() {
    let drive = room();
    let (picture, frame) = (draw(&drive), frame(&drive));
    let badge = |x, y| {
        let (x, y) = frame.at(x, y);
        color(&picture, (x + 19.0 - 9.0, y - 19.0))
    };
    assert_eq!(badge(9.0, 5.0), ColorRole::Ink.light());
    assert_eq!(badge(1.0, 5.0), ColorRole::Paper.light());
    assert_eq!(color(&picture, frame.at(9.0, 5.0)), ColorRole::Ink.light());
}

#[test]
fn the_badge_of_a_target_hides_neither_the_robot_nor_the_path() {
    let mut drive = room();
    drive.targets = vec![Target {
        number: 1,
        x: 9.0,
        y: 2.7,
        reached: true,
    }];
    // The robot ended at (9, 3), directly above, and came from below: no robot is on the two lower diagonals.
    let frame = frame(&drive);
    let (x, y) = frame.at(9.0, 2.7);
    let picture = draw(&drive);
    assert_eq!(
        color(&picture, (x + 19.0 - 9.0, y + 19.0)),
        ColorRole::Ink.light()
    );
    assert_ne!(
        color(&picture, (x + 19.0 - 9.0, y - 19.0)),
        ColorRole::Ink.light()
    );
}

#[test]
fn the_legend_names_the_winners_with_their_share_and_only_shown_items() {
    let drive = room();
    let texts = |drive: &DriveMap| -> Vec<String> {
        legend::entries(drive, &Palette::of(drive))
            .into_iter()
            .map(|entry| entry.text)
            .collect()
    };
    let expected = [
        "goon 60 %",
        "vff 30 %",
        "nobody 10 %",
        "takeover",
        "start",
        "end",
        "target reached",
        "target missed",
        "mover at start",
    ];
    assert_eq!(texts(&drive), expected);
    assert!(texts(&DriveMap::default()).is_empty());
}

#[test]
fn the_legend_has_ink_for_every_entry() {
    let drive = room();
    let (picture, frame, palette) = (draw(&drive), frame(&drive), Palette::of(&drive));
    for (entry, (x, y)) in legend::entries(&drive, &palette).iter().zip(&frame.legend) {
        assert!(
            inked(&picture, *x as u32..*x as u32 + 120, *y as u32 - 8..*y as u32 + 8) > 50,
            "{entry:?}"
        );
        if let Sign::Path(winner) = entry.sign {
            assert_eq!(color(&picture, (*x + 10.0, *y)), palette.tone(winner).light());
        }
    }
}

#[test]
fn the_title_is_above_the_map() {
    let mut drive = room();
    let with_title = inked(&draw(&drive), 84..400, 20..56);
    drive.title.clear();
    assert_eq!(
        (with_title > 200, inked(&draw(&drive), 84..400, 20..56)),
        (true, 0)
    );
}

#[test]
fn laser_points_show_the_walls_of_a_drive_without_a_world() {
    let mut drive = room();
    (drive.bounds, drive.shapes) = (None, Vec::new());
    drive.scans = (0..1000).map(|beam| (f64::from(beam) / 100.0, 5.0)).collect();
    assert!(probe(&drive, 4.0, 5.0).red() < 200);
    // A single beam through a door does not shrink the map.
    let before = frame(&drive).scale;
    drive.scans.push((500.0, 500.0));
    assert!(frame(&drive).scale > 0.99 * before);
}

#[test]
fn a_wide_world_fills_the_width_and_a_high_one_the_height() {
    let picture_size = |width: f64, height: f64| {
        let bounds = Some(Bounds {
            min: [0.0, 0.0],
            max: [width, height],
        });
        let picture = draw(&DriveMap { bounds, ..room() });
        (picture.width(), picture.height())
    };
    assert_eq!(picture_size(20.0, 14.0).0, 1600);
    assert_eq!(picture_size(200.0, 6.0).0, 1600);
    let (width, height) = picture_size(10.0, 200.0);
    assert!(
        width < 1000 && (1200..1500).contains(&height),
        "{width} x {height}"
    );
}

#[test]
fn an_empty_drive_is_drawn_too() {
    let picture = draw(&DriveMap::default());
    assert!(picture.width() >= 700 && picture.height() >= 500);
}

#[test]
fn a_robot_that_did_not_move_is_visible() {
    let path = vec![point(0.0, 3.0, -4.0, Some(0)); 3];
    let drive = DriveMap {
        paths: vec![RobotPath {
            points: path,
            ..RobotPath::default()
        }],
        ..DriveMap::default()
    };
    let frame = frame(&drive);
    assert!(frame.scale.is_finite() && frame.map.width() > 100.0);
    assert!(inked(&draw(&drive), 0..draw(&drive).width(), 0..draw(&drive).height()) > 0);
}

#[test]
fn empty_and_inverted_bounds_are_tolerated() {
    for (min, max) in [
        ([2.0, 2.0], [2.0, 2.0]),
        ([5.0, 5.0], [-5.0, -5.0]),
        ([f64::NAN, 0.0], [1.0, 1.0]),
        ([0.0, 0.0], [f64::INFINITY, 1.0]),
        ([-1e300, -1e300], [1e300, 1e300]),
        ([1e6, 1e6], [1e6, 1e6]),
        ([0.0, 0.0], [1e6, 1e-9]),
    ] {
        let picture = draw(&DriveMap {
            bounds: Some(Bounds { min, max }),
            ..room()
        });
        assert!(
            picture.width() <= 1600 && picture.height() <= 1600,
            "{min:?} {max:?}"
        );
    }
}

#[test]
fn an_invalid_pose_and_an_unknown_schema_do_not_affect_the_rest() {
    let mut drive = room();
    drive.paths[0]
        .points
        .insert(1, point(f64::NAN, f64::NAN, f64::INFINITY, Some(0)));
    drive.paths[0].points[0].winner = Some(77);
    drive.shapes.push(still(Outline::Circle {
        center: [f64::NAN, 0.0],
        radius: 1.0,
    }));
    drive.targets.push(Target {
        number: 3,
        x: f64::NEG_INFINITY,
        y: 0.0,
        reached: true,
    });
    assert_eq!(draw(&drive).width(), 1600);
    let texts: Vec<String> = legend::entries(&finite(&drive), &Palette::of(&drive))
        .into_iter()
        .map(|entry| entry.text)
        .collect();
    assert!(texts.contains(&"unknown 60 %".to_owned()), "{texts:?}");
}

#[test]
fn more_winners_than_colours_are_distinguished_by_dashes() {
    let path = (0..10)
        .map(|step| point(step as f64, step as f64, 0.0, Some(step)))
        .collect();
    let drive = DriveMap {
        paths: vec![RobotPath {
            points: path,
            ..RobotPath::default()
        }],
        ..DriveMap::default()
    };
    let palette = Palette::of(&drive);
    let mut styles: Vec<_> = (0..10)
        .map(|of| (palette.tone(Some(of)).light(), palette.is_dashed(Some(of))))
        .collect();
    styles.dedup();
    for (index, style) in styles.iter().enumerate() {
        assert!(!styles[..index].contains(style), "winner {index}");
    }
    assert_eq!(styles.len(), 10);
}

#[test]
fn the_same_drive_gives_the_same_picture() {
    assert_eq!(draw(&room()).data(), draw(&room()).data());
}

#[test]
fn every_robot_has_its_path_and_its_name() {
    let mut drive = room();
    let alone = draw(&drive);
    drive.paths[0].robot = "left".to_owned();
    drive.paths.push(RobotPath {
        robot: "right".to_owned(),
        points: vec![point(0.0, 2.0, 1.0, Some(1)), point(4.0, 8.0, 1.0, Some(1))],
        distance: 6.0,
        ..RobotPath::default()
    });
    let vff = Palette::of(&drive).tone(Some(1)).light();
    assert_eq!(probe(&drive, 4.6, 1.0), vff);
    let both = draw(&drive);
    let (x, y) = frame(&drive).at(8.0, 1.0);
    let (x, y) = (x as u32, y as u32);
    // To the right of its end, beyond its radius.
    let name = |picture: &Pixmap| inked(picture, x + 45..x + 75, y - 8..y + 8);
    assert!(
        name(&both) > name(&alone) + 20,
        "the name is beside the end of the path"
    );
    let entries = legend::entries(&drive, &Palette::of(&drive));
    let texts: Vec<_> = entries.iter().map(|entry| entry.text.as_str()).collect();
    assert_eq!(&texts[..3], ["goon 43 %", "vff 50 %", "nobody 7 %"]);
}

#[test]
fn a_schema_that_never_won_has_a_share_of_zero() {
    let mut drive = room();
    drive.takeovers.push(Takeover {
        x: 1.0,
        y: 1.0,
        to: 2,
    });
    drive.schema_names.push("stop".to_owned());
    let entries = legend::entries(&drive, &Palette::of(&drive));
    assert!(
        entries.iter().any(|entry| entry.text == "stop 0 %"),
        "{entries:?}"
    );
}
