//! The state kept across a reload: what was given up, and how many frontiers were seen.

use jde_schema::prelude::*;

use super::{Explore, GivenUp};

impl Memory for Explore {
    fn save(&self, _: &Context, saving: &mut Saving) {
        saving.put(&self.seen);
        let places: Vec<_> = self
            .given_up
            .iter()
            .map(|past| [past.place.0, past.place.1])
            .collect();
        saving.put_all(&places);
        for past in &self.given_up {
            saving.put_text(&past.reason);
        }
    }

    fn restore(&mut self, _: &Context, saved: &mut Saved) -> Result {
        self.seen = saved.take()?;
        let places: Vec<[f64; 2]> = saved.take_all()?;
        for [x, y] in places {
            self.given_up.push(GivenUp {
                place: (x, y),
                reason: saved.take_text()?.to_owned(),
            });
        }
        Ok(())
    }
}
