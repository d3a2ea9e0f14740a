//! ROS occupancy maps: the YAML file of a map server, and what its image means.
//!
//! Trinary maps only. Cells that are occupied become solid; unknown ones do not, but no robot starts there.

use std::fs;
use std::path::{Path, PathBuf};

use saphyr::{LoadableYamlNode, MarkedYaml, Scalar, YamlData};

use super::document::{self, Document, Table};
use super::grid::{Cell, Grid};
use super::picture::{self, Picture};
use crate::error::Fault;
use crate::geometry::Pose2;
use crate::scene::Fixture;
use crate::shape::Outline;

pub(crate) struct Map {
    name: String,
    /// Metres a side of a cell.
    resolution: f64,
    /// The lower left corner of the image in the world.
    origin: Pose2,
    grid: Grid,
}

/// The YAML file, as far as its lines can be believed.
struct Sheet<'a> {
    path: &'a Path,
    root: MarkedYaml<'a>,
    faults: Vec<Fault>,
}

/// The map that the world names, if it names one.
pub(crate) fn read(document: &Document<'_>, root: &Table<'_>) -> Option<Option<Map>> {
    let Some(item) = root.get("map") else {
        return Some(None);
    };
    let name = root.required("map", document::text)?;
    let path = document.path().parent().unwrap_or(Path::new("")).join(&name);
    let text = match fs::read_to_string(&path) {
        Ok(text) => text,
        Err(error) => {
            root.fault(
                &item.span(),
                format!("cannot read the map `{}`: {error}", path.display()),
            );
            return None;
        }
    };
    match load(&name, &path, &text) {
        Ok(map) => Some(Some(map)),
        Err(faults) => {
            faults.into_iter().for_each(|fault| document.push(fault));
            None
        }
    }
}

impl Map {
    pub(crate) fn fixtures(&self) -> impl Iterator<Item = Fixture> {
        self.grid.blocks().into_iter().map(|block| {
            let (left, right) = (block.left as f64, block.right as f64);
            let (bottom, top) = (block.bottom as f64, block.top as f64);
            let outline = Outline::Box {
                center: self.at((left + right) / 2.0, (bottom + top) / 2.0),
                size: [(right - left) * self.resolution, (top - bottom) * self.resolution],
                angle: self.origin.heading,
            };
            Fixture {
                name: self.name.clone(),
                outline,
            }
        })
    }

    /// The four corners of the image in the world.
    pub(crate) fn corners(&self) -> [[f64; 2]; 4] {
        let (width, height) = (self.grid.width as f64, self.grid.height as f64);
        [
            self.at(0.0, 0.0),
            self.at(width, 0.0),
            self.at(0.0, height),
            self.at(width, height),
        ]
    }

    /// Why a robot cannot start at a point of the world, as far as the map knows.
    pub(crate) fn misplaced(&self, [x, y]: [f64; 2]) -> Option<String> {
        let (sin, cos) = libm::sincos(self.origin.heading);
        let (dx, dy) = (x - self.origin.x, y - self.origin.y);
        let (column, row) = (
            (cos * dx + sin * dy) / self.resolution,
            (cos * dy - sin * dx) / self.resolution,
        );
        let inside =
            (0.0..self.grid.width as f64).contains(&column) && (0.0..self.grid.height as f64).contains(&row);
        let cell = inside.then(|| self.grid.cells[row as usize * self.grid.width + column as usize]);
        match cell {
            Some(Cell::Free) => None,
            Some(Cell::Occupied) => Some(format!("inside `{}`: move it to free ground", self.name)),
            Some(Cell::Unknown) => Some(format!("on unknown ground of `{}`", self.name)),
            None => Some(format!("outside the map `{}`", self.name)),
        }
    }

    /// A point of the world from columns and rows.
    fn at(&self, column: f64, row: f64) -> [f64; 2] {
        let point = self
            .origin
            .compose(Pose2::new(column * self.resolution, row * self.resolution, 0.0));
        [point.x, point.y]
    }
}

fn load(name: &str, path: &Path, text: &str) -> Result<Map, Vec<Fault>> {
    let single = |line, message| {
        vec![Fault {
            file: path.to_owned(),
            line,
            message,
        }]
    };
    let documents =
        MarkedYaml::load_from_str(text).map_err(|error| single(None, format!("not sound YAML: {error}")))?;
    let Some(root) = documents.into_iter().next().filter(|root| root.data.is_mapping()) else {
        return Err(single(
            Some(1),
            "expected the YAML of a map: image, resolution, origin, ...".to_owned(),
        ));
    };
    let mut sheet = Sheet {
        path,
        root,
        faults: Vec::new(),
    };
    let image = sheet.image();
    let resolution = sheet.number("resolution", None, "more than 0 m", |value| {
        value > 0.0 && value <= 1e3
    });
    let origin = sheet.origin();
    let negate = sheet.negate();
    // Without thresholds, those with which the usual shade of unknown ground, 205, is unknown.
    let occupied = sheet.number("occupied_thresh", Some(0.65), "0 to 1", |value| {
        (0.0..=1.0).contains(&value)
    });
    let free = sheet.number("free_thresh", Some(0.196), "0 to 1", |value| {
        (0.0..=1.0).contains(&value)
    });
    sheet.mode();
    if let (Some(occupied), Some(free)) = (occupied, free)
        && free > occupied
    {
        sheet.fault(
            "free_thresh",
            format!("is {free}: expected at most `occupied_thresh`, {occupied}"),
        );
    }
    let picture = image.and_then(|image| {
        picture::read(&image)
            .map_err(|fault| sheet.faults.push(fault))
            .ok()
    });
    match (picture, resolution, origin, negate, occupied, free) {
        (Some(picture), Some(resolution), Some(origin), Some(negate), Some(occupied), Some(free))
            if sheet.faults.is_empty() =>
        {
            let grid = judge(&picture, negate, occupied, free);
            Ok(Map {
                name: name.to_owned(),
                resolution,
                origin,
                grid,
            })
        }
        _ => Err(sheet.faults),
    }
}

