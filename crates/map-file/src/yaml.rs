//! The YAML file of a ROS map: its keys, their lines, and the image that it names.
//!
//! Trinary maps only. Unknown keys are ignored, as by a map server.

use std::path::{Path, PathBuf};

use saphyr::{LoadableYamlNode, MarkedYaml, Scalar, YamlData};

use crate::fault::Fault;
use crate::picture::{self, Picture};
use crate::similar::nearest;

/// The contents of the file, image included.
pub(crate) struct MapInfo {
    pub(crate) picture: Picture,
    /// The length of a cell's side in metres.
    pub(crate) resolution: f64,
    /// The lower left corner of the image in the world: x, y in metres and the heading in radians.
    pub(crate) origin: [f64; 3],
    /// Whether white is occupied.
    pub(crate) negate: bool,
    /// The likelihood above which a cell is occupied.
    pub(crate) occupied: f64,
    /// The likelihood below which a cell is free.
    pub(crate) free: f64,
}

struct MapYaml<'a> {
    path: &'a Path,
    root: MarkedYaml<'a>,
    faults: Vec<Fault>,
}

/// Returns the image that this text of the YAML file names.
pub(crate) fn image(path: &Path, text: &str) -> Option<PathBuf> {
    MapYaml::new(path, text).ok()?.image()
}

/// Reads the file and its image. Returns all faults of both.
pub(crate) fn read(path: &Path, text: &str) -> Result<MapInfo, Vec<Fault>> {
    let mut yaml = MapYaml::new(path, text)?;
    let is_likelihood = |value: f64| (0.0..=1.0).contains(&value);
    let image = yaml.image();
    let resolution = yaml.number("resolution", None, "more than 0 m", |value| {
        value > 0.0 && value <= 1e3
    });
    let origin = yaml.origin();
    let negate = yaml.negate();
    // The default thresholds classify the usual shade of unknown cells, 205, as unknown.
    let occupied = yaml.number("occupied_thresh", Some(0.65), "0 to 1", is_likelihood);
    let free = yaml.number("free_thresh", Some(0.196), "0 to 1", is_likelihood);
    yaml.mode();
    if let (Some(occupied), Some(free)) = (occupied, free)
        && free > occupied
    {
        yaml.fault(
            "free_thresh",
            format!("is {free}: expected at most `occupied_thresh`, {occupied}"),
        );
    }
    let picture = image.and_then(|image| {
        picture::read(&image)
            .map_err(|fault| yaml.faults.push(fault))
            .ok()
    });
    match (picture, resolution, origin, negate, occupied, free) {
        (Some(picture), Some(resolution), Some(origin), Some(negate), Some(occupied), Some(free))
            if yaml.faults.is_empty() =>
        {
            Ok(MapInfo {
                picture,
                resolution,
                origin,
                negate,
                occupied,
                free,
            })
        }
        _ => Err(yaml.faults),
    }
}

impl<'a> MapYaml<'a> {
    fn new(path: &'a Path, text: &'a str) -> Result<Self, Vec<Fault>> {
        let single = |line, message| {
            vec![Fault {
                file: path.to_owned(),
                line: Some(line),
                message,
            }]
        };
        let documents = MarkedYaml::load_from_str(text)
            .map_err(|error| single(error.marker().line(), format!("invalid YAML: {}", error.info())))?;
        let Some(root) = documents.into_iter().next().filter(|root| root.data.is_mapping()) else {
            return Err(single(
                1,
                "expected the YAML of a map: image, resolution, origin, ...".to_owned(),
            ));
        };
        Ok(Self {
            path,
            root,
            faults: Vec::new(),
        })
    }
}

impl MapYaml<'_> {
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

    fn origin(&mut self) -> Option<[f64; 3]> {
        let node = self.get("origin")?;
        let values: Option<Vec<f64>> = node
            .data
            .as_sequence()
            .and_then(|items| items.iter().map(float).collect());
        match values.as_deref() {
            Some(&[x, y, yaw]) if [x, y, yaw].iter().all(|value| value.abs() <= 1e5) => Some([x, y, yaw]),
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
                "is not `trinary`: scaled and raw maps contain probabilities, but a world needs cells that are occupied or free",
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

    /// Returns a required key. If it is missing, the fault names the most similar key.
    fn get(&mut self, key: &str) -> Option<&MarkedYaml<'_>> {
        if self.find(key).is_none() {
            let mapping = self.root.data.as_mapping()?;
            let similar = nearest(key, mapping.keys().filter_map(|name| name.data.as_str()));
            let hint = similar
                .map(|similar| format!("; is `{similar}` meant for it?"))
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
