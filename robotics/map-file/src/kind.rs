//! What a file is, by its content: for messages to somebody who gives a file of another kind than expected, and for
//! readers of several kinds.

use std::fmt;
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// The kind of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Nothing but white space.
    Empty,
    /// A file of jde, such as a world.
    Toml,
    /// The YAML file of a ROS map.
    RosMap,
    /// A map of the benchmarks of MovingAI.
    MovingAi,
    /// A world of Stage.
    Stage,
    /// A world or a model of Gazebo.
    Sdf,
    /// A list of worlds of cylinders, as of the BARN challenge.
    Cylinders,
    /// An image.
    Picture,
    /// A world of Webots.
    Webots,
    /// A robot of ROS.
    Urdf,
    /// Another file in XML.
    Xml,
    /// A body without a scale of its own or a physical meaning.
    Mesh,
    /// A scene in USD.
    Usd,
    /// A drawing.
    Dxf,
    /// A recording or a log of a robot.
    Recording,
    /// A packed file.
    Archive,
}

/// Bytes at the start of a text in which its kind shows.
const HEAD: usize = 16 << 10;

impl Kind {
    /// Returns the kind of a file with this content; `None` if it is another one, or cannot be distinguished.
    #[must_use]
    pub fn of(bytes: &[u8]) -> Option<Self> {
        Self::by_head(&bytes[..bytes.len().min(HEAD)], bytes.len() as u64)
    }

    /// Returns the kind of a regular file, however large; `None` as for its content, or if it cannot be read.
    #[must_use]
    pub fn of_file(path: &Path) -> Option<Self> {
        // Others may have no end, or wait for a writer.
        let about = std::fs::metadata(path).ok().filter(std::fs::Metadata::is_file)?;
        let mut head = Vec::new();
        File::open(path)
            .ok()?
            .take(HEAD as u64)
            .read_to_end(&mut head)
            .ok()?;
        Self::by_head(&head, about.len())
    }

    /// Returns the kind of a file with this start and length.
    fn by_head(head: &[u8], length: u64) -> Option<Self> {
        let head = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(head);
        if head.trim_ascii().is_empty() {
            return Some(Self::Empty);
        }
        if let Some(kind) = by_signature(head, length) {
            return Some(kind);
        }
        if head.contains(&0) {
            return None;
        }
        let text = String::from_utf8_lossy(head);
        let text = text.trim_start();
        if text.starts_with('<') {
            return Some(by_root(text));
        }
        by_lines(text)
    }

    /// Whether a world can be made of such a file, or it may hold one.
    #[must_use]
    pub const fn becomes_world(self) -> bool {
        match self {
            Self::RosMap
            | Self::MovingAi
            | Self::Stage
            | Self::Sdf
            | Self::Cylinders
            | Self::Xml
            | Self::Archive => true,
            Self::Empty
            | Self::Toml
            | Self::Picture
            | Self::Webots
            | Self::Urdf
            | Self::Mesh
            | Self::Usd
            | Self::Dxf
            | Self::Recording => false,
        }
    }

    /// Returns what somebody does who has such a file and needs a ROS map.
    #[must_use]
    pub const fn way_to_map(self) -> &'static str {
        match self {
            Self::Toml => "give the YAML file that its `map` names",
            Self::Picture => PICTURE,
            Self::MovingAi => "`jde new world NAME --from FILE` makes a world and a map of it",
            Self::Recording => {
                "make a map of its scans by an application with `slam`, and give the YAML file of that"
            }
            Self::Archive => "unpack it, and give the YAML file of the map",
            Self::Empty
            | Self::RosMap
            | Self::Stage
            | Self::Sdf
            | Self::Cylinders
            | Self::Webots
            | Self::Urdf
            | Self::Xml
            | Self::Mesh
            | Self::Usd
            | Self::Dxf => "give the YAML file of a map: image, resolution, origin, ...",
        }
    }

    /// Returns what somebody does who has such a file and needs a world.
    #[must_use]
    pub const fn way_to_world(self) -> &'static str {
        match self {
            Self::RosMap | Self::MovingAi | Self::Stage | Self::Sdf | Self::Cylinders => {
                "`jde new world NAME --from FILE` makes a world of it"
            }
            Self::Toml => "name it in an application, by `world`, or change a copy of it",
            Self::Picture => PICTURE,
            Self::Empty => "give a world",
            Self::Webots => {
                "its format is read by Webots alone; write its walls and boxes into a world file, or drive a robot with a laser \
                 through it, save the map that `slam` makes, and give the YAML file of that"
            }
            Self::Urdf => {
                "a robot is described by a robot file (`jde new robot NAME`) and put into a world by an application"
            }
            Self::Xml => "expected SDF, the format of Gazebo, with <sdf> around everything",
            Self::Mesh | Self::Usd | Self::Dxf => {
                "a world has walls, boxes and circles, seen from above: write them into a world file, or draw what stands at the \
                 height of a laser as a picture, dark on white, and give the YAML file of a ROS map that names it"
            }
            Self::Recording => {
                "make a map of its scans by an application with `slam`, and give the YAML file of that"
            }
            Self::Archive => "unpack it, and give the world in it",
        }
    }
}

