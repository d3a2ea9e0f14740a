//! World files and robot files. A world file is TOML with walls, boxes, circles, movers, people, balls, a
//! painted floor, a map and the starts of robots.
//!
//! The faults of a world and its map are reported together. The reader ignores nothing.

mod chargers;
mod edits;
mod fixtures;
mod floor;
mod grid;
mod loose;
mod map;
mod movers;
mod robot;
mod room;
mod scenery;
mod starts;
mod tags;
mod values;

use std::path::Path;

use jde_document::{Fault, FaultReport, Faults, Section};
use jde_map_file::Kind;

use crate::camera::Light;
use crate::charger::Charger;
use crate::error::WorldError;
use crate::floor::{Floor, Paint};
use crate::geometry::{Bounds, Pose2};
use crate::loose::LooseBody;
use crate::mover;
use crate::random::MAX_ROBOTS;
use crate::scene::Scene;
use crate::tag::Tag;

pub(crate) use self::edits::read as read_edits;
pub(crate) use self::fixtures::BoxPlan;
pub(crate) use self::robot::read as read_robot;

/// The distance between checks for things in the way of a mover, in metres. A very long way has
/// [`MAX_SAMPLES`] checks.
const STRIDE: f64 = 0.05;
/// Most checks along a way: half a kilometre.
const MAX_SAMPLES: usize = 10_000;
/// Most checks along all ways.
const MAX_ALL_SAMPLES: usize = 1_000_000;
/// Most movers and people, and most things that can be pushed: each is compared with each.
const MAX_MOVING: usize = 2000;

/// A world whose files have no faults.
pub(crate) struct WorldFile {
    pub(crate) name: String,
    pub(crate) scene: Scene,
    pub(crate) movers: Vec<mover::Mover>,
    pub(crate) loose: Vec<LooseBody>,
    pub(crate) floor: Floor,
    pub(crate) light: Light,
    pub(crate) tags: Vec<Tag>,
    pub(crate) chargers: Vec<Charger>,
    /// In the order of the robots' names.
    pub(crate) starts: Vec<Start>,
    pub(crate) bounds: Bounds,
    /// The length of the reference path from the start to the goal of a benchmark, in metres.
    pub(crate) reference_length: Option<f64>,
    pub(crate) warnings: Vec<Fault>,
}

/// The start of a robot.
pub(crate) struct Start {
    pub(crate) robot: String,
    pub(crate) pose: Pose2,
    /// What states it: a file and a line, or words.
    pub(crate) source: String,
}

pub(crate) fn read(text: &str, path: &Path) -> Result<WorldFile, Faults> {
    let keys = [
        "name",
        "map",
        "bounds",
        "reference_length",
        "floor",
        "floor_areas",
        "floor_lines",
        "sky",
        "light",
        "tags",
        "chargers",
        "walls",
        "boxes",
        "circles",
        "movers",
        "people",
        "balls",
        "robots",
    ];
    parse(text, path, "world", &keys, parse_world)
}

/// Returns the text of a file; `what` names its content in errors.
pub(crate) fn load(path: &Path, what: &str) -> Result<String, WorldError> {
    jde_document::read(path, &format!("a {what} file")).map_err(|faults| {
        // What is no text, or too long for one, may be of a known kind.
        let kind = Kind::of_file(path).filter(|kind| *kind != Kind::Toml);
        WorldError::Faults(match kind {
            Some(kind) => Fault::of_file(path, other_kind(kind, path, what)).into(),
            None => faults,
        })
    })
}

/// Returns what to do with a file of another kind; `what` was expected.
pub(crate) fn other_kind(kind: Kind, path: &Path, what: &str) -> String {
    let way = match what {
        "robot" => "`jde new robot NAME` writes a robot file",
        _ => kind.way_to_world(),
    };
    let way = way.replace("FILE", &path.display().to_string());
    format!("it is {kind}, and no {what} file: {way}")
}

/// Parses a text whose root has the given keys.
fn parse<T>(
    text: &str,
    path: &Path,
    what: &str,
    keys: &[&str],
    read: impl FnOnce(&mut FaultReport<'_>, &Section<'_>) -> Option<T>,
) -> Result<T, Faults> {
    let mut report = FaultReport::new(path, text);
    let Some(document) = jde_document::parse(&mut report, text) else {
        let kind = Kind::of(text.as_bytes()).filter(|kind| *kind != Kind::Toml);
        return Err(match kind {
            Some(kind) => Fault::of_file(path, other_kind(kind, path, what)).into(),
            None => report.into_faults(),
        });
    };
    let root = Section::new(format!("the {what}"), 0..0, document.get_ref());
    root.refuse_unknown(&mut report, keys);
    match read(&mut report, &root) {
        // A fault that affects no value, such as an unknown key, also refuses the file.
        Some(content) => report.finish().map(|_| content),
        None => Err(report.into_faults()),
    }
}

