//! The schema of a map from a file. It reads the file once each time that it awakes.

use std::path::Path as FilePath;

use jde_grid::MAX_CELLS;
use jde_map_file::MapFile;
use jde_schema::prelude::*;

/// Exports the map of a ROS map server's YAML file, with the numbers that Nav2's map server publishes.
///
/// It exports the map once after it awakes, in the frame "map".
#[derive(Describe)]
#[schema(perceptive, period = "1s", budget = "500ms")]
pub struct File {
    /// The YAML file, which names the image.
    #[modulation(default = "", unit = "path", fixed)]
    file: Modulation<Text<1024>>,
    /// The map.
    #[export(lasting)]
    map: Export<OccupancyGrid>,
    /// The map that is not exported yet.
    loaded: Option<MapFile>,
}

impl Schema for File {
    fn awake(&mut self, cx: &Context) -> Result {
        let loaded = load(self.file.get(cx).as_str())?;
        for line in loaded.left_out.lines() {
            warn!(cx, "{}: {line}", self.file.get(cx).as_str());
        }
        self.loaded = Some(loaded);
        Ok(())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let Some(loaded) = self.loaded.take() else {
            return Ok(());
        };
        let [x, y, heading] = loaded.origin;
        let mut map = self.map.loan(cx);
        map.header = Header::new(cx.now(), "map");
        map.info = MapMetaData {
            map_load_time: cx.now().into(),
            resolution: loaded.resolution as f32,
            width: loaded.width as u32,
            height: loaded.height as u32,
            padding: Padding::ZERO,
            origin: Pose2D::new(x, y, heading).into(),
        };
        let numbers = map.data.resize(loaded.cells.len());
        for (number, cell) in numbers.iter_mut().zip(loaded.cells) {
            *number = cell.to_ros();
        }
        map.publish();
        Ok(())
    }
}

impl Inspect for File {
    fn inspect(&self, cx: &Context, problems: &mut Problems) {
        problems.expect(&self.file, load(self.file.get(cx).as_str()));
    }
}

/// Reads a map that fits into the exported type.
fn load(file: &str) -> Result<MapFile> {
    if file.is_empty() {
        return Err("`file` names no map: give the YAML file of a ROS map".into());
    }
    let map = MapFile::load(FilePath::new(file)).map_err(|faults| format!("{faults:#}"))?;
    if map.cells.len() > MAX_CELLS {
        return Err(format!(
            "the map `{file}` has {} x {} cells: expected at most {MAX_CELLS} in all; export it with larger cells",
            map.width, map.height
        )
        .into());
    }
    Ok(map)
}