const PICTURE: &str = "a picture states no lengths: write a YAML file that names it, with `image: NAME.png`, \
    `resolution: 0.05` (metres of a pixel) and `origin: [0, 0, 0]`, and give that file";

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Empty => "an empty file",
            Self::Toml => "a TOML file, such as a world",
            Self::RosMap => "the YAML file of a ROS map",
            Self::MovingAi => "a map of MovingAI",
            Self::Stage => "a world of Stage",
            Self::Sdf => "a world or a model in SDF",
            Self::Cylinders => "a list of worlds of cylinders",
            Self::Picture => "a picture",
            Self::Webots => "a world of Webots",
            Self::Urdf => "a robot in URDF or Xacro",
            Self::Xml => "an XML file of an unknown kind",
            Self::Mesh => "a mesh",
            Self::Usd => "a scene in USD",
            Self::Dxf => "a drawing in DXF",
            Self::Recording => "a recording or a log of a robot",
            Self::Archive => "a packed file",
        })
    }
}

/// The kinds that begin with certain bytes.
fn by_signature(bytes: &[u8], length: u64) -> Option<Kind> {
    const SIGNATURES: [(&[u8], Kind); 21] = [
        (b"\x89PNG", Kind::Picture),
        (b"\xff\xd8\xff", Kind::Picture),
        (b"GIF8", Kind::Picture),
        (b"II*\0", Kind::Picture),
        (b"MM\0*", Kind::Picture),
        (b"\x1f\x8b", Kind::Archive),
        (b"PK\x03\x04", Kind::Archive),
        (b"\x28\xb5\x2f\xfd", Kind::Archive),
        (b"\x89MCAP", Kind::Recording),
        (b"#ROSBAG", Kind::Recording),
        (b"SQLite format 3\0", Kind::Recording),
        (b"# CARMEN", Kind::Recording),
        (b"#usda", Kind::Usd),
        (b"PXR-USDC", Kind::Usd),
        (b"#VRML_SIM", Kind::Webots),
        (b"#VRML", Kind::Mesh),
        (b"glTF", Kind::Mesh),
        (b"ply", Kind::Mesh),
        (b"Kaydara FBX", Kind::Mesh),
        (b"; FBX", Kind::Mesh),
        (b"AutoCAD Binary DXF", Kind::Dxf),
    ];
    let known = SIGNATURES.iter().find(|(start, _)| bytes.starts_with(start));
    let is_netpbm =
        matches!(bytes, [b'P', b'1'..=b'7', next, ..] if next.is_ascii_whitespace() || *next == b'#');
    // The size of the header follows that of the file and four bytes that are mostly 0.
    let is_bmp = bytes.starts_with(b"BM")
        && matches!(
            bytes.get(14..18),
            Some([12 | 40 | 52 | 56 | 64 | 108 | 124, 0, 0, 0])
        );
    let triangles = bytes.get(80..).and_then(|rest| rest.first_chunk());
    let is_binary_stl = triangles.is_some_and(|count| {
        let count = u64::from(u32::from_le_bytes(*count));
        count > 0 && length == 84 + 50 * count
    });
    let is_webp = bytes.starts_with(b"RIFF") && bytes.get(8..12) == Some(b"WEBP");
    known.map(|(_, kind)| *kind).or(match () {
        () if is_netpbm || is_bmp || is_webp => Some(Kind::Picture),
        () if is_binary_stl => Some(Kind::Mesh),
        () => None,
    })
}

/// Returns the kind of a text in XML.
fn by_root(mut text: &str) -> Kind {
    loop {
        let end = match text {
            _ if text.starts_with("<!--") => "-->",
            _ if text.starts_with("<?") => "?>",
            _ if text.starts_with("<!") => ">",
            _ => break,
        };
        let Some(at) = text.find(end) else { break };
        text = text[at + end.len()..].trim_start();
    }
    let name = text.strip_prefix('<').unwrap_or_default();
    let name = name.split(|letter: char| !letter.is_ascii_alphanumeric()).next();
    match name.unwrap_or_default() {
        "sdf" | "gazebo" => Kind::Sdf,
        "robot" => Kind::Urdf,
        "COLLADA" => Kind::Mesh,
        _ => Kind::Xml,
    }
}

