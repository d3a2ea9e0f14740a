//! The user's settings for all applications, and the saved layout of each: files in the user's configuration
//! folder.
//!
//! A file that cannot be parsed is renamed and logged. A file that cannot be written is logged, and its
//! content is not saved.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use eframe::egui;
use etcetera::BaseStrategy;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::style::{self, Units};

/// The largest file of settings that is read, bytes.
const MAX_SETTINGS: u64 = 16 << 20;

/// The user's settings for all applications.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, rename_all = "kebab-case")]
pub(crate) struct WindowSettings {
    /// Units of displayed numbers.
    pub(crate) units: Units,
    /// Dark, light, or as the desktop.
    pub(crate) theme: egui::ThemePreference,
    /// The zoom factor of the user interface.
    pub(crate) zoom: f32,
}

impl Default for WindowSettings {
    fn default() -> Self {
        Self {
            units: Units::default(),
            theme: egui::ThemePreference::System,
            zoom: 1.0,
        }
    }
}

impl WindowSettings {
    /// Applies the settings to a context before its first frame.
    pub(crate) fn begin(&self, ctx: &egui::Context) {
        style::install(ctx);
        ctx.set_theme(self.theme);
        // A change of the zoom also scales the screen's size, which before the first frame is only a guess
        // and may exceed what a card can draw.
        ctx.options_mut(|options| options.zoom_factor = self.zoom());
    }

    /// Applies the settings to a context from the next frame on.
    pub(crate) fn apply(&self, ctx: &egui::Context) {
        ctx.set_theme(self.theme);
        ctx.set_zoom_factor(self.zoom());
    }

    fn zoom(&self) -> f32 {
        if self.zoom.is_finite() {
            self.zoom.clamp(0.5, 3.0)
        } else {
            1.0
        }
    }
}

/// A folder of settings files.
#[derive(Clone, Debug)]
pub(crate) struct SettingsStore {
    folder: Option<PathBuf>,
}

impl SettingsStore {
    /// The user's store: `jde/view` in the configuration folder.
    pub(crate) fn of_user() -> Self {
        let folder = etcetera::choose_base_strategy()
            .ok()
            .map(|places| places.config_dir().join("jde").join("view"));
        Self { folder }
    }

    /// A store in `folder`, or one that saves nothing.
    #[cfg(test)]
    pub(crate) fn at(folder: Option<PathBuf>) -> Self {
        Self { folder }
    }

    /// Reads the value saved under a name. Returns `None` if there is none or if it cannot be read. A file
    /// that cannot be parsed is renamed to `*.unreadable` and logged.
    pub(crate) fn take<T: DeserializeOwned>(&self, name: &str) -> Option<T> {
        let path = self.path(name)?;
        let text = match jde_files::read_text(&path, MAX_SETTINGS) {
            Ok(text) => text,
            Err(error) => {
                if error.kind() != io::ErrorKind::NotFound {
                    tracing::warn!("{} cannot be read: {error}", path.display());
                }
                return None;
            }
        };
        match serde_json::from_str(&text) {
            Ok(saved) => Some(saved),
            Err(error) => {
                let renamed = path.with_extension("unreadable");
                let _ = fs::rename(&path, &renamed);
                tracing::warn!(
                    "{} cannot be read ({error}) and is now {}",
                    path.display(),
                    renamed.display()
                );
                None
            }
        }
    }

    /// Saves a value under a name, atomically. A failure is logged.
    pub(crate) fn keep<T: Serialize>(&self, name: &str, value: &T) {
        let Some(path) = self.path(name) else { return };
        if let Err(error) = write(&path, value) {
            tracing::warn!("{} cannot be written: {error}", path.display());
        }
    }

    fn path(&self, name: &str) -> Option<PathBuf> {
        let safe: String = name
            .chars()
            .map(|letter| {
                if letter.is_alphanumeric() || "-_.".contains(letter) {
                    letter
                } else {
                    '-'
                }
            })
            .collect();
        Some(self.folder.as_ref()?.join(format!("{safe}.json")))
    }
}

fn write<T: Serialize>(path: &Path, value: &T) -> io::Result<()> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder)?;
    }
    let text = serde_json::to_vec_pretty(value)?;
    jde_files::replace(path, |file| file.write_all(&text))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn saved_settings_are_read_at_the_next_start() {
        let folder = tempfile::tempdir().unwrap();
        let store = SettingsStore::at(Some(folder.path().join("deep/down")));
        let chosen = WindowSettings {
            zoom: 1.5,
            theme: egui::ThemePreference::Light,
            ..WindowSettings::default()
        };
        store.keep("settings", &chosen);
        assert_eq!(store.take::<WindowSettings>("settings"), Some(chosen));
    }

    #[test]
    fn the_first_frame_fills_its_window_at_every_zoom() {
        let ctx = egui::Context::default();
        let chosen = WindowSettings {
            zoom: 2.0,
            ..WindowSettings::default()
        };
        chosen.begin(&ctx);
        let size = egui::vec2(720.0, 450.0);
        let input = egui::RawInput {
            screen_rect: Some(egui::Rect::from_min_size(egui::Pos2::ZERO, size)),
            ..egui::RawInput::default()
        };
        let mut seen = None;
        let mut drawn = ctx.run_ui(input, |ui| {
            seen = Some((ui.ctx().content_rect().size(), ui.ctx().zoom_factor()));
        });
        // No renderer takes the textures.
        drawn.textures_delta.clear();
        assert_eq!(seen, Some((size, 2.0)));
    }

    #[test]
    fn an_unreadable_file_is_renamed_and_not_lost() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("settings.json"), "{ zoom").unwrap();
        let store = SettingsStore::at(Some(folder.path().to_owned()));
        assert_eq!(store.take::<WindowSettings>("settings"), None);
        assert_eq!(
            fs::read_to_string(folder.path().join("settings.unreadable")).unwrap(),
            "{ zoom"
        );
    }
}
