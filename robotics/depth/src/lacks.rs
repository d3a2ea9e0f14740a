//! Why a schema has no scan: the words of its panel and of the log.

use jde_schema::prelude::*;

/// The reason why there is no scan. It stays until there is one.
#[derive(Debug, Default)]
pub struct Lacks(Option<String>);

impl Lacks {
    /// Keeps what came of a picture or cloud. The log says a reason once. Returns whether there is a scan.
    pub fn keep(&mut self, cx: &Context, seen: Result<(), String>) -> bool {
        let before = core::mem::replace(&mut self.0, seen.err());
        if let Some(words) = &self.0
            && before.as_ref() != Some(words)
        {
            warn!(cx, "no scan: {words}");
        }
        self.0.is_none()
    }

    /// Why there is no scan; `None` if there is one.
    #[must_use]
    pub fn words(&self) -> Option<&str> {
        self.0.as_deref()
    }

    /// Writes it into a panel.
    pub fn draw(&self, pen: &mut Pen) {
        match &self.0 {
            Some(words) => pen.text(format!("No scan: {words}")),
            None => pen.text("It sees"),
        }
    }
}
