//! World files and robot files. A world file is TOML with walls, boxes, circles, movers, people, balls, a
//! painted floor, a map and the starts of robots.
//!
//! The faults of a world and its map are reported together. The reader ignores nothing.

mod chargers;
mod document;
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

use toml::de::DeTable;

use self::document::{Document, Table};
use crate::camera::Light;
use crate::charger::Charger;
use crate::error::{Fault, WorldError};
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
pub(crate) use jde_map_file::nearest;
use jde_map_file::{Kind, MAX_TEXT};

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

pub(crate) fn read(text: &str, path: &Path) -> Result<WorldFile, Vec<Fault>> {
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
    jde_files::read_text(path, MAX_TEXT).map_err(|error| {
        // What is no text, or too long for one, may be of a known kind.
        let kind = Kind::of_file(path);
        WorldError::Faults(vec![Fault {
            file: path.to_owned(),
            line: None,
            message: match kind {
                Some(kind) => other_kind(kind, path, what),
                None => format!("cannot read the {what}: {error}"),
            },
        }])
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
    read: impl FnOnce(&Document<'_>, &Table<'_>) -> Option<T>,
) -> Result<T, Vec<Fault>> {
    let (root, errors) = DeTable::parse_recoverable(text);
    let document = Document::new(path, text);
    let kind = Kind::of(text.as_bytes()).filter(|kind| *kind != Kind::Toml && !errors.is_empty());
    if let Some(kind) = kind {
        document.fault(&(0..0), other_kind(kind, path, what));
        return Err(document.into_faults());
    }
    for error in &errors {
        document.fault(&error.span().unwrap_or(0..0), error.message());
    }
    // The tree is unreliable after a syntax error.
    if !errors.is_empty() {
        return Err(document.into_faults());
    }
    let root = Table::new(&document, root.get_ref(), 0..0, what.to_owned(), keys);
    let plan = read(&document, &root);
    let faults = document.into_faults();
    // A fault that affects no value, such as an unknown key, also refuses the file.
    plan.filter(|_| faults.is_empty()).ok_or(faults)
}

/// Reads all parts before it returns, so that every fault is reported.
fn parse_world(document: &Document<'_>, root: &Table<'_>) -> Option<WorldFile> {
    let file_name = document
        .path()
        .file_stem()
        .map(|stem| stem.to_string_lossy().into_owned());
    let name = root.optional("name", file_name.unwrap_or_default(), values::text);
    let stated = starts::bounds(document, root);
    let reference_length = root.optional("reference_length", None, |item| values::positive(item).map(Some));
    let map = map::read(document, root);
    let floor = floor::read(document, root);
    let light = scenery::light(document, root);
    let tags = tags::read(document, root);
    let chargers = chargers::read(document, root);
    let things = fixtures::read(document, root);
    let balls = loose::balls(document, root);
    let movers = movers::read(document, root);
    let starts = starts::starts(document, root);
    let (name, stated, map, floor, light, tags) = (name?, stated?, map?, floor?, light?, tags?);
    let chargers = chargers?;
    let ((mut fixtures, mut loose), movers, starts) = (things?, movers?, starts?);
    let reference_length = reference_length?;
    loose.extend(balls?);

    if starts.len() > MAX_ROBOTS {
        root.fault(
            root.span(),
            format!("{} robots: expected at most {MAX_ROBOTS}", starts.len()),
        );
    }
    let mut is_valid = starts.len() <= MAX_ROBOTS;
    for (count, what) in [
        (movers.len(), "movers and people"),
        (loose.len(), "balls and movable boxes"),
    ] {
        if count > MAX_MOVING {
            root.fault(
                root.span(),
                format!("{count} {what}: expected at most {MAX_MOVING}"),
            );
            return None;
        }
    }
    fixtures.extend(map.iter().flat_map(map::Map::fixtures));
    let scene = Scene::new(fixtures);
    for (start, span) in &starts {
        let point = [start.pose.x, start.pose.y];
        if let Some(reason) = misplaced(point, &scene, stated, map.as_ref()) {
            document.fault(span, format!("robot `{}` starts {reason}", start.robot));
            is_valid = false;
        }
    }
    let movers_at_start: Vec<_> = movers
        .iter()
        .map(|(plan, _)| mover::Mover::new(plan.clone()))
        .collect();
    if !room::check(document, &scene, &movers_at_start, &loose) || !is_valid {
        return None;
    }
    let mut warnings: Vec<_> = map.iter().flat_map(map::Map::warnings).collect();
    if scene.is_empty() {
        warnings.push(document.fault_at(
            root.span(),
            "no walls: the world has no fixed things, and range sensors measure nothing",
        ));
    }
    let mut samples = 0;
    for (mover, span) in &movers {
        let mut obstacles: Vec<&str> = Vec::new();
        let solids: Vec<_> = mover::Mover::along(mover, STRIDE, MAX_SAMPLES).collect();
        samples += solids.len();
        if samples > MAX_ALL_SAMPLES {
            let length = MAX_ALL_SAMPLES as f64 * STRIDE / 1e3;
            document.fault(
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
            warnings.push(document.fault_at(span, text));
        }
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
        warnings,
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
