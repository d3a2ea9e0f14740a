//! Bags of ROS 2: which files of a folder belong to one. rosbag2 states it in `metadata.yaml`, in versions 1 to 9 of that
//! file. It reads no messages.

use std::collections::BTreeSet;
use std::fs;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

use jde_files::LeftOut;
use saphyr_parser::{Event, Parser};

use crate::part::Mark;

/// The file that makes a folder a bag.
const METADATA: &str = "metadata.yaml";
/// The largest such file: it names each topic and each file.
const MOST_BYTES: u64 = 16 << 20;
/// The most files that it may list: recorders begin one every few minutes.
const MOST_FILES: usize = 10_000;
/// Before this version the names of files begin with that of the bag's folder.
const NAMES_IN_FOLDER: u32 = 4;
/// How the names of files with messages end, and what is added if they are packed.
const EXTENSIONS: [&str; 2] = [".mcap", ".db3"];
const PACKED: &str = ".zstd";

/// The files of a bag.
#[derive(Debug, Default)]
pub(crate) struct Bag {
    /// In their order. Empty if the folder has none.
    pub(crate) files: Vec<PathBuf>,
    /// Files that are listed and missing, or not listed.
    pub(crate) left_out: LeftOut,
}

/// The key of everything that `metadata.yaml` says.
const BAG: &str = "rosbag2_bagfile_information";

/// A mapping or a list around a place of the file.
struct YamlNode {
    /// The key whose value it is; empty in a list.
    name: String,
    /// Whether it is itself a key.
    is_key: bool,
    /// Of a mapping, the key whose value is next, if that was read.
    key: Option<Option<String>>,
}

/// What `metadata.yaml` says of the files.
#[derive(Debug, Default, PartialEq, Eq)]
struct Listed {
    version: u32,
    files: Vec<String>,
}

/// Whether a file contains messages, by its name.
pub(crate) fn is_recording(path: &Path) -> bool {
    stem(path).is_some()
}

/// Returns the name without the ending of files with messages.
fn stem(path: &Path) -> Option<&str> {
    let name = path.file_name()?.to_str()?;
    let name = name.strip_suffix(PACKED).unwrap_or(name);
    EXTENSIONS
        .iter()
        .find_map(|extension| name.strip_suffix(extension))
}

/// Returns the bag in a folder. `None` if it is no bag: it has no `metadata.yaml`, and files whose names rosbag2 would not
/// have given them.
///
/// # Errors
/// The folder cannot be read, or none of the listed files exists.
pub(crate) fn find(folder: &Path) -> io::Result<Option<Bag>> {
    let mut present = Vec::new();
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if is_recording(&path) && path.is_file() {
            present.push(path);
        }
    }
    // `bag_10` is behind `bag_9`.
    present.sort_by(|a, b| (a.as_os_str().len(), a).cmp(&(b.as_os_str().len(), b)));
    let metadata = folder.join(METADATA);
    // Tools of ROS 2 describe folders of recordings in parts, too, whose files say themselves what they belong to.
    if present.iter().any(|path| matches!(Mark::read(path), Ok(Some(_)))) {
        return Ok(None);
    }
    if !metadata.is_file() {
        // A bag whose recorder was killed has no `metadata.yaml`.
        let name = folder
            .canonicalize()?
            .file_name()
            .map(|name| name.to_string_lossy().into_owned());
        let is_numbered = |path: &PathBuf| is_numbered(stem(path), name.as_deref());
        let is_bag = present.len() > 1 && present.iter().all(is_numbered);
        return Ok(is_bag.then(|| Bag {
            files: present,
            left_out: LeftOut::default(),
        }));
    }
    let mut left_out = LeftOut::default();
    let read = jde_files::read_text(&metadata, MOST_BYTES).map_err(|error| error.to_string());
    let listed = read
        .and_then(|text| Listed::read(&text))
        .unwrap_or_else(|reason| {
            left_out.add(
                METADATA,
                None,
                format_args!("{reason}; all files of the folder are read as one bag"),
            );
            Listed::default()
        });
    if listed.files.is_empty() {
        return Ok(Some(Bag {
            files: present,
            left_out,
        }));
    }
    let mut files = Vec::new();
    let mut known = BTreeSet::new();
    for name in &listed.files {
        match listed.resolve(folder, name) {
            None => left_out.add(
                format_args!("the file {name}"),
                None,
                format_args!("{METADATA} lists it, and it is missing"),
            ),
            Some(path) if known.insert(path.canonicalize()?) => files.push(path),
            Some(_) => left_out.add(
                format_args!("the file {name}"),
                None,
                format_args!("{METADATA} lists it twice"),
            ),
        }
    }
    for path in &present {
        if !known.contains(&path.canonicalize()?) {
            let name = path.file_name().unwrap_or_default().display().to_string();
            let what = format!("the file {name}");
            left_out.add(what, None, format_args!("{METADATA} does not list it"));
        }
    }
    if files.is_empty() {
        let lines: Vec<_> = left_out.lines().collect();
        return Err(io::Error::new(ErrorKind::NotFound, lines.join("; ")));
    }
    Ok(Some(Bag { files, left_out }))
}

