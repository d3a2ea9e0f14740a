//! The files that a world includes: where they are, and each read once.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use jde_files::Budget;

use super::xml::{self, Document, Node};
use crate::import::{MAX_TEXT, decoded};

/// Folders above the one of a file in which a model is searched.
const ABOVE: usize = 4;
/// The newest version of SDF that is known.
const NEWEST: [u32; 2] = [1, 12];
/// Models that Gazebo brings along and that are no obstacles.
const FLOORS_AND_LIGHTS: [&str; 2] = ["ground_plane", "sun"];

/// Why a model is not in the world.
pub(super) enum Missing {
    /// It is the floor, or a light.
    Floor,
    Because(String),
}

/// The models of a world.
pub(super) struct Models {
    /// The folders that the user states.
    folders: Vec<PathBuf>,
    read: HashMap<PathBuf, Rc<Document>>,
}

impl Models {
    pub(super) fn new(folders: &[PathBuf]) -> Self {
        Self {
            folders: folders.to_vec(),
            read: HashMap::new(),
        }
    }

    /// Returns the file that a URI in another file denotes.
    pub(super) fn find(&self, uri: &str, from: &Path, budget: &mut Budget) -> Result<PathBuf, Missing> {
        let (scheme, name) = uri.split_once("://").unwrap_or(("", uri));
        let is_web = matches!(scheme, "http" | "https");
        // On the Web, `OWNER/models/NAME`, and sometimes a version.
        let name = if is_web {
            let mut parts = name
                .trim_end_matches('/')
                .split('/')
                .skip_while(|part| *part != "models");
            parts.nth(1).unwrap_or_default()
        } else {
            name
        };
        let near = from.parent().unwrap_or(Path::new(""));
        let places = if is_web && name.is_empty() {
            Vec::new()
        } else if scheme == "file" || (scheme.is_empty() && Path::new(name).is_absolute()) {
            vec![near.join(name)]
        } else {
            let above = near.ancestors().take(ABOVE).map(|folder| match folder {
                folder if folder.as_os_str().is_empty() => Path::new("."),
                folder => folder,
            });
            let beside = above.flat_map(|folder| [folder.join(name), folder.join("models").join(name)]);
            self.folders
                .iter()
                .map(|folder| folder.join(name))
                .chain(beside)
                .collect()
        };
        let mut reasons = Vec::new();
        for place in places.iter().filter(|place| place.exists()) {
            if place.is_file() {
                return Ok(place.clone());
            }
            match model_file(place, budget) {
                Ok(file) => return Ok(file),
                Err(reason) => reasons.push(reason),
            }
        }
        let plain = name.to_ascii_lowercase().replace(' ', "_");
        if FLOORS_AND_LIGHTS.contains(&plain.as_str()) {
            return Err(Missing::Floor);
        }
        Err(Missing::Because(match reasons.into_iter().next() {
            Some(reason) => reason,
            None if is_web => {
                "it is on the Web: download it, and name the folder that contains its folder with \
                `--models DIR`"
                    .to_owned()
            }
            None if scheme == "file" => "there is no such file".to_owned(),
            None => format!(
                "it is neither in {} nor near it: name the folder that contains it with `--models DIR`",
                match self.folders.as_slice() {
                    [] => near_name(near),
                    folders => shown(folders),
                }
            ),
        }))
    }

    /// Returns the elements of a file.
    pub(super) fn read(&mut self, file: &Path, budget: &mut Budget) -> Result<Rc<Document>, String> {
        if let Some(document) = self.read.get(file) {
            return Ok(Rc::clone(document));
        }
        let document = read(file, budget)?;
        self.read.insert(file.to_owned(), Rc::clone(&document));
        Ok(document)
    }
}

fn read(file: &Path, budget: &mut Budget) -> Result<Rc<Document>, String> {
    let at = |message: String| format!("{}: {message}", file.display());
    let bytes = jde_files::read_unpacked(file, MAX_TEXT).map_err(|error| at(error.to_string()))?;
    budget.hold(bytes.len()).map_err(|error| at(error.to_string()))?;
    let parsed = Document::parse(&decoded(bytes), Some(file), budget);
    parsed.map_err(|(line, message)| at(format!("line {line}: {message}")))
}

/// Returns the SDF file of a model's folder: of those that its `model.config` names, the newest that is known.
fn model_file(folder: &Path, budget: &mut Budget) -> Result<PathBuf, String> {
    let configs = ["model.config", "manifest.xml"].map(|name| folder.join(name));
    let plain = folder.join("model.sdf");
    let Some(config) = configs.iter().find(|config| config.is_file()) else {
        let message = || format!("{} has no model.config", folder.display());
        return if plain.is_file() {
            Ok(plain)
        } else {
            Err(message())
        };
    };
    let document = read(config, budget)?;
    let files = document.root(&["model"]).into_iter().flat_map(|model| {
        let files: Vec<_> = model.children_named("sdf").collect();
        files
    });
    let version = |file: &Node| xml::version(file.attribute("version").unwrap_or_default());
    let known = files.filter(|file| version(file) <= NEWEST && !file.text().is_empty());
    let newest = known.max_by_key(version).map(|file| folder.join(file.text()));
    match newest {
        Some(file) if file.is_file() => Ok(file),
        Some(file) => Err(format!(
            "{} names {}, which is not a file",
            config.display(),
            file.display()
        )),
        None => Err(format!("{} names no SDF file", config.display())),
    }
}

fn near_name(folder: &Path) -> String {
    match folder.as_os_str().is_empty() {
        true => "this folder".to_owned(),
        false => folder.display().to_string(),
    }
}

fn shown(folders: &[PathBuf]) -> String {
    const MAX_SHOWN: usize = 3;
    let names: Vec<_> = folders
        .iter()
        .take(MAX_SHOWN)
        .map(|folder| folder.display().to_string())
        .collect();
    let more = if folders.len() > MAX_SHOWN { ", ..." } else { "" };
    format!("{}{more}", names.join(", "))
}
