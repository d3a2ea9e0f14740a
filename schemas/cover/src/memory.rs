//! The state kept across a reload: what was covered, which lines were driven along, and what was left out.

use jde_grid::{CellSet, Geometry};
use jde_schema::prelude::*;

use super::{Cover, Marks};

impl Memory for Cover {
    fn save(&self, _: &Context, saving: &mut Saving) {
        saving.put(&self.strokes);
        saving.put(&Flag::from(self.is_done));
        let places: Vec<_> = self.left_out.iter().map(|&(x, y)| [x, y]).collect();
        saving.put_all(&places);
        // Without any, the map has no cells.
        let Some(Marks { covered, driven }) = &self.marks else {
            saving.put(&[0_u32, 0]);
            return;
        };
        let geometry = covered.geometry();
        let (x, y, yaw) = geometry.origin();
        saving.put(&[geometry.width(), geometry.height()]);
        saving.put(&[geometry.resolution(), x, y, yaw]);
        saving.put_all(&covered.to_bits());
        saving.put_all(&driven.to_bits());
    }

    fn restore(&mut self, _: &Context, saved: &mut Saved) -> Result {
        self.strokes = saved.take()?;
        self.is_done = saved.take::<Flag>()?.get();
        let places: Vec<[f64; 2]> = saved.take_all()?;
        self.left_out = places.into_iter().map(|[x, y]| (x, y)).collect();
        let [width, height]: [u32; 2] = saved.take()?;
        if width == 0 {
            return Ok(());
        }
        let [resolution, x, y, yaw] = saved.take()?;
        let geometry = Geometry::new(width, height, resolution, (x, y, yaw))?;
        let mut cells = || -> Result<_> {
            let bits: Vec<u8> = saved.take_all()?;
            Ok(CellSet::from_bits(geometry, &bits).ok_or("the saved floor has another size")?)
        };
        let (covered, driven) = (cells()?, cells()?);
        self.marks = Some(Marks { covered, driven });
        Ok(())
    }
}