/// Whether a name is that of the folder with a number, as rosbag2 names the files of a bag.
fn is_numbered(stem: Option<&str>, folder: Option<&str>) -> bool {
    let number = stem
        .zip(folder)
        .and_then(|(stem, folder)| stem.strip_prefix(folder)?.strip_prefix('_'));
    number.is_some_and(|digits| !digits.is_empty() && digits.bytes().all(|byte| byte.is_ascii_digit()))
}

impl Listed {
    /// Reads the version and the names of the files, without building a tree: aliases cannot multiply anything.
    ///
    /// # Errors
    /// It is no YAML, or not that of a bag.
    fn read(text: &str) -> Result<Self, String> {
        let mut listed = Self::default();
        let mut others = Vec::new();
        let mut around: Vec<YamlNode> = Vec::new();
        let mut is_bag = false;
        for event in Parser::new_from_str(text) {
            let (event, _) = event.map_err(|error| format!("it is not YAML: {error}"))?;
            let value = match event {
                Event::Scalar(value, ..) => value,
                // An alias may stand for a name of a key, of which none is needed.
                Event::Alias(_) => "".into(),
                Event::MappingStart(..) | Event::SequenceStart(..) => {
                    let (name, is_key) = match around.last_mut() {
                        Some(YamlNode { key: Some(key), .. }) => {
                            let name = key.take();
                            let is_key = name.is_none();
                            (name, is_key)
                        }
                        Some(YamlNode { key: None, .. }) | None => (None, false),
                    };
                    let is_mapping = matches!(event, Event::MappingStart(..));
                    is_bag |= around.len() == 1 && name.as_deref() == Some(BAG);
                    around.push(YamlNode {
                        name: name.unwrap_or_default(),
                        is_key,
                        key: is_mapping.then_some(None),
                    });
                    continue;
                }
                Event::MappingEnd | Event::SequenceEnd => {
                    let ended = around.pop();
                    if ended.is_some_and(|ended| ended.is_key)
                        && let Some(YamlNode { key: Some(key), .. }) = around.last_mut()
                    {
                        *key = Some(String::new());
                    }
                    continue;
                }
                _ => continue,
            };
            let key = match around.last_mut() {
                Some(YamlNode { key: Some(key), .. }) => match key.take() {
                    Some(key) => key,
                    None => {
                        *key = Some(value.into_owned());
                        continue;
                    }
                },
                Some(YamlNode { key: None, .. }) | None => String::new(),
            };
            let path = around.iter().map(|node| node.name.as_str()).chain([key.as_str()]);
            // Deeper nodes say nothing of the files, and a hostile file may be deep.
            let path: Vec<&str> = path.take(6).collect();
            match path.as_slice() {
                ["", BAG, "version"] => listed.version = value.parse().unwrap_or_default(),
                ["", BAG, "relative_file_paths", ""] => listed.files.push(value.into_owned()),
                ["", BAG, "files", "", "path"] => others.push(value.into_owned()),
                _ => {}
            }
        }
        if !is_bag {
            return Err("it says nothing of a bag".to_owned());
        }
        if listed.files.is_empty() {
            listed.files = others;
        }
        if listed.files.len() > MOST_FILES {
            return Err(format!("it lists more than {MOST_FILES} files"));
        }
        Ok(listed)
    }