/// Returns the kind of another text, by its first lines.
fn by_lines(text: &str) -> Option<Kind> {
    let mut lines = text.lines().map(str::trim).filter(|line| !line.is_empty());
    let mut content = lines
        .clone()
        .filter(|line| !line.starts_with(['#', '%']) && *line != "---");
    let (first, second) = (content.next()?, content.next().unwrap_or_default());
    let word = first.split_whitespace().next().unwrap_or_default();
    let is_key = |line: &str, key: &str| {
        let rest = line.trim_start_matches(['"', '\'']).strip_prefix(key);
        rest.is_some_and(|rest| rest.trim_start_matches(['"', '\'', ' ']).starts_with(':'))
    };
    let is_assigned = first.split_once('=').is_some_and(|(key, _)| {
        let is_part = |letter: char| letter.is_ascii_alphanumeric() || "_-.\"' ".contains(letter);
        key.chars().all(is_part)
    });
    if word == "type" && second.starts_with("height") {
        Some(Kind::MovingAi)
    } else if matches!(first, "0" | "999") && lines.nth(1).is_some() && text.contains("SECTION") {
        Some(Kind::Dxf)
    } else if first.starts_with('[') || is_assigned {
        Some(Kind::Toml)
    } else if content
        .clone()
        .chain([first, second])
        .any(|line| is_key(line, "image") || is_key(line, "occupied_thresh"))
    {
        Some(Kind::RosMap)
    } else if word == "solid" && text.contains("facet") || matches!(word, "v" | "vn" | "o" | "mtllib") {
        Some(Kind::Mesh)
    } else if matches!(
        word,
        "PARAM" | "FLASER" | "RLASER" | "ODOM" | "ROBOTLASER1" | "RAWLASER1"
    ) {
        Some(Kind::Recording)
    } else if word.starts_with(|letter: char| letter.is_ascii_digit()) && first.contains(',') {
        Some(Kind::Cylinders)
    } else if first.starts_with(|letter: char| letter.is_ascii_alphabetic()) && has_entities(text) {
        Some(Kind::Stage)
    } else {
        None
    }
}

/// Whether a text has an entity of Stage, or includes and defines some: a word and `(`, at the start of a line.
fn has_entities(text: &str) -> bool {
    let mut lines = text
        .lines()
        .map(str::trim)
        .filter(|line| !line.is_empty())
        .peekable();
    while let Some(line) = lines.next() {
        let is_word = |text: &str| {
            let is_part = |letter: char| letter.is_ascii_alphanumeric() || letter == '_';
            !text.is_empty() && text.chars().all(is_part)
        };
        let opens = |line: &str| line.split_once('(').is_some_and(|(word, _)| is_word(word.trim()));
        let follows = is_word(line) && lines.peek().is_some_and(|next| next.starts_with('('));
        if opens(line) || follows || line.starts_with("define ") || line.starts_with("include ") {
            return true;
        }
    }
    false
}

#[cfg(test)]
mod tests {
    use super::Kind;

    #[test]
    fn a_file_is_known_by_its_content() {
        let kinds: &[(&[u8], Option<Kind>)] = &[
            (b" \n", Some(Kind::Empty)),
            (b"\xef\xbb\xbf# A map\nimage: m.pgm\n", Some(Kind::RosMap)),
            (b"---\n\"resolution\": 0.1\n'image' : m.pgm\n", Some(Kind::RosMap)),
            (b"# A world\nname = \"room\"\n", Some(Kind::Toml)),
            (b"[[walls]]\n", Some(Kind::Toml)),
            (
                b"type octile\nheight 2\nwidth 2\nmap\n..\n..\n",
                Some(Kind::MovingAi),
            ),
            (
                b"<?xml version='1.0'?>\n<!-- <robot> -->\n<sdf version='1.6'>",
                Some(Kind::Sdf),
            ),
            (b"<robot name='r'/>", Some(Kind::Urdf)),
            (b"<COLLADA/>", Some(Kind::Mesh)),
            (b"<launch/>", Some(Kind::Xml)),
            (b"# Desc: a world\ninclude \"map.inc\"\n", Some(Kind::Stage)),
            (b"resolution 0.02\nwindow\n(\n size [1 1]\n)\n", Some(Kind::Stage)),
            (b"0 1.5,2.0 3,4\n", Some(Kind::Cylinders)),
            (b"P5 1 1 255\n\0", Some(Kind::Picture)),
            (b"#VRML_SIM R2023b utf8\n", Some(Kind::Webots)),
            (b"  0\nSECTION\n  2\nHEADER\n", Some(Kind::Dxf)),
            (b"solid box\n facet normal 0 0 1\n", Some(Kind::Mesh)),
            (b"# OBJ\nv 1 2 3\n", Some(Kind::Mesh)),
            (b"#usda 1.0\n", Some(Kind::Usd)),
            (b"ODOM 0 0 0 0 0 0 0 host 0\n", Some(Kind::Recording)),
            (b"just words\n", None),
            (b"\0\x01\x02", None),
        ];
        for (bytes, expected) in kinds {
            assert_eq!(Kind::of(bytes), *expected, "{}", String::from_utf8_lossy(bytes));
        }
        let mut stl = vec![0; 84 + 50];
        stl[80] = 1;
        assert_eq!(Kind::of(&stl), Some(Kind::Mesh));
    }
}
