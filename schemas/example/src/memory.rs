//! What it hands on when it is reloaded: how far it is, and the place that somebody wants it to go to first.

use jde_schema::prelude::*;

use super::{Example, Wish};

impl Memory for Example {
    fn save(&self, _: &Context, saving: &mut Saving) {
        saving.put(&self.reached);
        let places: Vec<_> = self.wish.iter().map(|wish| wish.at).collect();
        saving.put_all(&places);
        saving.put_text(self.wish.as_ref().map_or("", |wish| &wish.by));
        saving.put(&self.skipped);
    }

    fn restore(&mut self, _: &Context, saved: &mut Saved) -> Result {
        self.reached = saved.take()?;
        let at = saved.take_all()?.into_iter().next();
        let by = saved.take_text()?.to_owned();
        self.wish = at.map(|at| Wish { at, by });
        // A build before did not know of any.
        self.skipped = saved.take().unwrap_or_default();
        Ok(())
    }
}
