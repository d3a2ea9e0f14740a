//! The state kept across a reload: what an operator has drawn, and the obstacles that were seen.

use jde_grid::{Place, SeenObstacles};
use jde_schema::prelude::*;

use super::Plan;

impl Memory for Plan {
    fn save(&self, _: &Context, saving: &mut Saving) {
        saving.put(&self.drawn.zones);
        saving.put(&self.drawn.lanes);
        saving.put(&self.drawn.points);
        saving.put(&self.drawn.width);
        let seen = self.remembered.iter().flat_map(SeenObstacles::places);
        let (places, times): (Vec<Place>, Vec<Duration>) = seen.unzip();
        let (columns, rows): (Vec<i32>, Vec<i32>) = places.into_iter().unzip();
        let times: Vec<u64> = times.iter().map(|time| time.as_nanos() as u64).collect();
        saving.put(&self.remembered.as_ref().map_or(0.0, SeenObstacles::resolution));
        saving.put_all(&columns);
        saving.put_all(&rows);
        saving.put_all(&times);
    }

    fn restore(&mut self, _: &Context, saved: &mut Saved) -> Result {
        self.drawn.zones = saved.take()?;
        self.drawn.lanes = saved.take()?;
        self.drawn.points = saved.take()?;
        self.drawn.width = saved.take()?;
        // Earlier builds did not save what was seen.
        let resolution: f64 = saved.take().unwrap_or_default();
        if resolution > 0.0 {
            let (columns, rows) = (saved.take_all::<i32>()?, saved.take_all::<i32>()?);
            let times = saved.take_all()?.into_iter().map(Duration::from_nanos);
            let places = columns.into_iter().zip(rows).zip(times);
            self.remembered = Some(SeenObstacles::of(resolution, places));
        }
        Ok(())
    }
}
