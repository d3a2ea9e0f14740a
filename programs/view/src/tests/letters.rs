//! The fonts of the windows contain every letter of the displayed texts.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use eframe::egui::{Context, FontId, RawInput};

use super::common::ROOT;

/// Folders whose sources contain displayed texts.
const FOLDERS: [&str; 3] = ["programs/view/src", "schemas", "drivers"];

#[test]
fn the_fonts_contain_every_letter_of_a_label() {
    let mut letters = BTreeSet::new();
    for folder in FOLDERS {
        collect(&Path::new(ROOT).join(folder), &mut letters);
    }
    assert!(letters.contains(&'µ'), "the sources were searched");
    let ctx = Context::default();
    // Fonts are loaded with the first frame.
    let mut output = ctx.run_ui(RawInput::default(), |_| {});
    // No renderer takes the textures.
    output.textures_delta.clear();
    ctx.fonts_mut(|fonts| {
        for font in [FontId::proportional(13.0), FontId::monospace(13.0)] {
            let missing: Vec<_> = letters
                .iter()
                .filter(|letter| !fonts.has_glyph(&font, **letter))
                .collect();
            assert!(missing.is_empty(), "{:?} lacks {missing:?}", font.family);
        }
    });
}

/// Collects the letters outside ASCII in sources, without comments.
fn collect(folder: &Path, letters: &mut BTreeSet<char>) {
    for entry in fs::read_dir(folder).expect("the folder exists") {
        let path = entry.expect("the entry can be read").path();
        if path.is_dir() {
            collect(&path, letters);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            let text = fs::read_to_string(&path).expect("the file is text");
            let code = text.lines().filter(|line| !line.trim_start().starts_with("//"));
            letters.extend(code.flat_map(str::chars).filter(|letter| !letter.is_ascii()));
        }
    }
}