/// What the shades mean: the darker, the likelier a cell is occupied; the other way round when negated.
fn judge(picture: &Picture, negate: bool, occupied: f64, free: f64) -> Grid {
    let cell = |&shade: &f32| {
        let likely = f64::from(if negate { shade } else { 1.0 - shade });
        if likely > occupied {
            Cell::Occupied
        } else if likely < free {
            Cell::Free
        } else {
            Cell::Unknown
        }
    };
    let cells = picture
        .shades
        .chunks_exact(picture.width)
        .rev()
        .flatten()
        .map(cell)
        .collect();
    Grid {
        width: picture.width,
        height: picture.height,
        cells,
    }
}

impl Sheet<'_> {
    fn image(&mut self) -> Option<PathBuf> {
        let name = match &self.get("image")?.data {
            YamlData::Value(Scalar::String(name)) if !name.is_empty() => name.to_string(),
            _ => {
                self.fault("image", "is not the name of a file");
                return None;
            }
        };
        Some(self.path.parent().unwrap_or(Path::new("")).join(name))
    }

    fn origin(&mut self) -> Option<Pose2> {
        let node = self.get("origin")?;
        let values: Option<Vec<f64>> = node
            .data
            .as_sequence()
            .and_then(|items| items.iter().map(float).collect());
        match values.as_deref() {
            Some(&[x, y, yaw]) if [x, y, yaw].iter().all(|value| value.abs() <= 1e5) => {
                Some(Pose2::new(x, y, yaw))
            }
            _ => {
                self.fault("origin", "is not [x, y, yaw] in metres and radians");
                None
            }
        }
    }

    fn negate(&mut self) -> Option<bool> {
        match self.find("negate").map(|node| &node.data) {
            None => Some(false),
            Some(YamlData::Value(Scalar::Boolean(negate))) => Some(*negate),
            Some(YamlData::Value(Scalar::Integer(value @ 0..=1))) => Some(*value == 1),
            Some(_) => {
                self.fault("negate", "is neither 0 nor 1");
                None
            }
        }
    }

    fn mode(&mut self) {
        let trinary = match self.find("mode").map(|node| &node.data) {
            None => true,
            Some(data) => data.as_str() == Some("trinary"),
        };
        if !trinary {
            self.fault(
                "mode",
                "is not `trinary`: scaled and raw maps say how likely, a world needs to know",
            );
        }
    }

    fn number(
        &mut self,
        key: &str,
        default: Option<f64>,
        expected: &str,
        fits: impl Fn(f64) -> bool,
    ) -> Option<f64> {
        let node = match (self.find(key), default) {
            (None, Some(default)) => return Some(default),
            (None, None) => return self.get(key).and(None),
            (Some(node), _) => node,
        };
        match float(node) {
            Some(value) if fits(value) => Some(value),
            Some(value) => {
                self.fault(key, format!("is {value}: expected {expected}"));
                None
            }
            None => {
                self.fault(key, format!("is not a number: expected {expected}"));
                None
            }
        }
    }

    fn find(&self, key: &str) -> Option<&MarkedYaml<'_>> {
        let mapping = self.root.data.as_mapping()?;
        mapping
            .iter()
            .find(|(name, _)| name.data.as_str() == Some(key))
            .map(|(_, value)| value)
    }

    /// A key that must be there; when it is not, the fault names the key most like it.
    fn get(&mut self, key: &str) -> Option<&MarkedYaml<'_>> {
        if self.find(key).is_none() {
            let mapping = self.root.data.as_mapping()?;
            let near = super::nearest(key, mapping.keys().filter_map(|name| name.data.as_str()));
            let hint = near
                .map(|near| format!("; is `{near}` meant for it?"))
                .unwrap_or_default();
            self.push(1, format!("`{key}` is missing{hint}"));
        }
        self.find(key)
    }

    fn fault(&mut self, key: &str, message: impl AsRef<str>) {
        let line = self.find(key).map_or(1, |node| node.span.start.line());
        self.push(line, format!("`{key}` {}", message.as_ref()));
    }

    fn push(&mut self, line: usize, message: String) {
        self.faults.push(Fault {
            file: self.path.to_owned(),
            line: Some(line),
            message,
        });
    }
}

fn float(node: &MarkedYaml<'_>) -> Option<f64> {
    match &node.data {
        YamlData::Value(Scalar::Integer(value)) => Some(*value as f64),
        YamlData::Value(Scalar::FloatingPoint(value)) => Some(value.0).filter(|value| value.is_finite()),
        _ => None,
    }
}