/// Reads all parts before it returns, so that every fault is reported.
fn parse_world(report: &mut FaultReport<'_>, root: &Section<'_>) -> Option<WorldFile> {
    let file_name = report
        .file()
        .file_stem()
        .map(|stem| stem.to_string_lossy().into_owned());
    let name = root.optional(report, "name", file_name.unwrap_or_default(), values::text);
    let stated = starts::bounds(report, root);
    let reference_length = root.optional(report, "reference_length", None, |node| {
        values::positive(node).map(Some)
    });
    let map = map::read(report, root);
    let floor = floor::read(report, root);
    let light = scenery::light(report, root);
    let tags = tags::read(report, root);
    let chargers = chargers::read(report, root);
    let things = fixtures::read(report, root);
    let balls = loose::balls(report, root);
    let movers = movers::read(report, root);
    let starts = starts::starts(report, root);
    let (name, stated, map, floor, light, tags) = (name?, stated?, map?, floor?, light?, tags?);
    let chargers = chargers?;
    let ((mut fixtures, mut loose), movers, starts) = (things?, movers?, starts?);
    let reference_length = reference_length?;
    loose.extend(balls?);

    if starts.len() > MAX_ROBOTS {
        let message = format!("has {} robots: expected at most {MAX_ROBOTS}", starts.len());
        root.fault(report, &root.key_span("robots"), message);
    }
    let mut is_valid = starts.len() <= MAX_ROBOTS;
    for (count, what) in [
        (movers.len(), "movers and people"),
        (loose.len(), "balls and movable boxes"),
    ] {
        if count > MAX_MOVING {
            root.fault(
                report,
                &root.span,
                format!("has {count} {what}: expected at most {MAX_MOVING}"),
            );
            return None;
        }
    }
    fixtures.extend(map.iter().flat_map(map::Map::fixtures));
    let scene = Scene::new(fixtures);
    for (start, span) in &starts {
        let point = [start.pose.x, start.pose.y];
        if let Some(reason) = misplaced(point, &scene, stated, map.as_ref()) {
            report.fault(span, format!("robot `{}` starts {reason}", start.robot));
            is_valid = false;
        }
    }
    let movers_at_start: Vec<_> = movers
        .iter()
        .map(|(plan, _)| mover::Mover::new(plan.clone()))
        .collect();
    if !room::check(report, &scene, &movers_at_start, &loose) || !is_valid || report.count() > 0 {
        return None;
    }
    let mut doubts = Vec::new();
    if scene.is_empty() {
        let text = "no walls: the world has no fixed things, and range sensors measure nothing";
        doubts.push((&root.span, text.to_owned()));
    }
    let mut samples = 0;
    for (mover, span) in &movers {
        let mut obstacles: Vec<&str> = Vec::new();
        let solids: Vec<_> = mover::Mover::along(mover, STRIDE, MAX_SAMPLES).collect();
        samples += solids.len();
        if samples > MAX_ALL_SAMPLES {
            let length = MAX_ALL_SAMPLES as f64 * STRIDE / 1e3;
            report.fault(
                span,
                format!("the ways of all movers have more than {length} km: shorten them"),
            );
            return None;
        }
        obstacles.extend(solids.iter().flat_map(|solid| scene.near(solid, 0.0)));
        obstacles.sort_unstable();
        obstacles.dedup();
        if !obstacles.is_empty() {
            let text = format!(
                "the way of mover `{}` crosses `{}`: the mover passes through",
                mover.name,
                obstacles.join("`, `")
            );
            doubts.push((span, text));
        }
    }
    for (span, text) in doubts {
        report.concern(span, text);
    }
    let ways = movers.iter().flat_map(|(mover, _)| mover.path.iter().copied());
    let corners = scene
        .corners()
        .chain(map.iter().flat_map(map::Map::corners))
        .chain(floor.paints.iter().flat_map(Paint::corners))
        .chain(ways)
        .chain(loose.iter().flat_map(|(body, _)| body.corners()));
    let around = Bounds::around(corners.chain(starts.iter().map(|(start, _)| [start.pose.x, start.pose.y])));
    let bounds = stated.or(around).unwrap_or(Bounds {
        min: [0.0; 2],
        max: [0.0; 2],
    });
    let loose = loose.into_iter().map(|(body, _)| body).collect();
    let starts = starts.into_iter().map(|(start, _)| start).collect();
    Some(WorldFile {
        name,
        scene,
        movers: movers_at_start,
        loose,
        floor,
        light,
        tags,
        chargers,
        starts,
        bounds,
        reference_length,
        warnings: (map.iter().flat_map(map::Map::warnings))
            .chain(report.concerns().iter().cloned())
            .collect(),
    })
}

/// Returns why no robot, however small, can start at a point.
fn misplaced(
    point: [f64; 2],
    scene: &Scene,
    stated: Option<Bounds>,
    map: Option<&map::Map>,
) -> Option<String> {
    /// The largest gap that rounding alone can cause, in metres.
    const NONE: f64 = 1e-9;
    if let Some(bounds) = stated.filter(|bounds| !bounds.contains(point)) {
        let Bounds { min, max } = bounds;
        return Some(format!("outside the bounds {min:?} to {max:?}"));
    }
    if let Some(reason) = map.and_then(|map| map.misplaced(point)) {
        return Some(reason);
    }
    let (name, gap) = scene.nearest(point.into())?;
    (gap <= NONE).then(|| format!("inside `{name}`: move it to free ground"))
}
