//! Maps as worlds: the map itself, written beside the world, and a place where a robot can start. It traces no walls.

use jde_map_file::{MapCell, MapFile};

use super::writer::Draft;
use super::{ImportedWorld, map_files};
use crate::geometry::Pose2;

/// What a robot has around its start, if the map has such a place, m.
const AROUND: f64 = 0.5;

/// Returns the world `name` of a map; `comment` is its first line.
pub(super) fn world(map: MapFile, comment: &str, name: &str) -> ImportedWorld {
    let (yaml, picture) = map_files(name);
    let start = start(&map);
    let mut notes = Vec::new();
    match start {
        Some([x, y, _]) => notes.push(format!("The robot starts at ({x:.2}, {y:.2}).")),
        None => notes.push("The map has no free cell, and no robot can start on it.".to_owned()),
    }
    let is_likely = |cell: &MapCell| matches!(cell, MapCell::Likely(_));
    if map.cells.iter().any(is_likely) {
        notes.push(
            "Cells with a probability are free below 20 %, occupied from 65 % and unknown between."
                .to_owned(),
        );
    }
    let draft = Draft {
        map: Some(yaml.clone()),
        starts: start
            .map(|start| ("robot".to_owned(), start))
            .into_iter()
            .collect(),
        ..Draft::default()
    };
    ImportedWorld {
        name: name.to_owned(),
        text: draft.write(comment, name),
        files: vec![(yaml, map.yaml(&picture).into_bytes()), (picture, map.image())],
        left_out: map.left_out,
        notes,
    }
}

/// Returns the world `name` of a map of MovingAI.
pub(super) fn moving_ai(map: MapFile, name: &str) -> ImportedWorld {
    let mut world = world(map, "Converted from a map of MovingAI. Metres, degrees.", name);
    let yaml = map_files(name).0;
    world.notes.push(format!(
        "A cell is 1 m wide, because the file states no lengths: change `resolution` in {yaml}."
    ));
    world
}

/// Returns a free place of a map, m, m, degrees: the nearest one to the origin with room around it, or else the one with
/// most room.
fn start(map: &MapFile) -> Option<[f64; 3]> {
    let room = room(map);
    let [x, y, heading] = map.origin;
    let origin = Pose2::new(x, y, heading);
    let place = |index: usize| {
        let cell = [index % map.width, index / map.width];
        let [x, y] = cell.map(|cell| (cell as f64 + 0.5) * map.resolution);
        origin.compose(Pose2::new(x, y, 0.0))
    };
    // A cell without room is not free.
    let enough = ((AROUND / map.resolution).ceil() as usize + 1).min(usize::from(u16::MAX)) as u16;
    let distance = |index: &usize| {
        let place = place(*index);
        libm::hypot(place.x, place.y)
    };
    let wide = (0..room.len()).filter(|index| room[*index] >= enough);
    let nearest = wide.min_by(|a, b| distance(a).total_cmp(&distance(b)));
    let widest = || {
        (0..room.len())
            .filter(|index| room[*index] > 0)
            .rev()
            .max_by_key(|index| room[*index])
    };
    let place = place(nearest.or_else(widest)?);
    Some([place.x, place.y, 0.0])
}

/// Returns for each cell how many cells it is away from one that is not free, or from the edge, along rows, columns and
/// diagonals.
fn room(map: &MapFile) -> Vec<u16> {
    let (width, height) = (map.width, map.height);
    let mut room = vec![0; map.cells.len()];
    let cells = (0..height).flat_map(|row| (0..width).map(move |column| (row, column)));
    // From below, the cells below are known, and from above, those above.
    for (row, column) in cells.clone() {
        let index = row * width + column;
        if map.cells[index].decided() == MapCell::Free && row > 0 && column > 0 && column + 1 < width {
            let below = index - width;
            let known = [index - 1, below - 1, below, below + 1];
            let least = known.map(|index| room[index]).into_iter().min();
            room[index] = least.unwrap_or(0_u16).saturating_add(1);
        } else if map.cells[index].decided() == MapCell::Free {
            room[index] = 1;
        }
    }
    for (row, column) in cells.rev() {
        let index = row * width + column;
        if room[index] > 0 && row + 1 < height && column > 0 && column + 1 < width {
            let above = index + width;
            let known = [index + 1, above - 1, above, above + 1];
            let least = known.map(|index| room[index]).into_iter().min();
            room[index] = room[index].min(least.unwrap_or(0_u16).saturating_add(1));
        } else if room[index] > 0 {
            room[index] = 1;
        }
    }
    room
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    fn map(rows: &str) -> MapFile {
        let (width, height) = (rows.lines().next().map_or(0, str::len), rows.lines().count());
        let text = format!("type octile\nheight {height}\nwidth {width}\nmap\n{rows}");
        MapFile::parse_moving_ai(Path::new("a.map"), &text).expect("a map")
    }

    #[test]
    fn a_robot_starts_where_there_is_room() {
        assert_eq!(start(&map("@@@\n@@@\n")), None);
        assert_eq!(start(&map("@@@\n@@.\n")), Some([2.5, 0.5, 0.0]));
        assert_eq!(start(&map(".@...\n@@...\n.@...\n")), Some([3.5, 1.5, 0.0]));
        let mut moved = map(".....\n.....\n.....\n");
        moved.origin = [-4.0, -2.0, 0.0];
        assert_eq!(start(&moved), Some([-0.5, -0.5, 0.0]));
    }
}
