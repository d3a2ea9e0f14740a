//! Maps of the benchmarks of MovingAI (Sturtevant, *Benchmarks for Grid-Based Pathfinding*, 2012): a header, and a letter for
//! each cell, by rows from the top.

use std::path::Path;

use jde_document::Fault;
use jde_files::LeftOut;

use crate::picture::{fits, too_large};
use crate::{MapCell, MapFile};

/// The side of a cell, m. The format states none.
const RESOLUTION: f64 = 1.0;

impl MapFile {
    /// Reads the text of a map of MovingAI, the file `path`. A cell has a side of one metre, because the format states no
    /// lengths. Ground and swamp are free; trees, water and what is out of bounds are occupied.
    ///
    /// # Errors
    /// The first fault.
    pub fn parse_moving_ai(path: &Path, text: &str) -> Result<Self, Fault> {
        let mut lines = (1..).zip(text.lines());
        let fault = |line, message: String| Fault::at_line(path, line, message);
        let (mut width, mut height) = (None, None);
        loop {
            let Some((number, line)) = lines.next() else {
                return Err(fault(1, "has no line `map` before the cells".to_owned()));
            };
            let mut words = line.split_whitespace();
            let size = match (words.next(), words.next()) {
                (None | Some("type"), _) => continue,
                (Some("map"), None) => break,
                (Some("width"), Some(size)) => width.insert((number, size)),
                (Some("height"), Some(size)) => height.insert((number, size)),
                _ => {
                    let message = "expected `type octile`, `height ROWS`, `width COLUMNS` and `map`";
                    return Err(fault(number, message.to_owned()));
                }
            };
            if size.1.parse::<usize>().is_err() {
                let message = format!("`{}` is not a number of cells", size.1.escape_debug());
                return Err(fault(number, message));
            }
        }
        let size = |stated: Option<(usize, &str)>, name| {
            let size = stated.and_then(|(_, size)| size.parse::<usize>().ok());
            size.ok_or_else(|| fault(1, format!("has no line `{name}` before the cells")))
        };
        let (width, height) = (size(width, "width COLUMNS")?, size(height, "height ROWS")?);
        if !fits(width, height) {
            return Err(fault(1, too_large(width, height)));
        }
        let mut rows: Vec<Vec<MapCell>> = Vec::new();
        for (number, line) in lines.take(height) {
            let row: Option<Vec<MapCell>> = line.chars().map(cell).collect();
            match row.filter(|row| row.len() == width) {
                Some(row) => rows.push(row),
                None => {
                    let message = format!("expected {width} letters of `.GS@OTW`");
                    return Err(fault(number, message));
                }
            }
        }
        if rows.len() < height {
            let message = format!("ends early: {} of {height} rows are present", rows.len());
            return Err(fault(text.lines().count(), message));
        }
        Ok(Self {
            width,
            height,
            resolution: RESOLUTION,
            origin: [0.0; 3],
            cells: rows.into_iter().rev().flatten().collect(),
            left_out: LeftOut::default(),
        })
    }
}

const fn cell(letter: char) -> Option<MapCell> {
    match letter {
        '.' | 'G' | 'S' => Some(MapCell::Free),
        '@' | 'O' | 'T' | 'W' => Some(MapCell::Occupied),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<MapFile, String> {
        MapFile::parse_moving_ai(Path::new("arena.map"), text).map_err(|fault| fault.to_string())
    }

    #[test]
    fn the_first_row_is_the_highest() {
        use MapCell::{Free, Occupied};
        let map = read("type octile\nheight 2\nwidth 3\nmap\n.GS\n@TW\n").unwrap();
        assert_eq!((map.width, map.height), (3, 2));
        assert_eq!(map.cells, [Occupied, Occupied, Occupied, Free, Free, Free]);
    }

    #[test]
    fn faults_name_their_line() {
        for (text, expected) in [
            (
                "type octile\nheight two\n",
                "arena.map:2: `two` is not a number of cells",
            ),
            (
                "type octile\nheight 2\nmap\n..\n",
                "arena.map:1: has no line `width COLUMNS` before the cells",
            ),
            (
                "type octile\nheight 2\nwidth 2\nmap\n..\n.x\n",
                "arena.map:6: expected 2 letters of `.GS@OTW`",
            ),
            (
                "type octile\nheight 2\nwidth 2\nmap\n..\n",
                "arena.map:5: ends early: 1 of 2 rows are present",
            ),
        ] {
            assert_eq!(read(text).unwrap_err(), expected);
        }
        let large = read("type octile\nheight 100000\nwidth 100000\nmap\n").unwrap_err();
        assert!(large.contains("100000 x 100000 pixels"), "{large}");
    }
}