    /// Returns the path of a listed file. `None` if there is none.
    fn resolve(&self, folder: &Path, name: &str) -> Option<PathBuf> {
        let parent = folder.parent().filter(|_| self.version < NAMES_IN_FOLDER);
        let stated = parent.map(|parent| parent.join(name));
        // Bags are renamed, and packed ones of version 4 have names as before it.
        let own = Path::new(name).file_name().map(|name| folder.join(name));
        // Others unpack the files and leave the list as it is.
        let unpacked = own
            .as_ref()
            .and_then(|own| Some(own.to_str()?.strip_suffix(PACKED)?.into()));
        let places = [Some(folder.join(name)), stated, own.clone(), unpacked];
        places.into_iter().flatten().find(|path| path.is_file())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const VERSION_9: &str = "\
rosbag2_bagfile_information:
  version: 9
  storage_identifier: mcap
  duration:
    nanoseconds: 2900000000
  topics_with_message_count:
    - topic_metadata:
        name: /scan
        type: sensor_msgs/msg/LaserScan
        offered_qos_profiles:
          - history: keep_last
            path: no
      message_count: 30
  relative_file_paths:
    - office_0.mcap
    - office_1.mcap
  files:
    - path: office_0.mcap
      message_count: 30
  custom_data: ~
";

    fn folder(names: &[&str]) -> tempfile::TempDir {
        let outer = tempfile::tempdir().unwrap();
        fs::create_dir(outer.path().join("office")).unwrap();
        for name in names {
            fs::write(outer.path().join("office").join(name), "").unwrap();
        }
        outer
    }

    fn found(folder: &Path) -> (Vec<String>, Vec<String>) {
        let bag = find(folder).unwrap().expect("a bag");
        let names = bag
            .files
            .iter()
            .map(|path| path.file_name().unwrap().to_str().unwrap().to_owned());
        (names.collect(), bag.left_out.lines().collect())
    }

    #[test]
    fn the_files_are_those_that_are_listed() {
        let names = [
            "office_0.mcap",
            "office_1.mcap",
            "office_0_recovered.mcap",
            "notes.txt",
        ];
        let outer = folder(&names);
        let folder = outer.path().join("office");
        fs::write(folder.join(METADATA), VERSION_9).unwrap();
        let unlisted = "the file office_0_recovered.mcap is left out: metadata.yaml does not list it";
        let (files, left_out) = found(&folder);
        assert_eq!(
            (files.as_slice(), left_out.as_slice()),
            (
                ["office_0.mcap".to_owned(), "office_1.mcap".to_owned()].as_slice(),
                [unlisted.to_owned()].as_slice()
            )
        );
        fs::remove_file(folder.join("office_1.mcap")).unwrap();
        let missing = "the file office_1.mcap is left out: metadata.yaml lists it, and it is missing";
        assert_eq!(found(&folder).1, [unlisted, missing]);
        fs::remove_file(folder.join("office_0.mcap")).unwrap();
        let error = find(&folder).unwrap_err().to_string();
        assert!(error.contains(missing), "{error}");
    }

    #[test]
    fn names_of_older_versions_and_of_packed_files_are_found() {
        let outer = folder(&["office_0.db3", "office_1.db3.zstd"]);
        let folder = outer.path().join("office");
        for (version, names) in [
            (1, ["office/office_0.db3", "office/office_1.db3.zstd"]),
            (3, ["before/office_0.db3", "before/office_1.db3.zstd"]),
            (4, ["office/office_0.db3.zstd", "office_1.db3.zstd"]),
        ] {
            let [first, second] = names;
            let text = format!("{BAG}: {{version: {version}, relative_file_paths: [{first}, \"{second}\"]}}");
            fs::write(folder.join(METADATA), text).unwrap();
            let expected = ["office_0.db3".to_owned(), "office_1.db3.zstd".to_owned()];
            assert_eq!(found(&folder), (expected.to_vec(), Vec::new()), "{version}");
        }
    }

    #[test]
    fn a_folder_without_a_list_is_a_bag_by_the_names_of_its_files() {
        let outer = folder(&["office_0.db3", "office_10.db3", "office_9.db3"]);
        let folder = outer.path().join("office");
        assert_eq!(
            found(&folder).0,
            ["office_0.db3", "office_9.db3", "office_10.db3"]
        );
        fs::write(folder.join("other_0.db3"), "").unwrap();
        assert!(find(&folder).unwrap().is_none());
    }

    #[test]
    fn a_list_that_cannot_be_read_is_said_and_all_files_are_read() {
        let outer = folder(&["office_0.db3"]);
        let folder = outer.path().join("office");
        for (text, reason) in [
            ("", "it says nothing of a bag"),
            ("image: map.pgm\n", "it says nothing of a bag"),
            ("{", "it is not YAML"),
            ("a: &a [x, x]\nb: [*a, *a]\n", "it says nothing of a bag"),
        ] {
            fs::write(folder.join(METADATA), text).unwrap();
            let (files, left_out) = found(&folder);
            assert_eq!(files, ["office_0.db3"]);
            assert!(left_out[0].contains(reason), "{left_out:?}");
        }
        let deep = format!("{BAG}: {}{}", "[".repeat(200), "]".repeat(200));
        fs::write(folder.join(METADATA), deep).unwrap();
        assert_eq!(found(&folder).0, ["office_0.db3"]);
    }
}
